"""The FOLD 1.2 keys of a design file, read with checks of form only; shared by designs and certificates."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from inverse.errors import InputError
from inverse.files.reading import json_object, read_text
from inverse.limits import check_coordinates

ASSIGNMENTS = ("M", "V", "B")
EDGE_TYPES = ("B", "FL", "CFL")
MAX_BYTES = 100_000_000


@dataclass(frozen=True, eq=False)
class FoldFrame:
    """What a design file says, unverified: arrays as in FOLD, our ``bdffpq:`` keys beside them.

    Attributes:
        vertices_coords: (V, 3) float64.
        edges_vertices: (E, 2) int64.
        edges_assignment: one of ``M``, ``V``, ``B`` per edge.
        edges_fold_angle: (E,) float64 in degrees, valley positive.
        edges_type: one of ``B``, ``FL``, ``CFL`` per edge.
        faces_vertices: vertices of each facet.
        document: the whole JSON document.
    """

    vertices_coords: NDArray[np.float64]
    edges_vertices: NDArray[np.int64]
    edges_assignment: tuple[str, ...]
    edges_fold_angle: NDArray[np.float64]
    edges_type: tuple[str, ...]
    faces_vertices: tuple[tuple[int, ...], ...]
    document: dict[str, Any]


def read_frame(path: Path) -> FoldFrame:
    """Read a design file.

    Raises:
        InputError: missing or unreadable file, not JSON, a key missing or of the wrong shape; the message
            names the file and the key.
    """
    return frame_of(read_document(path), str(path))


def read_document(path: Path) -> dict[str, Any]:
    """Read the JSON object of a FOLD file.

    Raises:
        InputError: missing or unreadable file, or not a JSON object; the message names the file.
    """
    return json_object(read_text(path, MAX_BYTES), str(path))


def frame_of(document: dict[str, Any], where: str = "design") -> FoldFrame:
    """The frame of a FOLD document, checked in form.

    Args:
        document: a JSON object.
        where: name of the document in messages.

    Raises:
        InputError: a key missing or of the wrong shape.
    """
    coords = array_of(document, "vertices_coords", np.float64, 3, where)
    check_coordinates(coords, where)
    n_vertices = len(coords)
    edges = edges_of(document, n_vertices, where)
    n_edges = len(edges)
    faces = facets_of(document, n_vertices, where)
    angle = array_of(document, "edges_foldAngle", np.float64, 0, where)
    if len(angle) != n_edges:
        raise InputError(f"edges_foldAngle has {len(angle)} entries for {n_edges} edges", where=where)
    return FoldFrame(
        coords,
        edges,
        words_of(document, "edges_assignment", ASSIGNMENTS, n_edges, where),
        angle,
        words_of(document, "bdffpq:edges_type", EDGE_TYPES, n_edges, where),
        faces,
        document,
    )


def facets_of(document: dict[str, Any], n_vertices: int, where: str) -> tuple[tuple[int, ...], ...]:
    """``faces_vertices``, every number below ``n_vertices``.

    Raises:
        InputError: no such key, no facets, or a number that is none.
    """
    faces = _get(document, "faces_vertices", where)
    if not isinstance(faces, list) or not faces:
        raise InputError("faces_vertices must be a list of facets", where=where)
    for f, face in enumerate(faces):
        if not isinstance(face, list) or not all(_is_index(v, n_vertices) for v in face):
            raise InputError(
                f"faces_vertices[{f}] is {str(face)[:60]}: vertex numbers below {n_vertices} are needed", where=where
            )
    return tuple(tuple(face) for face in faces)


def edges_of(document: dict[str, Any], n_vertices: int, where: str) -> NDArray[np.int64]:
    """``edges_vertices``, (E, 2) int64, every number below ``n_vertices``.

    Raises:
        InputError: no such key, rows of another form, or a number that is none.
    """
    edges: NDArray[np.int64] = array_of(document, "edges_vertices", np.int64, 2, where)
    bad = (edges < 0) | (edges >= n_vertices)
    if bad.any():
        raise InputError(f"edges_vertices[{np.argmax(bad.any(axis=1))}] names a vertex that is not there", where=where)
    return edges


def _get(document: dict[str, Any], key: str, where: str) -> Any:
    if key not in document:
        raise InputError(f"the key {key!r} is missing", where=where, hint="`inverse solve` writes files with all keys.")
    return document[key]


def _is_index(value: object, count: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < count


def array_of(document: dict[str, Any], key: str, dtype: type, width: int, where: str) -> NDArray[Any]:
    """A list of numbers (width 0) or of rows of ``width`` numbers.

    Raises:
        InputError: no such key, another form, or a number that is not finite.
    """
    value = _get(document, key, where)
    rows: list[Any] = value if isinstance(value, list) else [None]
    flat = rows if width == 0 else [x for row in rows for x in (row if isinstance(row, list) else [None])]
    kinds = (int,) if dtype is np.int64 else (int, float)
    well_formed = all(isinstance(x, kinds) and not isinstance(x, bool) for x in flat)
    if not well_formed or (width and any(len(row) != width for row in rows)):
        shape = "a list of numbers" if width == 0 else f"a list of rows of {width} numbers"
        raise InputError(f"{key} must be {shape}", where=where)
    try:
        array: NDArray[Any] = np.array(rows, dtype).reshape((-1, width) if width else -1)
    except OverflowError:
        raise InputError(f"{key} holds a number that is too large", where=where) from None
    if not np.isfinite(array).all():
        raise InputError(f"{key} holds a number that is not finite", where=where)
    return array


def words_of(document: dict[str, Any], key: str, allowed: tuple[str, ...], count: int, where: str) -> tuple[str, ...]:
    """One of the allowed words for each of ``count`` edges.

    Raises:
        InputError: no such key, another number of words, or a word that is not allowed.
    """
    value = _get(document, key, where)
    if not isinstance(value, list) or len(value) != count:
        raise InputError(f"{key} must be a list with one word for each of the {count} edges", where=where)
    for k, word in enumerate(value):
        if word not in allowed:
            raise InputError(f"{key}[{k}] is {repr(word)[:60]}: allowed are {', '.join(allowed)}", where=where)
    return tuple(value)
