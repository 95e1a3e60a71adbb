"""The polish: Newton's rate, least moves, and equations that repeat or contradict each other."""

from __future__ import annotations

import numpy as np
import pytest
from designs import ALL, assert_close, eggbox, hybrid, miura, perturbed, tube

from inverse import constraints
from inverse.model import DesignModel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.nlp.term import Constraint
from inverse.origami.pattern import Design
from inverse.solvers.least_move import LeastMove
from inverse.solvers.projection import Projection, balanced, brought_near, polish

NAMES = ["miura", "eggbox", "hybrid", "polygonal", "two_holes"]


def posed(design: Design, *more: Constraint) -> tuple[DesignModel, Problem]:
    model = DesignModel(design)
    terms = [*constraints.hard_constraints(model, {"edge_length": (0.999999, 1.000001)}), *more]
    return model, Problem(model.seed_points.size, [], terms)


def residual(problem: Problem, x: np.ndarray) -> np.ndarray:
    rows = Point(problem, x, problem.parameters()).rows
    return (rows - problem.lower)[problem.lower == problem.upper]


def jacobian(problem: Problem, x: np.ndarray) -> np.ndarray:
    return Point(problem, x, problem.parameters()).jacobian.toarray()[problem.lower == problem.upper]


def moved(model: DesignModel, size: float, seed: int = 0) -> np.ndarray:
    return model.seed_points.ravel() + size * np.random.default_rng(seed).standard_normal(model.seed_points.size)


@pytest.mark.parametrize("name", NAMES)
def test_small_errors_vanish_at_newtons_rate(name: str) -> None:
    model, problem = posed(ALL[name]())
    x = moved(model, 1e-4)
    sizes = [np.abs(residual(problem, x)).max()]
    assert sizes[0] > 1e-5
    for steps in range(2, 9):
        sizes.append(
            np.abs(residual(problem, polish(Point(problem, x, problem.parameters()), steps=steps).variables)).max()
        )
    assert sizes[-1] < 5e-15
    assert sizes[1] < 30 * sizes[0] ** 2
    assert sizes[2] < max(30 * sizes[1] ** 2, 5e-15)
    assert sizes == sorted(sizes, reverse=True)


@pytest.mark.parametrize("name", NAMES)
def test_the_move_is_the_least_one(name: str) -> None:
    """Dense Newton steps of least norm go the same way; along the solutions nothing moves to first order."""
    model, problem = posed(ALL[name]())
    start = moved(model, 1e-4)
    x = polish(Point(problem, start, problem.parameters())).variables
    dense = start
    for _ in range(5):
        dense = dense - np.linalg.lstsq(jacobian(problem, dense), residual(problem, dense), rcond=1e-12)[0]
    assert_close(x, dense, 1e-11)
    j = jacobian(problem, x)
    tangent = np.linalg.svd(j)[2][len(j) :]
    assert len(tangent) == problem.n_variables - len(j)
    move = x - start
    assert np.linalg.norm(tangent @ move) < 30 * np.linalg.norm(move) ** 2
    assert np.linalg.norm(move) < np.linalg.norm(start - model.seed_points.ravel())


def test_a_move_along_the_solutions_is_kept() -> None:
    model, problem = posed(eggbox(4, 5))
    exact = model.seed_points.ravel()
    tangent = np.linalg.svd(jacobian(problem, exact))[2][len(jacobian(problem, exact)) :]
    along = tangent.T @ np.random.default_rng(1).standard_normal(len(tangent))
    errors = []
    for h in (1e-3, 5e-4):
        x = polish(Point(problem, exact + h * along, problem.parameters())).variables
        assert np.abs(residual(problem, x)).max() < 5e-15
        errors.append(np.linalg.norm(x - exact - h * along))
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)


def test_nothing_to_remove() -> None:
    model, problem = posed(hybrid(3))
    x = polish(Point(problem, model.seed_points.ravel(), problem.parameters())).variables
    assert_close(x, model.seed_points.ravel(), 1e-14)
    no_equations = Problem(x.size, [], [constraints.edge_length(model, (0.5, 2))])
    assert polish(Point(no_equations, x, no_equations.parameters())).variables is x


@pytest.mark.parametrize("name", ALL)
def test_a_polished_design_is_not_made_worse(name: str) -> None:
    model, problem = posed(ALL[name]())
    for seed in range(4):
        once = polish(Point(problem, moved(model, 1e-5, seed), problem.parameters())).variables
        again = polish(Point(problem, once, problem.parameters())).variables
        assert np.abs(residual(problem, again)).max() <= np.abs(residual(problem, once)).max()


def test_inequalities_are_left_alone() -> None:
    """The edge bounds of ``posed`` are far too narrow for the perturbed mesh: they play no part."""
    model, problem = posed(eggbox(3, 3))
    x = polish(Point(problem, moved(model, 1e-3), problem.parameters())).variables
    violations = Point(problem, x, problem.parameters()).violations
    assert violations["edge_length"][0] > 1e-5
    assert violations["opposite_angles"][0] < 1e-14


@pytest.mark.parametrize("times", [2, 3])
def test_equations_that_repeat_each_other(times: int) -> None:
    """Copies of an anchor change neither the result nor its accuracy."""
    design = hybrid(3)
    model = DesignModel(design)
    vertices, to = np.array([0, 5, 17]), perturbed(design, 1e-4, 2).vertices_coords[[0, 5, 17]]
    anchors = [constraints.on_point(model, f"anchor_{k}", vertices, to) for k in range(times)]
    _, once = posed(design, anchors[0])
    _, often = posed(design, *anchors)
    assert often.n_rows == once.n_rows + 9 * (times - 1)
    start = moved(model, 1e-4)
    x = polish(Point(often, start, often.parameters())).variables
    assert np.abs(residual(often, x)).max() < 1e-14
    assert_close(x, polish(Point(once, start, once.parameters())).variables, 1e-10)


@pytest.mark.parametrize("k", [4, 6])
def test_the_dependent_equations_of_a_tube(k: int) -> None:
    model, problem = posed(tube(k, 3))
    j = jacobian(problem, model.seed_points.ravel())
    assert np.linalg.matrix_rank(j, tol=1e-9) < len(j)
    x = polish(Point(problem, moved(model, 1e-5), problem.parameters())).variables
    assert np.abs(residual(problem, x)).max() < 1e-13
    assert np.abs(x - model.seed_points.ravel()).max() < 1e-3


def test_equations_that_contradict_each_other() -> None:
    """Nothing can satisfy them; the result is finite and no worse than the start."""
    design = eggbox(3, 3)
    model = DesignModel(design)
    at = design.vertices_coords[[0]]
    places = [at, at + np.array([1e-3, 0, 0])]
    twice = [constraints.on_point(model, f"anchor_{k}", np.array([0]), to) for k, to in enumerate(places)]
    _, problem = posed(design, *twice)
    start = moved(model, 1e-4)
    x = polish(Point(problem, start, problem.parameters())).variables
    assert np.isfinite(x).all()
    assert np.abs(residual(problem, x)).max() <= np.abs(residual(problem, start)).max()
    assert np.abs(x - start).max() < 0.1


def test_slopes_that_are_no_numbers_end_a_polish_and_a_move(monkeypatch: pytest.MonkeyPatch) -> None:
    model, problem = posed(eggbox())
    point = Point(problem, moved(model, 1e-4), problem.parameters(), np.ones(problem.n_rows))
    jacobian = Point.jacobian.fget
    assert jacobian is not None
    monkeypatch.setattr(Point, "jacobian", property(lambda own: np.nan * jacobian(own)))
    assert polish(point) is point
    assert balanced(point) is point
    assert Projection().moved(point, 0 * point.variables) is None


def test_what_is_far_off_comes_nearer_without_a_leap() -> None:
    """From where Newton's method leaps and the polish gives up; along the solutions little moves."""
    model, problem = posed(miura(12, 12))
    x = moved(model, 0.08)
    start = Point(problem, x, problem.parameters())
    sizes = [np.linalg.norm(residual(problem, one.variables)) for one in (start, brought_near(start))]
    assert sizes[1] < 0.3 * sizes[0]
    leap = LeastMove(start.jacobian[problem.equations])(residual(problem, x))
    assert np.abs(brought_near(start).variables - x).max() < 0.5 * np.abs(leap).max()


def test_where_equations_hold_nothing_is_brought_near() -> None:
    model, problem = posed(eggbox())
    exact = polish(Point(problem, model.seed_points.ravel(), problem.parameters()))
    assert_close(brought_near(exact).variables, exact.variables, 1e-12)
