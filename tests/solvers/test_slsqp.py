"""The second solver: problems with known solutions, agreement with the first, and how a run is ended."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import casadi
import numpy as np
import pytest
from designs import assert_close

import inverse
from inverse.formulation.formulate import formulate
from inverse.nlp.kernels import Elements, Kernel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.nlp.term import Constraint, Objective
from inverse.policy import verdict
from inverse.solvers.chart import Chart, Functions
from inverse.solvers.ipopt import Ipopt
from inverse.solvers.run import Ending, Progress, Run
from inverse.solvers.slsqp import Slsqp
from inverse.terms.goal import Goal

DOME = {"height": "0.45 - 0.3*(x^2 + y^2)", "domain": [[-0.6, 0.6], [-0.6, 0.6]]}
PLANE = {"side": "u0", "every": 2, "to": {"plane": {"point": [-0.55, 0, 0], "normal": [1, 0, 0]}}}


def on(_: Progress) -> bool:
    return True


def elements(name: str, residual: Callable[[casadi.SX], casadi.SX], n: int) -> Elements:
    return Elements(name, Kernel(name, lambda q, _: residual(q), n), np.arange(n)[None], np.empty((1, 0)))


def bounded(name: str, residual: Callable[[casadi.SX], casadi.SX], n: int, lower: float, upper: float) -> Constraint:
    return Constraint(elements(name, residual, n), np.array([[lower]]), np.array([[upper]]), (name,))


def sphere(times: int = 1) -> tuple[Problem, np.ndarray, np.ndarray]:
    """The point of a sphere that is nearest to (2, 1, 2) with z at most 1/2; with its solution and multipliers.

    The sphere is given ``times`` over. With z = 1/2 the circle x^2 + y^2 = 3/4 is left: (x, y) is along (2, 1).
    """
    aim = casadi.DM([2, 1, 2])
    objective = Objective(elements("aim", lambda q: q - aim, 3), 3.0)  # the plain sum of squares
    terms = [bounded(f"sphere_{k}", casadi.sumsqr, 3, 1.0, 1.0) for k in range(times)]
    terms += [
        bounded("active", lambda q: q[2], 3, -5.0, 0.5),
        bounded("idle", lambda q: q[0] + q[1], 3, -9.0, np.inf),
    ]
    x = np.sqrt(0.75 / 5) * np.array([2.0, 1.0, 0.0]) + np.array([0, 0, 0.5])
    # 2 (x - 2) + 2 l x = 0 and 2 (z - 2) + 2 l z + m = 0
    of_sphere = 2 / x[0] - 1
    of_bound = 4 - 2 * (1 + of_sphere) * 0.5
    return Problem(3, [objective], terms), x, np.array([*[of_sphere / times] * times, of_bound, 0.0])


def solved(problem: Problem, start: np.ndarray) -> Run:
    solver = Slsqp(problem, 1e-9, 1.0, on)
    return solver.run(Point(problem, start, problem.parameters()), 200)


@pytest.mark.parametrize("start", [[1.0, 0, 0], [0, 0.6, -0.8], [0.3, 0.2, 0.1], [2.0, 1, 2]])
def test_a_solution_in_closed_form(start: list[float]) -> None:
    """From the sphere, and from points that violate the equation, the last one stationary without it."""
    problem, x, multipliers = sphere()
    attempt = solved(problem, np.array(start))
    assert attempt.ending is Ending.SOLVED
    assert_close(attempt.end.variables, x, 1e-7)
    assert_close(attempt.end.multipliers, multipliers, 1e-6)
    assert multipliers[1] > 0.5  # the bound is active and pushes down
    assert attempt.seconds > attempt.seconds_functions > 0


def test_an_equation_that_is_given_twice() -> None:
    problem, x, multipliers = sphere(2)
    attempt = solved(problem, np.array([0.3, 0.2, 0.1]))
    assert attempt.ending is Ending.SOLVED
    assert_close(attempt.end.variables, x, 1e-7)
    # Only the sum of the two is determined.
    assert_close(attempt.end.multipliers[:2].sum(), multipliers[:2].sum(), 1e-6)
    assert_close(attempt.end.multipliers[2:], multipliers[2:], 1e-6)


def test_a_lower_bound_pushes_up() -> None:
    problem, _, _ = sphere()
    flipped = [
        problem.constraints[0],
        bounded("active", lambda q: -q[2], 3, -0.5, 5.0),
        problem.constraints[2],
    ]
    attempt = solved(Problem(3, problem.objectives, flipped), np.array([1.0, 0, 0]))
    _, x, multipliers = sphere()
    assert_close(attempt.end.variables, x, 1e-7)
    assert_close(attempt.end.multipliers, multipliers * [1, -1, 1], 1e-6)


def test_equations_that_nothing_satisfies() -> None:
    problem, _, _ = sphere()
    terms = [bounded("one", casadi.sumsqr, 3, 1.0, 1.0), bounded("two", lambda q: q[0], 3, 2.0, 2.0)]
    attempt = solved(Problem(3, problem.objectives, terms), np.array([1.0, 0.1, 0]))
    assert attempt.ending is not Ending.SOLVED
    assert np.isfinite(attempt.end.variables).all()


def test_slopes_along_the_manifold() -> None:
    """Both forms of the derivative agree with the change between points of the manifold."""
    problem, goal = grid()
    origin = goal.model.seed_points.ravel()
    origin = origin + 1e-3 * np.random.default_rng(1).standard_normal(origin.size)
    chart = Chart(Functions(problem, problem.parameters()), origin)
    directions = chart.tangents[:, :4]
    y, share, step = np.array([0.1, -0.2, 0.1, 0.05]), 0.6, 1e-5
    place = chart.at(directions @ y, share)
    assert place is not None
    for count in (3, 40):
        slopes = chart.slopes(place, place.jacobian[-count:], directions)
        for k in range(5):
            move = step * np.eye(5)[k]
            ahead = chart.at(directions @ (y + move[:4]), share + move[4])
            behind = chart.at(directions @ (y - move[:4]), share - move[4])
            assert ahead is not None
            assert behind is not None
            change = (ahead.rows - behind.rows)[-count:] / (2 * step)
            assert_close(slopes[:, k], change, 1e-7)


@cache
def grid() -> tuple[Problem, Goal]:
    formulation = formulate(inverse.load({"name": "dome", "pattern": {"size": [6, 6]}, "target": DOME}))
    goal = formulation.goal
    return Problem(goal.n_variables, formulation.objectives, formulation.fixed), goal


def test_agreement_with_ipopt() -> None:
    """From near one optimum both come to it, with the same multipliers."""
    problem, goal = grid()
    parameters, start = problem.parameters(), goal.model.seed_points.ravel()
    gradient = Point(problem, start, parameters).gradient
    first = Ipopt(problem, 1e-10, goal.model.refinement, on).run(Point(problem, start, parameters), 200, careful=True)
    second = Slsqp(problem, 1e-9, np.abs(gradient).max(), on).run(
        first.end.moved(first.end.variables + 1e-3 * np.sin(np.arange(start.size))).pushed(None), 300
    )
    assert first.ending is second.ending is Ending.SOLVED
    values = [run.end.objective for run in (first, second)]
    assert_close(values[1], values[0], 1e-6 * values[0])
    assert_close(second.end.variables, first.end.variables, 1e-4)
    assert not verdict.judge(second.end, goal).failed


@pytest.mark.parametrize("keys", [{}, {"constraints": {"anchors": [PLANE]}}])
def test_a_design(keys: dict[str, object]) -> None:
    """From specification to certificate; an anchor makes the seed violate equations."""
    seen: list[Progress] = []
    pattern = {"size": [6, 6], "u_lines": "CFL"}
    task = {"name": "dome", "pattern": pattern, "target": DOME, "solver": {"method": "nlopt"}} | keys
    result = inverse.solve(inverse.load(task), watch=lambda _, progress: seen.append(progress))
    assert result.certified
    assert result.converged
    assert result.report["fit"]["rms"] < 0.01 * result.report["fit"]["start_rms"]
    assert {a["method"].split(",")[0] for a in result.report["attempts"]} == {"nlopt"}
    assert [p.iteration for p in seen] == sorted({p.iteration for p in seen})
    assert result.report["iterations"] > seen[-1].iteration


def test_what_report_raises_is_raised_again() -> None:
    problem, _, _ = sphere()

    def report(progress: Progress) -> bool:
        if progress.iteration == 2:
            raise KeyboardInterrupt
        return True

    with pytest.raises(KeyboardInterrupt):
        Slsqp(problem, 1e-9, 1.0, report).run(Point(problem, np.array([1.0, 0, 0]), problem.parameters()), 99)


def test_report_stops_the_run() -> None:
    problem, _, _ = sphere()
    seen: list[Progress] = []

    def report(progress: Progress) -> bool:
        seen.append(progress)
        return len(seen) < 3

    attempt = Slsqp(problem, 1e-9, 1.0, report).run(Point(problem, np.array([1.0, 0, 0]), problem.parameters()), 99)
    assert attempt.ending is Ending.GIVEN_UP
    assert [p.iteration for p in seen] == [0, 1, 2]
    for progress in seen:
        assert progress.violation == Point(problem, progress.variables, problem.parameters()).violation


@pytest.mark.parametrize("limit", [1, 4, 13])
def test_the_limit(limit: int) -> None:
    problem, goal = grid()
    seen: list[Progress] = []

    def report(progress: Progress) -> bool:
        seen.append(progress)
        return True

    solver = Slsqp(problem, 1e-9, 1e-9, report)
    attempt = solver.run(Point(problem, goal.model.seed_points.ravel(), problem.parameters()), limit)
    assert attempt.ending is Ending.LIMIT
    assert attempt.iterations == limit
    assert len(seen) <= limit


def test_iterations_run_out() -> None:
    task = {"name": "dome", "pattern": {"size": [6, 6]}, "target": DOME}
    result = inverse.solve(inverse.load(task | {"solver": {"method": "nlopt", "max_iterations": 4}}))
    assert not result.converged
    assert result.ending == "iteration_limit"
