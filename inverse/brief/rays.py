"""Lines through points, and whether they meet a surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from inverse._types import FloatArray, IntArray
from inverse.surfaces.nearest import Nearest

EDGE = 1e-9  # of a triangle: lines that pass so near to its edge meet it
AT_ONCE = 1_000_000  # pairs of a line and a triangle: bounds the memory


def met(points: FloatArray, directions: FloatArray, surface: Nearest, reach: float) -> NDArray[np.bool_]:
    """Which lines meet a surface near their points.

    Args:
        points: (N, 3).
        directions: (N, 3) unit vectors; both ways are looked.
        surface: the surface.
        reach: how far from its point a line may meet it.

    Returns:
        (N,) bool.
    """
    vertices, triangles = surface.vertices, surface.triangles
    found = np.zeros(len(points), np.bool_)
    for sign in (1.0, -1.0):
        left = np.flatnonzero(~found)
        first = surface.first_met(points[left], sign * directions[left], reach)
        found[left] = _are_met(first, points[left], directions[left], vertices, triangles, reach)
    left = np.flatnonzero(~found)
    found[left] = met_by_any(points[left], directions[left], vertices, triangles, reach)
    return found


def met_from_above(points: FloatArray, surface: Nearest) -> NDArray[np.bool_]:
    """Which of some points (N, 3) have a surface straight above or below, (N,)."""
    up = np.broadcast_to([0.0, 0.0, 1.0], points.shape)
    plan = np.array([1.0, 1.0, 0.0])
    places, vertices, triangles = points * plan, surface.vertices * plan, surface.triangles
    # From below everything, however high the surface is; what is met is then looked at in plan.
    height = surface.vertices[:, 2]
    low = float(height.min()) - max(float(np.ptp(surface.vertices, axis=0).max()), 1e-300)
    first = surface.first_met(places + np.array([0.0, 0.0, low]), up, np.inf)
    found = _are_met(first, places, up, vertices, triangles, 0.0)
    left = np.flatnonzero(~found)
    found[left] = met_by_any(places[left], up[left], vertices, triangles, 0.0)
    return found


def _are_met(
    facet: IntArray, points: FloatArray, directions: FloatArray, vertices: FloatArray, triangles: IntArray, reach: float
) -> NDArray[np.bool_]:
    """Whether lines (N) meet the triangles (N,) that are named for them, -1 for none."""
    found = np.zeros(len(points), np.bool_)
    named = np.flatnonzero(facet >= 0)
    a, b, c = vertices[triangles[facet[named]]].transpose(1, 0, 2)
    found[named] = _meets(points[named], directions[named], a, b - a, c - a, reach)
    return found


def met_by_any(
    points: FloatArray, directions: FloatArray, vertices: FloatArray, triangles: IntArray, reach: float
) -> NDArray[np.bool_]:
    """The same as of :func:`met`, by looking at every triangle that is near to a point.

    Args:
        points: (N, 3).
        directions: (N, 3) unit vectors.
        vertices: (V, 3) of the surface.
        triangles: (T, 3) int.
        reach: how far from its point a line may meet it.
    """
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    centres = (a + b + c) / 3
    radii = np.sqrt(np.max([np.sum((k - centres) ** 2, axis=1) for k in (a, b, c)], axis=0))
    found = np.zeros(len(points), np.bool_)
    if not len(points):
        return found
    p, t = _near(points, centres, (radii + reach) * (1 + 1e-9))
    for some in np.array_split(np.arange(len(p)), max(1, len(p) // AT_ONCE)):
        q, s = p[some], t[some]
        hit = _meets(points[q], directions[q], a[s], b[s] - a[s], c[s] - a[s], reach)
        found[q[hit]] = True
    return found


def _near(points: FloatArray, centres: FloatArray, radii: FloatArray) -> tuple[IntArray, IntArray]:
    """Pairs of points (N, 3) and balls around centres (T, 3) that may hold them, as two arrays of numbers."""
    if len(points) < len(centres):
        near = cKDTree(centres, balanced_tree=False).query_ball_point(points, float(radii.max()))
    else:
        near = cKDTree(points, balanced_tree=False).query_ball_point(centres, radii)
    counts = np.array([len(one) for one in near])
    if not counts.any():
        return np.empty(0, np.int64), np.empty(0, np.int64)
    one = np.repeat(np.arange(len(near)), counts)
    other = np.concatenate([np.asarray(some, np.int64) for some in near if some])
    return (one, other) if len(points) < len(centres) else (other, one)


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
