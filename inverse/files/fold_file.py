"""Designs as FOLD 1.2 files, written so that other programs read them too."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.files.atomic import write_atomically
from inverse.files.fold_format import FoldFrame, frame_of, read_frame
from inverse.limits import check_extent
from inverse.origami import folding, geometry
from inverse.origami.holes import hole_strips
from inverse.origami.pattern import EDGE_TYPE_NAMES, B, Design, Pattern


def document(design: Design) -> dict[str, Any]:
    """The FOLD document of a design: the design state as root frame, the two flat states as further frames."""
    root = _root(design, geometry.fold_angles(design.pattern, design.vertices_coords))
    root["file_frames"] = [_flat_frame(design, "developed", 0.0), _flat_frame(design, "flat-folded", np.pi)]
    return root


def frame(design: Design) -> FoldFrame:
    """What a design's file would say, for the certificate: the same as writing and reading it.

    Raises:
        InputError: coordinates that no file can hold.
    """
    return frame_of(document(design))


def state_document(design: Design, t: float, vertices_coords: FloatArray) -> dict[str, Any]:
    """The FOLD document of one state of a design's motion, a single frame.

    Mountains and valleys are those of the design, in the flat states too. These lie in the plane z = 0 and have two
    coordinates.

    Args:
        design: the mesh in its design state.
        t: the folding amount in radians.
        vertices_coords: (V, 3) vertices of an intermediate state, wherever it is to stand.
    """
    state = _root(design, folding.fold_angles_at(design, np.array([t]))[0])
    title = f"t = {np.degrees(t):g} degrees"
    if t in (0.0, np.pi):
        flat = folding.flat_state(design, t)[:, :2].tolist()
        return state | {"frame_title": title, "frame_attributes": ["2D", "orientable"], "vertices_coords": flat}
    return state | {"frame_title": title, "vertices_coords": vertices_coords.tolist()}


def _root(design: Design, fold_angles: FloatArray) -> dict[str, Any]:
    """The design state as root frame, but with these fold angles, (E,) in radians."""
    pattern = design.pattern
    valley = geometry.fold_angles(pattern, design.vertices_coords) > 0
    assignment = np.where(pattern.edges_type == B, "B", np.where(valley, "V", "M"))
    root: dict[str, Any] = {
        "file_spec": 1.2,
        "file_creator": "inverse",
        "file_title": design.name,
        "file_classes": ["singleModel"],
        "frame_title": "design",
        "frame_classes": ["foldedForm"],
        "frame_attributes": ["3D", "orientable"],
        "frame_unit": design.unit,
        "vertices_coords": design.vertices_coords.tolist(),
        "edges_vertices": pattern.edges_vertices.tolist(),
        "edges_assignment": assignment.tolist(),
        "edges_foldAngle": np.degrees(fold_angles).tolist(),
        "faces_vertices": [list(face) for face in pattern.faces_vertices],
        "bdffpq:edges_type": [EDGE_TYPE_NAMES[t] for t in pattern.edges_type],
        "bdffpq:topology": pattern.topology,
        "bdffpq:holes": [list(strip) for strip in hole_strips(pattern)],
    }
    if pattern.grid is not None:
        root["bdffpq:grid"] = list(pattern.grid)
    return root


def write(design: Design, path: Path | str) -> None:
    """Write a design file, whole or not at all; coordinates keep every bit.

    Args:
        design: the mesh in its design state.
        path: the file, replaced if it is there.
    """
    write_atomically(Path(path), json.dumps(document(design), allow_nan=False) + "\n")


def read(path: Path | str) -> Design:
    """Read a design file; :func:`write` followed by :func:`read` gives the same design.

    Args:
        path: a FOLD file of this kind.

    Returns:
        The design.

    Raises:
        InputError: the file is not a valid design, see :func:`inverse.files.fold_format.read_frame` and
            :meth:`inverse.origami.pattern.Pattern.from_faces`.
    """
    frame = read_frame(Path(path))
    try:
        return _design(frame)
    except InputError as error:
        raise InputError(error.message, where=str(path), hint=error.hint) from None


def _design(frame: FoldFrame) -> Design:
    words = {
        frozenset(pair): EDGE_TYPE_NAMES.index(word)
        for pair, word in zip(frame.edges_vertices.tolist(), frame.edges_type, strict=True)
    }

    def types(edges: IntArray) -> np.ndarray:
        found = []
        for pair in edges.tolist():
            kind = words.get(frozenset(pair), B)
            if kind == B:
                raise InputError(f"interior edge {pair[0]}-{pair[1]} has no type: FL or CFL is needed")
            found.append(kind)
        return np.array(found, np.int8)

    pattern = Pattern.from_faces(frame.faces_vertices, len(frame.vertices_coords), types)
    if (grid := frame.document.get("bdffpq:grid")) is not None:
        pattern = replace(pattern, grid=_grid(grid, pattern))
    points = frame.vertices_coords
    check_extent(points[pattern.corners[:, 2]], "the design", None)
    _check_areas(pattern, points)
    unit, title = frame.document.get("frame_unit", "unit"), frame.document.get("file_title", "design")
    return Design(pattern, points, str(unit), str(title))


def _check_areas(pattern: Pattern, points: FloatArray) -> None:
    """Refuse facets without a plane: nothing can be folded or drawn with them."""
    face, _, vertex, following = pattern.corners.T
    n_faces = len(pattern.faces_vertices)
    middles = geometry.facet_centroids(pattern, points)[face]
    doubled, reach = np.zeros((n_faces, 3)), np.zeros(n_faces)
    np.add.at(doubled, face, np.cross(points[vertex] - middles, points[following] - middles))
    np.maximum.at(reach, face, np.linalg.norm(points[vertex] - middles, axis=1))
    flat = ~(np.linalg.norm(doubled, axis=1) > 1e-12 * reach**2)
    if flat.any():
        f = int(np.argmax(flat))
        raise InputError(f"facet {f} with vertices {list(pattern.faces_vertices[f])[:8]} has no area")


def _grid(grid: Any, pattern: Pattern) -> tuple[int, int]:
    """The size that a file claims, if its facets are numbered as the format says."""
    if not (isinstance(grid, list) and len(grid) == 2 and all(type(k) is int and k > 0 for k in grid)):
        raise InputError(f"bdffpq:grid is {grid!r}: two positive whole numbers [m, n] are needed")
    m, n = grid
    wrong = InputError(
        f"bdffpq:grid is [{m}, {n}], but the facets are not those of such a grid",
        hint="Number vertices (i, j) -> i (n+1) + j and facets (i, j) -> i n + j, or leave the key out.",
    )
    if m * n != len(pattern.faces_vertices):
        raise wrong
    i, j = (k.ravel() for k in np.meshgrid(np.arange(m), np.arange(n), indexing="ij"))
    there = (i + 1) % m if pattern.n_holes else i + 1
    expected = np.stack([i * (n + 1) + j, there * (n + 1) + j, there * (n + 1) + j + 1, i * (n + 1) + j + 1], axis=1)
    facets = zip(pattern.faces_vertices, expected.tolist(), strict=True)
    if not all(set(face) == set(vertices) for face, vertices in facets):
        raise wrong
    return m, n


def _flat_frame(design: Design, title: str, t: float) -> dict[str, Any]:
    angles = np.degrees(folding.fold_angles_at(design, np.array([t]))[0])
    return {
        "frame_title": title,
        "frame_classes": ["foldedForm"],
        "frame_attributes": ["2D"],
        "frame_parent": 0,
        "frame_inherit": True,
        "vertices_coords": folding.flat_state(design, t)[:, :2].tolist(),
        "edges_foldAngle": angles.tolist(),
    }
