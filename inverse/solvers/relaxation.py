"""A problem without the bounds that do not matter where a run stands: half the rows, and half the time of a step."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.nlp.problem import Problem
from inverse.solvers.ipopt import Solver
from inverse.solvers.run import Attempt

MARGIN = 0.1  # bounds closer than this fraction of their width, or this number where they have one side, are kept
WORTHWHILE = 0.25  # of all bounds at most so many may be kept


@dataclass(frozen=True, eq=False)
class Relaxation:
    """A problem with fewer bounds.

    Attributes:
        problem: the problem that is left.
        rows: (R',) int, its rows in the whole problem.
    """

    problem: Problem
    rows: IntArray

    def parameters(self, whole: FloatArray) -> FloatArray:
        """Its parameters, with those of the objectives as in the parameters of the whole problem."""
        own, shared = self.problem.parameters(), self.problem.n_objective_parameters
        return np.concatenate([whole[:shared], own[shared:]])


@dataclass(frozen=True, eq=False)
class LightSolver:
    """A solver without idle bounds, to be used like one with all of them.

    Attributes:
        relaxation: what it solves.
        n_rows: number of rows of the whole problem.
        solver: of the relaxation.
    """

    relaxation: Relaxation
    n_rows: int
    solver: Solver

    def approach(self, start: FloatArray, parameters: FloatArray, limit: int, *, is_good: bool) -> Attempt:
        """As :meth:`Solver.approach`, with parameters and multipliers of the whole problem."""
        own = self.relaxation.parameters(parameters)
        return self._whole(self.solver.approach(start, own, limit, is_good=is_good))

    def run(
        self, start: FloatArray, parameters: FloatArray, multipliers: FloatArray | None, limit: int, *, careful: bool
    ) -> Attempt:
        """As :meth:`Solver.run`, with parameters and multipliers of the whole problem."""
        own, rows = self.relaxation.parameters(parameters), self.relaxation.rows
        first = None if multipliers is None else multipliers[rows]
        return self._whole(self.solver.run(start, own, first, limit, careful=careful))

    def _whole(self, attempt: Attempt) -> Attempt:
        multipliers = np.zeros(self.n_rows)
        multipliers[self.relaxation.rows] = attempt.multipliers
        return replace(attempt, multipliers=multipliers)


def relaxed(problem: Problem, variables: FloatArray, parameters: FloatArray) -> Relaxation | None:
    """Leave out the bounds that are far from active.

    Args:
        problem: the whole problem.
        variables: (n,) where a run stands.
        parameters: of the whole problem.

    Returns:
        The relaxation, or None if too few bounds can be left out.
    """
    values = problem.rows(variables, parameters)
    width = np.where(np.isfinite(problem.upper - problem.lower), problem.upper - problem.lower, 1.0)
    slack = np.minimum(values - problem.lower, problem.upper - values)
    needed = (slack < MARGIN * width) | (width == 0.0)
    constraints, rows, start, dropped, kept = [], [], 0, 0, 0
    for constraint in problem.constraints:
        count, k = constraint.lower.shape
        own = needed[start : start + count * k].reshape(count, k).any(axis=1)
        if own.any():
            constraints.append(constraint.only(own))
        rows.append(start + np.flatnonzero(np.repeat(own, k)))
        if not constraint.is_equation:
            dropped, kept = dropped + int((~own).sum()), kept + int(own.sum())
        start += count * k
    if kept > WORTHWHILE * (kept + dropped) or dropped == 0 or not constraints:
        return None
    return Relaxation(Problem(problem.n_variables, problem.objectives, constraints), np.concatenate(rows))
