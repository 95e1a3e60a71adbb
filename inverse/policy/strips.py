"""Pairs of facets that lie alike: what holds for one pair is to hold along its whole strip."""

from __future__ import annotations

import numpy as np

from inverse._types import IntArray
from inverse.origami.pattern import Pattern


def alike(pattern: Pattern, pairs: IntArray) -> IntArray:
    """Pairs of facets and, on a grid, all pairs that lie alike along the strips that they belong to.

    Args:
        pattern: the pattern.
        pairs: (N, 2) int, facets.

    Returns:
        (M, 2) int, each pair once with the smaller number first where there is a grid, else the given ones.
    """
    if pattern.grid is None or not len(pairs):
        return pairs
    m, n = pattern.grid
    (i0, j0), (i1, j1) = np.divmod(pairs[:, 0], n), np.divmod(pairs[:, 1], n)
    found = set()
    for a, b, c, d in np.stack([i0, j0, i1, j1], axis=1).tolist():
        if abs(c - a) <= abs(d - b):
            found |= {(i * n + b, (i + c - a) * n + d) for i in range(m) if 0 <= i + c - a < m}
        else:
            found |= {(a * n + j, c * n + j + d - b) for j in range(n) if 0 <= j + d - b < n}
    return np.array(sorted({(min(p), max(p)) for p in found}), np.int64)
