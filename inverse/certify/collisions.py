"""Facets that pass through each other: in the design state, and how far the motion is free of it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from inverse.certify.certificate import Measured
from inverse.certify.motion import N_STATES, STATES_AT_ONCE, Motion
from inverse.crossing import crossing_facets

FloatArray = NDArray[np.float64]

RESOLUTION = 0.01  # degrees, to which the first crossing is located
# In a flat state all layers lie in one plane, and whether they cross is undecidable. The predicates were seen
# to call facets crossing that merely meet in an edge folded to within 1e-7 degrees of 0 or 180, never at
# 1e-6. This close to a flat state, the smallest fold that the certificate allows is 9e-5 degrees.
NEAREST_TO_FLAT = 0.01


def design_crossings(points: FloatArray, facets: tuple[tuple[int, ...], ...]) -> Measured:
    """Number of pairs of facets that cross in the design state, in the file's coordinates, (V, 3)."""
    pairs = crossing_facets(points, facets)
    if not len(pairs):
        return 0.0, "no facets cross"
    named = ", ".join(f"{a} and {b}" for a, b in pairs[:3].tolist())
    more = f" and {len(pairs) - 3} more pairs" if len(pairs) > 3 else ""
    return float(len(pairs)), f"facets {named}{more}"


def free_range(motion: Motion) -> tuple[float, float]:
    """The part of the motion around the design state in which no facets were found to cross, in degrees.

    States are sampled outwards from 90 degrees at the motion's own spacing and just before the flat states;
    the first crossing is then located by bisection. A crossing that comes and goes between two samples is
    missed. A side without any crossing is reported up to its flat state, 0 or 180.
    """
    outwards = np.linspace(90.0, 180.0, N_STATES // 2 + 1)[1:]
    outwards[-1] = 180.0 - NEAREST_TO_FLAT
    return _reach(motion, 180.0 - outwards, 0.0), _reach(motion, outwards, 180.0)


def _reach(motion: Motion, states: FloatArray, flat: float) -> float:
    free = 90.0
    for some in np.array_split(states, range(STATES_AT_ONCE, len(states), STATES_AT_ONCE)):
        for crossed, points in zip(some.tolist(), motion.vertices(np.radians(some / 2)), strict=True):
            if _crosses(motion, points):
                return _located(motion, free, crossed)
            free = crossed
    return flat


def _located(motion: Motion, free: float, crossed: float) -> float:
    """The last state without a crossing between one without and one with, in degrees."""
    while abs(crossed - free) > RESOLUTION:
        middle = (free + crossed) / 2
        if _crosses(motion, motion.vertices(np.radians([middle / 2]))[0]):
            crossed = middle
        else:
            free = middle
    return free


def _crosses(motion: Motion, points: FloatArray) -> bool:
    return len(crossing_facets(points, motion.mesh.facets)) > 0
