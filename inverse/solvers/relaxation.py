"""A problem without the bounds that do not matter where a run stands: half the rows, and half the time of a step."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.solvers.ipopt import Ipopt
from inverse.solvers.run import Run

MARGIN = 0.1  # bounds closer than this fraction of their width, or this number where they have one side, are kept
WORTHWHILE = 0.25  # of all bounds at most so many may be kept


@dataclass(frozen=True, eq=False)
class Relaxation:
    """A problem with fewer bounds.

    Attributes:
        whole: the problem with all.
        problem: the problem that is left.
        rows: (R',) int, its rows in the whole problem.
    """

    whole: Problem
    problem: Problem
    rows: IntArray

    def own(self, point: Point) -> Point:
        """A point of the whole problem as one of this problem, with the same parameters of the objectives."""
        shared = self.whole.layout.n_objective
        parameters = np.concatenate([point.parameters[:shared], self.problem.parameters()[shared:]])
        multipliers = None if point.multipliers is None else point.multipliers[self.rows]
        return Point(self.problem, point.variables, parameters, multipliers)

    def back(self, point: Point, parameters: FloatArray) -> Point:
        """A point of this problem as one of the whole problem with the given parameters."""
        multipliers = np.zeros(self.whole.n_rows)
        multipliers[self.rows] = point.balance
        return Point(self.whole, point.variables, parameters, multipliers)


@dataclass(frozen=True, eq=False)
class LightIpopt:
    """IPOPT without idle bounds, to be used like one with all of them.

    Attributes:
        relaxation: what it solves.
        solver: of the relaxation.
    """

    relaxation: Relaxation
    solver: Ipopt

    def approach(self, start: Point, limit: int, *, is_good: bool, is_spread: bool = False) -> Run:
        """As :meth:`Ipopt.approach`, from and to points of the whole problem."""
        own = self.relaxation.own(start)
        return self._whole(start, self.solver.approach(own, limit, is_good=is_good, is_spread=is_spread))

    def ease(self, start: Point, limit: int) -> Run:
        """As :meth:`Ipopt.ease`, from and to points of the whole problem."""
        return self._whole(start, self.solver.ease(self.relaxation.own(start), limit))

    def run(self, start: Point, limit: int, *, careful: bool) -> Run:
        """As :meth:`Ipopt.run`, from and to points of the whole problem."""
        return self._whole(start, self.solver.run(self.relaxation.own(start), limit, careful=careful))

    def _whole(self, start: Point, run: Run) -> Run:
        end = self.relaxation.back(run.end, start.parameters)
        return replace(run, end=end, method=f"{run.method}, without idle bounds")


def relaxed(point: Point) -> Relaxation | None:
    """Leave out the bounds that are far from active.

    Args:
        point: where a run stands, of the whole problem.

    Returns:
        The relaxation, or None if too few bounds can be left out.
    """
    problem, values = point.problem, point.rows
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
    # Which bounds are far off differs from task to task.
    light = Problem(problem.n_variables, problem.objectives, constraints, is_kept=False)
    return Relaxation(problem, light, np.concatenate(rows))
