"""The facets of a flat pattern of which only the edges are known."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.repair.foreign import Pair

_NEAR = 1e-9  # of the size of the pattern: nearer than this a vertex lies on an edge


def facets_of_graph(points: FloatArray, edges: Sequence[Pair], border: set[Pair]) -> tuple[tuple[int, ...], ...]:
    """Walk around every facet of a planar graph.

    From each half-edge the walk goes on along the next edge clockwise from where it came, so that it keeps a
    facet on its left. The walk around the outside turns clockwise and is left out; one along border edges only
    is a hole.

    Args:
        points: (V, 2) vertices in the plane.
        edges: pairs of vertices.
        border: those of the edges that the file assigns to the boundary.

    Returns:
        Facets, counter-clockwise.

    Raises:
        InputError: edges cross or overlap, or the graph is in several pieces or encloses nothing.
    """
    pairs = np.array(edges, np.int64).reshape(-1, 2)
    _check_crossings(points, pairs)
    following = _following(points, pairs)
    facets: list[tuple[int, ...]] = []
    holes: list[tuple[int, ...]] = []
    outside = 0
    left = set(following)
    for start in sorted(following):
        if start not in left:
            continue
        walk = [start]
        left.discard(start)
        while (step := following[walk[-1]]) != start:
            left.discard(step)
            walk.append(step)
        facet = tuple(a for a, _ in walk)
        steps = set(walk)
        bridge = next((step for step in walk if step[::-1] in steps), None)
        if bridge is not None:
            raise InputError(
                f"edge {bridge[0]}-{bridge[1]} has the same region on both sides",
                hint="Every edge must have two facets, or a facet and the outside, on its sides.",
            )
        if _area(points[list(facet)]) <= 0:
            outside += 1
            continue
        is_hole = all(tuple(sorted(step)) in border for step in walk)
        (holes if is_hole else facets).append(facet)
    if outside > 1:
        raise InputError(f"the edges form {outside} separate pieces", hint="Give each pattern a file of its own.")
    if not facets and len(holes) == 1:
        facets = holes
    if not facets:
        raise InputError("the edges enclose no facets")
    return tuple(facets)


def _following(points: FloatArray, pairs: IntArray) -> dict[Pair, Pair]:
    """The half-edge after each half-edge on the walk around the facet on its left."""
    spokes: dict[int, list[tuple[float, int]]] = {}
    for a, b in [*pairs.tolist(), *pairs[:, ::-1].tolist()]:
        x, y = points[b] - points[a]
        spokes.setdefault(a, []).append((float(np.arctan2(y, x)), b))
    following = {}
    for vertex, around in spokes.items():
        around.sort()
        for k, (angle, other) in enumerate(around):
            if len(around) > 1:
                before, neighbour = around[k - 1]
                if (angle - before) % (2 * np.pi) < _NEAR:
                    raise InputError(f"edges {vertex}-{neighbour} and {vertex}-{other} lie upon each other")
            following[other, vertex] = (vertex, around[k - 1][1])
    return following


def _check_crossings(points: FloatArray, pairs: IntArray) -> None:
    """Edges may meet in common vertices only."""
    a, b = points[pairs[:, 0]], points[pairs[:, 1]]
    near = _NEAR * np.ptp(points, axis=0).max() ** 2
    low, high = np.minimum(a, b), np.maximum(a, b)
    for k in range(len(pairs) - 1):
        others = np.arange(k + 1, len(pairs))
        apart = (low[others] > high[k]).any(axis=1) | (high[others] < low[k]).any(axis=1)
        others = others[~apart & ~np.isin(pairs[others], pairs[k]).any(axis=1)]
        c, d = a[others], b[others]
        sides = _turn(a[k], b[k], c), _turn(a[k], b[k], d), _turn(c, d, a[k]), _turn(c, d, b[k])
        # Zero counts as crossing: a vertex upon an edge is not joined to it.
        r, s, t, u = (np.where(np.abs(side) < near, 0.0, np.sign(side)) for side in sides)
        crossing = np.flatnonzero((r * s <= 0) & (t * u <= 0))
        if len(crossing):
            (p, q), (v, w) = pairs[k].tolist(), pairs[others[crossing[0]]].tolist()
            raise InputError(f"edges {p}-{q} and {v}-{w} cross or touch without a common vertex, so that facets cannot "
                             "be found", hint="Add a vertex there, or give faces_vertices.")  # fmt: skip


def _turn(a: FloatArray, b: FloatArray, c: FloatArray) -> FloatArray:
    """Twice the signed area of triangles a, b, c; (N, 2) or (2,) each."""
    u, v = b - a, c - a
    return np.asarray(u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])


def _area(polygon: FloatArray) -> float:
    x, y = (polygon - polygon[0]).T
    return float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2
