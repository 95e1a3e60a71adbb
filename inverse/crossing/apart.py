"""Facets that are apart for certain, in many states at once: a filter before exact predicates.

What is filtered out is proven: a direction was found along which all of one facet lies before all of another, by more
than rounding can make of it. Numbers that are no numbers prove nothing. The rest is doubtful, and decided exactly.

Every direction serves, however it was found and rounded: the extents along it are what counts. Coordinates relative to
a point of the mesh are rounded by 1e-16 of themselves, and sums of three products by a few times as much, so that two
extents that are ``MARGIN`` of the mesh's size apart are so for the given numbers too.
"""

from __future__ import annotations

import numpy as np

from inverse._types import BoolArray, FloatArray, IntArray
from inverse.crossing.neighbours import Neighbours

MARGIN = 1e-12  # of the size of the mesh
OPENED = 1e-7  # of a facet's reach: a hinge with less to its two sides is all but folded up
GROUP = 4  # facets of a group, groups of a larger one
TOP = 16  # groups that are compared each with each


def doubtful_hinges(states: FloatArray, known: Neighbours) -> BoolArray:
    """Facets with a common edge that may share more than it.

    Let d be a unit vector at right angles to the hinge p q, along which the other vertices of one facet are m or more
    above it and those of the other m or more below. With d tilted towards p by less than m over the facets' reach,
    triangles of the two facets without a common vertex, one at p and one at q, are on different sides of the hinge's
    middle; all others of the one without p and q are so anyway. Nor are the facets folded onto each other: seen along
    the hinge there is an angle of 2 m over their reach between any two vertices of theirs, and the predicates call
    them so up to 1e-8.

    Args:
        states: (S, V, 3) vertices.
        known: what facets have in common.

    Returns:
        (S, K) bool.
    """
    points = np.ascontiguousarray(states.transpose(2, 0, 1))
    p, q = (points.take(known.edges[:, k], axis=2) for k in (0, 1))
    with np.errstate(invalid="ignore", divide="ignore"):
        hinge = _unit(q - p)
        offsets = [
            [points.take(vertices, axis=2) - p for vertices in known.others[:, side].T] for side in (0, 1)
        ]  # of the other vertices of both facets
        first, second = (_unit(_beside(np.sum(some, axis=0), hinge)) for some in offsets)
        across = _beside(_unit(first - second), hinge)
        clear = np.minimum.reduce(
            [sign * _dot(x, across) for sign, some in zip((1, -1), offsets, strict=True) for x in some]
        )
        reach = np.maximum.reduce([np.abs(x).max(axis=0) for some in offsets for x in some])
        return np.asarray(~(clear > 2 * OPENED * reach))


def _dot(a: FloatArray, b: FloatArray) -> FloatArray:
    """Products of vectors (3, ...)."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def _unit(vectors: FloatArray) -> FloatArray:
    return np.asarray(vectors / np.sqrt(_dot(vectors, vectors)))


def _beside(vectors: FloatArray, units: FloatArray) -> FloatArray:
    """The part of vectors (3, ...) at right angles to units."""
    return np.asarray(vectors - _dot(vectors, units) * units)


def doubtful_pairs(states: FloatArray, corners: IntArray, known: Neighbours) -> tuple[IntArray, IntArray]:
    """Facets without common vertices that may share a point.

    Boxes along each state's principal axes come first, those of groups of facets before those of facets; then the
    planes of the facets themselves.

    Args:
        states: (S, V, 3) vertices.
        corners: (F, k) int, vertices of every facet, the last repeated where it has fewer.
        known: what facets have in common.

    Returns:
        (N,) int, states; (N, 2) int, the facets.
    """
    centred = states - states.mean(axis=1, keepdims=True)
    margin = MARGIN * float(np.abs(centred).max(initial=0.0))
    spread = np.einsum("svx,svy->sxy", centred, centred)
    axes = np.linalg.eigh(spread)[1] if np.isfinite(spread).all() else np.broadcast_to(np.eye(3), spread.shape)
    turned = np.ascontiguousarray((centred @ axes[:, :, ::-1]).transpose(2, 0, 1))
    at = [turned.take(vertices, axis=2) for vertices in corners.T]
    order = _order(centred[len(states) // 2][corners].mean(axis=1))
    here, there = _touching(np.minimum.reduce(at), np.maximum.reduce(at) + margin, order)
    count = len(corners)
    keep = ~_are_in(here % count, there % count, known.pairs, count)
    here, there = here[keep], there[keep]

    at = [x.reshape(3, -1) for x in at]
    planes = _planes(at, margin)
    for one, other in ((0, 1), (1, 0)):
        pair = here, there
        near = ~_beyond_plane(at, planes, pair[one], pair[other])
        here, there = here[near], there[near]
    return here // count, np.stack([here % count, there % count], axis=1)


def _order(points: FloatArray) -> IntArray:
    """Numbers of points (N, 3), so that near ones are together, filled up with -1 to a power of ``GROUP``.

    Halves along the longest side, halves of these, and so on.
    """
    count = 1
    while count < len(points):
        count *= GROUP
    groups = np.r_[np.arange(len(points)), np.full(count - len(points), -1)][None]
    while groups.shape[1] > 1:
        places = points[groups]
        longest = np.ptp(places, axis=1).argmax(axis=1)
        along = np.take_along_axis(places, longest[:, None, None], axis=2)[..., 0]
        along[groups < 0] = np.inf
        groups = np.take_along_axis(groups, np.argsort(along, axis=1), axis=1).reshape(-1, groups.shape[1] // 2)
    return np.asarray(groups.ravel())


def _touching(low: FloatArray, high: FloatArray, order: IntArray) -> tuple[IntArray, IntArray]:
    """Pairs of boxes of one state that meet, the smaller number first.

    Args:
        low: (3, S, F) low ends of boxes.
        high: (3, S, F) high ends.
        order: of the boxes, near ones together, -1 for none.

    Returns:
        Two arrays (N,) of places in (S, F).
    """
    n_states, count = low.shape[1:]
    levels = [
        [np.where(order < 0, empty, ends.take(order, axis=2)) for empty, ends in ((np.inf, low), (-np.inf, high))]
    ]
    while levels[-1][0].shape[2] > TOP:
        parts = [[ends[:, :, k::GROUP] for k in range(GROUP)] for ends in levels[-1]]
        levels.append([np.minimum.reduce(parts[0]), np.maximum.reduce(parts[1])])
    # All groups of a state with each other, then the parts of those that meet.
    n_top = levels[-1][0].shape[2]
    here = there = np.arange(n_states)
    for lowest, highest in reversed(levels):
        size = n_top if lowest.shape[2] == n_top else GROUP
        a, b = (np.ascontiguousarray(ends.reshape(3, -1, size).transpose(0, 2, 1)) for ends in (lowest, highest))
        apart = np.zeros((size, size, len(here)), bool)
        for x in range(3):
            apart |= a[x].take(here, axis=1)[:, None] > b[x].take(there, axis=1)
            apart |= b[x].take(here, axis=1)[:, None] < a[x].take(there, axis=1)
        one, other, pair = np.nonzero(~apart)
        here, there = size * here[pair] + one, size * there[pair] + other
        once = here <= there
        here, there = here[once], there[once]
    apart = here != there
    here, there = here[apart], there[apart]
    state = here // len(order)
    one, other = order[here - len(order) * state], order[there - len(order) * state]
    return count * state + np.minimum(one, other), count * state + np.maximum(one, other)


def _are_in(one: IntArray, other: IntArray, known: IntArray, count: int) -> BoolArray:
    """Which pairs, two (N,) of numbers below a count, are among known ones (K, 2)."""
    keys, wanted = np.sort(known[:, 0] * count + known[:, 1]), one * count + other
    if not len(keys):
        return np.zeros(len(wanted), bool)
    return np.asarray(keys[np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)] == wanted)


def _planes(at: list[FloatArray], margin: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Normals (3, N) of facets whose k-th corners are at (3, N), and their extents along these, (N,), margins added."""
    with np.errstate(invalid="ignore", divide="ignore"):
        normals = _unit(np.cross(at[2] - at[0], at[-1] - at[1], axis=0))
    along = [_dot(x, normals) for x in at]
    return normals, np.minimum.reduce(along) - margin, np.maximum.reduce(along) + margin


def _beyond_plane(
    at: list[FloatArray], planes: tuple[FloatArray, FloatArray, FloatArray], facet: IntArray, other: IntArray
) -> BoolArray:
    """Which facets (N,) lie on one side of others' planes, (N,); see :func:`_planes`."""
    normals, low, high = planes
    own, least, most = normals.take(facet, axis=1), low.take(facet), high.take(facet)
    above, below = np.ones(len(facet), bool), np.ones(len(facet), bool)
    for x in at:
        along = _dot(x.take(other, axis=1), own)
        above &= along > most
        below &= along < least
    return np.asarray(above | below)
