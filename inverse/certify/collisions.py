"""Facets that pass through each other: in the design state, and how far the motion is free of it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.certify.certificate import Crossing, Measured
from inverse.certify.motion import N_STATES, Motion
from inverse.crossing import crossing_facets, first_crossing

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
    half = N_STATES // 2
    outwards = np.linspace(90.0, 180.0, half + 1)[1:]
    outwards[-1] = 180.0 - NEAREST_TO_FLAT
    low, high = motion.sampled[half - 1 :: -1].copy(), motion.sampled[half + 1 :].copy()
    low[-1], high[-1] = motion.vertices(np.radians([NEAREST_TO_FLAT / 2, 90.0 - NEAREST_TO_FLAT / 2]))
    of, tell = 2 * half, progress or (lambda done, of: None)
    ends = (
        _first(motion, 180.0 - outwards, low, lambda done: tell(done, of)),
        _first(motion, outwards, high, lambda done: tell(half + done, of)),
    )
    free = tuple(flat if end is None else end.t for end, flat in zip(ends, (0.0, 180.0), strict=True))
    return (free[0], free[1]), tuple(end for end in ends if end is not None)


def _first(motion: Motion, states: FloatArray, vertices: FloatArray, told: Callable[[int], None]) -> Crossing | None:
    """The first crossing in states (N,) in degrees, with vertices (N, V, 3), outwards from the design state."""
    found = first_crossing(vertices, motion.mesh.facets, told)
    if found is None:
        return None
    k, pairs = found
    return _located(motion, 90.0 if k == 0 else float(states[k - 1]), float(states[k]), pairs)


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
