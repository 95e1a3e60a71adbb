"""Sections swept along an axis: closest points, what is shown, wrong input."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import inverse
from inverse.errors import InputError
from inverse.surfaces.axis import Axis, arc
from inverse.surfaces.mesh import MeshTarget
from inverse.surfaces.section import SectionTarget

DOOR = [[-0.5, 0.0], [0.5, 0.0], [0.5, 2.1], [-0.5, 2.1]]
ALONG_Y = Axis([[0, 0, 0], [0, 3, 0]], smooth=False)


def door(axis: Axis = ALONG_Y) -> SectionTarget:
    return SectionTarget(axis, [(0.0, np.array(DOOR))])


def test_a_door_stands_upright() -> None:
    vertices, _ = door().triangles()
    assert vertices.min(axis=0) == pytest.approx([-0.5, 0, 0])
    assert vertices.max(axis=0) == pytest.approx([0.5, 3, 2.1])


@pytest.mark.parametrize(("end", "wide", "high"), [([3, 0, 0], 1, 2), ([0, 3, 0], 0, 2), ([0, 0, 3], 0, 1)])
def test_up_is_up(end: list[float], wide: int, high: int) -> None:
    """Of a vertical axis up is the y of space, and x its x."""
    size = np.ptp(door(Axis([[0, 0, 0], end], smooth=False)).triangles()[0], axis=0)
    assert size[[wide, high]] == pytest.approx([1, 2.1])


def test_x_is_to_the_right_seen_from_the_end() -> None:
    skew = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    vertices, _ = SectionTarget(ALONG_Y, [(0.0, np.array(skew))]).triangles()
    assert vertices.min(axis=0)[0] == pytest.approx(-1)  # looking from y = 3 to y = 0, the right is at negative x
    vertices, _ = SectionTarget(Axis([[0, 0, 0], [0, 0, 3]], smooth=False), [(0.0, np.array(skew))]).triangles()
    assert vertices.max(axis=0) == pytest.approx([1, 1, 3])


@pytest.mark.parametrize("axis", [ALONG_Y, arc([0, 0, 0], [1, 4, 0.5], [4, 8, 1])], ids=["straight", "bent"])
def test_closest_points_are_those_of_the_surface(axis: Axis) -> None:
    target = SectionTarget(axis, [(0.0, np.array(DOOR)), (1.0, 0.9 * np.array(DOOR))])
    rng = np.random.default_rng(1)
    vertices, triangles = target.triangles()
    points = vertices[rng.integers(0, len(vertices), 200)] + 0.1 * rng.normal(size=(200, 3))
    by_mesh = MeshTarget(vertices, triangles).distances(points)
    assert target.distances(points) == pytest.approx(by_mesh, abs=0.02)  # beside a taper the nearest is aslant
    found = target.closest(points)
    weighed = np.linalg.norm(np.einsum("nij,nj->ni", found.weights, points - found.feet), axis=1)
    assert (weighed <= target.distances(points) + 1e-12).all()


def test_sections_change_along_the_axis() -> None:
    target = SectionTarget(ALONG_Y, [(0.0, np.array(DOOR)), (1.0, 0.5 * np.array(DOOR))])
    sizes = np.ptp(target.outlines(np.array([0.0, 0.5, 1.0])), axis=1)
    assert sizes == pytest.approx(np.array([[1, 2.1], [0.75, 1.575], [0.5, 1.05]]))


@pytest.mark.parametrize(
    ("section", "match"),
    [
        ([[0, 0], [1, 0]], "at least 3"),
        ([[0, 0], [1, 0], [2, 0]], "no area"),
        ([[0, 0], [1, 1], [1, 0], [0, 1]], "no area|sides 0 and 2 .* meet"),
        ([[0, 0], [2, 2], [2, 0], [0, 1]], "sides 0 and 2 of the section meet"),
        ([[0, DOOR], [1, DOOR[:3]]], "3 and 4 corners"),
        ([[0.5, DOOR], [0.5, DOOR]], "must increase"),
        ([[0, DOOR], [2, DOOR]], "2"),
        ("door", "list|section"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], r"\[x, y\]"),
    ],
)
def test_wrong_sections_are_refused_with_their_place(section: Any, match: str) -> None:
    target = {"axis": {"polyline": [[0, 0, 0], [0, 3, 0]]}, "section": section}
    with pytest.raises(InputError, match=match) as caught:
        inverse.load({"name": "s", "pattern": {"kind": "tube", "size": [4, 4]}, "target": target})
    assert "target" in str(caught.value.where)
