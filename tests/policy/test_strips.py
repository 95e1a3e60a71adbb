"""Pairs of facets that lie alike along a strip of a grid."""

from __future__ import annotations

import numpy as np
from designs import assert_close, miura, staircase

from inverse.policy.strips import alike


def test_a_pair_across_a_strip_stands_for_all_along_it() -> None:
    pattern = miura(3, 4).pattern  # facet (i, j) is 4 i + j
    along_u = alike(pattern, np.array([[1, 3]]))
    assert_close(along_u, [[1, 3], [5, 7], [9, 11]], 0)
    along_v = alike(pattern, np.array([[8, 0]]))
    assert_close(along_v, [[0, 8], [1, 9], [2, 10], [3, 11]], 0)


def test_a_shifted_pair_stays_within_the_grid() -> None:
    pattern = miura(3, 4).pattern
    assert_close(alike(pattern, np.array([[0, 6]])), [[0, 6], [4, 10]], 0)


def test_every_pair_is_there_once() -> None:
    pattern = miura(3, 4).pattern
    assert_close(alike(pattern, np.array([[1, 3], [7, 5], [9, 11]])), alike(pattern, np.array([[1, 3]])), 0)


def test_without_a_grid_pairs_stay_as_they_are() -> None:
    pairs = np.array([[0, 2], [1, 3]])
    assert alike(staircase().pattern, pairs) is pairs
    assert len(alike(miura(3, 3).pattern, np.empty((0, 2), np.int64))) == 0
