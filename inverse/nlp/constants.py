"""Numbers of an expression taken out of it, so that expressions which differ in them alone share their functions."""

from __future__ import annotations

from collections.abc import Callable

import casadi
import numpy as np

from inverse._types import FloatArray

_POWERS = (casadi.OP_POW, casadi.OP_CONSTPOW)


def lifted(expression: Callable[[casadi.SX], casadi.SX], n: int) -> tuple[Callable[..., casadi.SX], FloatArray]:
    """An expression with its numbers as parameters.

    Exponents stay, since slopes of powers depend on what they are.

    Args:
        expression: of n variables.
        n: how many.

    Returns:
        The expression of variables (n,) and parameters (c,), and the numbers (c,) that were in it.
    """
    q = casadi.SX.sym("q", n)
    function = casadi.Function("given", [q], [casadi.densify(expression(q))])
    exponents, latest = set(), dict[int, int]()  # which instruction wrote to a place last
    for k in range(function.n_instructions()):
        if function.instruction_id(k) in _POWERS:
            exponents.add(latest[function.instruction_input(k)[1]])
        for place in function.instruction_output(k):
            if function.instruction_id(k) != casadi.OP_OUTPUT:
                latest[place] = k
    numbers = [
        k
        for k in range(function.n_instructions())
        if function.instruction_id(k) == casadi.OP_CONST and k not in exponents
    ]
    values = np.array([function.instruction_constant(k) for k in numbers], np.float64)
    place_of = {k: place for place, k in enumerate(numbers)}

    def rebuilt(q: casadi.SX, p: casadi.SX) -> casadi.SX:
        found = casadi.SX(function.size1_out(0), 1)
        work: dict[int, casadi.SX] = {}
        for k in range(function.n_instructions()):
            kind = function.instruction_id(k)
            places = function.instruction_input(k)
            if kind == casadi.OP_OUTPUT:
                found[function.instruction_output(k)[1]] = work[places[0]]
                continue
            if kind == casadi.OP_CONST:
                value = p[place_of[k]] if k in place_of else casadi.SX(function.instruction_constant(k))
            elif kind == casadi.OP_INPUT:
                value = q[places[1]]
            elif len(places) == 1:
                value = casadi.SX.unary(kind, work[places[0]])
            else:
                value = casadi.SX.binary(kind, work[places[0]], work[places[1]])
            work[function.instruction_output(k)[0]] = value
        return found

    return rebuilt, values
