"""The extended developed state taken apart into flat pieces, none of which lies over itself."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.fabricate.extras import needed
from inverse.fabricate.units import millimetres
from inverse.origami import geometry
from inverse.origami.pattern import Design, Pattern
from inverse.pictures.sheets import Sheet, lay_out

OVERLAP = 1e-9  # of a piece's area
TRUE = 1e-6  # of the mean edge: by how much a drawing may differ from the design
SIZES = 1e-3, 1e9  # mm, of the mean edge: beyond, places in a drawing have no 9 digits, or overlap cannot be told


@dataclass(frozen=True, eq=False)
class Piece:
    """A flat piece of the developed state, its top side up.

    Attributes:
        faces: its facets.
        places: (2,) in mm of each of its vertices.
    """

    faces: tuple[int, ...]
    places: dict[int, FloatArray]

    def polygon(self, vertices: tuple[int, ...]) -> FloatArray:
        """(k, 2) places of some of its vertices."""
        return np.array([self.places[v] for v in vertices])


def pieces_of(design: Design, scale: float) -> list[Piece]:
    """Pieces to be cut, in the order of their first facets.

    Facets that foldlines join make one piece. Where that would lie over itself, as a strongly curved sheet may, it is
    cut further: facets join their neighbours one after the other as long as there is room.

    Args:
        design: the design.
        scale: of the model, 1 for full size; a design without a unit is taken as millimetres.

    Raises:
        InputError: the scale is not positive; the design cannot be developed; shapely is missing.
    """
    return [piece for sheet in to_scale(design, lay_out(design), scale) for piece in _without_overlap(design, sheet)]


def edges_of(pattern: Pattern, pieces: list[Piece]) -> list[list[int]]:
    """Edges of every piece, ascending."""
    piece_of = {f: k for k, piece in enumerate(pieces) for f in piece.faces}
    found: list[list[int]] = [[] for _ in pieces]
    for edge, faces in enumerate(pattern.edges_faces.tolist()):
        for k in {piece_of[f] for f in faces if f >= 0}:
            found[k].append(edge)
    return found


def to_scale(design: Design, sheets: list[Sheet], scale: float) -> list[Sheet]:
    """Sheets of the developed state in mm of the model.

    Args:
        design: the design.
        sheets: in its unit.
        scale: of the model, 1 for full size.

    Raises:
        InputError: the scale is not positive, or makes edges too short or too long to be drawn; the design cannot be
            developed, so that the sheets are not true.
    """
    if not (np.isfinite(scale) and scale > 0):
        raise InputError(f"the scale is {scale:g}: it must be greater than 0", hint="0.1 makes a model of 1 : 10.")
    _check_true(design, sheets)
    factor = scale * millimetres(design.unit)
    with np.errstate(over="ignore"):
        mean = factor * float(geometry.edge_lengths(design.pattern, design.vertices_coords).mean())
    if not SIZES[0] <= mean <= SIZES[1]:
        raise InputError(
            f"at the scale {scale:g} edges are {mean:.3g} mm long: {SIZES[0]:g} to {SIZES[1]:g} mm can be drawn",
            hint="Give another --scale; 0.1 makes a model of 1 : 10.",
        )
    return [replace(sheet, points=factor * sheet.points) for sheet in sheets]


def _check_true(design: Design, sheets: list[Sheet]) -> None:
    """Edges, and chords between the neighbours of a facet's corner, are as long as in the design."""
    pattern, points = design.pattern, design.vertices_coords
    mean = float(geometry.edge_lengths(pattern, points).mean())
    for sheet in sheets:
        corners = pattern.corners[np.isin(pattern.corners[:, 0], sheet.faces)]
        for ends in (corners[:, [2, 3]], corners[:, [1, 3]]):
            wrong = np.abs(_lengths(sheet.place_of(ends)) - _lengths(points[ends])) / mean
            worst = int(np.argmax(wrong))
            if not wrong[worst] <= TRUE:
                raise InputError(
                    f"the developed state tears: facet {corners[worst, 0]} is off by {wrong[worst]:.2g} mean edges",
                    hint="`inverse check` says which condition fails; `inverse repair` moves a pattern.",
                )


def _lengths(ends: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1))


def _without_overlap(design: Design, sheet: Sheet) -> list[Piece]:
    shapely = needed("shapely")
    faces_vertices = design.pattern.faces_vertices
    places = dict(zip(sheet.vertices.tolist(), sheet.points, strict=True))
    outlines = {f: shapely.Polygon([places[v] for v in faces_vertices[f]]) for f in sheet.faces.tolist()}
    whole = shapely.union_all(list(outlines.values()))
    area = sum(outline.area for outline in outlines.values())
    if area - whole.area <= OVERLAP * area:
        return [_piece(design, tuple(outlines), places)]
    neighbours = _neighbours(design, sheet.faces)
    left, found = list(outlines), []
    while left:
        taken, covered = [left[0]], outlines[left[0]]
        queue = deque(taken)
        while queue:
            for other in neighbours[queue.popleft()]:
                is_new = other in left and other not in taken
                if is_new and covered.intersection(outlines[other]).area <= OVERLAP * outlines[other].area:
                    taken.append(other)
                    covered = covered.union(outlines[other])
                    queue.append(other)
        found.append(_piece(design, tuple(sorted(taken)), places))
        left = [f for f in left if f not in taken]
    return found


def _neighbours(design: Design, faces: IntArray) -> dict[int, list[int]]:
    found: dict[int, list[int]] = {f: [] for f in faces.tolist()}
    for a, b in design.pattern.edges_faces[design.pattern.interior_edges].tolist():
        if a in found and b in found:
            found[a].append(b)
            found[b].append(a)
    return found


def _piece(design: Design, faces: tuple[int, ...], places: dict[int, FloatArray]) -> Piece:
    used = sorted({v for f in faces for v in design.pattern.faces_vertices[f]})
    return Piece(faces, {v: places[v] for v in used})
