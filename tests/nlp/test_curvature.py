"""The Hessian without elements that nothing pushes is the Hessian of the function that solvers are given."""

from __future__ import annotations

import numpy as np
import pytest
from designs import assert_close

import inverse
from inverse.formulation.formulate import formulate
from inverse.nlp.layout import Layout
from inverse.nlp.problem import Problem

TASKS = {
    "sheet": {"pattern": {"size": [5, 4]}, "target": {"height": "0.3*cos(x)", "domain": [[-1, 1], [-1, 1]]}},
    "tube": {
        "pattern": {"kind": "tube", "size": [4, 3]},
        "target": {"axis": {"polyline": [[0, 0, 0], [0, 0, 3]]}, "radius": [[0, 1.0], [1, 0.8]]},
    },
    "footprint": {
        "pattern": {"size": [3, 3]},
        "target": {"height": "0.3*cos(x)", "domain": [[-1, 1], [-1, 1]]},
        "objectives": {"footprint": 1e-3},
    },
}


@pytest.mark.parametrize("name", TASKS)
@pytest.mark.parametrize("share", [0.0, 0.2, 1.0])
@pytest.mark.parametrize("is_linear", [False, True])
def test_it_is_the_solvers_hessian(name: str, share: float, is_linear: bool) -> None:
    formulation = formulate(inverse.load({"name": name, **TASKS[name]}))
    problem = Problem(formulation.goal.n_variables, formulation.objectives, formulation.fixed)
    rng = np.random.default_rng(3)
    x = formulation.goal.seed_variables + 0.01 * rng.standard_normal(problem.n_variables)
    multipliers = rng.standard_normal(problem.n_rows) * (rng.random(problem.n_rows) < share)
    p = Layout.linearized(problem.parameters()) if is_linear else problem.parameters()
    expected = problem.evaluations.curvature(x, p, 7.0, multipliers)
    assert_close(problem.curvature(x, p, 7.0, multipliers), expected, 1e-11 * np.abs(expected).max())
