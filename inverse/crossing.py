"""Facets that pass through each other, by exact predicates (libigl).

libigl decides exactly for triangles without common vertices. For those with a common vertex it compares with absolute
tolerances, which say nothing far from the origin or at small scale: there the facets' corners decide, exactly as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import combinations

import numpy as np

from inverse._types import BoolArray, FloatArray, IntArray

Faces = tuple[tuple[int, ...], ...]


def triangles_of(faces_vertices: Sequence[Sequence[int]]) -> tuple[IntArray, IntArray]:
    """Fans of triangles, (T, 3) int, and the facet of each, (T,) int, of convex facets."""
    rows = [
        (face[0], face[k], face[k + 1], f) for f, face in enumerate(faces_vertices) for k in range(1, len(face) - 1)
    ]
    table = np.array(rows, np.int64)
    return np.ascontiguousarray(table[:, :3]), table[:, 3]


def crossing_facets(points: FloatArray, faces_vertices: Sequence[Sequence[int]]) -> IntArray:
    """Pairs of facets that intersect in more than a common edge or vertex, touching ones included.

    The answer is exact for the given numbers at any distance from the origin and at any scale, up to the facets'
    own deviation from planes; facets with a common edge count once they are folded onto each other to 1e-8 rad.

    Args:
        points: (V, 3) vertices.
        faces_vertices: convex facets that turn at every corner.

    Returns:
        (N, 2) int, each pair once, the smaller facet first.
    """
    import igl.predicates  # loaded when used: the package itself must import fast

    faces = tuple(map(tuple, faces_vertices))
    triangles, facet = _fans(faces)
    # The predicates are exact unless products underflow. A power of two costs no digits, and that is all it takes:
    # they work on differences, so that nothing need be centred.
    _, exponent = np.frexp(np.abs(points).max(initial=0.0))
    scaled = np.ascontiguousarray(np.ldexp(points, -exponent), np.float64)

    _, pairs, _ = igl.predicates.find_self_intersections(scaled, triangles)
    pairs = pairs.reshape(-1, 2)
    n_common = (triangles[pairs[:, 0], :, None] == triangles[pairs[:, 1], None, :]).sum(axis=(1, 2))
    facets = np.sort(facet[pairs[n_common != 1]], axis=1)
    # The two halves of one quad, planar to rounding only, may seem to cross along their diagonal.
    facets = facets[facets[:, 0] != facets[:, 1]]

    corners, at_vertex, overlapping = _neighbours(faces)
    overlapping = np.concatenate([at_vertex[_corners_cross(scaled, corners)], overlapping])
    return np.asarray(np.unique(np.concatenate([facets, overlapping]), axis=0))


@lru_cache(maxsize=4)
def _fans(faces: Faces) -> tuple[IntArray, IntArray]:
    return triangles_of(faces)


@lru_cache(maxsize=4)
def _neighbours(faces: Faces) -> tuple[IntArray, IntArray, IntArray]:
    """Facets with common vertices that are no neighbours across an edge.

    Returns:
        (N, 5) int: a vertex that is all that two facets have in common, the ends of the first facet's edges from
        there and those of the second's.
        (N, 2) int: these facets, the smaller one first.
        (M, 2) int: facets with more in common than an edge. Convex ones overlap between these vertices.
    """
    facets_at: dict[int, list[int]] = {}
    for f, face in enumerate(faces):
        for v in face:
            facets_at.setdefault(v, []).append(f)
    common: dict[tuple[int, int], list[int]] = {}
    for v, around in facets_at.items():
        for f, g in combinations(around, 2):
            common.setdefault((f, g), []).append(v)
    corners, at_vertex, overlapping = [], [], []
    for (f, g), vertices in common.items():
        if len(vertices) == 1:
            corners.append((vertices[0], *_beside(faces[f], vertices[0]), *_beside(faces[g], vertices[0])))
            at_vertex.append((f, g))
        elif len(vertices) > 2 or any(vertices[1] not in _beside(faces[k], vertices[0]) for k in (f, g)):
            overlapping.append((f, g))
    return (
        np.array(corners, np.int64).reshape(-1, 5),
        np.array(at_vertex, np.int64).reshape(-1, 2),
        np.array(overlapping, np.int64).reshape(-1, 2),
    )


def _beside(face: tuple[int, ...], vertex: int) -> tuple[int, int]:
    k = face.index(vertex)
    return face[k - 1], face[(k + 1) % len(face)]


def _corners_cross(points: FloatArray, corners: IntArray) -> BoolArray:
    """Whether two facets with one common vertex share more than it, (N,) for corners (N, 5).

    Being convex they do if, and only if, their corners share a ray. With [a b c] for the determinant of three edges
    from the vertex, the planes of corners a, b and c, d meet in the line along

        [a b d] c - [a b c] d = [c d a] b - [c d b] a.

    The left side lies in one corner, or opposite to it, where the two factors differ in sign, and so the right side.
    """
    import igl.predicates

    vertex, a, b, c, d = (np.ascontiguousarray(points[column]) for column in corners.T)
    orient = igl.predicates.orient3d
    cda, cdb = (np.ravel(orient(c, d, x, vertex)) for x in (a, b))
    abc, abd = (np.ravel(orient(a, b, x, vertex)) for x in (c, d))
    meet = np.zeros(len(corners), bool)
    for sign in (1, -1):
        meet |= (sign * cda >= 0) & (sign * cdb <= 0) & (sign * abc <= 0) & (sign * abd >= 0)
    # Where only two vanish, one corner has no area.
    in_plane = (cda == 0) & (cdb == 0) & (abc == 0) & (abd == 0)
    meet &= in_plane | (((cda != 0) | (cdb != 0)) & ((abc != 0) | (abd != 0)))
    meet[in_plane] = _flat_corners_cross(*(x[in_plane] for x in (vertex, a, b, c, d)))
    return meet


def _flat_corners_cross(vertex: FloatArray, a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> BoolArray:
    """The same for corners in one plane, each (N, 3): an edge of one lies within the other."""
    import igl.predicates

    # Seen along the axis nearest to the plane's normal; the signs of tetrahedra are then those of triangles.
    axis = np.abs(np.cross(a - vertex, b - vertex)).argmax(axis=1)[:, None]
    apex = np.zeros_like(vertex)
    for flat in (vertex, a, b, c, d):
        np.put_along_axis(flat, axis, 0.0, axis=1)
    np.put_along_axis(apex, axis, 1.0, axis=1)

    def turn(p: FloatArray, q: FloatArray) -> IntArray:
        return np.ravel(igl.predicates.orient3d(vertex, p, q, apex))

    def within(x: FloatArray, p: FloatArray, q: FloatArray) -> BoolArray:
        side = turn(p, q)
        return np.asarray((side != 0) & (side * turn(p, x) >= 0) & (side * turn(x, q) >= 0))

    return within(c, a, b) | within(d, a, b) | within(a, c, d) | within(b, c, d)
