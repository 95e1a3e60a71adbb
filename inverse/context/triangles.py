"""Triangles of polygons with holes, by ear clipping: enough for pictures of buildings, no further library."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from inverse._types import FloatArray, IntArray

# Twice the area of a corner over its longest side squared, below which it counts as straight.
_FLAT = 1e-9


def plane_axes(ring: FloatArray) -> FloatArray:
    """Two orthonormal axes, (2, 3), of the best plane of a ring (n, 3), counter-clockwise in them."""
    edges = np.roll(ring, -1, axis=0) - ring
    normal = np.cross(ring - ring[0], edges).sum(axis=0)
    length = float(np.linalg.norm(normal))
    normal = normal / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    along = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal))])
    along /= np.linalg.norm(along)
    return np.stack([along, np.cross(normal, along)])


def triangulate(rings: Sequence[FloatArray]) -> IntArray:
    """Cuts a polygon with holes into triangles.

    Args:
        rings: the outer ring and then the holes, each (n, 3); nearly planar, in any sense of rotation.

    Returns:
        Triangles, (T, 3), as indices into the rings' points stacked in order, turning as the outer ring does.
    """
    plane = np.concatenate(rings) @ plane_axes(rings[0]).T
    starts = np.cumsum([0, *(len(ring) for ring in rings)])
    loops = [list(range(a, b)) for a, b in itertools.pairwise(starts)]
    # Holes run against the outer ring, so that the polygon is on the left of every edge.
    loops = [loops[0]] + [loop[::-1] if _area(plane[loop]) > 0.0 else loop for loop in loops[1:]]
    return np.asarray(_clip(plane, _bridged(plane, loops)), dtype=np.int64).reshape(-1, 3)


def _area(points: FloatArray) -> float:
    """Signed area of a ring (n, 2), counter-clockwise positive."""
    x, y = (points - points[0]).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _bridged(plane: FloatArray, loops: list[list[int]]) -> list[int]:
    """One loop through all loops: each hole hangs on the loop by a cut, walked there and back."""
    loop, waiting = loops[0], loops[1:]
    while waiting:
        starts = [(h, i) for h, hole in enumerate(waiting) for i in range(len(hole))]
        pairs = [(h, i, j) for h, i in starts for j in range(len(loop))]
        ends = plane[np.array([(waiting[h][i], loop[j]) for h, i, j in pairs])]
        walls = np.concatenate([np.stack([ring, np.roll(ring, -1)], axis=1) for ring in (loop, *waiting)])
        order = np.argsort(np.sum((ends[:, 1] - ends[:, 0]) ** 2, axis=1))
        # The shortest cut that crosses no edge; if the rings cross there may be none: then just the shortest.
        free = (int(k) for k in order if not _crosses(ends[k], plane[walls]))
        h, i, j = pairs[next(free, int(order[0]))]
        hole = waiting.pop(h)
        loop = [*loop[: j + 1], *hole[i:], *hole[: i + 1], *loop[j:]]
    return loop


def _crosses(cut: FloatArray, walls: FloatArray) -> bool:
    """Whether a segment (2, 2) crosses any of the segments (n, 2, 2) between their ends."""
    a, b, c, d = cut[0], cut[1], walls[:, 0], walls[:, 1]
    apart = _cross(b - a, c - a) * _cross(b - a, d - a) < 0.0
    return bool(np.any(apart & (_cross(d - c, a - c) * _cross(d - c, b - c) < 0.0)))


def _clip(plane: FloatArray, loop: list[int]) -> list[tuple[int, int, int]]:
    """Ears of a loop, roundest first; vertices that lie straight between their neighbours go without one."""
    triangles = []
    while len(loop) > 2:
        ring = plane[loop]
        before, after = np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0)
        sides = np.stack([ring - before, after - ring, before - after])
        longest = np.max(np.sum(sides**2, axis=2), axis=0)
        roundness = _cross(sides[0], sides[1]) / np.where(longest > 0.0, longest, 1.0)
        ears = (int(k) for k in np.argsort(-roundness) if roundness[k] > _FLAT and _is_empty(ring, int(k)))
        k = next(ears, int(np.argmin(np.abs(roundness))))
        if roundness[k] > _FLAT:
            triangles.append((loop[k - 1], loop[k], loop[(k + 1) % len(loop)]))
        del loop[k]
    return triangles


def _is_empty(ring: FloatArray, k: int) -> bool:
    """Whether no other vertex of the ring lies in the triangle of vertex k and its neighbours."""
    corners = ring[[k - 1, k, (k + 1) % len(ring)]]
    sides = np.roll(corners, -1, axis=0) - corners
    inside = np.all(_cross(sides[:, None], ring[None] - corners[:, None]) >= 0.0, axis=0)
    # Cuts to holes are walked twice, so a vertex may be there again: only other places count.
    inside &= np.all(np.any(ring[None] != corners[:, None], axis=2), axis=0)
    return not bool(np.any(inside))
