"""The first of many states of a mesh in which facets cross."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.crossing.apart import doubtful_hinges, doubtful_pairs
from inverse.crossing.exact import below_one, corners_cross, crossing_facets, triangles_cross
from inverse.crossing.neighbours import Faces, neighbours

AT_ONCE = 2**15  # facets of all states that are looked at together: bounds the memory


def first_crossing(
    states: FloatArray, faces_vertices: Sequence[Sequence[int]], told: Callable[[int], None] | None = None
) -> tuple[int, IntArray] | None:
    """The first state with crossing facets, as :func:`crossing_facets` finds them.

    Most facets are apart by much. Which are is found for many states together, in ordinary numbers with a margin; only
    the others are given to the exact predicates.

    Args:
        states: (S, V, 3) vertices in every state.
        faces_vertices: convex facets that turn at every corner.
        told: told how many states are done, one after the other.

    Returns:
        The number of the state and its pairs of crossing facets, (N, 2) int; None where no facets cross.
    """
    faces, tell = tuple(map(tuple, faces_vertices)), told or (lambda done: None)
    some = max(AT_ONCE // max(len(faces), 1), 1)
    for first in range(0, len(states), some):
        crossing = np.flatnonzero(_crossing(states[first : first + some], faces))
        done = first + int(crossing[0]) if len(crossing) else min(first + some, len(states))
        for k in range(first, done):
            tell(k + 1)
        if len(crossing):
            return done, crossing_facets(states[done], faces)
    return None


def _crossing(states: FloatArray, faces: Faces) -> np.ndarray:
    """In which states (S,) of some, (S, V, 3), facets cross."""
    known = neighbours(faces)
    scaled = below_one(states)
    found = np.full(len(states), bool(len(known.overlapping)))
    if found.all():
        return found
    n_vertices = states.shape[1]
    shifts = n_vertices * np.arange(len(states))[:, None, None]
    at_vertex = (known.corners + shifts).reshape(-1, 5)
    found |= corners_cross(scaled.reshape(-1, 3), at_vertex).reshape(len(states), -1).any(axis=1)

    state, pairs = doubtful_pairs(scaled, _corners(faces), known)
    hinge_state, hinge = np.nonzero(doubtful_hinges(scaled, known))
    state = np.concatenate([state, hinge_state, np.repeat(np.arange(len(states)), len(known.same_way))])
    pairs = np.concatenate([pairs, known.at_edge[hinge], np.tile(known.same_way, (len(states), 1))])
    for k in np.unique(state[~found[state]]).tolist():
        found[k] = triangles_cross(scaled[k], faces, np.unique(pairs[state == k]))
    return found


@lru_cache(maxsize=4)
def _corners(faces: Faces) -> IntArray:
    """Vertices (F, k) of every facet, the last repeated where it has fewer than another."""
    most = max(map(len, faces))
    return np.array([face + face[-1:] * (most - len(face)) for face in faces], np.int64)
