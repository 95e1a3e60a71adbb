"""Objectives mean the same at every number of facets; steps with linear constraints; rounds that are accelerated."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from designs import assert_close

import inverse
from inverse.formulation.formulate import formulate
from inverse.model import DesignModel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import geometry
from inverse.origami.pattern import FloatArray
from inverse.policy.following import _ahead

SIZES = (8, 16, 24)


def task(n: int, **keys: Any) -> inverse.spec.Loaded:
    target = {"height": "0.05", "domain": [[-0.6, 0.6], [-0.6, 0.6]]}
    return inverse.load({"name": "flat", "pattern": {"size": [n, n]}, "target": target} | keys)


def terms(n: int, move: Any) -> dict[str, float]:
    """Values of the objectives after a movement of the seed, a function of places 0..1 along u and v."""
    formulation = formulate(task(n))
    model = formulation.goal.model
    problem = Problem(model.seed_points.size, formulation.objectives, formulation.fixed)
    u, v = np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    moved = model.seed.vertices_coords + move(model, u.ravel()[:, None], v.ravel()[:, None])
    return Point(problem, model.to_dimensionless(moved).ravel(), problem.parameters()).objective_terms


def shifted(model: DesignModel, u: FloatArray, v: FloatArray) -> FloatArray:
    """From the target, where the seed's mean vertex is and its facets are not."""
    heights = geometry.facet_centroids(model.pattern, model.seed.vertices_coords)[:, 2]
    return np.hstack([0.01 + 0 * u, 0.02 + 0 * u, 0.08 - heights.mean() + 0 * u])


def bent(model: DesignModel, u: FloatArray, v: FloatArray) -> FloatArray:
    return np.hstack([0 * u, 0.2 * u * u, 0.3 * u * u + 0.1 * v * v])


def stretched(model: DesignModel, u: FloatArray, v: FloatArray) -> FloatArray:
    return 0.1 * (model.seed.vertices_coords - model.centre)


@pytest.mark.parametrize(("name", "move"), [("coverage", shifted), ("fairness", bent), ("evenness", stretched)])
def test_the_same_movement_costs_the_same_at_every_size(name: str, move: Any) -> None:
    values = [terms(n, move)[name] for n in SIZES]
    assert values[0] > 1e-9
    # Along the last two lines of a parity there is no second difference, and corrugations that reach beyond the
    # target's border are taken back to it: matters of one row in n.
    tolerance = {"coverage": 0.08, "fairness": 0.02, "evenness": 1e-9}[name]
    assert_close(values, [values[0]] * len(SIZES), tolerance * values[0])


def test_distances_are_in_sixteenths_of_the_model() -> None:
    for n in SIZES:
        model = formulate(task(n)).goal.model
        plan = model.scale * model.refinement * 16
        assert plan == pytest.approx(formulate(task(16)).goal.model.scale * 16, rel=1e-12)
        # Whatever the distances are, by how much lifting and lowering raise their mean square is the lift squared.
        low, flat, high = (terms(n, lambda _, u, v, z=z: np.array([0.0, 0.0, z]))["fit"] for z in (-0.02, 0.0, 0.02))
        assert (low + high) / 2 - flat == pytest.approx((0.02 * 16 / plan) ** 2 / 3, rel=1e-6)


def test_the_share_of_curvature() -> None:
    formulation = formulate(task(4))
    model = formulation.goal.model
    problem = Problem(model.seed_points.size, formulation.objectives, formulation.fixed)
    rng = np.random.default_rng(1)
    x = model.seed_points.ravel() + 0.05 * rng.standard_normal(model.seed_points.size)
    p, multipliers = problem.parameters(), rng.standard_normal(problem.n_rows)
    hessian = problem.functions["hess_lag"]
    whole, linear = hessian(x, p, 2.0, multipliers), hessian(x, problem.layout.linearized(p), 2.0, multipliers)
    objective = hessian(x, p, 2.0, 0 * multipliers)
    assert_close(np.asarray(linear), np.asarray(objective), 0)
    assert np.abs(np.asarray(whole) - np.asarray(linear)).max() > 1e-2
    assert_close(Point(problem, x, problem.layout.linearized(p)).gradient, Point(problem, x, p).gradient, 0)


@pytest.mark.parametrize("rate", [-0.9, -0.5, 0.4])
def test_rounds_that_go_past_the_solution_are_pulled_back(rate: float) -> None:
    rng = np.random.default_rng(2)
    solution, aim = rng.standard_normal((2, 5, 3))
    plain, before, steps = aim, None, 0
    while np.abs(aim - solution).max() > 1e-6:
        found = solution + rate * (aim - solution)
        step = found, found - aim
        aim, before = _ahead(step, before), step
        plain = solution + rate * (plain - solution)
        steps += 1
        assert steps < 30
    assert np.abs(plain - solution).max() > 1e2 * np.abs(aim - solution).max()


def test_a_result_is_a_start() -> None:
    dome = {"height": "0.45 - 0.3*(x^2 + y^2)", "domain": [[-0.6, 0.6], [-0.6, 0.6]]}
    first = inverse.solve(task(6, target=dome))
    again = inverse.solve(task(6, target=dome), start=first)
    assert again.certified
    assert again.converged
    assert again.report["iterations"] <= 1
    assert_close(again.design.vertices_coords, first.design.vertices_coords, 1e-7)
    moved = task(6, target=dome | {"height": "0.462 - 0.31*(x^2 + y^2)"})
    cold, warm = inverse.solve(moved), inverse.solve(moved, start=first)
    assert warm.certified
    assert warm.converged
    assert warm.report["iterations"] < 0.7 * cold.report["iterations"]
    assert_close(warm.design.vertices_coords, cold.design.vertices_coords, 1e-6)
    with pytest.raises(inverse.InputError, match="the start has another pattern: 36 facets, the specification 64"):
        inverse.solve(task(8, target=dome), start=first)


def test_a_result_of_a_task_with_other_bounds_is_a_start() -> None:
    dome = {"height": "0.45 - 0.3*(x^2 + y^2)", "domain": [[-0.6, 0.6], [-0.6, 0.6]]}
    tight = {"edge_length": [0.95, 1.05]}  # too many near their limits to be left out
    first = inverse.solve(task(6, target=dome))
    moved = task(6, target=dome, constraints=tight | {"keep_out": [{"below": -1.0}]})
    result = inverse.solve(moved, start=first)
    assert result.multipliers.size > first.multipliers.size
    assert result.certified
    assert result.converged
