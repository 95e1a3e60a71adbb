"""The extended developed state taken apart into flat pieces, none of which lies over itself."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from inverse.errors import InputError
from inverse.fabricate.extras import needed
from inverse.fabricate.units import millimetres
from inverse.pattern import Design, FloatArray, IntArray
from inverse.pictures.sheets import Sheet, lay_out

OVERLAP = 1e-9  # of a piece's area


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
        InputError: the scale is not positive; shapely is missing.
    """
    if not (np.isfinite(scale) and scale > 0):
        raise InputError(f"the scale is {scale:g}: it must be greater than 0", hint="0.1 makes a model of 1 : 10.")
    factor = scale * millimetres(design.unit)
    return [piece for sheet in lay_out(design) for piece in _without_overlap(design, sheet, factor)]


def _without_overlap(design: Design, sheet: Sheet, factor: float) -> list[Piece]:
    shapely = needed("shapely")
    faces_vertices = design.pattern.faces_vertices
    places = dict(zip(sheet.vertices.tolist(), factor * sheet.points, strict=True))
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
