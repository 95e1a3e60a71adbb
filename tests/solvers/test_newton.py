"""Newton's method from the solution of a task like this one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from designs import assert_close

import inverse
from inverse.formulation.formulate import Formulation, formulate
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.policy import verdict
from inverse.policy.control import Control
from inverse.policy.rounds import Rounds
from inverse.solvers.kkt import REGULARIZED, Factors
from inverse.solvers.newton import METHOD, newton
from inverse.solvers.run import Ending, Progress


def task(height: str, **keys: Any) -> Formulation:
    base = {"name": "t", "pattern": {"size": [8, 8]}, "target": {"height": height, "domain": [[-0.6, 0.6]] * 2}}
    return formulate(inverse.load(base | keys))


def solved(formulation: Formulation) -> Point:
    point = Rounds(formulation, inverse.load(TASK).specification.solver, Control(np.inf), "ipopt").run()
    assert point.violation < 1e-7
    return point


def moved(point: Point, formulation: Formulation) -> Point:
    problem = Problem(formulation.goal.n_variables, formulation.objectives, formulation.fixed)
    return Point(problem, point.variables, problem.parameters(), point.multipliers)


def always(_: Progress) -> bool:
    return True


TASK = {"name": "t", "target": {"height": "0", "domain": [[0, 1], [0, 1]]}, "pattern": {"size": [4, 4]}}
DOME, HIGHER = "1.01*sqrt(1.02 - x^2 - y^2)", "1.03*sqrt(1.03 - x^2 - y^2)"
# Bounds that push: folds of at least 70 degrees, edges that may hardly change.
TIGHT = {"constraints": {"fold_angle": [75, 160], "edge_length": [0.8, 1.25]}}


@pytest.mark.parametrize("keys", [{}, TIGHT], ids=["no bound pushes", "bounds push"])
def test_it_comes_to_the_solution_that_ipopt_finds(keys: dict[str, Any]) -> None:
    before, after = task(DOME, **keys), task(HIGHER, **keys)
    start, expected = solved(before), solved(after)
    run = newton(moved(start, after), after.goal.model.refinement, 1e-9, 99, always)
    assert run is not None
    assert (run.ending, run.method) == (Ending.SOLVED, METHOD)
    assert run.end.objective == pytest.approx(expected.objective, rel=1e-7)
    assert_close(run.end.variables, expected.variables, 1e-4)
    judged = verdict.judge(run.end, after.goal)
    assert judged.failed == ()
    assert judged.stationarity < 1e-8
    assert run.end.violation < 2e-9
    bounds = run.end.problem.lower != run.end.problem.upper
    pushing = np.abs(run.end.balance[bounds]).max() > 0
    assert pushing == bool(keys)


def test_it_ends_where_it_is_told_to() -> None:
    before, after = task(DOME), task(HIGHER)
    start = moved(solved(before), after)
    seen: list[int] = []

    def twice(progress: Progress) -> bool:
        seen.append(progress.iteration)
        return len(seen) < 2

    assert newton(start, after.goal.model.refinement, 1e-9, 99, twice) is None
    assert seen == [0, 1]


def test_it_gives_up_far_away_and_where_there_is_no_number() -> None:
    before = task(DOME)
    start = solved(before)
    far = start.moved(start.variables + 3.0 * np.random.default_rng(0).standard_normal(start.variables.size))
    assert newton(far, before.goal.model.refinement, 1e-9, 99, always) is None
    assert newton(start.moved(np.full_like(start.variables, np.nan)), 1.0, 1e-9, 99, always) is None


def test_a_saddle_is_no_minimum() -> None:
    """Where the objective counts negatively every solution is a maximum: as many pivots are negative as that takes."""
    formulation = task(DOME)
    point = solved(formulation)
    problem, held = point.problem, point.problem.equations
    up = problem.curvature(point.variables, point.parameters, 1e3, 1e3 * point.balance)
    assert Factors(problem, held, up, point.jacobian.data, 0.0).is_minimum
    assert not Factors(problem, held, -up, point.jacobian.data, 0.0).is_minimum
    assert Factors(problem, held, -up, point.jacobian.data, 1e3).is_minimum


def test_a_step_solves_its_equations() -> None:
    formulation = task(DOME, **TIGHT)
    point = solved(formulation)
    problem = point.problem
    rng = np.random.default_rng(2)
    held = np.sort(np.r_[problem.equations, rng.choice(np.flatnonzero(problem.lower != problem.upper), 9, False)])
    hessian = problem.curvature(point.variables, point.parameters, 1e3, 1e3 * point.balance)
    factors = Factors(problem, held, hessian, point.jacobian.data, 0.5)
    slope, off = rng.standard_normal(problem.n_variables), rng.standard_normal(len(held))
    move, change = factors.step(slope, off)
    whole = np.zeros((problem.n_variables,) * 2)
    whole[problem.evaluations.hessian_pattern] = hessian
    whole += np.triu(whole, 1).T + 0.5 * np.eye(len(whole))
    rows = point.jacobian[held].toarray()
    size = 1e-7 * (1 + np.abs(move).max() + np.abs(change).max())
    assert_close(whole @ move + rows.T @ change, -slope, size)
    assert_close(rows @ move - REGULARIZED * change, -off, size)


def test_held_rows_are_kept_in_any_order_of_tasks() -> None:
    """Structures are kept by the rows that are held: another set in between changes nothing."""
    before, after = task(DOME), task(HIGHER)
    start = solved(before)
    first = newton(moved(start, after), 1.0, 1e-9, 99, always)
    tight = task(DOME, **TIGHT)
    newton(moved(solved(tight), tight), 1.0, 1e-9, 99, always)
    again = newton(moved(start, after), 1.0, 1e-9, 99, always)
    assert first is not None
    assert again is not None
    assert (first.end.variables == again.end.variables).all()
    assert (first.iterations, first.method) == (again.iterations, again.method)
