"""What a solve or a repair leaves behind: design, certificate and report first, then pictures."""

from __future__ import annotations

import json
import os
import platform
import threading
import time
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from inverse import interrupts, pictures
from inverse.errors import InputError
from inverse.files import fold_file
from inverse.files.atomic import json_text, write_atomically
from inverse.origami.pattern import CFL, Design
from inverse.repair.repairing import Repair
from inverse.results.folder import NAMES, Results, unwritable
from inverse.results.result import Result

PACKAGES = ("inverse", "casadi", "numpy", "scipy", "pyvista", "trimesh", "libigl")


def files(folder: Path) -> list[Path]:
    """The files of a result that are there; pictures may be missing."""
    return [folder / name for name in NAMES if (folder / name).exists()]


def output_folder(name: str, given: Path | None) -> Path:
    """The folder to write to, ``out/<name>`` if none is given; it is made when something is written.

    Raises:
        InputError: the folder cannot be made or written to.
    """
    folder = given or Path("out") / name
    existing = folder.absolute()
    while not existing.exists() and existing != existing.parent:
        existing = existing.parent
    if not existing.is_dir():
        raise InputError(f"{existing} is a file, so no results can be written to {folder}", hint="Choose another -o.")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise InputError(f"{existing} may not be written to", where=str(folder), hint="Choose another -o.")
    return folder


def keeps_earlier(result: Result, folder: Path) -> bool:
    """Whether an interrupted run has nothing that may replace what an earlier one left in a folder.

    What was certified and converged stays; what was certified alone stays if this run's design is not, or is the seed
    that it began with.
    """
    try:
        told = json.loads((folder / "report.json").read_text(encoding="utf-8"))
        certified, converged = told["certified"] is True, told["converged"] is True
    except (OSError, ValueError, TypeError, KeyError):
        return False
    found = result.certified and result.iterations > 0 and not converged
    return result.interrupted and certified and not found and (folder / "design.fold").exists()


@dataclass(frozen=True)
class Written:
    """How writing went.

    Attributes:
        notes: sentences about how the task was understood, and about what could not be written, if anything.
        interrupted: Ctrl-C or SIGTERM came meanwhile, so that pictures are missing.
    """

    notes: list[str]
    interrupted: bool = False


def save(result: Result | Repair, folder: Path, *, pictures: bool = True) -> list[str]:
    """Write everything into a folder of its own; see :meth:`inverse.results.result.Result.save`."""
    with Results(folder) as results:
        return write(result, results, pictures=pictures).notes


def write(result: Result | Repair, results: Results, *, pictures: bool = True) -> Written:
    """Write everything that a solve or a repair promises.

    Args:
        result: what was found.
        results: where.
        pictures: whether to draw.

    Raises:
        InputError: nothing could be written; what was there is still there.
    """
    versions = {name: version(name) for name in PACKAGES} | {"python": platform.python_version()}
    asked = list(result.notes) if isinstance(result, Result) else []
    report = {"name": result.design.name, "status": result.status, **result.report}
    report |= {"versions": versions, "notes": asked}
    stop = threading.Event()
    try:
        with interrupts.held(stop):
            new = results.filling()
            fold_file.write(result.design, new / "design.fold")
            _write_json(new / "certificate.json", result.certificate.document())
            _write_json(new / "report.json", report)
            results.replace()
    except OSError as error:
        raise unwritable(results.folder, error) from None
    interrupted = Written([*asked, "Interrupted: the results have no pictures."], interrupted=True)
    if stop.is_set():
        return interrupted
    if not pictures:
        return Written(asked)
    try:
        with interrupts.raised():
            return Written([*asked, *_add_pictures(result, results, report)])
    except KeyboardInterrupt:
        return interrupted


def _add_pictures(result: Result | Repair, results: Results, report: dict[str, Any]) -> list[str]:
    """Draw, and tell in the report how that went; what is there already does not depend on it."""
    began = time.perf_counter()
    try:
        new = results.filling()
        shown: dict[str, Any] = {}
        if isinstance(result, Result):
            shown = {"target": result.target, "context": result.context, "caption": result.caption}
        notes = _draw(result.design, shown, new)
        seconds = {**report.get("seconds", {}), "pictures": time.perf_counter() - began}
        _write_json(new / "report.json", report | {"notes": [*report["notes"], *notes], "seconds": seconds})
        results.add()
    except OSError as error:
        return [f"The pictures cannot be written: {error}"]
    return notes


def _draw(design: Design, shown: dict[str, Any], folder: Path) -> list[str]:
    """Draw a design, with what of its surroundings and verdicts is to be shown."""
    pictures.crease_pattern_picture(design, folder / "crease_pattern.svg")
    if (design.pattern.edges_type == CFL).any():  # else the developed state has a single layer
        pictures.layers_picture(design, folder / "layers.svg")
    missing = pictures.can_render()
    if missing is not None:
        return [missing]
    try:
        pictures.design_picture(design, folder / "design.png", **shown)
        pictures.states_picture(design, folder / "states.png")
    except RuntimeError as error:  # the process that draws was killed or took too long
        return [f"No 3D pictures: {error}"]
    return []


def _write_json(path: Path, document: dict[str, Any]) -> None:
    write_atomically(path, json_text(document) + "\n")
