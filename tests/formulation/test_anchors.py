"""Anchors, keep-outs and separations as distances in space, whatever the unit and place of the seed."""

from __future__ import annotations

import numpy as np
import pytest
from designs import GENERAL, assert_close, holds, holed, miura, perturbed, rotation, rows_of

from inverse import constraints
from inverse.crossing import crossing_facets
from inverse.formulation.anchors import PolylineAnchor
from inverse.model import DesignModel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import seeds
from inverse.origami.pattern import Design
from inverse.terms import separation

VERTICES = np.array([0, 3, 12, 20])


@pytest.fixture(params=[1.0, 1e-3, 1e5])
def model(request: pytest.FixtureRequest) -> DesignModel:
    seed = miura(4, 4)
    return DesignModel(seed.moved_to(request.param * (seed.vertices_coords @ rotation(2) + [5.0, -7.0, 2.0])))


def placed(model: DesignModel, where: np.ndarray) -> np.ndarray:
    """The seed with the held vertices at these places."""
    points = model.seed.vertices_coords.copy()
    points[VERTICES] = where
    return points


def test_points(model: DesignModel) -> None:
    to = np.arange(12.0).reshape(4, 3) * model.scale
    constraint = constraints.on_point(model, "held", VERTICES, to)
    assert constraint.is_equation
    assert constraint.labels == ("vertex 0", "vertex 3", "vertex 12", "vertex 20")
    offset = np.random.default_rng(0).standard_normal((4, 3)) * model.scale
    assert_close(rows_of(constraint, model, placed(model, to)), 0, 1e-13)
    assert_close(rows_of(constraint, model, placed(model, to + offset)), offset / model.scale, 1e-13)


def test_planes(model: DesignModel) -> None:
    point, normal = 2 * model.centre, np.array([2.0, -1.0, 2.0]) / 3
    constraint = constraints.on_plane(model, "held", VERTICES, point, normal)
    assert constraint.is_equation
    where = np.random.default_rng(1).standard_normal((4, 3)) * model.scale
    expected = (where - point) @ normal / model.scale
    assert_close(rows_of(constraint, model, placed(model, where))[:, 0], expected, 1e-12)


def test_segments_are_slid_along_and_end(model: DesignModel) -> None:
    rng = np.random.default_rng(2)
    start, end = (rng.standard_normal((4, 3)) * model.scale for _ in range(2))
    start[1], end[1] = [0, 0, 0], [0, 0, -2 * model.scale]  # along an axis
    constraint = constraints.on_segment(model, "held", VERTICES, start, end)
    for fraction in (0.0, 0.3, 1.0):
        rows = rows_of(constraint, model, placed(model, start + fraction * (end - start)))
        assert_close(rows[:, :2], 0, 1e-13)
        assert_close(rows[:, 2], fraction * np.linalg.norm(end - start, axis=1) / model.scale, 1e-13)
    assert_close(constraint.upper[:, 2], np.linalg.norm(end - start, axis=1) / model.scale, 1e-13)
    assert not constraint.lower.any()
    assert not constraint.upper[:, :2].any()
    for fraction in (-0.01, 1.01):
        assert not holds(constraint, model, placed(model, start + fraction * (end - start))).any()
    offset = rng.standard_normal((4, 3)) * model.scale
    along = (end - start) / np.linalg.norm(end - start, axis=1, keepdims=True)
    beside = np.linalg.norm(np.cross(offset, along), axis=1) / model.scale
    rows = rows_of(constraint, model, placed(model, start + offset))
    assert_close(np.linalg.norm(rows[:, :2], axis=1), beside, 1e-13)


def test_circles(model: DesignModel) -> None:
    centre, normal, radius = model.centre + model.scale, np.array([1.0, 2.0, -2.0]), 1.7 * model.scale
    constraint = constraints.on_circle(model, "held", VERTICES, centre, normal, radius)
    assert constraint.is_equation
    axis = normal / 3
    first = np.array([0.0, 1.0, 1.0]) / np.sqrt(2)
    angle = np.array([0.0, 1.0, 2.5, -2.0])[:, None]
    outward = np.cos(angle) * first + np.sin(angle) * np.cross(axis, first)
    assert_close(rows_of(constraint, model, placed(model, centre + radius * outward)), 0, 1e-13)
    # Away from the circle the rows are the heights over its plane and, to first order, outward distances.
    away = 1e-4 * np.array([1.0, -2.0, 0.5, 3.0])[:, None]
    moved = centre + (radius + away * model.scale) * outward + 3 * away * model.scale * axis
    rows = rows_of(constraint, model, placed(model, moved))
    assert_close(rows, np.hstack([3 * away, away]), 1e-6)


def test_keep_outs_hold_on_the_side_of_the_normal(model: DesignModel) -> None:
    point, normal = model.centre, np.array([0.0, 3.0, 4.0])
    constraint = constraints.keep_out(model, "out", point, normal)
    points = perturbed(model.seed, 0.1 * model.scale).vertices_coords
    heights = (points - point) @ normal / 5
    assert_close(rows_of(constraint, model, points)[:, 0], heights / model.scale, 1e-11)
    np.testing.assert_array_equal(holds(constraint, model, points), heights >= 0)
    assert len(constraint.labels) == model.pattern.n_vertices


def test_the_worst_element_is_named(model: DesignModel) -> None:
    to = model.seed.vertices_coords[VERTICES]
    held = constraints.on_point(model, "held", VERTICES, to)
    bounded = constraints.edge_length(model, (0.5, 1.5))
    problem = Problem(model.seed_points.size, [], [held, bounded])
    points = model.seed_points.copy()
    p = problem.parameters()
    found = Point(problem, points.ravel(), p).violations
    assert found["held"][0] < 1e-13
    assert found["edge_length"][0] == 0
    points[12] += [0, 0.25, 0]
    points[3] += [0.2, 0, 0]
    assert Point(problem, points.ravel(), p).violations["held"] == (pytest.approx(0.25, abs=1e-12), "vertex 12")
    points[0] += [3, 0, 0]
    size, where = Point(problem, points.ravel(), p).violations["edge_length"]
    a, b = (int(v) for v in where.removeprefix("edge ").split("-"))
    assert 0 in (a, b)
    longest = max(np.sum((points[0] - points[v]) ** 2) for v in (1, 5))
    assert size == pytest.approx(longest - 1.5**2, rel=1e-12)  # all edges of the seed have length 1


# ---- vertices that slide along polylines


def test_vertices_go_on_at_the_ends_of_their_segments() -> None:
    line = np.array([[0.0, 0, 0], [1, 0, 0], [1, 2, 0], [1, 2, 3]])
    anchor = PolylineAnchor("line", np.arange(6), line, np.array([0, 0, 1, 1, 2, 0]))
    places = [[0.5, 0, 0], [1, 0, 0], [1, 0, 0], [1, 2, 0], [1, 2, 3], [0, 0, 0]]
    assert anchor.moved_on(np.array(places)).segments.tolist() == [0, 1, 0, 2, 2, 0]
    moved = anchor.moved_on(np.array(places) + 1e-8)
    assert moved.segments.tolist() == [0, 1, 0, 2, 2, 0]
    assert moved.name == "line"


# ---- facets that are kept apart


def plane_of(design: Design, facet: int) -> tuple[np.ndarray, np.ndarray]:
    points = design.vertices_coords[list(design.pattern.faces_vertices[facet])]
    normal = np.cross(points[1] - points[0], points[2] - points[0])
    return points[0], normal / np.linalg.norm(normal)


@pytest.mark.parametrize("pair", [(0, 15), (1, 10), (5, 15)])
def test_separated_facets_stay_on_one_side(model: DesignModel, pair: tuple[int, int]) -> None:
    constraint = separation.in_design(model, np.array([pair]))
    assert constraint is not None
    design = model.seed
    assert holds(constraint, model, design.vertices_coords).all()
    assert (constraint.lower > 0).all()
    assert (constraint.lower <= 0.05).all()
    heights = []
    for f, g in (pair, pair[::-1]):
        point, normal = plane_of(design, f)
        others = [v for v in design.pattern.faces_vertices[g] if v not in design.pattern.faces_vertices[f]]
        heights.append((design.vertices_coords[others] - point) @ normal / model.scale)
    kept = max((h for h in heights if abs(np.sign(h).sum()) == len(h)), key=lambda h: np.abs(h).min())
    assert_close(rows_of(constraint, model, design.vertices_coords)[:, 0], np.abs(kept), 1e-10)
    assert not holds(constraint, model, design.vertices_coords @ np.diag([1.0, 1, -1])).any()


def test_facets_in_one_plane_cannot_be_separated() -> None:
    """Facets (0, 0) and (2, 0) of a Miura lie in parallel planes, those of a strip's continuation in one."""
    design = seeds.grid((1, 3))
    flat = DesignModel(design.moved_to(design.vertices_coords * [1, 1, 0]))
    assert separation.in_design(flat, np.array([[0, 2]])) is None


def test_crossing_facets_are_found() -> None:
    for name in ("staircase", "polygonal", "holed"):
        design = GENERAL[name]()
        assert len(crossing_facets(design.vertices_coords, design.pattern.faces_vertices)) == 0
    design = holed()
    points = design.vertices_coords.copy()
    a, b = design.pattern.faces_vertices[0], design.pattern.faces_vertices[12]
    shift = points[list(b)].mean(axis=0) - points[list(a)].mean(axis=0)
    points[a[0]] += 1.3 * shift  # a corner is pulled through the facet
    pairs = crossing_facets(points, design.pattern.faces_vertices).tolist()
    assert pairs
    assert all(p[0] < p[1] for p in pairs)
    assert all(0 in p for p in pairs)
