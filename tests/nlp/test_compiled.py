"""Functions are made once for all problems of one structure; everything numeric is a parameter."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any

import numpy as np
import pytest

import inverse
from inverse.formulation.formulate import formulate
from inverse.nlp import compiled
from inverse.nlp.problem import Problem


@pytest.fixture(autouse=True)
def _nothing_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compiled, "_kept", OrderedDict())


def problem(height: str = "1.2*sqrt(1.1 - x^2 - y^2)", size: int = 4, **keys: Any) -> Problem:
    task = {
        "name": "dome",
        "pattern": {"size": [size, size]},
        "target": {"height": height, "domain": [[-0.6, 0.6], [-0.5, 0.5]]},
        **keys,
    }
    formulation = formulate(inverse.load(task))
    return Problem(formulation.goal.n_variables, formulation.objectives, formulation.fixed)


@pytest.mark.parametrize(
    "other",
    [
        lambda: problem("1.3*sqrt(1.4 - x^2 - y^2)"),
        lambda: problem(objectives={"fairness": 3e-4}),
        lambda: problem(constraints={"fold_angle": [30, 150], "edge_length": [0.5, 2.0]}),
        lambda: problem(pattern={"size": [4, 4], "sector_angle": 70}),
    ],
    ids=["target", "weights", "bounds", "seed"],
)
def test_what_is_numeric_shares_the_functions(other: Any) -> None:
    first, second = problem(), other()
    assert first.functions is second.functions
    # Shared functions give what its own would give.
    x, p = np.random.default_rng(0).standard_normal(second.n_variables), second.parameters()
    shared = [np.asarray(f(x, p)[1]) for f in (second.functions["nlp"], second.functions["grad_f"])]
    own = second._made()
    for name, values in zip(("nlp", "grad_f"), shared, strict=True):
        assert np.asarray(own[name](x, p)[1]) == pytest.approx(values, rel=1e-12, abs=1e-14)


@pytest.mark.parametrize(
    "other",
    [
        lambda: problem("1.2*cos(x)"),
        lambda: problem(size=5),
        lambda: problem(objectives={"fairness": 0.0}),
        lambda: problem(constraints={"keep_out": [{"below": -9.0}]}),
        lambda: problem(pattern={"size": [4, 4], "u_lines": "CFL"}, constraints={"sector_angle": [20, 150]}),
    ],
    ids=["another surface", "another size", "a term less", "a term more", "other elements"],
)
def test_another_structure_has_functions_of_its_own(other: Any) -> None:
    assert problem().functions is not other().functions


def test_only_so_many_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """A sweep over many sizes does not fill the memory; the latest stay, and one that is too large by itself too."""
    sizes = [problem(size=n) for n in (3, 4, 5)]
    monkeypatch.setattr(compiled, "KEPT_ROWS", sizes[1].n_rows + sizes[2].n_rows)
    for one in sizes:
        one.functions  # noqa: B018
    assert [rows for rows, _ in compiled._kept.values()] == [one.n_rows for one in sizes[1:]]
    assert problem(size=5).functions is sizes[2].functions
    monkeypatch.setattr(compiled, "KEPT_ROWS", 1)
    large = problem(size=6)
    assert large.functions is problem(size=6).functions
