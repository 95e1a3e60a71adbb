"""Which facets have what in common, found once for a list of facets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations

import numpy as np

from inverse._types import IntArray

Faces = tuple[tuple[int, ...], ...]


@dataclass(frozen=True, eq=False)
class Neighbours:
    """Pairs of facets with common vertices, the smaller facet first.

    Attributes:
        corners: (N, 5) int; a vertex that is all that two facets have in common, the ends of the first facet's edges
            from there and those of the second's.
        at_vertex: (N, 2) int; these facets.
        at_edge: (K, 2) int; facets with one common edge, which they run through in opposite directions.
        edges: (K, 2) int; the ends of that edge.
        others: (K, 2, s) int; the other vertices of both facets, repeated where a facet has fewer than another.
        same_way: (L, 2) int; facets with one common edge that both run through in the same direction.
        overlapping: (M, 2) int; facets with more in common than an edge. Convex ones overlap between these vertices.
    """

    corners: IntArray
    at_vertex: IntArray
    at_edge: IntArray
    edges: IntArray
    others: IntArray
    same_way: IntArray
    overlapping: IntArray

    @property
    def pairs(self) -> IntArray:
        """All pairs of facets with common vertices, (P, 2)."""
        return np.concatenate([self.at_vertex, self.at_edge, self.same_way, self.overlapping])


@lru_cache(maxsize=4)
def neighbours(faces: Faces) -> Neighbours:
    """Facets with common vertices, of convex facets."""
    facets_at: dict[int, list[int]] = {}
    for f, face in enumerate(faces):
        for v in face:
            facets_at.setdefault(v, []).append(f)
    common: dict[tuple[int, int], list[int]] = {}
    for v, around in facets_at.items():
        for f, g in combinations(around, 2):
            common.setdefault((f, g), []).append(v)
    corners, at_vertex, at_edge, edges, others, same_way, overlapping = [], [], [], [], [], [], []
    most = max(map(len, faces), default=3)
    for (f, g), vertices in common.items():
        if len(vertices) == 1:
            corners.append((vertices[0], *_beside(faces[f], vertices[0]), *_beside(faces[g], vertices[0])))
            at_vertex.append((f, g))
        elif len(vertices) > 2 or any(vertices[1] not in _beside(faces[k], vertices[0]) for k in (f, g)):
            overlapping.append((f, g))
        elif _follows(faces[f], vertices) == _follows(faces[g], vertices):
            same_way.append((f, g))
        else:
            at_edge.append((f, g))
            edges.append(vertices)
            others.append([_filled([v for v in faces[k] if v not in vertices], most - 2) for k in (f, g)])
    return Neighbours(
        _table(corners, 5), _table(at_vertex, 2), _table(at_edge, 2), _table(edges, 2),
        np.array(others, np.int64).reshape(-1, 2, most - 2), _table(same_way, 2), _table(overlapping, 2),
    )  # fmt: skip


def _beside(face: tuple[int, ...], vertex: int) -> tuple[int, int]:
    k = face.index(vertex)
    return face[k - 1], face[(k + 1) % len(face)]


def _follows(face: tuple[int, ...], vertices: Sequence[int]) -> bool:
    """Whether the second of two neighbouring vertices comes after the first."""
    return face[(face.index(vertices[0]) + 1) % len(face)] == vertices[1]


def _filled(vertices: list[int], count: int) -> list[int]:
    return vertices + vertices[-1:] * (count - len(vertices))


def _table(rows: Sequence[Sequence[int]], width: int) -> IntArray:
    return np.array(rows, np.int64).reshape(-1, width)
