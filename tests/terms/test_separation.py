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


# ---- the side that a facet lies on


FLAT = [[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]  # facet 0, its plane z = 0


def side(*points: list[float], faces: list[tuple[int, ...]] | None = None) -> separation.Side | None:
    """Of a facet on ``points`` beside the flat one."""
    faces = faces or [(0, 1, 2), tuple(range(3, 3 + len(points)))]
    return separation.side_of(faces, np.array([*FLAT, *points], float), (0, 1))


@pytest.mark.parametrize("sign", [1, -1])
def test_a_facet_lies_on_one_side_by_the_least_of_its_heights(sign: int) -> None:
    """The other facet leans, so that its own plane passes through the flat one."""
    found = side([0, 0, 0.2 * sign], [1, 0, 0.2 * sign], [0, 1, 0.7 * sign])
    assert found == separation.Side(0, (3, 4, 5), sign, pytest.approx(0.2))


def test_the_plane_that_separates_them_most_is_taken() -> None:
    """Vertices of the flat facet are at least 3/5 below the other's plane, its own as little as 1/4 above."""
    steep = [[2.0, 0, 0.25], [2.0, 1, 0.25], [2.5, 0, 0.25 + 2.0 / 3]]
    found = side(*steep)
    assert found is not None
    assert (found.facet, found.others) == (1, (0, 1, 2))
    normal = np.cross(np.subtract(steep[1], steep[0]), np.subtract(steep[2], steep[1]))
    heights = (np.array(FLAT) - steep[0]) @ normal / np.linalg.norm(normal)
    assert found.least == pytest.approx(np.abs(heights).min())
    assert found.least > 0.25
    assert found.sign == np.sign(heights[0])


def test_of_planes_that_separate_alike_the_first_facets_is_taken() -> None:
    found = side([0, 0, 0.5], [1, 0, 0.5], [0, 1, 0.5])
    assert found is not None
    assert found.facet == 0


def test_facets_through_each_others_planes_have_no_side() -> None:
    assert side([0.2, 0.2, -1], [0.2, 0.2, 1], [0.2, 5, 1]) is None


def test_only_vertices_of_its_own_have_a_side() -> None:
    """Of two facets with a common edge one vertex each; the common ones are at height zero."""
    found = side([0.5, -1, 0.3], faces=[(0, 1, 2), (1, 0, 3)])
    assert found is not None
    assert found.others in ((2,), (3,))
    assert side(faces=[(0, 1, 2), (2, 1, 0)]) is None


def test_a_thousandth_of_an_edge_off_a_plane_says_nothing_of_the_side() -> None:
    assert separation.TOUCHING == 1e-3
    for height, says in ((0.99e-3, False), (1.01e-3, True)):
        found = side([0, 0, height], [1, 0, height], [0, 1, height])
        assert (found is not None) is says


# ---- facets kept apart in the design state


def test_rows_in_the_design_state_are_heights_that_may_halve() -> None:
    """By a twentieth of an edge at most; a facet that is nearer keeps half of what it has."""
    design = eggbox(4, 4)
    model = DesignModel(design)
    faces, points = model.pattern.faces_vertices, model.seed_points
    pairs = np.array([[f, g] for f in range(len(faces)) for g in range(f + 2, len(faces))])
    sides = [found for pair in pairs.tolist() if (found := separation.side_of(faces, points, pair))]
    constraint = separation.in_design(model, pairs)
    assert constraint is not None
    least = np.concatenate([[one.least] * len(one.others) for one in sides])
    assert_close(constraint.lower.ravel(), np.minimum(0.05, least / 2), 1e-15)
    assert np.isinf(constraint.upper).all()
    assert constraint.labels == tuple(f"vertex {v}" for one in sides for v in one.others)
    rows = rows_of(constraint, model, design.vertices_coords).ravel()
    assert (rows > 0).all()
    assert_close([rows[k:][: len(one.others)].min() for k, one in _starts(sides)], [s.least for s in sides], 1e-12)


def _starts(sides: list[separation.Side]) -> list[tuple[int, separation.Side]]:
    counts = [0, *np.cumsum([len(one.others) for one in sides]).tolist()]
    return list(zip(counts, sides, strict=False))


def test_facets_that_nothing_separates_have_no_rows() -> None:
    model = DesignModel(eggbox(2, 4))
    assert separation.in_design(model, np.array([[0, 0]])) is None
    assert separation.in_state(model, np.array([[0, 0]]), 2.0) == []


@pytest.mark.parametrize("distance", [0.06, 0.2])
def test_the_clearance_is_a_twentieth_or_half_of_what_there_is(
    distance: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same in a state of the motion."""
    model = DesignModel(eggbox(2, 4))
    other = model.pattern.faces_vertices[2]
    monkeypatch.setattr(separation, "side_of", lambda *_: separation.Side(0, tuple(other), 1.0, distance))
    expected = {0.06: 0.03, 0.2: 0.05}[distance]
    constraint = separation.in_design(model, np.array([[0, 2]]))
    assert constraint is not None
    assert_close(constraint.lower, expected, 1e-15)
    (in_state,) = separation.in_state(model, np.array([[0, 2]]), 2.0)
    assert_close(in_state.lower, expected, 1e-15)
