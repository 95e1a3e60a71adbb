"""Equation (9): wished moves projected onto the constraints, and what is left of the residual removed by Newton."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

from inverse._types import FloatArray, IntArray
from inverse.nlp.problem import Problem

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


def polish(problem: Problem, variables: FloatArray, parameters: FloatArray, *, steps: int = 8) -> FloatArray:
    """Move variables to the nearest point where all equations hold to rounding.

    Args:
        problem: gives rows and Jacobian; inequalities are left alone.
        variables: (n,) near a solution.
        parameters: parameter vector of the problem.
        steps: at most so many steps.

    Returns:
        (n,) variables; the given ones if no step made the residual smaller.
    """
    equations = np.flatnonzero(problem.lower == problem.upper)
    if len(equations) == 0:
        return variables
    best, best_size = variables, np.inf
    x = variables
    order = None
    for _ in range(steps + 1):  # the last step is looked at too
        rows, jacobian = problem.rows_and_jacobian(x, parameters)
        residual = rows[equations] - problem.lower[equations]
        size = float(np.abs(residual).max())
        if not size < best_size:  # nor if it is not a number
            break
        best, best_size = x, size
        if size < EXACT:
            break
        least = LeastMove.of(jacobian[equations], order)
        if least is None:
            break
        x, order = x - least(residual), least.order
    return best


def balanced(problem: Problem, variables: FloatArray, multipliers: FloatArray, parameters: FloatArray) -> FloatArray:
    """Multipliers that fit a polished design: the least change of given ones that balances the gradient.

    A polish moves the design by little, but multipliers times the constraints' curvature times that little is what
    stationarity is then short of.

    Args:
        problem: gives rows and Jacobian.
        variables: (n,) the polished design.
        multipliers: (R,) of all rows before the polish.
        parameters: parameter vector of the problem.

    Returns:
        (R,) multipliers; those of idle bounds stay as they are.
    """
    _, gradient = problem.objective_and_gradient(variables, parameters)
    _, jacobian = problem.rows_and_jacobian(variables, parameters)
    largest = float(np.abs(multipliers).max(initial=0.0))
    active = np.flatnonzero((problem.lower == problem.upper) | (np.abs(multipliers) > ACTIVE * largest))
    left = gradient + jacobian.T @ multipliers
    least = LeastMove.of(jacobian[active]) if len(active) and np.isfinite(left).all() else None
    if least is None:
        return multipliers
    corrected = multipliers.copy()
    corrected[active] += least.multipliers(left)
    better = np.abs(gradient + jacobian.T @ corrected).max() < np.abs(left).max()
    return corrected if better else multipliers


class Projection:
    """Moves within the constraints of one problem, one after the other, as a drag makes them.

    Args:
        problem: its equations hold after every move, and its inequalities too.
        parameters: parameter vector of the problem.
    """

    def __init__(self, problem: Problem, parameters: FloatArray) -> None:
        self._problem, self._parameters = problem, parameters
        self._equations = np.flatnonzero(problem.lower == problem.upper)
        self._order: IntArray | None = None

    def moved(self, x: FloatArray, wish: FloatArray) -> FloatArray | None:
        """One Euler step of equation (9): the wished move without what would violate the constraints.

        A bound that the step would exceed is held like an equation, and the step is made again.

        Args:
            x: (n,) variables that satisfy the constraints.
            wish: (n,) wished move.

        Returns:
            (n,) variables that satisfy the constraints; None if the step is too long for Newton's method.
        """
        rows, jacobian = self._problem.rows_and_jacobian(x, self._parameters)
        if not np.isfinite(jacobian.data).all():
            return None
        held: IntArray = np.empty(0, np.int64)
        while True:
            chosen = np.concatenate([self._equations, held])
            least = self._least_move(jacobian[chosen], len(held))
            if least is None:
                return None
            # What the wish does to the held rows is taken back; rows off their bounds are brought there.
            off = rows[chosen] - self._bounds(rows, chosen)
            trial = self._corrected(x + wish - least(jacobian[chosen] @ wish + off), chosen, least)
            if trial is None:
                return None
            beyond = np.setdiff1d(np.flatnonzero(self._problem.excess(trial, self._parameters) > WITHIN), chosen)
            if len(beyond) == 0:
                return trial
            held = np.concatenate([held, beyond])

    def _corrected(self, x: FloatArray, chosen: IntArray, least: LeastMove) -> FloatArray | None:
        """Newton corrections until the chosen rows are at their bounds, with factors of a point near by."""
        rows = self._problem.rows(x, self._parameters)
        bounds = self._bounds(rows, chosen)
        size = np.inf
        for k in range(3 * CHORDS):
            residual = rows[chosen] - bounds
            last, size = size, float(np.abs(residual).max(initial=0.0))
            stuck = size > STUCK * last
            if size <= ENOUGH or (size <= 1e3 * ENOUGH and stuck):  # in rounding
                return x
            if not np.isfinite(size) or (size > last and size > 1.0):
                return None
            if k % CHORDS == CHORDS - 1 or stuck:
                _, jacobian = self._problem.rows_and_jacobian(x, self._parameters)
                fresh = self._least_move(jacobian[chosen], len(chosen) - len(self._equations))
                if fresh is None:
                    return None
                least = fresh
            x = x - least(residual)
            rows = self._problem.rows(x, self._parameters)
        return None

    def _least_move(self, jacobian: sparse.csr_matrix, n_held: int) -> LeastMove | None:
        """Factors for the equations and the bounds held besides; the order of the equations is found once."""
        if self._order is None:  # the first factors are those of the equations alone
            least = LeastMove.of(jacobian)
            self._order = None if least is None else least.order
            return least
        n = len(self._equations)
        return LeastMove.of(jacobian, np.concatenate([self._order, np.arange(n, n + n_held)]))

    def _bounds(self, rows: FloatArray, chosen: IntArray) -> FloatArray:
        """The bound that each of the chosen rows is nearest to."""
        lower, upper = self._problem.lower[chosen], self._problem.upper[chosen]
        own = rows[chosen]
        return np.asarray(np.where(np.abs(own - lower) <= np.abs(own - upper), lower, upper))
