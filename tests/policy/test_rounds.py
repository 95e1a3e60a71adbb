"""The rounds of a solve: pivoting where fast steps stall, a start over the plan, the limit of iterations."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from designs import assert_close

import inverse
from inverse import objectives
from inverse.formulation.formulate import formulate
from inverse.surfaces.mesh import MeshTarget
from inverse.surfaces.parametric import HeightTarget
from inverse.terms.goal import Goal
from inverse.terms.surface_fit import SurfaceFitting, fit_vertices, mean_points

DOME = {"height": "0.45 - 0.3*(x^2 + y^2)", "domain": [[-0.6, 0.6], [-0.6, 0.6]]}


def task(**keys: object) -> inverse.spec.Loaded:
    return inverse.load({"name": "dome", "pattern": {"size": [6, 6]}, "target": DOME} | keys)


STEPS = ["ipopt, linearized constraints", "ipopt, static pivots, without idle bounds", "ipopt, pivoting"]


@pytest.mark.parametrize("stall", [1, 2, 3])
def test_a_stalled_run_goes_on_with_pivoting(stall: int, monkeypatch: pytest.MonkeyPatch) -> None:
    usual = inverse.solve(task())
    assert [a["method"] for a in usual.report["attempts"]] == STEPS[:2]
    monkeypatch.setattr(sys.modules["inverse.solvers.ipopt"], "STALL", stall)
    result = inverse.solve(task())
    assert [a["method"] for a in result.report["attempts"]] == STEPS
    assert result.report["attempts"][1]["iterations"] == stall
    assert result.certified
    assert result.converged
    assert_close(result.report["fit"]["rms"], usual.report["fit"]["rms"], 1e-5)


def test_a_round_keeps_to_the_iterations_allowed() -> None:
    result = inverse.solve(task(solver={"max_iterations": 3}))
    assert result.report["attempts"][0]["ended"] == "Maximum_Iterations_Exceeded"
    assert {attempt["iterations"] for attempt in result.report["attempts"]} <= {0, 1, 2, 3}
    assert not result.converged
    assert result.ending == "iteration_limit"


def test_places_over_the_plan() -> None:
    target = HeightTarget("0.5*x - 0.2*y", ((-1.0, 1.0), (-1.0, 1.0)))
    rng = np.random.default_rng(5)
    points = rng.uniform(-0.9, 0.9, (40, 3))
    over = target.over_plan(points)
    # On a plane the triangulation is exact; what is left is of the order of the squeeze squared.
    assert_close(over[:, :2], points[:, :2], 1e-6)
    assert_close(over[:, 2], 0.5 * over[:, 0] - 0.2 * over[:, 1], 1e-10)
    beyond = target.over_plan(np.array([[3.0, 0.25, 7.0]]))
    assert_close(beyond[0], [1.0, 0.25, 0.45], 1e-6)


def test_the_first_closest_points_lie_over_the_seed() -> None:
    vertices, triangles = HeightTarget(str(DOME["height"]), DOME["domain"]).triangles()  # type: ignore[arg-type]
    goal = Goal(SurfaceFitting(formulate(task()).goal.model, MeshTarget(vertices, triangles)))
    (elements,) = objectives.fit(goal)
    feet = goal.model.to_lengths(elements.parameters[:, :3])
    seed = mean_points(goal.model.seed.vertices_coords, fit_vertices(goal.model, "facets"))
    inside = np.abs(seed[:, :2]).max(axis=1) < 0.6
    assert inside.sum() > 20
    assert_close(feet[inside, :2], seed[inside, :2], 1e-4)
