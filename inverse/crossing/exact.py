"""Facets that pass through each other, by exact predicates (libigl).

libigl decides exactly for triangles without common vertices. For those with a common vertex it compares with absolute
tolerances, which say nothing far from the origin or at small scale: there the facets' corners decide, exactly as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from inverse._types import BoolArray, FloatArray, IntArray
from inverse.crossing.neighbours import Faces, neighbours


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
    faces = tuple(map(tuple, faces_vertices))
    scaled = below_one(points)
    facets = _crossing_triangles(scaled, *_fans(faces))
    known = neighbours(faces)
    overlapping = np.concatenate([known.at_vertex[corners_cross(scaled, known.corners)], known.overlapping])
    return np.asarray(np.unique(np.concatenate([facets, overlapping]), axis=0))


def triangles_cross(points: FloatArray, faces: Faces, facets: IntArray) -> bool:
    """Whether any of some facets (N,) cross each other; not looked at is what only one vertex in common says.

    Args:
        points: (V, 3) vertices, coordinates below 1.
        faces: all facets.
        facets: numbers of those that are looked at.
    """
    triangles, facet = _fans(faces)
    own = np.isin(facet, facets)
    return len(_crossing_triangles(points, triangles[own], facet[own])) > 0


def _crossing_triangles(points: FloatArray, triangles: IntArray, facet: IntArray) -> IntArray:
    """Pairs of facets (N, 2), some repeated, whose triangles (T, 3) cross, but for those with one common vertex."""
    import igl.predicates  # loaded when used: the package itself must import fast

    _, pairs, _ = igl.predicates.find_self_intersections(points, triangles)
    pairs = pairs.reshape(-1, 2)
    n_common = (triangles[pairs[:, 0], :, None] == triangles[pairs[:, 1], None, :]).sum(axis=(1, 2))
    facets = np.sort(facet[pairs[n_common != 1]], axis=1)
    # The two halves of one quad, planar to rounding only, may seem to cross along their diagonal.
    return np.asarray(facets[facets[:, 0] != facets[:, 1]])


def below_one(points: FloatArray) -> FloatArray:
    """Points (..., 3) over the power of two that brings all coordinates below 1.

    The predicates are exact unless products underflow. A power of two costs no digits, and that is all it takes: they
    work on differences, so that nothing need be centred.
    """
    _, exponent = np.frexp(np.abs(points).max(initial=0.0))
    return np.ascontiguousarray(np.ldexp(points, -exponent), np.float64)


@lru_cache(maxsize=4)
def _fans(faces: Faces) -> tuple[IntArray, IntArray]:
    return triangles_of(faces)


def corners_cross(points: FloatArray, corners: IntArray) -> BoolArray:
    """Whether two facets with one common vertex share more than it.

    Being convex they do if, and only if, their corners share a ray. With [a b c] for the determinant of three edges
    from the vertex, the planes of corners a, b and c, d meet in the line along

        [a b d] c - [a b c] d = [c d a] b - [c d b] a.

    The left side lies in one corner, or opposite to it, where the two factors differ in sign, and so the right side.

    Args:
        points: (V, 3) vertices, coordinates below 1.
        corners: (N, 5) the vertex, the ends a, b of the first facet's edges from there and c, d of the second's.

    Returns:
        (N,) bool.
    """
    import igl.predicates

    orient = igl.predicates.orient3d
    vertex, a, b, c, d = (points.take(column, axis=0) for column in corners.T)
    abc, abd = (np.ravel(orient(a, b, x, vertex)) for x in (c, d))
    # Most corners lie on one side of the other's plane, and have no line in common.
    meet = (abc != abd) | (abc == 0)
    left = np.flatnonzero(meet)
    vertex, a, b, c, d, abc, abd = (x.take(left, axis=0) for x in (vertex, a, b, c, d, abc, abd))
    cda, cdb = (np.ravel(orient(c, d, x, vertex)) for x in (a, b))
    both = np.zeros(len(left), bool)
    for sign in (1, -1):
        both |= (sign * cda >= 0) & (sign * cdb <= 0) & (sign * abc <= 0) & (sign * abd >= 0)
    # Where only two vanish, one corner has no area.
    in_plane = (cda == 0) & (cdb == 0) & (abc == 0) & (abd == 0)
    both &= in_plane | (((cda != 0) | (cdb != 0)) & ((abc != 0) | (abd != 0)))
    if in_plane.any():
        both[in_plane] = _flat_corners_cross(*(x[in_plane] for x in (vertex, a, b, c, d)))
    meet[left] = both
    return np.asarray(meet)


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
