"""Patterns as other programs write them: FOLD files with any subset of keys, OBJ meshes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from inverse._types import FloatArray
from inverse.errors import InputError
from inverse.files.fold_format import EDGE_TYPES, array_of, edges_of, facets_of, read_document, words_of
from inverse.files.meshes import read_obj
from inverse.limits import check_coordinates, check_extent

FORMATS = (".fold", ".obj")
ASSIGNMENTS = ("B", "M", "V", "F", "U", "C")

Pair = tuple[int, int]


@dataclass(frozen=True, eq=False)
class ForeignMesh:
    """What a file says, checked in form only.

    Attributes:
        vertices_coords: (V, 3) float64, in ``unit``; z is 0 where the file has two coordinates.
        faces_vertices: vertices of each facet, turning either way; None if the file gives edges only.
        assignments: one of B, M, V, F, U, C by edge (lower vertex first), for every edge that the file lists.
        types: FL or CFL by edge, where the file says so.
        unit: length unit.
        name: title of the pattern.
    """

    vertices_coords: FloatArray
    faces_vertices: tuple[tuple[int, ...], ...] | None
    assignments: dict[Pair, str]
    types: dict[Pair, str]
    unit: str
    name: str


def pair_of(a: int, b: int) -> Pair:
    """An edge by its vertices, the lower one first."""
    return (a, b) if a < b else (b, a)


def read_foreign(path: Path) -> ForeignMesh:
    """Read a pattern from a FOLD or OBJ file.

    Raises:
        InputError: missing or unreadable file, or one whose parts have the wrong form; the message names the
            file, the line where the format has lines, and the key or number at fault.
    """
    if path.suffix.lower() not in FORMATS:
        given = path.suffix or "a file without an ending"
        raise InputError(f"{given} is no format that patterns are read from: allowed are {', '.join(FORMATS)}",
                         where=str(path))  # fmt: skip
    if path.suffix.lower() == ".obj":
        found = read_obj(path)
        facets = np.split(found.corners, np.cumsum(found.sizes)[:-1])
        mesh = ForeignMesh(found.vertices, tuple(tuple(f.tolist()) for f in facets), {}, {}, "unit", path.stem)
    else:
        mesh = _from_fold(read_document(path), path)
    _check_coordinates(mesh, path)
    return mesh


def _from_fold(document: dict[str, Any], path: Path) -> ForeignMesh:
    where = str(path)
    frame = _frame(document, where)
    points = _coordinates(frame, where)
    if "edges_vertices" not in frame and "faces_vertices" not in frame:
        raise InputError("the file has neither edges_vertices nor faces_vertices", where=where,
                         hint="Export the pattern with its edges or its facets.")  # fmt: skip
    faces = facets_of(frame, len(points), where) if "faces_vertices" in frame else None
    pairs: list[Pair] = []
    if "edges_vertices" in frame:
        pairs = [pair_of(a, b) for a, b in edges_of(frame, len(points), where).tolist()]
        _check_edges(pairs, where)
    for key in ("edges_assignment", "edges_foldAngle", "bdffpq:edges_type"):
        if key in frame and "edges_vertices" not in frame:
            raise InputError(f"the file has {key}, but no edges_vertices that it belongs to", where=where)
    types: Iterable[str] = ()
    if "bdffpq:edges_type" in frame:
        types = words_of(frame, "bdffpq:edges_type", EDGE_TYPES, len(pairs), where)
    unit, title = frame.get("frame_unit", "unit"), frame.get("file_title") or frame.get("frame_title") or path.stem
    return ForeignMesh(
        points, faces, dict(zip(pairs, _assignments(frame, len(pairs), where), strict=True)),
        {pair: word for pair, word in zip(pairs, types, strict=False) if word != "B"},
        _printable(unit), _printable(title),
    )  # fmt: skip


def _printable(value: object) -> str:
    """A title that any file can hold: no control characters, no halves of surrogate pairs."""
    return "".join(letter if letter.isprintable() else " " for letter in str(value))


def _frame(document: dict[str, Any], where: str) -> dict[str, Any]:
    """The root frame, or the first other one with coordinates, completed by what it inherits."""
    others = document.get("file_frames", [])
    if not isinstance(others, list) or not all(isinstance(frame, dict) for frame in others):
        raise InputError("file_frames must be a list of frames", where=where)
    frames = [document, *others]

    def complete(k: int, below: frozenset[int]) -> dict[str, Any]:
        frame: dict[str, Any] = frames[k]
        parent = frame.get("frame_parent", 0)
        if k == 0 or frame.get("frame_inherit") is not True:
            return frame
        if type(parent) is not int or not 0 <= parent < len(frames) or parent in below:
            raise InputError(f"frame {k} inherits from frame {parent!r}, which cannot be", where=where)
        return complete(parent, below | {parent}) | frame

    for k, frame in enumerate(frames):
        if "vertices_coords" in frame:
            return complete(k, frozenset({k}))
    raise InputError("no frame of the file has vertices_coords", where=where,
                     hint="Export the pattern with the coordinates of its vertices.")  # fmt: skip


def _coordinates(frame: dict[str, Any], where: str) -> FloatArray:
    rows = frame["vertices_coords"]
    width = len(rows[0]) if isinstance(rows, list) and rows and isinstance(rows[0], list) else 3
    if rows == []:
        raise InputError("the pattern has no vertices", where=where)
    points: FloatArray = array_of(frame, "vertices_coords", np.float64, 2 if width == 2 else 3, where)
    return np.hstack([points, np.zeros((len(points), 3 - points.shape[1]))])


def _check_edges(pairs: list[Pair], where: str) -> None:
    seen: dict[Pair, int] = {}
    for k, (a, b) in enumerate(pairs):
        if a == b:
            raise InputError(f"edges_vertices[{k}] joins vertex {a} to itself", where=where)
        if (a, b) in seen:
            raise InputError(f"edge {a}-{b} is listed twice, as edges {seen[a, b]} and {k}", where=where)
        seen[a, b] = k


def _assignments(frame: dict[str, Any], count: int, where: str) -> list[str]:
    """The word of every edge; an unassigned one takes the sign of its fold angle, if there is one."""
    words = ["U"] * count
    if "edges_assignment" in frame:
        words = list(words_of(frame, "edges_assignment", ASSIGNMENTS, count, where))
    if "edges_foldAngle" in frame and "U" in words:
        angles: FloatArray = array_of(frame, "edges_foldAngle", np.float64, 0, where)
        if len(angles) != count:
            raise InputError(f"edges_foldAngle has {len(angles)} entries for {count} edges", where=where)
        signs = {1.0: "V", -1.0: "M", 0.0: "U"}
        words = [signs[float(s)] if word == "U" else word for word, s in zip(words, np.sign(angles), strict=True)]
    return words


def _check_coordinates(mesh: ForeignMesh, path: Path) -> None:
    check_coordinates(mesh.vertices_coords, str(path))
    check_extent(mesh.vertices_coords, "the pattern", str(path))
