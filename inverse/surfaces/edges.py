"""Edges of triangles, and which of them are on the border."""

from __future__ import annotations

import numpy as np

from inverse._types import IntArray


def edges_of(triangles: IntArray) -> tuple[IntArray, IntArray]:
    """The edge that each side of triangles (T, 3) lies on, and how many triangles have an edge.

    Returns:
        (T, 3) int, edges of the sides from each corner to the next one, numbered by their lower and then by their
        higher vertex; (E,) int.
    """
    if not len(triangles):
        return np.empty((0, 3), np.int64), np.empty(0, np.int64)
    following = triangles[:, [1, 2, 0]]
    low, high = np.minimum(triangles, following), np.maximum(triangles, following)
    keys = (low * (int(triangles.max()) + 1) + high).ravel()
    order = np.argsort(keys, kind="stable")
    new = np.r_[True, np.diff(keys[order]) != 0]
    edge = np.empty(len(keys), np.int64)
    edge[order] = np.cumsum(new) - 1
    return edge.reshape(-1, 3), np.bincount(edge)
