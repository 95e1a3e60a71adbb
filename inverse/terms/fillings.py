"""Cuts of a polygon into quadrilaterals."""

from __future__ import annotations

from collections.abc import Collection
from functools import cache

Quadrilateral = tuple[int, int, int, int]
Filling = tuple[Quadrilateral, ...]


def quadrilaterals(k: int) -> list[Quadrilateral]:
    """All that occur in a cut of a polygon with corners 0 .. k - 1: those whose sides leave even polygons beside them.

    Args:
        k: number of corners; of an odd polygon there are none.
    """
    if k % 2:
        return []
    return [
        (a, b, c, d)
        for a in range(k)
        for b in range(a + 1, k, 2)
        for c in range(b + 1, k, 2)
        for d in range(c + 1, k, 2)
    ]


def fillings(k: int, allowed: Collection[Quadrilateral]) -> list[Filling]:
    """All ways to cut a polygon into quadrilaterals: 1, 3, 12, 55 for 4, 6, 8, 10 corners where all are allowed.

    Args:
        k: number of corners, 0 .. k - 1.
        allowed: quadrilaterals that may be used.
    """

    @cache
    def between(low: int, high: int) -> list[Filling]:
        """Of the part between the corners low and high, by the quadrilateral on the side that joins these two."""
        if high - low == 1:
            return [()]
        return [
            ((low, a, b, high), *first, *second, *third)
            for a in range(low + 1, high, 2)
            for b in range(a + 1, high, 2)
            if (low, a, b, high) in allowed
            for first in between(low, a)
            for second in between(a, b)
            for third in between(b, high)
        ]

    return between(0, k - 1) if k % 2 == 0 else []
