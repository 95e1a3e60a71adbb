"""What is seen in a drawing: convex facets and the lines on them, in space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.origami.pattern import Pattern
from inverse.pictures import drawing
from inverse.pictures.camera import basis

NONE = -1


@dataclass(frozen=True, eq=False)
class Body:
    """Convex facets and lines.

    Attributes:
        polygons: corners of each facet, (k, 3).
        edges: (S, 2, 3) ends of the lines.
        sides: (S, 2) int, the facets on both sides of each line, ``NONE`` where there is none.
    """

    polygons: tuple[FloatArray, ...]
    edges: FloatArray
    sides: IntArray

    @property
    def points(self) -> FloatArray:
        """(N, 3) corners of all facets."""
        return np.concatenate(self.polygons) if self.polygons else np.zeros((0, 3))

    def seen(self, view: FloatArray) -> Body:
        """The same in coordinates of a viewer: to the right, up and towards him are the rows of ``view`` (3, 3)."""
        return Body(tuple(polygon @ view.T for polygon in self.polygons), self.edges @ view.T, self.sides)

    def behind(self, depth: float) -> Body:
        """What is left of a seen body behind a plane across the line of sight."""
        kept = [_clipped(polygon, depth) for polygon in self.polygons]
        number = np.cumsum([len(one) > 2 for one in kept]) - 1
        there = np.array([len(one) > 2 for one in kept] + [False])
        number = np.append(number, NONE)
        a, b = self.edges[:, 0], self.edges[:, 1]
        step = b[:, 2] - a[:, 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            cut = np.where(step != 0, (depth - a[:, 2]) / step, 0.0)
        start = np.where(a[:, 2] > depth, cut, 0.0)[:, None]
        end = np.where(b[:, 2] > depth, cut, 1.0)[:, None]
        left = (a[:, 2] <= depth) | (b[:, 2] < depth)
        edges = np.stack([a + start * (b - a), a + end * (b - a)], axis=1)[left]
        sides = np.where(there[self.sides], number[self.sides], NONE)[left]
        return Body(tuple(one for one in kept if len(one) > 2), edges, sides)

    def cut(self, depth: float) -> FloatArray:
        """Where a plane across the line of sight cuts the facets of a seen body, (N, 2, 2)."""
        found = []
        for polygon in self.polygons:
            after = np.roll(polygon, -1, axis=0)
            across = (polygon[:, 2] > depth) != (after[:, 2] > depth)
            if across.sum() == 2:
                p, q = polygon[across], after[across]
                share = (depth - p[:, 2]) / (q[:, 2] - p[:, 2])
                found.append((p + share[:, None] * (q - p))[:, :2])
        return np.array(found).reshape(-1, 2, 2)


def body_of(pattern: Pattern, points: FloatArray) -> Body:
    """A mesh, with vertices (V, 3)."""
    polygons = tuple(points[list(face)] for face in pattern.faces_vertices)
    return Body(polygons, points[pattern.edges_vertices], pattern.edges_faces)


def solid(vertices: FloatArray, triangles: IntArray) -> Body:
    """Buildings: triangles (T, 3) of vertices (V, 3), with the lines where their surfaces meet."""
    lines = drawing.buildings(vertices, triangles, basis(0.3, 0.3))[1]
    edges = lines.points[lines.ends]
    return Body(tuple(vertices[triangles]), edges, np.full((len(edges), 2), NONE))


def together(bodies: Sequence[Body]) -> Body:
    """Several bodies as one."""
    starts = np.cumsum([0, *(len(body.polygons) for body in bodies)])
    sides = [
        np.where(body.sides < 0, NONE, body.sides + start) for body, start in zip(bodies, starts[:-1], strict=True)
    ]
    polygons = tuple(polygon for body in bodies for polygon in body.polygons)
    return Body(polygons, np.concatenate([body.edges for body in bodies]), np.concatenate(sides))


def normals(polygons: Sequence[FloatArray]) -> FloatArray:
    """(F, 3) normals of nearly flat polygons, as long as twice their area."""
    sums = np.zeros((len(polygons), 3))
    for count in {len(polygon) for polygon in polygons}:
        these = [f for f, polygon in enumerate(polygons) if len(polygon) == count]
        corners = np.array([polygons[f] for f in these])
        corners = corners - corners[:, :1]
        sums[these] = np.cross(corners, np.roll(corners, -1, axis=1)).sum(axis=1)
    return sums


def _clipped(polygon: FloatArray, depth: float) -> FloatArray:
    """The part of a convex polygon (k, 3) up to a depth, (m, 3)."""
    below = polygon[:, 2] <= depth
    if below.all():
        return polygon
    found: list[FloatArray] = []
    for p, q, here, there in zip(
        polygon, np.roll(polygon, -1, axis=0), below, np.roll(below, -1), strict=True
    ):  # fmt: skip
        if here:
            found.append(p)
        if here != there:
            found.append(p + (depth - p[2]) / (q[2] - p[2]) * (q - p))
    return np.array(found).reshape(-1, 3)
