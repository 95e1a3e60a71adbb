"""Flaps along seams: trapezoids on one side of each, by which two pieces are glued together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from inverse._types import FloatArray
from inverse.fabricate.cut.pieces import OVERLAP, Piece, edges_of
from inverse.fabricate.extras import needed
from inverse.origami.pattern import Pattern

_TAPER = np.pi / 4
_OUTER = 1 / 3  # least length of the outer side, of the edge
_SHALLOW = 0.02  # a flap less deep than this share of its edge is left out,
_LESS = 0.25  # unless it is deeper than this share of what is asked for
_SHARE = 0.45  # of the free angle at a vertex, so that two flaps have room in it


@dataclass(frozen=True, eq=False)
class Flap:
    """A trapezoid beside a piece.

    Attributes:
        piece: number of the piece that it belongs to.
        edge: number of the seam's edge in the design.
        outline: (4, 2) in mm, where the piece is; the seam's edge is between its last and first corner.
    """

    piece: int
    edge: int
    outline: FloatArray


def flaps_along(pattern: Pattern, pieces: list[Piece], edges: list[int], depth: float) -> list[Flap]:
    """One flap for every edge of a seam, on the side where it can be deeper; of equal ones at the edge's left facet.

    A flap is tapered by 45 degrees, or less where the free angle at a vertex is narrow, and less deep where it would
    lie over facets or other flaps of its piece. An edge that has no room on either side gets none.

    Args:
        pattern: of the design.
        pieces: of its developed state.
        edges: of the seams.
        depth: in mm.

    Raises:
        InputError: shapely is missing.
    """
    piece_of = {f: k for k, piece in enumerate(pieces) for f in piece.faces}
    own = (pattern.edges_vertices[edges] for edges in edges_of(pattern, pieces))
    rooms = [_Room(pattern, piece, ends.tolist()) for piece, ends in zip(pieces, own, strict=True)]
    found = []
    for edge in edges:
        left, right = (piece_of[f] for f in pattern.edges_faces[edge].tolist())
        tail, head = pattern.edges_vertices[edge].tolist()
        tried = [(rooms[k].deepest(ends, depth), k, ends) for k, ends in ((left, (tail, head)), (right, (head, tail)))]
        reached, piece, ends = tried[1] if tried[1][0] > tried[0][0] * (1 + 1e-6) else tried[0]
        if reached > 0:
            found.append(Flap(piece, edge, rooms[piece].take(ends, reached)))
    return found


class _Room:
    """What is free around a piece."""

    def __init__(self, pattern: Pattern, piece: Piece, edges: list[list[int]]) -> None:
        self._shapely = needed("shapely")
        self._places = piece.places
        outlines = [self._shapely.Polygon(piece.polygon(pattern.faces_vertices[f])) for f in piece.faces]
        self._facets = self._shapely.STRtree(outlines)
        self._flaps: list[Any] = []
        self._neighbours: dict[int, list[int]] = {v: [] for v in piece.places}
        for a, b in edges:
            self._neighbours[a].append(b)
            self._neighbours[b].append(a)

    def deepest(self, ends: tuple[int, int], depth: float) -> float:
        """How deep a flap can be, the piece on the left of the edge; 0 for none."""
        length = float(np.linalg.norm(self._places[ends[1]] - self._places[ends[0]]))
        tapers = self._tapers(ends)
        least = min(_SHALLOW * length, _LESS * depth)
        depth = min(depth, (1 - _OUTER) * length / float((1 / np.tan(tapers)).sum()))
        while depth >= least:
            if self._is_free(self._shapely.Polygon(self._trapezoid(ends, depth, tapers))):
                return depth
            depth *= 0.9
        return 0.0

    def take(self, ends: tuple[int, int], depth: float) -> FloatArray:
        """The outline of a flap, (4, 2), for which there is no room afterwards."""
        outline = self._trapezoid(ends, depth, self._tapers(ends))
        self._flaps.append(self._shapely.Polygon(outline))
        return outline

    def _trapezoid(self, ends: tuple[int, int], depth: float, tapers: FloatArray) -> FloatArray:
        a, b = (self._places[v] for v in ends)
        along = (b - a) / np.linalg.norm(b - a)
        outwards = depth * np.array([along[1], -along[0]])
        at_a, at_b = depth / np.tan(tapers)
        return np.array([b, b + outwards - at_b * along, a + outwards + at_a * along, a])

    def _tapers(self, ends: tuple[int, int]) -> FloatArray:
        """Angles between the edge and the flap's sides at its ends, (2,)."""
        a, b = ends
        return np.minimum(_TAPER, _SHARE * np.array([self._free_angle(a, b, -1), self._free_angle(b, a, 1)]))

    def _free_angle(self, at: int, towards: int, way: int) -> float:
        """Angle at a vertex from an edge to the next one of the piece, counter-clockwise (1) or clockwise (-1)."""
        others = [v for v in self._neighbours[at] if v != towards]
        x, y = (np.array([self._places[v] for v in [towards, *others]]) - self._places[at]).T
        angles = np.arctan2(y, x)
        return float((way * (angles[1:] - angles[0]) % (2 * np.pi)).min())

    def _is_free(self, flap: Any) -> bool:
        near = [*self._facets.geometries[self._facets.query(flap, predicate="intersects")], *self._flaps]
        common = self._shapely.area(self._shapely.intersection(near, flap))
        return bool((common <= OVERLAP / 10 * flap.area).all())
