"""The least violation of all constraints: found where there is none, and told where there is some everywhere."""

from __future__ import annotations

import numpy as np
import pytest
from designs import assert_close
from domes import PATTERNS, task

from inverse.formulation.formulate import formulate
from inverse.nlp.kernels import Elements, Kernel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.nlp.term import Constraint, Objective
from inverse.solvers.feasibility import WITHIN, least_violation


def on_the_line(*bounds: tuple[float, float]) -> Point:
    """x within several bounds at once, from 5."""

    def variable(name: str) -> Elements:
        return Elements(name, Kernel(name, lambda q, _: q, 1), np.array([[0]]), np.empty((1, 0)))

    terms = [
        Constraint(variable(f"bound{k}"), np.array([[low]]), np.array([[high]]), ("x",))
        for k, (low, high) in enumerate(bounds)
    ]
    problem = Problem(1, [Objective(variable("square"), 1.0)], terms)
    return Point(problem, np.array([5.0]), problem.parameters())


def test_what_contradicts_itself_is_met_half_way() -> None:
    found = least_violation(on_the_line((6.0, 9.0), (0.0, 4.0)), lambda: True)
    assert found.settled
    assert not found.is_feasible
    assert_close(found.point.variables, [5.0], 1e-3)
    assert found.squared == pytest.approx(2.0, rel=1e-3)


def test_what_can_be_met_is() -> None:
    found = least_violation(on_the_line((-np.inf, 1.0), (-2.0, np.inf)), lambda: True)
    assert found.settled
    assert found.is_feasible
    assert -2 - WITHIN <= found.point.variables[0] <= 1 + WITHIN


def test_who_says_stop_gets_no_verdict() -> None:
    found = least_violation(on_the_line((6.0, 9.0), (0.0, 4.0)), lambda: False)
    assert not found.settled
    assert_close(found.point.variables, [5.0], 0)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_sheet_comes_to_its_anchors(pattern: str) -> None:
    """Two corners drawn together by a fifth."""
    corners = [0, -1]
    seed = formulate(task(pattern=PATTERNS[pattern])).goal.model.seed
    numbers = [range(seed.pattern.n_vertices)[k] for k in corners]
    a, b = seed.vertices_coords[corners]
    points = [(0.9 * p + 0.1 * q).tolist() for p, q in ((a, b), (b, a))]
    anchors = [{"vertices": [v], "to": {"point": p}} for v, p in zip(numbers, points, strict=True)]
    formulation = formulate(task(pattern=PATTERNS[pattern], constraints={"anchors": anchors}))
    goal = formulation.goal
    problem = Problem(goal.n_variables, formulation.objectives, formulation.fixed)
    found = least_violation(Point(problem, goal.seed_variables, problem.parameters()), lambda: True)
    assert found.is_feasible
    assert_close(goal.model.points(found.point.variables)[numbers], np.array(points), 1e-6)
