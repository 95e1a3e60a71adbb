"""The least violation of all constraints together, whatever the objective: Levenberg and Marquardt's method."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

from inverse._types import FloatArray
from inverse.nlp.point import Point

WITHIN = 1e-7  # largest violation that counts as none
SETTLED = 1e-4  # of the violation's norm: its gradient where it is least
LITTLE, AFTER = 1e-2, 20  # less gain than this in so many steps is none
STEPS = 200
DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-2, 1e-8, 1e8


@dataclass(frozen=True, eq=False)
class Least:
    """Where the search for a design that meets all constraints ended.

    Attributes:
        point: the design.
        squared: sum of all squared violations.
        settled: whether nothing near by is better; False where the search was given up before it could say so.
    """

    point: Point
    squared: float
    settled: bool

    @property
    def is_feasible(self) -> bool:
        """Whether all constraints hold."""
        return self.point.violation <= WITHIN


def least_violation(start: Point, go_on: Callable[[], bool]) -> Least:
    """Go downhill in the sum of squared violations until there is none left, or none less near by.

    Args:
        start: where; all rows count alike, as they are dimensionless.
        go_on: asked before every step.

    Returns:
        The end; not settled where ``go_on`` said no or the steps ran out.
    """
    at, damping = start, DAMPING
    missing = _missing(at)
    squared = float(missing @ missing)
    history = [squared]
    for _ in range(STEPS):
        if at.violation <= WITHIN:
            return Least(at, squared, settled=True)
        if not go_on() or not np.isfinite(squared):
            return Least(at, squared, settled=False)
        violated = missing != 0
        jacobian = at.jacobian[violated]
        gradient = jacobian.T @ missing[violated]
        if np.linalg.norm(gradient) <= SETTLED * np.sqrt(squared):
            return Least(at, squared, settled=True)
        curvature = (jacobian.T @ jacobian).tocsc()
        while True:
            move = _solved(curvature, damping, -gradient)
            if move is not None:
                trial = at.moved(at.variables + move)
                left = _missing(trial)
                size = float(left @ left)
                linear = missing[violated] + jacobian @ move
                gain = (squared - size) / max(squared - float(linear @ linear), np.finfo(float).tiny)
                if gain > 1e-3:  # not a number excluded
                    break
            damping *= 4
            if damping > MOST_DAMPING:
                return Least(at, squared, settled=True)
        damping = max(damping / 5, LEAST_DAMPING) if gain > 0.75 else 2 * damping if gain < 0.25 else damping
        at, missing, squared = trial, left, size
        history.append(squared)
        if len(history) > AFTER and history[-AFTER - 1] - squared < LITTLE * squared:
            return Least(at, squared, settled=True)
    return Least(at, squared, settled=False)


def _missing(point: Point) -> FloatArray:
    """By how much every row (R,) is beyond its bounds, with its sign."""
    return np.asarray(point.rows - np.clip(point.rows, point.problem.lower, point.problem.upper))


def _solved(curvature: sparse.csc_matrix, damping: float, right: FloatArray) -> FloatArray | None:
    system = curvature + damping * sparse.identity(curvature.shape[0], format="csc")
    try:
        factors = splu(system, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
    except RuntimeError:  # SuperLU's word for a pivot of zero
        return None
    return np.asarray(factors.solve(right))
