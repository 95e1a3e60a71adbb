"""Equation (9): wished moves projected onto the constraints, and what is left of the residual removed by Newton."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

from inverse._types import FloatArray, IntArray
from inverse.nlp.point import Point

CUT_OFF = 1e-13  # squared: directions in which no row changes by more than 3e-7 of a move are left alone
EXACT = 1e-15  # residual below which there is nothing to remove
ENOUGH = 1e-13  # residual at which a step's Newton corrections end
WITHIN = 1e-9  # by how much a bound may be exceeded before it is held like an equation
ACTIVE = 1e-4  # of the largest multiplier: bounds that push by more than this are active
STUCK = 0.9  # corrections that leave more of the residual than this need new factors, or are at its rounding
CHORDS = 16  # Newton corrections with the same factors, which cost less than making the factors anew once


class LeastMove:
    """The least move that changes the rows of a Jacobian by given amounts: J^T (J J^T + e I)^-1 applied to them.

    J J^T is positive definite on disks (math of section 2: full row rank). The tiny e is the cut-off that keeps
    redundant equations (tubes, anchors that repeat each other) solvable, and costs nothing, since Newton's next step
    takes care of it. A positive definite matrix is factorized in a symmetric order without pivoting, four times
    faster than the system of moves and multipliers together.

    Made by :meth:`of`, which knows of Jacobians that have no factors.

    Args:
        jacobian: (R, n) J.
        order: (R,) int, an order of the rows in which the factors stay sparse, from an earlier Jacobian of the same
            sparsity; found anew if None.

    Attributes:
        order: (R,) int, to be given to the next.
    """

    def __init__(self, jacobian: sparse.csr_matrix, order: IntArray | None = None) -> None:
        given = np.arange(jacobian.shape[0]) if order is None else order
        # Rows of one size: beside a row with a thousandth of an edge in its denominator e would be less than rounding.
        sizes = np.maximum(np.sqrt(jacobian.multiply(jacobian).sum(axis=1)), np.finfo(float).tiny)
        self._scale = 1 / np.asarray(sizes).ravel()[given]
        self._given = given
        self._jacobian = (sparse.diags(self._scale) @ jacobian[given]).tocsr()
        system = self._jacobian @ self._jacobian.T + CUT_OFF * sparse.identity(self._jacobian.shape[0])
        how = "MMD_AT_PLUS_A" if order is None else "NATURAL"
        self._factors = splu(system.tocsc(), permc_spec=how, diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        self.order: IntArray = np.argsort(self._factors.perm_c) if order is None else order

    @classmethod
    def of(cls, jacobian: sparse.csr_matrix, order: IntArray | None = None) -> LeastMove | None:
        """The least move, or None where the factors do not exist: a slope that is no number, a pivot of zero."""
        try:
            return cls(jacobian, order)
        except RuntimeError:  # SuperLU's word for both
            return None

    def multipliers(self, gradient: FloatArray) -> FloatArray:
        """Multipliers (R,) with which the rows come nearest to balancing a gradient (n,)."""
        balance = np.empty_like(self._scale)
        balance[self._given] = self._scale * self._factors.solve(-(self._jacobian @ gradient))
        return balance

    def __call__(self, change: FloatArray) -> FloatArray:
        """The move (n,) that changes the rows by ``change`` (R,)."""
        return np.asarray(self._jacobian.T @ self._factors.solve(self._scale * change[self._given]))


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

    Its equations hold after every move, and its inequalities too.
    """

    def __init__(self) -> None:
        self._order: IntArray | None = None

    def moved(self, point: Point, wish: FloatArray) -> Point | None:
        """One Euler step of equation (9): the wished move without what would violate the constraints.

        A bound that the step would exceed is held like an equation, and the step is made again.

        Args:
            point: variables that satisfy the constraints; of the same problem every time.
            wish: (n,) wished move.

        Returns:
            A point that satisfies the constraints; None if the step is too long for Newton's method.
        """
        jacobian = point.jacobian  # first: it brings the rows along
        if not np.isfinite(jacobian.data).all():
            return None
        held: IntArray = np.empty(0, np.int64)
        while True:
            chosen = np.concatenate([point.problem.equations, held])
            least = self._least_move(jacobian[chosen], len(held))
            if least is None:
                return None
            # What the wish does to the held rows is taken back; rows off their bounds are brought there.
            off = point.rows[chosen] - _bounds(point, chosen)
            step = wish - least(jacobian[chosen] @ wish + off)
            trial = self._corrected(point.moved(point.variables + step), chosen, least)
            if trial is None:
                return None
            beyond = np.setdiff1d(np.flatnonzero(trial.excess > WITHIN), chosen)
            if len(beyond) == 0:
                return trial
            held = np.concatenate([held, beyond])

    def _corrected(self, point: Point, chosen: IntArray, least: LeastMove) -> Point | None:
        """Newton corrections until the chosen rows are at their bounds, with factors of a point near by."""
        n_held = len(chosen) - len(point.problem.equations)
        bounds = _bounds(point, chosen)
        size = np.inf
        for k in range(3 * CHORDS):
            residual = point.rows[chosen] - bounds
            last, size = size, float(np.abs(residual).max(initial=0.0))
            stuck = size > STUCK * last
            if size <= ENOUGH or (size <= 1e3 * ENOUGH and stuck):  # in rounding
                return point
            if not np.isfinite(size) or (size > last and size > 1.0):
                return None
            if k % CHORDS == CHORDS - 1 or stuck:
                fresh = self._least_move(point.jacobian[chosen], n_held)
                if fresh is None:
                    return None
                least = fresh
            point = point.moved(point.variables - least(residual))
        return None

    def _least_move(self, jacobian: sparse.csr_matrix, n_held: int) -> LeastMove | None:
        """Factors for the equations and the bounds held besides; the order of the equations is found once."""
        if self._order is None:  # the first factors are those of the equations alone
            least = LeastMove.of(jacobian)
            self._order = None if least is None else least.order
            return least
        n = jacobian.shape[0] - n_held
        return LeastMove.of(jacobian, np.concatenate([self._order, np.arange(n, n + n_held)]))


def _bounds(point: Point, chosen: IntArray) -> FloatArray:
    """The bound that each of the chosen rows is nearest to."""
    lower, upper, own = point.problem.lower[chosen], point.problem.upper[chosen], point.rows[chosen]
    return np.asarray(np.where(np.abs(own - lower) <= np.abs(own - upper), lower, upper))
