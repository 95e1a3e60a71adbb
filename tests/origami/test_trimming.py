"""Grids without some of their facets stay one mechanism."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import COURT, CROSS, ELL, YOU

import inverse
from inverse.origami.trimming import in_one_piece, part_of


@pytest.mark.parametrize("mask", [ELL, CROSS, YOU, COURT], ids=["ell", "cross", "you", "court"])
def test_outlines_of_some_width_stay_as_they_are(mask: np.ndarray) -> None:
    assert (in_one_piece(mask) == mask).all()


def test_what_hangs_on_a_hinge_or_a_corner_goes() -> None:
    mask = np.ones((6, 6), bool)
    mask[4:] = False
    mask[4:, 2] = True  # a strip one facet wide turns about its first edge
    expected = np.ones((6, 6), bool)
    expected[4:] = False
    assert (in_one_piece(mask) == expected).all()
    blocks = np.zeros((6, 6), bool)
    blocks[:4, :4] = blocks[3:, 3:] = True  # they share one facet and no vertex
    assert in_one_piece(blocks).sum() == 16


def test_facets_do_not_meet_in_a_corner_alone() -> None:
    mask = np.zeros((8, 8), bool)
    mask[:, :2] = mask[:2] = mask[6:] = True
    mask[:4, 2:5] = mask[4:, 5:] = True
    assert mask[3:5, 4:6].tolist() == [[True, False], [False, True]]
    kept = in_one_piece(mask)
    a, b, c, d = kept[:-1, :-1], kept[1:, :-1], kept[:-1, 1:], kept[1:, 1:]
    assert not ((a & d & ~b & ~c) | (b & c & ~a & ~d)).any()
    assert mask.sum() - 4 <= kept.sum() < mask.sum()
    assert (kept <= mask).all()


@pytest.mark.parametrize("seed", range(8))
def test_any_part_is_one_mechanism_and_certified(seed: int) -> None:
    rng = np.random.default_rng(seed)
    design = inverse.seeds.grid((9, 8), u_lines="CFL" if seed % 2 else "FL")
    kept = in_one_piece(rng.random((9, 8)) < 0.8)
    part = part_of(design, kept.ravel())
    assert len(part.pattern.faces_vertices) == kept.sum()
    assert inverse.check(part).certified, inverse.check(part).document()


def test_nothing_is_left_where_no_four_facets_meet() -> None:
    assert not in_one_piece(np.eye(5, dtype=bool)).any()
