"""Pairs of axis-parallel boxes that overlap, by a sweep."""

from __future__ import annotations

import numpy as np

from inverse._types import FloatArray, IntArray

_AT_ONCE = 4_000_000  # pairs that overlap along the sweep's axis


def overlapping_boxes(low: FloatArray, high: FloatArray) -> IntArray:
    """Pairs of boxes that overlap or touch.

    Args:
        low: (N, 3) lower corners.
        high: (N, 3) upper corners.

    Returns:
        (P, 2) int, each pair once, the smaller number first.
    """
    # Along the axis on which the boxes lie most apart, a box can only meet those that begin before it ends.
    axis = int(np.argmax(np.ptp(low, axis=0) / np.maximum((high - low).mean(axis=0), 1e-300)))
    order = np.argsort(low[:, axis], kind="stable")
    low, high = low[order], high[order]
    counts = np.searchsorted(low[:, axis], high[:, axis], side="right") - np.arange(1, len(low) + 1)
    others = [k for k in range(3) if k != axis]
    found = []
    for part in np.array_split(np.arange(len(low)), max(1, -(-int(counts.sum()) // _AT_ONCE))):
        own = counts[part]
        one = np.repeat(part, own)
        other = one + 1 + np.arange(len(one)) - np.repeat(np.cumsum(own) - own, own)
        for k in others:
            meet = (low[one, k] <= high[other, k]) & (low[other, k] <= high[one, k])
            one, other = one[meet], other[meet]
        found.append(np.sort(order[np.stack([one, other], axis=1)], axis=1))
    return np.concatenate(found)
