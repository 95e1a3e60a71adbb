"""What a solve or a repair leaves behind: design, certificate, report, pictures, each file whole or not at all."""

from __future__ import annotations

import json
import os
import platform
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

from inverse import fold_file, pictures
from inverse.certify import Certificate
from inverse.context import Context, read_city_json, triangulated
from inverse.errors import InputError
from inverse.files import write_atomically
from inverse.pattern import CFL, Design
from inverse.pictures.design_state import Surface
from inverse.repair import Repair
from inverse.solve import Result
from inverse.spec import Loaded

PACKAGES = ("inverse", "casadi", "numpy", "scipy", "pyvista", "trimesh", "libigl")


def files(folder: Path) -> list[Path]:
    """The files of a result that are there; pictures may be missing."""
    written = ("design.fold", "certificate.json", "report.json")
    pictured = ("design.png", "states.png", "crease_pattern.svg", "layers.svg")
    return [folder / name for name in written + pictured if (folder / name).exists()]


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


def write(result: Result, loaded: Loaded, context: Context | None, folder: Path) -> list[str]:
    """Write everything that a solve promises.

    Args:
        result: of :func:`inverse.solve`.
        loaded: the specification it was solved for.
        context: buildings for the picture.
        folder: where; made if missing.

    Returns:
        Sentences about what could not be written, if anything.
    """
    report = {"name": loaded.specification.name, "status": result.status, **result.report}
    return _write(
        folder,
        result.design,
        result.certificate,
        report,
        {"specification": loaded.specification.model_dump(mode="json")},
        target=result.formulation.goal.target.triangles(),
        context=triangulated(context)[:2] if context else None,
    )


def write_repair(result: Repair, folder: Path) -> list[str]:
    """Write everything that a repair promises.

    Args:
        result: of :func:`inverse.repair`.
        folder: where; made if missing.

    Returns:
        Sentences about what could not be written, if anything.
    """
    report = {"name": result.design.name, "status": result.status, **result.report}
    return _write(folder, result.design, result.certificate, report, {}, target=None, context=None)


def _write(
    folder: Path,
    design: Design,
    certificate: Certificate,
    report: dict[str, Any],
    task: dict[str, Any],
    *,
    target: Surface | None,
    context: Surface | None,
) -> list[str]:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        fold_file.write(design, folder / "design.fold")
        _write_json(folder / "certificate.json", certificate.document())
        began = time.perf_counter()
        notes = _write_pictures(design, target, context, folder)
        spent = {"pictures": time.perf_counter() - began}
        versions = {name: version(name) for name in PACKAGES} | {"python": platform.python_version()}
        seconds = {"seconds": {**report.get("seconds", {}), **spent}}
        _write_json(folder / "report.json", report | {"versions": versions} | task | {"notes": notes} | seconds)
    except OSError as error:
        raise InputError(
            f"the results cannot be written: {error}", where=str(folder), hint="Choose another -o."
        ) from None
    return notes


def _write_pictures(design: Design, target: Surface | None, context: Surface | None, folder: Path) -> list[str]:
    pictures.crease_pattern_picture(design, folder / "crease_pattern.svg")
    if (design.pattern.edges_type == CFL).any():
        pictures.layers_picture(design, folder / "layers.svg")
    else:
        (folder / "layers.svg").unlink(missing_ok=True)  # the developed state has a single layer
    missing = pictures.can_render()
    if missing is not None:
        for name in ("design.png", "states.png"):
            (folder / name).unlink(missing_ok=True)  # a picture of an earlier design would mislead
        return [missing]
    pictures.design_picture(design, folder / "design.png", target=target, context=context)
    pictures.states_picture(design, folder / "states.png")
    return []


def _write_json(path: Path, document: dict[str, Any]) -> None:
    write_atomically(path, json.dumps(document, indent=1, allow_nan=False) + "\n")
