"""Facets that pass through each other, by exact predicates (libigl)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

FAR = 100.0  # sizes of the mesh from the origin


def triangles_of(faces_vertices: Sequence[Sequence[int]]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Fans of triangles, (T, 3) int, and the facet of each, (T,) int, of convex facets."""
    rows = [
        (face[0], face[k], face[k + 1], f) for f, face in enumerate(faces_vertices) for k in range(1, len(face) - 1)
    ]
    table = np.array(rows, np.int64)
    return np.ascontiguousarray(table[:, :3]), table[:, 3]


def crossing_facets(points: NDArray[np.float64], faces_vertices: Sequence[Sequence[int]]) -> NDArray[np.int64]:
    """Pairs of facets that intersect in more than a common edge or vertex.

    Args:
        points: (V, 3) vertices.
        faces_vertices: convex facets.

    Returns:
        (N, 2) int, each pair once, the smaller facet first.
    """
    import igl.predicates  # loaded when used: the package itself must import fast

    triangles, facet = triangles_of(faces_vertices)
    points = np.ascontiguousarray(points, np.float64)
    size = float(np.ptp(points, axis=0).max())
    if np.abs(points[0]).max() > FAR * size > 0:
        # Small beside their coordinates, as in a file that is normalized, facets that only meet seem to cross. Both
        # the difference and the power of two are exact.
        points = np.ldexp(points - points[0], -int(np.frexp(size)[1]))
    found, pairs, _ = igl.predicates.find_self_intersections(points, triangles)
    if not found:
        return np.empty((0, 2), np.int64)
    facets = np.sort(facet[pairs], axis=1)
    # The two halves of one quad, planar to rounding only, may seem to cross along their diagonal.
    return np.asarray(np.unique(facets[facets[:, 0] != facets[:, 1]], axis=0))
