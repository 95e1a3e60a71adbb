"""Holes of targets are filled smoothly for the fit, and stay in everything that is shown."""

from __future__ import annotations

import numpy as np
import pytest
from shapes import COURT, block, bow, squares, triangles

from inverse.surfaces.holes import HoledTarget
from inverse.surfaces.mesh import MeshTarget

TWO = block(24, 20, (3, 8, 4, 9), (14, 20, 10, 16))


def holed(mask: np.ndarray) -> HoledTarget:
    vertices, faces = squares(mask, height=bow)
    found = HoledTarget.of(MeshTarget(vertices, triangles(faces)))
    assert found is not None
    return found


@pytest.mark.parametrize("mask", [COURT, TWO], ids=["one", "two"])
def test_the_filling_goes_on_from_around(mask: np.ndarray) -> None:
    target = holed(mask)
    x, y = (k.ravel() for k in np.meshgrid(np.linspace(0.2, 11.8, 40), np.linspace(0.2, 9.8, 40)))
    points = np.column_stack([x, y, bow(x, y)])
    assert target.distances(points).max() < 0.02
    assert target.mesh.distances(points).max() > 1
    assert target.over_plan(points - [0, 0, 1]) == pytest.approx(points, abs=0.02)


def test_what_is_shown_has_the_holes() -> None:
    target = holed(COURT)
    assert target.samples()[1].sum() == pytest.approx(target.mesh.samples()[1].sum())
    assert target.filled.samples()[1].sum() == pytest.approx(target.samples()[1].sum() + 12, rel=0.01)


def test_moved_and_flattened_keep_both() -> None:
    target = holed(COURT)
    point = np.array([[6.0, 5.0, 1.5]])
    there = target.moved(np.array([1.0, 2.0, 3.0]))
    assert there.distances(point - [1, 2, 3]) == pytest.approx(target.distances(point))
    assert np.ptp(target.flattened(0.0).closest(point).feet) >= 0
    assert len(target.flattened(0.5).triangles()[1]) == len(target.triangles()[1])


def test_a_mesh_without_holes_is_none() -> None:
    vertices, faces = squares(block(6, 6))
    assert HoledTarget.of(MeshTarget(vertices, triangles(faces))) is None


def test_facets_may_turn_either_way() -> None:
    vertices, faces = squares(COURT, height=bow)
    mixed = [face[::-1] if k % 3 else face for k, face in enumerate(faces)]
    found = HoledTarget.of(MeshTarget(vertices, triangles(mixed)))
    assert found is not None
    assert found.distances(np.array([[6.0, 5.0, 1.5]])) == pytest.approx(0, abs=0.02)


def test_holes_that_touch_themselves_or_are_not_seen_stay_open() -> None:
    eight = block(12, 12, (3, 6, 3, 6), (6, 9, 6, 9))
    slit = squares(block(8, 8))
    upright = squares(block(8, 8, (3, 5, 3, 5)))
    upright = upright[0][:, [0, 2, 1]] + [0, 0, 0], upright[1]
    for vertices, faces in (squares(eight), slit):
        assert HoledTarget.of(MeshTarget(vertices, triangles(faces))) is None
    vertices, faces = upright
    assert HoledTarget.of(MeshTarget(vertices, triangles(faces))) is not None  # its plan is upright as well


def test_many_holes_take_no_time() -> None:
    mask = np.ones((30, 30), bool)
    mask[2::4, 2::4] = False
    assert len(holed(mask).filled.triangles()[1]) > 2 * mask.sum()
