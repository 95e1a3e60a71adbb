"""Facets kept apart in states of the motion: against the folded seed, and in a solve whose tube crosses without."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from designs import assert_close, eggbox, hybrid, rows_of, tube

import inverse
from inverse.model import DesignModel
from inverse.origami import folding
from inverse.origami.pattern import Design
from inverse.spec import load
from inverse.terms import separation


@pytest.mark.parametrize("t", [0.3, 2.2, 3.0])
@pytest.mark.parametrize("design", [eggbox(4, 4), hybrid(), tube(6, 3)], ids=["eggbox", "hybrid", "tube"])
def test_rows_are_heights_over_the_plane_of_a_folded_facet(design: Design, t: float) -> None:
    model = DesignModel(design)
    pairs = np.array([[0, 2], [7, 1], [3, 9], [4, 8]])
    state = folding.fold(design, np.array([t])).vertices_coords[0] / model.scale
    found = separation.in_state(model, pairs, t)
    assert len(found) > 1
    for constraint in found:
        f, g = (int(word) for word in constraint.name.split("_")[1:3])
        a, b, c = state[list(design.pattern.faces_vertices[f][:3])]
        normal = np.cross(b - a, c - b)
        others = [v for v in design.pattern.faces_vertices[g] if v not in design.pattern.faces_vertices[f]]
        heights = (state[others] - a) @ normal / np.linalg.norm(normal)
        assert_close(rows_of(constraint, model, design.vertices_coords).ravel(), np.abs(heights), 1e-12)
        assert_close(constraint.lower, min(separation.CLEARANCE, np.abs(heights).min() / 2), 1e-12)


def test_rows_follow_the_motion_of_another_design() -> None:
    """They are those of the folded design, not of the seed; 2.2 is on the same side of 90 degrees."""
    seed = eggbox(3, 3)
    model = DesignModel(seed)
    (constraint,) = separation.in_state(model, np.array([[0, 2]]), 2.2)
    other = eggbox(3, 3, fold_state=0.62, sector_angle=1.1)
    state = folding.fold(other, np.array([2.2])).vertices_coords[0] / model.scale
    f, g = (int(word) for word in constraint.name.split("_")[1:3])
    a, b, c = state[list(other.pattern.faces_vertices[f][:3])]
    normal = np.cross(b - a, c - b)
    heights = [abs((state[v] - a) @ normal) / np.linalg.norm(normal) for v in other.pattern.faces_vertices[g]]
    assert_close(np.sort(rows_of(constraint, model, other.vertices_coords).ravel()), np.sort(heights), 1e-12)
    assert np.abs(rows_of(constraint, model, seed.vertices_coords).ravel() - np.sort(heights)).max() > 1e-2


def test_pairs_that_touch_say_nothing() -> None:
    """Neighbours share an edge, and of facets in one plane neither is on a side of the other."""
    model = DesignModel(eggbox(2, 4))
    assert separation.in_state(model, np.empty((0, 2), np.int64), 2.0) == []
    assert separation.side_of(model.pattern.faces_vertices, model.seed_points * [1, 1, 0], (0, 3)) is None


def s_curve(**limits: Any) -> inverse.Result:
    """A 4-gon along an S so strong that its facets cross when it is nearly flat."""
    angles = np.sin(np.linspace(0, 2 * np.pi, 401))
    steps = np.column_stack([np.sin(angles), 0 * angles, np.cos(angles)]) * 6 / 400
    points = np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])[::20].tolist()
    task = {
        "pattern": {"kind": "tube", "size": [4, 10]},
        "target": {"axis": {"spline": points}, "radius": 1.0},
        "constraints": limits,
    }
    return inverse.solve(load({"name": "s"} | task))


@pytest.mark.slow
def test_an_asked_range_of_the_motion_is_kept_open() -> None:
    before = s_curve()
    assert before.ending == "solved"
    (end,) = before.certificate.crossings
    assert before.certificate.free_range == (0.0, end.t)
    assert 100 < end.t < 160
    a, b = end.facets[0]
    assert f"facets {a} and {b}" in end.sentence
    after = s_curve(free_range=[5, 160])
    assert after.ending == "solved"
    low, high = after.certificate.free_range or (90, 90)
    assert low <= 5
    assert high >= 160
    assert after.report["fit"]["mean_over_radius"] < 0.01
