"""Equation (9): wished moves projected onto the constraints, and what is left of the residual removed by Newton."""

from __future__ import annotations

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.nlp.part import Part
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.solvers.holding import Holding
from inverse.solvers.least_move import LeastMove

# Of moves from far away towards where equations hold, one after the other: what only large moves would remove is left.
CUT_OFFS = (1e-2, 1e-2)
EXACT = 1e-15  # residual below which there is nothing to remove
WITHIN = 1e-9  # by how much a bound may be exceeded before it is held like an equation
ACTIVE = 1e-4  # of the largest multiplier: bounds that push by more than this are active


def polish(point: Point, *, steps: int = 8) -> Point:
    """Move a point to the nearest one where all equations hold to rounding.

    Args:
        point: near a solution; inequalities are left alone.
        steps: at most so many steps.

    Returns:
        The point, with the same multipliers; the given one if no step made the residual smaller.
    """
    equations, lower = point.problem.equations, point.problem.lower
    if len(equations) == 0:
        return point
    best, best_size = point, np.inf
    at = point
    order = None
    for _ in range(steps + 1):  # the last step is looked at too
        jacobian = at.jacobian  # first: it brings the rows along
        residual = at.rows[equations] - lower[equations]
        size = float(np.abs(residual).max())
        if not size < best_size:  # nor if it is not a number
            break
        best, best_size = at, size
        if size < EXACT:
            break
        least = LeastMove.of(jacobian[equations], order)
        if least is None:
            break
        at, order = at.moved(at.variables - least(residual)), least.order
    return best


def brought_near(point: Point) -> Point:
    """Move a point nearer to where the equations hold, from so far away that Newton's method would leap.

    Args:
        point: with equations off by a tenth and more.

    Returns:
        The point that the last move came to that left less of the residual; the given one if none did.
    """
    equations, lower = point.problem.equations, point.problem.lower
    order = None
    for cut_off in CUT_OFFS:
        jacobian = point.jacobian  # first: it brings the rows along
        residual = point.rows[equations] - lower[equations]
        least = LeastMove.of(jacobian[equations], order, cut_off)
        if least is None:
            break
        moved, order = point.moved(point.variables - least(residual)), least.order
        if not np.linalg.norm(moved.rows[equations] - lower[equations]) < np.linalg.norm(residual):
            break
        point = moved
    return point


def balanced(point: Point) -> Point:
    """A polished point with multipliers that fit it: the least change of those it has that balances the gradient.

    A polish moves the design by little, but multipliers times the constraints' curvature times that little is what
    stationarity is then short of. Those of idle bounds stay as they are.
    """
    problem, multipliers = point.problem, point.balance
    largest = float(np.abs(multipliers).max(initial=0.0))
    active = np.flatnonzero((problem.lower == problem.upper) | (np.abs(multipliers) > ACTIVE * largest))
    left = point.lagrangian_gradient
    least = LeastMove.of(point.jacobian[active]) if len(active) and np.isfinite(left).all() else None
    if least is None:
        return point
    corrected = multipliers.copy()
    corrected[active] += least.multipliers(left)
    better = np.abs(point.gradient + point.jacobian.T @ corrected).max() < np.abs(left).max()
    return point.pushed(corrected) if better else point


class Projection:
    """Moves within the constraints of one problem, one after the other, as a drag makes them.

    Its equations hold after every move, and its inequalities too. Factors are kept from one move to the next, see
    :class:`inverse.solvers.holding.Holding`.
    """

    def __init__(self) -> None:
        self._problem: Problem | None = None
        self._equations: Holding | None = None
        self._with_bounds: tuple[IntArray, Holding] | None = None  # the bounds that were held last

    @property
    def factorizations(self) -> int:
        """How many factors were made of the equations alone."""
        return 0 if self._equations is None else self._equations.factorizations

    def moved(self, point: Point, wish: FloatArray) -> Point | None:
        """One Euler step of equation (9): the wished move without what would violate the constraints.

        A bound that the step would exceed is held like an equation, and the step is made again.

        Args:
            point: variables that satisfy the constraints; of the same problem every time.
            wish: (n,) wished move.

        Returns:
            A point that satisfies the constraints; None if the step is too long for Newton's method.
        """
        problem = point.problem
        if self._equations is None or self._problem is not problem:
            self._problem, self._with_bounds = problem, None
            self._equations = Holding([Part(problem, problem.equations)])
        chosen, holding = problem.equations, self._equations
        values = problem.lower[chosen]
        held: IntArray = np.empty(0, np.int64)
        while True:
            trial = holding.moved(point, wish, values)
            if trial is None:
                return None
            beyond = np.setdiff1d(np.flatnonzero(trial.excess > WITHIN), chosen)
            if len(beyond) == 0:
                return trial
            held = np.union1d(held, beyond)
            holding = self._holding(self._equations, held)
            chosen = np.concatenate([problem.equations, held])
            values = _bounds(trial, chosen)

    def _holding(self, equations: Holding, held: IntArray) -> Holding:
        """The equations, and bounds (k,) held besides."""
        if self._with_bounds is None or not np.array_equal(self._with_bounds[0], held):
            assert self._problem is not None  # moved() set it
            bounds = Part(self._problem, held)
            self._with_bounds = held, Holding([*equations.parts, bounds], equations.order)
        return self._with_bounds[1]


def _bounds(point: Point, chosen: IntArray) -> FloatArray:
    """The bound that each of the chosen rows is nearest to."""
    lower, upper, own = point.problem.lower[chosen], point.problem.upper[chosen], point.rows[chosen]
    return np.asarray(np.where(np.abs(own - lower) <= np.abs(own - upper), lower, upper))
