"""Numbers taken out of an expression: the same values, and one form for all numbers."""

from __future__ import annotations

from collections.abc import Callable

import casadi
import numpy as np
import pytest

from inverse.nlp.constants import lifted
from inverse.nlp.kernels import Kernel

EXPRESSIONS: dict[str, Callable[[casadi.SX, float], casadi.SX]] = {
    "dome": lambda q, a: a * casadi.sqrt(1.3 - q[0] ** 2 - q[1] ** 2) - 0.7,
    "powers": lambda q, a: a * (q[0] + 2) ** 3.5 + q[1] ** 3 - casadi.fmax(0.1, q[0]),
    "several": lambda q, a: casadi.vertcat(q[1], 0.5 * a, casadi.sin(3 * q[0]) / a),
    "branches": lambda q, a: casadi.if_else(q[0] > 0.2, a * q[1], -0.3 * q[1]),
    "a number alone": lambda _, a: casadi.SX(a),
}


@pytest.mark.parametrize("name", EXPRESSIONS)
def test_values_and_slopes_stay_the_same(name: str) -> None:
    def expression(q: casadi.SX) -> casadi.SX:
        return EXPRESSIONS[name](q, 1.25)

    residual, numbers = lifted(expression, 2)
    with_numbers, with_parameters = Kernel("a", lambda q, _: expression(q), 2), Kernel("b", residual, 2, len(numbers))
    for at in np.random.default_rng(1).uniform(-0.5, 0.5, (5, 2)):
        for what in ("value", "jacobian", "square_curvature"):
            given = np.asarray(getattr(with_numbers, what)(at, []))
            assert np.asarray(getattr(with_parameters, what)(at, numbers)) == pytest.approx(given, rel=1e-14)


@pytest.mark.parametrize("name", EXPRESSIONS)
def test_expressions_that_differ_in_numbers_have_one_form(name: str) -> None:
    def kernel(a: float) -> Kernel:
        residual, numbers = lifted(lambda q: EXPRESSIONS[name](q, a), 2)
        return Kernel(str(a), residual, 2, len(numbers))

    assert kernel(1.25).form == kernel(0.75).form


def test_exponents_are_part_of_the_form() -> None:
    """Slopes of powers depend on them, and have no value at 0 for one that is a parameter."""
    forms = []
    for exponent in (2.5, 3.5):
        residual, numbers = lifted(lambda q, k=exponent: 1.5 * q[0] ** k, 1)
        assert numbers.tolist() == [1.5]
        forms.append(Kernel("power", residual, 1, 1).form)
    assert forms[0] != forms[1]
