"""Moves with factors that were kept: the results are those of new ones, and factors that serve no more are renewed."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from designs import ALL, assert_close, eggbox, miura, tube

from inverse import constraints
from inverse.dragging import LIMITS
from inverse.model import DesignModel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import geometry
from inverse.origami.pattern import Design
from inverse.solvers.least_move import LeastMove
from inverse.solvers.projection import Projection

SHEETS = {"miura": lambda: miura(8, 8), "eggbox": lambda: eggbox(8, 8)}
SMALL, LARGE = 0.005, 0.3  # of a move, in edges: the first is what factors serve for, the second is not


def posed(design: Design) -> tuple[Point, np.ndarray]:
    """A point on the constraints, and a wish of one edge for a corner that others follow."""
    model = DesignModel(design)
    problem = Problem(model.n_variables, [], constraints.hard_constraints(model, LIMITS))
    points = model.seed_points
    weights = np.exp(-((np.linalg.norm(points - points[0], axis=1) / (geometry.diagonal(points) / 4)) ** 2))
    wish = (weights[:, None] * np.array([0.3, -0.5, 0.8])).ravel()
    return Point(problem, points.ravel(), problem.parameters()), wish


def moved(projection: Projection, point: Point, wish: np.ndarray, moves: int) -> list[Point]:
    path = [point]
    for _ in range(moves):
        further = projection.moved(path[-1], wish)
        assert further is not None
        path.append(further)
    return path


@pytest.mark.parametrize("name", SHEETS)
def test_kept_factors_change_nothing(name: str) -> None:
    """Every move is the one that new factors make, and its residual as small."""
    start, wish = posed(SHEETS[name]())
    projection = Projection()
    path = moved(projection, start, SMALL * wish, 10)
    assert projection.factorizations < 5
    for before, after in pairwise(path):
        fresh = Projection().moved(before, SMALL * wish)
        assert fresh is not None
        assert_close(after.variables, fresh.variables, 1e-9 * SMALL)
        assert np.abs(after.rows[after.problem.equations]).max() < 1e-12


@pytest.mark.parametrize("name", ["miura", "eggbox", "hybrid", "polygonal"])
def test_forces_of_another_jacobian(name: str) -> None:
    """The projection of a wish is that of new factors."""
    start, _ = posed(ALL[name]())
    rng = np.random.default_rng(0)
    near = start.moved(start.variables + 1e-3 * rng.standard_normal(start.variables.size))
    equations = start.problem.equations
    old, new = start.jacobian[equations], near.jacobian[equations]
    wish = rng.standard_normal(start.variables.size)
    forces = LeastMove(old).forces_of(new, new @ wish)
    assert forces is not None
    assert_close(new.T @ forces, LeastMove(new)(new @ wish), 1e-9)
    assert np.abs(old.T @ LeastMove(old).forces(new @ wish) - new.T @ forces).max() > 1e-4  # it is no small matter
    far = start.moved(start.variables + 0.1 * rng.standard_normal(start.variables.size)).jacobian[equations]
    assert LeastMove(old).forces_of(far, far @ wish) is None


def test_factors_that_serve_no_more_are_renewed() -> None:
    start, wish = posed(miura(8, 8))
    projection = Projection()
    path = moved(projection, start, SMALL * wish, 3)
    assert projection.factorizations == 1
    path = moved(projection, path[-1], LARGE * wish, 1)
    path = moved(projection, path[-1], LARGE * wish, 3)
    assert projection.factorizations >= 4  # at once where one move changes too much
    before = projection.factorizations
    moved(projection, path[-1], SMALL * wish, 3)
    assert projection.factorizations <= before + 2


def test_the_same_from_run_to_run() -> None:
    start, wish = posed(eggbox(8, 8))
    ends = [moved(Projection(), start, 0.02 * wish, 12)[-1].variables for _ in range(2)]
    assert (ends[0] == ends[1]).all()


@pytest.mark.parametrize(("k", "rows"), [(6, 3), (6, 4), (8, 4)])
def test_equations_that_depend_on_each_other_hold(k: int, rows: int) -> None:
    start, wish = posed(tube(k, rows))
    equations = start.problem.equations
    for point in moved(Projection(), start, 0.02 * wish, 8):
        assert np.abs(point.rows[equations]).max() < 1e-10


def test_bounds_are_held_with_factors_of_their_own() -> None:
    """A roof over a corner that wants upwards: later moves go along it, and the equations hold."""
    design = eggbox(5, 5)
    model = DesignModel(design)
    top = int(np.argmax(design.vertices_coords[:, 2]))
    roof = float(design.vertices_coords[top, 2]) + 0.01
    keep_out = constraints.keep_out(model, "roof", np.array([0, 0, roof]), np.array([0.0, 0, -1]))
    problem = Problem(model.n_variables, [], [*constraints.hard_constraints(model, LIMITS), keep_out])
    wish = np.zeros((design.pattern.n_vertices, 3))
    wish[top] = 0.01, 0, 0.02
    path = moved(Projection(), Point(problem, model.seed_points.ravel(), problem.parameters()), wish.ravel(), 6)
    heights = [model.points(point.variables)[:, 2].max() for point in path]
    assert heights[-1] == pytest.approx(roof, abs=1e-8)
    assert max(heights) < roof + 1e-8
    assert max(point.violation for point in path) < 1e-8
    assert path[-1].variables[3 * top] > path[0].variables[3 * top]


def test_another_problem_begins_anew() -> None:
    projection = Projection()
    for design in (miura(4, 4), miura(4, 5)):
        start, wish = posed(design)
        assert moved(projection, start, SMALL * wish, 2)[-1].violation < 1e-12
        assert projection.factorizations >= 1
