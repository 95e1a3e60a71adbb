"""Lines through points, and whether they meet a surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from inverse._types import FloatArray, IntArray

EDGE = 1e-9  # of a triangle: lines that pass so near to its edge meet it


def met(
    points: FloatArray, directions: FloatArray, vertices: FloatArray, triangles: IntArray, reach: float
) -> NDArray[np.bool_]:
    """Which lines meet a surface near their points.

    Args:
        points: (N, 3).
        directions: (N, 3) unit vectors; both ways are looked.
        vertices: (V, 3) of the surface.
        triangles: (T, 3) int.
        reach: how far from its point a line may meet it.

    Returns:
        (N,) bool.
    """
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    centres = (a + b + c) / 3
    radii = np.sqrt(np.max([np.sum((k - centres) ** 2, axis=1) for k in (a, b, c)], axis=0))
    found = np.zeros(len(points), np.bool_)
    near = cKDTree(points).query_ball_point(centres, (radii + reach) * (1 + 1e-9))
    counts = np.array([len(one) for one in near])
    if not counts.any():
        return found
    p = np.concatenate([np.asarray(one, np.int64) for one in near if one])
    t = np.repeat(np.arange(len(triangles)), counts)
    for some in np.array_split(np.arange(len(p)), max(1, len(p) // 1_000_000)):
        q, s = p[some], t[some]
        hit = _meets(points[q], directions[q], a[s], b[s] - a[s], c[s] - a[s], reach)
        found[q[hit]] = True
    return found


def _meets(
    p: FloatArray, d: FloatArray, a: FloatArray, e: FloatArray, f: FloatArray, reach: float
) -> NDArray[np.bool_]:
    """Moller and Trumbore's test, for lines (N) and triangles (N) by a corner and two sides."""
    across = np.cross(d, f)
    volume = np.einsum("ij,ij->i", e, across)
    with np.errstate(divide="ignore", invalid="ignore"):
        offset = p - a
        u = np.einsum("ij,ij->i", offset, across) / volume
        beside = np.cross(offset, e)
        v = np.einsum("ij,ij->i", d, beside) / volume
        t = np.einsum("ij,ij->i", f, beside) / volume
        return np.asarray((u >= -EDGE) & (v >= -EDGE) & (u + v <= 1 + EDGE) & (np.abs(t) <= reach))
