"""Our own verdict at its limits and just beyond, on two variables whose optimum is known by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from inverse.nlp.kernels import Elements, Kernel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.nlp.term import Constraint, Objective
from inverse.policy import verdict
from inverse.policy.verdict import Judgement

GOAL: Any = None  # nothing of it is asked


def variable(name: str, k: int) -> Elements:
    """One variable as it is."""
    kernel = Kernel(name, lambda q, _: q, 1)
    return Elements(name, kernel, np.array([[k]]), np.empty((1, 0)))


def bounds(name: str, k: int, low: float, high: float) -> Constraint:
    return Constraint(variable(name, k), np.array([[low]]), np.array([[high]]), (f"the place of {name}",))


def point(x: float, multiplier: float, low: float = -np.inf, high: float = np.inf, y: float = 0.0) -> Point:
    """The least x^2 with x within bounds and y = 0, at (x, y)."""
    terms = [bounds("wall", 0, low, high), bounds("level", 1, 0.0, 0.0)]
    problem = Problem(2, [Objective(variable("square", 0), 1.0)], terms)
    return Point(problem, np.array([x, y]), problem.parameters(), np.array([multiplier, 0.0]))


@pytest.fixture(autouse=True)
def _no_goal(monkeypatch: pytest.MonkeyPatch) -> None:
    """Gradients as they are, and no footprint."""
    monkeypatch.setattr(verdict, "gradient_scale", lambda *_: 1.0)
    monkeypatch.setattr(verdict, "limits", lambda *_: [])


def judged(at: Point) -> Judgement:
    return verdict.judge(at, GOAL)


def fails(at: Point) -> str:
    """The one sentence on what fails, or nothing."""
    failed = judged(at).failed
    assert len(failed) <= 1
    return "".join(failed)


def test_the_optimum_is_one() -> None:
    found = judged(point(0.5, -1.0, low=0.5))
    assert (found.stationarity, found.complementarity, found.failed) == (0.0, 0.0, ())
    assert found.violations == {"wall": (0.0, "the place of wall"), "level": (0.0, "the place of level")}
    assert judged(point(-0.5, 1.0, high=-0.5)).failed == ()


@pytest.mark.parametrize("sign", [-1, 1])
def test_a_gradient_is_left_up_to_a_millionth(sign: int) -> None:
    assert not fails(point(0.5, -1.0 + sign * 0.99e-6, low=0.5))
    assert "not stationary" in fails(point(0.5, -1.0 + sign * 1.01e-6, low=0.5))


def test_the_scale_of_gradients_is_what_they_are_measured_by(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(verdict, "gradient_scale", lambda *_: 10.0)
    assert judged(point(0.5, -0.5, low=0.5)).stationarity == 0.05


@pytest.mark.parametrize("side", [-1, 1])
def test_bounds_that_push_from_afar_are_settled_up_to_a_hundredth_of_the_objective(side: int) -> None:
    """x = 1/2 + s is held by a bound at 1/2: multiplier times slack s (1 + 2 s), objective near 1/4; and mirrored."""

    def held(slack: float) -> Point:
        x = side * (0.5 + slack)
        return point(x, -2 * x, **{"low" if side > 0 else "high": side * 0.5})

    assert not fails(held(0.0024))
    assert "bounds are not settled" in fails(held(0.0026))


def test_where_the_objective_vanishes_a_little_is_left() -> None:
    """x = s is held by a bound at 0: multiplier times slack 2 s^2, objective s^2, allowed s^2 / 100 + 1e-10."""
    assert not fails(point(7.0e-6, -14.0e-6, low=0.0))
    assert "bounds are not settled" in fails(point(7.2e-6, -14.4e-6, low=0.0))


def test_multipliers_belong_to_the_bound_that_their_sign_names() -> None:
    """Pushed down at the lower bound, where an upper one is three away, or none; and up at the upper bound."""
    assert judged(point(-0.5, 1.0, low=-0.5, high=2.5)).complementarity == 3.0
    assert judged(point(-0.5, 1.0, low=-0.5)).complementarity == 1.0
    assert judged(point(0.5, -1.0, low=-1.5, high=0.5)).complementarity == 2.0
    assert "bounds are not settled" in fails(point(-0.5, 1.0, low=-0.5))


def test_equations_hold_to_a_billionth_and_bounds_to_ten_millionths() -> None:
    assert not fails(point(0.5, -1.0, low=0.5, y=0.99e-9))
    assert fails(point(0.5, -1.0, low=0.5, y=-1.01e-9)).startswith("constraint level is violated by 1e-09 at the place")
    within, beyond = 0.5 - 0.99e-7, 0.5 - 1.01e-7
    assert not fails(point(within, -2 * within, low=0.5))
    assert fails(point(beyond, -2 * beyond, low=0.5)).startswith("constraint wall is violated by 1e-07 at the place")


def test_what_is_no_number_passes_nothing() -> None:
    with np.errstate(invalid="ignore"):
        failed = judged(point(np.nan, -1.0, low=0.5)).failed
    assert [sentence.split()[0] for sentence in failed] == ["the", "bounds", "constraint"]


@pytest.mark.parametrize("at", [0, 1])
def test_limits_of_the_footprint_hold_to_a_millionth(at: int, monkeypatch: pytest.MonkeyPatch) -> None:
    values = [3.0, 3.0]

    def limits(*_: Any) -> list[dict[str, Any]]:
        return [
            {"state": "flat", "measure": f"side {k}", "value": value, "limit": 3.0} for k, value in enumerate(values)
        ]

    monkeypatch.setattr(verdict, "limits", limits)
    values[at] = 3.0 * (1 + 0.99e-6)
    assert not fails(point(0.5, -1.0, low=0.5))
    values[at] = 3.0 * (1 + 1.01e-6)
    assert fails(point(0.5, -1.0, low=0.5)) == f"the flat side {at} is 3, 3 allowed"


# ---- an asked range of the motion


def faults(asked: tuple[float, float] | None, free: tuple[float, float] | None) -> tuple[str, ...]:
    ends = (SimpleNamespace(sentence="one end"), SimpleNamespace(sentence="the other"))
    certificate: Any = SimpleNamespace(free_range=free, crossings=ends)
    return verdict.range_faults(asked, certificate)


ASKED = (np.pi / 4, 3 * np.pi / 4)


@pytest.mark.parametrize("free", [(45.0, 135.0), (0.0, 180.0), None])
def test_a_range_that_is_free(free: tuple[float, float] | None) -> None:
    assert faults(ASKED, free) == ()


@pytest.mark.parametrize("free", [(46.0, 180.0), (0.0, 134.0), (46.0, 134.0)])
def test_a_range_that_is_not_free_to_both_ends(free: tuple[float, float]) -> None:
    (sentence,) = faults(ASKED, free)
    assert f"free from {free[0]:g} to {free[1]:g} degrees, not from 45 to 135" in sentence
    assert sentence.endswith("one end; the other")


def test_who_asks_for_no_range_misses_none() -> None:
    assert faults(None, (89.0, 91.0)) == ()
