"""Functions called with arrays: the same numbers as CasADi's own matrices, also from two threads."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from designs import eggbox, miura

from inverse import constraints
from inverse.dragging import LIMITS
from inverse.model import DesignModel
from inverse.nlp.part import Part
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami.pattern import Design


def posed(design: Design) -> Point:
    model = DesignModel(design)
    problem = Problem(model.n_variables, [], constraints.hard_constraints(model, LIMITS))
    x = model.seed_points.ravel() + 1e-2 * np.random.default_rng(0).standard_normal(model.n_variables)
    return Point(problem, x, problem.parameters())


def test_the_same_as_by_matrices_of_casadi() -> None:
    point = posed(miura(4, 5))
    rows, jacobian = point.problem.functions["jac_g"](point.variables, point.parameters)
    dense = np.asarray(jacobian)
    assert (point.rows == np.asarray(rows).ravel()).all()
    assert (point.jacobian.toarray() == dense).all()
    assert (posed(miura(4, 5)).rows == point.rows).all()  # without a Jacobian
    value, gradient = point.problem.functions["grad_f"](point.variables, point.parameters)
    assert point.objective == float(value)
    assert (point.gradient == np.asarray(gradient).ravel()).all()


def test_earlier_results_stay() -> None:
    point = posed(eggbox(4, 4))
    before = point.jacobian, point.rows.copy(), point.jacobian.toarray()
    other = point.moved(point.variables[::-1].copy())
    assert other.jacobian.data[0] != point.jacobian.data[0]
    assert (point.rows == before[1]).all()
    assert (before[0].toarray() == before[2]).all()


def test_two_threads() -> None:
    point = posed(miura(12, 12))
    places = [point.variables + 1e-3 * k for k in range(16)] + [2 * point.variables] * 16
    alone = [point.moved(x).jacobian.toarray() for x in places]
    with ThreadPoolExecutor(2) as pool:
        together = list(pool.map(lambda x: point.moved(x).jacobian.toarray(), places))
    assert all((a == b).all() for a, b in zip(alone, together, strict=True))


def test_a_part_is_those_rows_of_the_whole() -> None:
    """Also for bounds that differ from those of the terms, elements of several rows and other parameters."""
    point = posed(eggbox(3, 4))
    parameters = point.parameters * (1 + 1e-3 * np.arange(point.parameters.size))
    parameters[-1] = 1
    point = point.given(parameters)
    rows = np.flatnonzero(np.random.default_rng(1).random(point.problem.n_rows) < 0.3)
    for chosen in (rows, point.problem.equations, rows[:1]):
        part = Part(point.problem, chosen)
        assert (part.rows(point) == point.rows[chosen]).all()
        values, jacobian = part.linearized(point)
        assert (values == point.rows[chosen]).all()
        assert (jacobian.toarray() == point.jacobian[chosen].toarray()).all()
