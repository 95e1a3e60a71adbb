"""Leaving idle bounds out: which rows stay, and that a bound that matters is never lost."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from designs import assert_close

import inverse
from inverse.formulation.formulate import formulate
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import geometry
from inverse.origami.pattern import FloatArray
from inverse.solvers import relaxation

DOME = {"height": "0.45 - 0.3*(x^2 + y^2)", "domain": [[-0.6, 0.6], [-0.6, 0.6]]}


def task(**keys: Any) -> inverse.spec.Loaded:
    return inverse.load({"name": "dome", "pattern": {"size": [6, 6]}, "target": DOME} | keys)


def whole(**keys: Any) -> tuple[Problem, FloatArray]:
    formulation = formulate(task(**keys))
    model = formulation.goal.model
    return Problem(model.seed_points.size, formulation.objectives, formulation.fixed), model.seed_points.ravel()


def test_equations_stay_and_idle_bounds_go() -> None:
    problem, x = whole()
    p = problem.parameters()
    found = relaxation.relaxed(Point(problem, x, p))
    assert found is not None
    assert list(found.rows) == list(np.flatnonzero(problem.lower == problem.upper))
    assert found.problem.objectives == problem.objectives


def test_bounds_that_are_near_stay() -> None:
    problem, x = whole()
    rng = np.random.default_rng(3)
    p, y = problem.parameters(), x + 0.02 * rng.standard_normal(x.size)
    rows = Point(problem, y, p).rows
    near = rng.choice(np.flatnonzero(problem.lower < problem.upper), 20, replace=False)
    problem.lower[near] = rows[near] - 1e-3
    kept = relaxation.relaxed(Point(problem, y, p))
    assert kept is not None
    assert set(near) <= set(kept.rows)
    # The rows that are left are the same functions with the same bounds, whatever the objectives' parameters are.
    other = p.copy()
    other[: problem.layout.n_objective] *= 1.5
    everything = Point(problem, y, other, rng.standard_normal(problem.n_rows))
    own = kept.own(everything)
    assert_close(own.rows, everything.rows[kept.rows], 1e-15)
    assert_close(own.jacobian.toarray(), everything.jacobian[kept.rows].toarray(), 1e-15)
    assert own.objective == pytest.approx(everything.objective, rel=1e-14)
    assert_close(own.balance, everything.balance[kept.rows], 0)
    back = kept.back(own, other)
    assert_close(back.balance[kept.rows], own.balance, 0)
    assert not np.delete(back.balance, kept.rows).any()
    assert_close(back.rows, everything.rows, 0)


def test_nothing_to_leave_out() -> None:
    problem, x = whole(constraints={"edge_length": [0.999, 1.001], "sector_angle": [59, 121], "fold_angle": [1, 179]})
    assert relaxation.relaxed(Point(problem, x, problem.parameters())) is None
    only = Problem(problem.n_variables, problem.objectives, [c for c in problem.constraints if c.is_equation])
    assert relaxation.relaxed(Point(only, x, only.parameters())) is None


@pytest.mark.parametrize(
    "bounds", [{"edge_length": [0.9, 1.1]}, {"fold_angle": [60, 175]}, {"sector_angle": [50, 130]}]
)
def test_bounds_that_matter_hold(bounds: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    usual = inverse.solve(task(constraints=bounds))
    assert usual.certified
    assert usual.converged
    monkeypatch.setattr(relaxation, "WORTHWHILE", -1.0)
    without = inverse.solve(task(constraints=bounds))
    assert {a["method"] for a in without.report["attempts"]} <= {
        "ipopt, linearized constraints",
        "ipopt, static pivots",
    }
    assert_close(usual.design.vertices_coords, without.design.vertices_coords, 1e-5)


def test_a_facet_that_turns_over_is_noticed() -> None:
    seed = formulate(task()).goal.model.seed
    points = seed.vertices_coords
    assert geometry.are_convex(seed.pattern, points)
    assert geometry.are_convex(seed.pattern, points @ np.linalg.qr(np.random.default_rng(0).standard_normal((3, 3)))[0])
    a, b, c, d = seed.pattern.faces_vertices[0]
    reflex, bow_tie = points.copy(), points.copy()
    reflex[a] = points[c] + 0.1 * (points[b] - points[c]) + 0.1 * (points[d] - points[c])
    bow_tie[[a, b]] = points[[b, a]]
    assert not geometry.are_convex(seed.pattern, reflex)
    assert not geometry.are_convex(seed.pattern, bow_tie)


def test_a_light_run_that_turns_a_facet_over_is_done_again(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = inverse.solve(task())
    monkeypatch.setattr(geometry, "are_convex", lambda *_: False)
    again = inverse.solve(task())
    assert [a["method"] for a in again.report["attempts"]][-2:] == [
        "ipopt, static pivots, without idle bounds",
        "ipopt, static pivots",
    ]
    assert again.certified
    assert again.converged
    assert_close(again.design.vertices_coords, usual.design.vertices_coords, 1e-6)
