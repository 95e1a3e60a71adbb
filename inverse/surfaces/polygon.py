"""Polygons in a plane: which are simple, what lies within them, triangles that fill them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import Delaunay, cKDTree

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError


def checked(polygon: FloatArray, what: str) -> FloatArray:
    """A polygon (n, 2) counter-clockwise.

    Args:
        polygon: corners, the first not repeated.
        what: what it is, for messages.

    Raises:
        InputError: it has no area, or two sides meet.
    """
    following = np.roll(polygon, -1, axis=0)
    doubled = float((polygon[:, 0] * following[:, 1] - polygon[:, 1] * following[:, 0]).sum())
    size = float(np.ptp(polygon, axis=0).max())
    n, steps = len(polygon), following - polygon
    short = np.flatnonzero(np.linalg.norm(steps, axis=1) <= 1e-9 * size)
    if len(short):
        raise InputError(f"corners {short[0]} and {(short[0] + 1) % n} of {what} coincide (counted from 0)")
    for i in range(n - 2):
        j = np.arange(i + 2, n - (i == 0))
        apart, step, others = polygon[j] - polygon[i], steps[i], steps[j]
        turn = step[0] * others[:, 1] - step[1] * others[:, 0]
        turn = np.where(np.abs(turn) < 1e-12 * size**2, np.nan, turn)  # parallel
        a = (apart[:, 0] * others[:, 1] - apart[:, 1] * others[:, 0]) / turn
        b = (apart[:, 0] * step[1] - apart[:, 1] * step[0]) / turn
        meets = (a >= 0) & (a <= 1) & (b >= 0) & (b <= 1)
        if meets.any():
            raise InputError(f"sides {i} and {j[np.argmax(meets)]} of {what} meet (counted from 0)")
    if abs(doubled) < 1e-6 * size**2:
        raise InputError(f"{what} has no area")
    return polygon if doubled > 0 else polygon[::-1]


def within(points: FloatArray, polygon: FloatArray) -> NDArray[np.bool_]:
    """Whether points (N, 2) lie in a polygon (n, 2), by how often a ray meets its sides."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    x, y = points[:, 0, None], points[:, 1, None]
    spans = (a[:, 1] > y) != (b[:, 1] > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        meets = a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    return np.asarray((spans & (x < meets)).sum(axis=1) % 2 == 1)


def filled(rim: FloatArray, spacing: float) -> tuple[FloatArray, IntArray]:
    """Places within a polygon, and triangles of its corners and them.

    Args:
        rim: (n, 2) corners, which stay the only ones on the border.
        spacing: of the places, about.

    Returns:
        Places (k, 2), and triangles (T, 3) that number the corners first.
    """
    low, high = rim.min(axis=0), rim.max(axis=0)
    counts = np.maximum(np.ceil((high - low) / spacing).astype(int), 1)
    sides = [np.linspace(a, b, k + 1)[1:-1] for a, b, k in zip(low, high, counts, strict=True)]
    plan = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 2)
    plan = plan[within(plan, rim)]
    # Not so near to the border that triangles would cross it.
    plan = plan[cKDTree(rim).query(plan)[0] > 0.6 * spacing] if len(plan) else plan
    whole = np.concatenate([rim, plan])
    cells = Delaunay(whole).simplices
    return plan, np.asarray(cells[within(whole[cells].mean(axis=1), rim)], np.int64)


def divided(polygon: FloatArray, spacing: float) -> FloatArray:
    """The polygon with places between its corners, no farther from each other than a spacing."""
    parts = []
    for a, b in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        count = max(int(np.ceil(float(np.linalg.norm(b - a)) / spacing - 1e-9)), 1)
        parts.append(a + np.arange(count)[:, None] / count * (b - a))
    return np.concatenate(parts)
