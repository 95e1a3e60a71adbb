"""Strip lengths with which a word of foldlines and complementary foldlines does not double back.

Where all lines of the one direction are of one type, strips of the translation surface lie side by side along that
direction, each with the same cross section: a polyline in the plane, whose steps are those of the other direction. The
mesh doubles back exactly where this polyline meets itself. Its steps go along (+-d, +-w), and at every line exactly
one of the two signs flips. Seen along the diagonals, which no length and no angle changes but by a stretch, that is
a rectilinear polyline with a turn to the left or to the right at every line: FL and CFL flip different signs, and
which of them turns left changes from line to line.

Such a polyline is never forced to meet itself: with every step much shorter than the one before, it winds into free
space. This is where the search starts; then it is made compact, as drawings of circuits are: all that is upright moves
as far as what it passes allows, then all that is level, to and fro until nothing becomes shorter.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from inverse._types import BoolArray, FloatArray, IntArray
from inverse.origami.pattern import FL

T = TypeVar("T", int, float)

_ROUNDS = 20
_SHRINK = 3  # a step is longer than all that follow together


def lengths_without_crossing(types: Sequence[int]) -> list[int]:
    """Small whole lengths with which the cross section meets itself nowhere.

    Args:
        types: FL or CFL of every interior line of the mixed direction.

    Returns:
        One relative length for each strip, one more than lines; all 1 where equal strips do.
    """
    turns, alike = _turns(types), [1] * (len(types) + 1)
    if not crosses(types, alike):
        return alike
    there = _compact(turns)
    back = _compact([-turn for turn in turns[::-1]])[::-1]
    return min(there, back, key=lambda lengths: (max(lengths), sum(lengths)))


def crosses(types: Sequence[int], lengths: Sequence[float]) -> bool:
    """Whether the cross section meets itself.

    Args:
        types: FL or CFL of every interior line.
        lengths: of the strips, one more.
    """
    points: FloatArray = np.array(_corners(_turns(types), lengths), np.float64)
    low, high = np.minimum(points[:-1], points[1:]), np.maximum(points[:-1], points[1:])
    touch: BoolArray = np.asarray(np.all((low[:, None] <= high) & (high[:, None] >= low), axis=2))
    k = np.arange(len(low))
    return bool(touch[np.abs(k[:, None] - k) > 1].any())


def _turns(types: Sequence[int]) -> list[int]:
    """1 (left) or -1 at every line."""
    return [(1 if one == FL else -1) * (-1) ** k for k, one in enumerate(types)]


def _corners(turns: Sequence[int], lengths: Sequence[T]) -> list[tuple[T | int, T | int]]:
    """Corners of the rectilinear polyline, exact for whole lengths however long they are."""
    x: T | int = 0
    y: T | int = 0
    dx, dy = 1, 0
    corners = [(x, y)]
    for turn, length in zip([*turns, 1], lengths, strict=True):
        x, y = x + length * dx, y + length * dy
        corners.append((x, y))
        dx, dy = -turn * dy, turn * dx
    return corners


def _compact(turns: Sequence[int]) -> list[int]:
    """Lengths of a polyline with these turns that meets itself nowhere, about as short as its winding allows."""
    count = len(turns) + 1
    # Only the order of coordinates matters from here on, so ranks stand for numbers of any size.
    corners = _corners(turns, [_SHRINK ** (count - k) for k in range(count)])
    places = np.array([_ranks([corner[axis] for corner in corners]) for axis in (0, 1)])
    best = _lengths(places)
    for turn in range(_ROUNDS):
        for axis in (0, 1):
            sign = -1 if turn % 2 else 1
            places[axis] = sign * _pushed(sign * places[axis], places[1 - axis])
        found = _lengths(places)
        if turn % 2 and found.sum() >= best.sum():
            break
        if found.sum() < best.sum():
            best = found
    return [int(length) for length in best]


def _ranks(values: Sequence[int]) -> IntArray:
    rank = {value: k for k, value in enumerate(sorted(set(values)))}
    return np.array([rank[value] for value in values], np.int64)


def _lengths(places: IntArray) -> IntArray:
    return np.asarray(np.abs(np.diff(places, axis=1)).sum(axis=0))


def _pushed(along: IntArray, across: IntArray) -> IntArray:
    """Coordinates (N,) of all corners pushed down as far as they go: steps across keep one apart, and their order."""
    # Neighbouring corners with one coordinate in common move together.
    group = np.cumsum(np.r_[0, np.diff(along) != 0])
    first = np.flatnonzero(np.r_[True, np.diff(group) != 0])
    low, high = np.minimum.reduceat(across, first), np.maximum.reduceat(across, first)
    old = along[first]
    new = np.zeros_like(old)
    order = np.argsort(old, kind="stable")
    for k, one in enumerate(order):
        before = order[:k]
        passed = before[(low[before] <= high[one]) & (high[before] >= low[one]) & (old[before] < old[one])]
        new[one] = new[passed].max(initial=-1) + 1
    return np.asarray(new[group])
