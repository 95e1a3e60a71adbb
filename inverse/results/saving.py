"""What a solve or a repair leaves behind: design, certificate and report first, then pictures."""

from __future__ import annotations

import json
import platform
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal

from inverse import interrupts, pictures
from inverse.files import fold_file
from inverse.files.atomic import json_text, write_atomically
from inverse.origami.pattern import CFL, Design
from inverse.pictures.rendering import Renderer
from inverse.repair.repairing import Repair
from inverse.results.folder import Results, unwritable
from inverse.results.result import Result

Pictures = Literal["none", "svg", "all"]
PACKAGES = ("inverse", "casadi", "numpy", "scipy", "pyvista", "trimesh", "libigl")


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


def save(result: Result | Repair, folder: Path, *, pictures: Pictures | None = None) -> list[str]:
    """Write everything into a folder of its own; see :meth:`inverse.results.result.Result.save`."""
    with Results(folder) as results:
        return write(result, results, pictures=pictures).notes


def write(
    result: Result | Repair,
    results: Results,
    *,
    pictures: Pictures | None = None,
    renderer: Renderer | None = None,
    phase: Callable[[str], None] | None = None,
) -> Written:
    """Write everything that a solve or a repair promises.

    Args:
        result: what was found.
        results: where.
        pictures: what to draw; by default what the specification says, and all of a repair.
        renderer: what renders 3D pictures, perhaps ready by now; by default it is started when they are drawn.
        phase: told what is being drawn.

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
    if pictures is None:
        pictures = result.specification["pictures"] if isinstance(result, Result) else "all"
    if pictures == "none":
        return Written(asked)
    try:
        with interrupts.raised(), ExitStack() as stack:
            notes = []
            if pictures == "all" and isinstance(result, Result) and result.ending == "interrupted":
                # Who ended the solve is waiting for the end.
                pictures, notes = "svg", ["Interrupted: the results have no 3D pictures."]
            if pictures == "all" and renderer is None:
                renderer = stack.enter_context(Renderer())
            drawing = renderer if pictures == "all" else None
            return Written([*asked, *_add_pictures(result, results, report, phase or (lambda _: None), drawing, notes)])
    except KeyboardInterrupt:
        return interrupted


def _add_pictures(
    result: Result | Repair,
    results: Results,
    report: dict[str, Any],
    phase: Callable[[str], None],
    renderer: Renderer | None,
    notes: list[str],
) -> list[str]:
    """Draw, and tell in the report how that went; what is there already does not depend on it."""
    began = time.perf_counter()
    try:
        new = results.filling()
        if renderer is not None:
            _begin(result, renderer, phase)
        _draw(result.design, new, phase)
        if renderer is not None:
            notes = _finish(renderer, new, phase)
        seconds = {**report.get("seconds", {}), "pictures": time.perf_counter() - began}
        _write_json(new / "report.json", report | {"notes": [*report["notes"], *notes], "seconds": seconds})
        results.add()
    except OSError as error:
        return [f"The pictures cannot be written: {error}"]
    return notes


def _begin(result: Result | Repair, renderer: Renderer, phase: Callable[[str], None]) -> None:
    """Have the 3D pictures rendered, while something else is drawn here."""
    phase("drawing states.png")
    renderer.begin([pictures.states_scene(result.design)], "states.png")
    phase("drawing design.png")
    shown = (result.target, result.context, result.caption) if isinstance(result, Result) else (None, None, "")
    renderer.begin([pictures.design_scene(result.design, *shown)], "design.png")


def _finish(renderer: Renderer, folder: Path, phase: Callable[[str], None]) -> list[str]:
    """Wait for the 3D pictures; sentences about what is missing."""
    phase("drawing design.png and states.png")
    missing = renderer.missing()
    if missing is not None:
        return [missing]
    try:
        for picture in renderer.finish():
            write_atomically(folder / picture.name, picture.read_bytes())
    except RuntimeError as error:  # the process that draws was killed or took too long
        return [f"No 3D pictures: {error}"]
    return []


def _draw(design: Design, folder: Path, phase: Callable[[str], None]) -> None:
    """Draw what needs no renderer."""
    phase("drawing crease_pattern.svg")
    pictures.crease_pattern_picture(design, folder / "crease_pattern.svg")
    if (design.pattern.edges_type == CFL).any():  # else the developed state has a single layer
        phase("drawing layers.svg")
        pictures.layers_picture(design, folder / "layers.svg")


def _write_json(path: Path, document: dict[str, Any]) -> None:
    write_atomically(path, json_text(document) + "\n")
