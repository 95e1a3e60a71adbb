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
from inverse.certify import Certificate
from inverse.context import Context, read_city_json, triangulated
from inverse.errors import InputError
from inverse.files import fold_file
from inverse.files.atomic import json_text, write_atomically
from inverse.origami.pattern import CFL, Design
from inverse.pictures.design_state import Surface
from inverse.repair import Repair
from inverse.results.folder import NAMES, Results, unwritable
from inverse.solve import Result
from inverse.spec import Loaded

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


def read_context(loaded: Loaded) -> Context | None:
    """The building context that a specification names, if any.

    Raises:
        InputError: the file cannot be used, with the place in the specification.
    """
    keys = loaded.specification.context
    if keys is None:
        return None
    try:
        return read_city_json(loaded.folder / keys.file, keys.origin)
    except InputError as error:
        raise loaded.source.error(("context", "file"), str(error).split("\n")[0], error.hint) from None


def keeps_earlier(result: Result, folder: Path) -> bool:
    """Whether an interrupted run has nothing that may replace what an earlier one left in a folder.

    That is certified, and this run's is not, or is the seed that it began with.
    """
    try:
        earlier = json.loads((folder / "certificate.json").read_text(encoding="utf-8"))["certified"] is True
    except (OSError, ValueError, TypeError, KeyError):
        return False
    found = result.certified and result.report["iterations"] > 0
    return result.interrupted and earlier and not found and (folder / "design.fold").exists()


@dataclass(frozen=True)
class Written:
    """How writing went.

    Attributes:
        notes: sentences about what could not be written, if anything.
        interrupted: Ctrl-C or SIGTERM came meanwhile, so that pictures are missing.
    """

    notes: list[str]
    interrupted: bool = False


def write(result: Result, loaded: Loaded, context: Context | None, results: Results) -> Written:
    """Write everything that a solve promises.

    Args:
        result: of :func:`inverse.solve`.
        loaded: the specification it was solved for.
        context: buildings for the picture.
        results: where.

    Raises:
        InputError: nothing could be written; what was there is still there.
    """
    report = {"name": loaded.specification.name, "status": result.status, **result.report}
    return _write(
        results,
        result.design,
        result.certificate,
        report,
        {"specification": loaded.specification.model_dump(mode="json")},
        target=result.formulation.goal.target.triangles(),
        context=triangulated(context)[:2] if context else None,
    )


def write_repair(result: Repair, results: Results) -> Written:
    """Write everything that a repair promises.

    Args:
        result: of :func:`inverse.repair`.
        results: where.

    Raises:
        InputError: nothing could be written; what was there is still there.
    """
    report = {"name": result.design.name, "status": result.status, **result.report}
    return _write(results, result.design, result.certificate, report, {}, target=None, context=None)


def _write(
    results: Results,
    design: Design,
    certificate: Certificate,
    report: dict[str, Any],
    task: dict[str, Any],
    *,
    target: Surface | None,
    context: Surface | None,
) -> Written:
    versions = {name: version(name) for name in PACKAGES} | {"python": platform.python_version()}
    report = report | {"versions": versions} | task | {"notes": []}
    stop = threading.Event()
    try:
        with interrupts.held(stop):
            new = results.filling()
            fold_file.write(design, new / "design.fold")
            _write_json(new / "certificate.json", certificate.document())
            _write_json(new / "report.json", report)
            results.replace()
    except OSError as error:
        raise unwritable(results.folder, error) from None
    interrupted = Written(["Interrupted: the results have no pictures."], interrupted=True)
    if stop.is_set():
        return interrupted
    try:
        with interrupts.raised():
            return Written(_add_pictures(results, design, report, target, context))
    except KeyboardInterrupt:
        return interrupted


def _add_pictures(
    results: Results, design: Design, report: dict[str, Any], target: Surface | None, context: Surface | None
) -> list[str]:
    """Draw, and tell in the report how that went; what is there already does not depend on it."""
    began = time.perf_counter()
    try:
        new = results.filling()
        notes = _draw(design, target, context, new)
        seconds = {**report.get("seconds", {}), "pictures": time.perf_counter() - began}
        _write_json(new / "report.json", report | {"notes": notes, "seconds": seconds})
        results.add()
    except OSError as error:
        return [f"The pictures cannot be written: {error}"]
    return notes


def _draw(design: Design, target: Surface | None, context: Surface | None, folder: Path) -> list[str]:
    pictures.crease_pattern_picture(design, folder / "crease_pattern.svg")
    if (design.pattern.edges_type == CFL).any():  # else the developed state has a single layer
        pictures.layers_picture(design, folder / "layers.svg")
    missing = pictures.can_render()
    if missing is not None:
        return [missing]
    try:
        pictures.design_picture(design, folder / "design.png", target=target, context=context)
        pictures.states_picture(design, folder / "states.png")
    except RuntimeError as error:  # the process that draws was killed or took too long
        return [f"No 3D pictures: {error}"]
    return []


def _write_json(path: Path, document: dict[str, Any]) -> None:
    write_atomically(path, json_text(document) + "\n")
