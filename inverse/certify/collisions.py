"""Facets that pass through each other: in the design state, and how far the motion is free of it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.certify.certificate import Crossing, Measured
from inverse.certify.motion import N_STATES, STATES_AT_ONCE, Motion
from inverse.crossing import crossing_facets

RESOLUTION = 0.01  # degrees, to which the first crossing is located
# In a flat state all layers lie in one plane, and whether they cross is undecidable. Facets that meet in an edge
# count as crossing if it is folded to within 1e-8 rad, 6e-7 degrees, of 180 degrees. This close to a flat state, the
# smallest fold that the certificate allows is 9e-5 degrees.
NEAREST_TO_FLAT = 0.01
MAX_LISTED_PAIRS = 10


def design_crossings(points: FloatArray, facets: tuple[tuple[int, ...], ...]) -> Measured:
    """Number of pairs of facets that cross in the design state, in the file's coordinates, (V, 3)."""
    pairs = crossing_facets(points, facets)
    if not len(pairs):
        return 0.0, "no facets cross"
    named = ", ".join(f"{a} and {b}" for a, b in pairs[:3].tolist())
    more = f" and {len(pairs) - 3} more pairs" if len(pairs) > 3 else ""
    return float(len(pairs)), f"facets {named}{more}"


def free_range(
    motion: Motion, progress: Callable[[int, int], None] | None = None
) -> tuple[tuple[float, float], tuple[Crossing, ...]]:
    """The part of the motion around the design state in which no facets were found to cross, in degrees.

    States are sampled outwards from 90 degrees at the motion's own spacing and just before the flat states;
    the first crossing is then located by bisection. A crossing that comes and goes between two samples is
    missed. A side without any crossing is reported up to its flat state, 0 or 180.

    Args:
        motion: of the design.
        progress: told how many states of how many are looked at.

    Returns:
        The range, and at each of its ends that is not a flat state what crosses there.
    """
    outwards = np.linspace(90.0, 180.0, N_STATES // 2 + 1)[1:]
    outwards[-1] = 180.0 - NEAREST_TO_FLAT
    of, tell = 2 * len(outwards), progress or (lambda done, of: None)
    ends = (
        _first(motion, 180.0 - outwards, lambda done: tell(done, of)),
        _first(motion, outwards, lambda done: tell(of // 2 + done, of)),
    )
    low, high = (flat if end is None else end.t for end, flat in zip(ends, (0.0, 180.0), strict=True))
    return (low, high), tuple(end for end in ends if end is not None)


def _first(motion: Motion, states: FloatArray, told: Callable[[int], None]) -> Crossing | None:
    free, done = 90.0, 0
    for some in np.array_split(states, range(STATES_AT_ONCE, len(states), STATES_AT_ONCE)):
        for crossed, points in zip(some.tolist(), motion.vertices(np.radians(some / 2)), strict=True):
            pairs = crossing_facets(points, motion.mesh.facets)
            if len(pairs):
                return _located(motion, free, crossed, pairs)
            free, done = crossed, done + 1
            told(done)
    return None


def _located(motion: Motion, free: float, crossed: float, pairs: IntArray) -> Crossing:
    """The last state without a crossing between one without and one with, in degrees, and what crosses beyond."""
    while abs(crossed - free) > RESOLUTION:
        middle = (free + crossed) / 2
        found = crossing_facets(motion.vertices(np.radians([middle / 2]))[0], motion.mesh.facets)
        if len(found):
            crossed, pairs = middle, found
        else:
            free = middle
    return Crossing(free, tuple((int(a), int(b)) for a, b in pairs[:MAX_LISTED_PAIRS].tolist()))
