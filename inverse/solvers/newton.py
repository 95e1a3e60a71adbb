"""Newton's method from the solution of a task like this one: the bounds that push are known but for a few.

A solver that starts anew has to find out which bounds matter, and how strongly; here the start tells. Rows that are
held, equations and bounds that push, are linearized and solved together with the Lagrangian's slope. Factors are kept
as long as their steps take most of the residual away, since a Hessian and its factorization cost five times what
everything else in a step does. Where this comes to nothing, IPOPT goes on from the start.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.nlp.point import Point
from inverse.solvers.ipopt import OBJECTIVE_SCALE
from inverse.solvers.kkt import Factors
from inverse.solvers.run import Ending, Progress, Run

METHOD = "Newton's method on the bounds that push"  # for the report

STEPS, FACTORS = 40, 16  # at most so many
LONGEST = 2.0  # edges: a longer step of some vertex leads nowhere
# The Hessian is shifted by this multiple of the residual: far away soft directions, in which curvature says little,
# are hardly followed, near by they are, and the end is as fast as Newton's. On domes moved by 1 to 10 % no run arrived
# without the shift; with 0.02 to 0.5 all did, with 0.1 in 5 to 10 steps.
SHIFT = 0.1
WARNED, EASED = 4.0, 2.0  # factors of the shift after a step that made the residual larger, and smaller
LEAST, MORE, LARGEST = 1e-4, 5.0, 100.0  # of shifts that make a Hessian positive: the first, the next, the last
CLOSE, POOR = 1e-3, 0.03  # factors are kept below this residual, where a step left no more of it than this share
WORSE = 10.0  # a residual of so many times the first ends the run
BEYOND = 1e-9  # by how much a bound may be exceeded before it is held
CLOSED = 1e-12  # by how much a held row may be off at the end

NOTHING: IntArray = np.empty(0, np.int64)


def newton(
    start: Point, refinement: float, tolerance: float, limit: int, report: Callable[[Progress], bool]
) -> Run | None:
    """Come to a solution near a start.

    Args:
        start: where; its multipliers tell which bounds push.
        refinement: of the model, see :class:`inverse.solvers.ipopt.Ipopt`.
        tolerance: of the Lagrangian's slope, as IPOPT's.
        limit: iterations.
        report: told every iterate; False ends the run.

    Returns:
        The run, or None where it does not come to a minimum.
    """
    began = time.perf_counter()
    at, factors = _Iterate.of(start, OBJECTIVE_SCALE * refinement**2), None
    held, n_made, last, first, caution = NOTHING, 0, np.inf, at.size, 1.0
    for count in range(min(STEPS, limit)):
        point = at.point
        if not (at.size < np.inf and report(Progress(count, point.objective, point.violation, point.variables))):
            return None
        fits = factors is not None and np.array_equal(held, at.held)
        if fits and at.is_settled(tolerance):
            end = point.pushed(at.multipliers / at.scale)
            return Run(end, Ending.SOLVED, count, time.perf_counter() - began, 0.0, METHOD)
        if not fits:
            first = max(first, at.size)  # bounds that are let go leave a slope of their own
        if at.size > WORSE * first:
            return None
        caution = max(caution / EASED, 1.0) if at.size < last else caution * WARNED
        is_new = not fits or at.size > POOR * last or at.size > CLOSE
        if is_new:
            held, n_made, factors = at.held, n_made + 1, at.factors(caution * SHIFT * min(at.size, last))
            if n_made > FACTORS or factors is None:
                return None
        assert factors is not None  # fits was false without
        last = at.size
        move, change = factors.step(at.slope, at.off)
        if not np.abs(move).max() <= LONGEST:
            return None
        at = at.stepped(move, change)
    return None


@dataclass(frozen=True, eq=False)
class _Iterate:
    """A point with the rows that are held there.

    Attributes:
        point: the point.
        scale: of the objective.
        sides: (R,) int, 1 and -1 of rows that are held at their upper and lower bound, else 0; 1 of equations.
        multipliers: (R,), times the scale; zero of rows that are not held.
    """

    point: Point
    scale: float
    sides: IntArray
    multipliers: FloatArray

    @classmethod
    def of(cls, start: Point, scale: float) -> _Iterate:
        """The iterate at a start: bounds that push more than they are away are held."""
        multipliers, problem = scale * start.balance, start.problem
        slack = np.where(multipliers > 0, problem.upper - start.rows, start.rows - problem.lower)
        pushing = np.abs(multipliers) > np.maximum(slack, 0.0)
        return cls._holding(start, scale, np.where(pushing, np.sign(multipliers), 0).astype(np.int64), multipliers)

    @classmethod
    def _holding(cls, point: Point, scale: float, sides: IntArray, multipliers: FloatArray) -> _Iterate:
        """With all equations, the given bounds, and those that are exceeded."""
        lower, upper, rows = point.problem.lower, point.problem.upper, point.rows
        sides = np.where((sides == 0) & (rows > upper + BEYOND), 1, sides)
        sides = np.where((sides == 0) & (rows < lower - BEYOND), -1, sides)
        sides = np.where(lower == upper, 1, sides)
        return cls(point, scale, sides, np.where(sides != 0, multipliers, 0.0))

    @cached_property
    def held(self) -> IntArray:
        """(k,) int, the rows that are held."""
        return np.flatnonzero(self.sides)

    @cached_property
    def slope(self) -> FloatArray:
        """Gradient (n,) of the Lagrangian, times the scale."""
        return np.asarray(self.scale * self.point.gradient + self.point.jacobian.T @ self.multipliers)

    @cached_property
    def off(self) -> FloatArray:
        """By how much the held rows (k,) are off their bounds."""
        problem, held = self.point.problem, self.held
        bounds = np.where(self.sides[held] > 0, problem.upper[held], problem.lower[held])
        return np.asarray(self.point.rows[held] - bounds)

    @cached_property
    def size(self) -> float:
        """The largest component of slope and offsets; infinite where one is no number."""
        size = max(float(np.abs(self.slope).max()), float(np.abs(self.off).max(initial=0.0)))
        return size if np.isfinite(size) else np.inf

    def is_settled(self, tolerance: float) -> bool:
        """Whether it is a solution."""
        return bool(np.abs(self.slope).max() <= tolerance and np.abs(self.off).max(initial=0.0) <= CLOSED)

    def factors(self, shift: float) -> Factors | None:
        """Factors for a step, with a shift of the Hessian and as much more as makes it lead down; None without."""
        point = self.point
        curvature = point.problem.curvature(point.variables, point.parameters, self.scale, self.multipliers)
        while shift <= LARGEST:
            try:
                found = Factors(point.problem, self.held, curvature, point.jacobian.data, shift)
            except RuntimeError:  # SuperLU's word for a pivot of zero
                return None
            if found.is_minimum:
                return found
            shift = max(MORE * shift, LEAST)
        return None

    def stepped(self, move: FloatArray, change: FloatArray) -> _Iterate:
        """After a move (n,) and a change of the held rows' multipliers (k,); bounds that would pull are let go."""
        multipliers, problem = self.multipliers.copy(), self.point.problem
        multipliers[self.held] += change
        pulls = (problem.lower != problem.upper) & (multipliers * self.sides < 0)
        sides = np.where(pulls, 0, self.sides)
        return self._holding(self.point.moved(self.point.variables + move), self.scale, sides, multipliers)
