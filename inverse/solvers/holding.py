"""Moves that keep some rows of a problem at their values, with factors kept from one move to the next."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import scipy.sparse as sparse

from inverse._types import FloatArray, IntArray
from inverse.nlp.part import Part
from inverse.nlp.point import Point
from inverse.solvers.least_move import LeastMove

ENOUGH = 1e-13  # residual at which a step's Newton corrections end
STUCK = 0.9  # corrections that leave more of the residual than this need new factors, or are at its rounding
CHORDS = 16  # Newton corrections with the same factors, which cost less than making the factors anew once
PATIENCE = 8  # the same with factors of an earlier move, whose iterations came before


class Holding:
    """Some rows of a problem, and factors of their slopes at a place that moves began from.

    Moves follow the slopes of the place where they begin, whatever the age of the factors: these only guide the
    iterations, and their result is that of new factors. Where iterations get stuck the factors are renewed.

    Args:
        parts: rows that are held; the first are those that ``order`` is of.
        order: an order of the rows of the first part, see :class:`LeastMove`.

    Attributes:
        parts: the rows.
        order: the same, or the order of all rows if none was given; None before the first move.
        factorizations: how many factors were made.
    """

    def __init__(self, parts: list[Part], order: IntArray | None = None) -> None:
        self.parts = parts
        self.order = order
        self.factorizations = 0
        self._least: LeastMove | None = None
        self._slopes: FloatArray = np.empty(0)  # nonzeros of the Jacobian that the factors are of
        self._far = np.inf  # factors of slopes that differ by more than this take too long

    def moved(self, point: Point, wish: FloatArray, values: FloatArray) -> Point | None:
        """The wished move without what changes the rows; the rest of their residual is removed by Newton's method.

        Args:
            point: where to begin, with rows near their values.
            wish: (n,).
            values: (R,) of the rows.

        Returns:
            Where the rows have their values; None if the way is too long for Newton's method.
        """
        rows, jacobian = self._linearized(point)
        if not np.isfinite(jacobian.data).all():
            return None
        # What the wish does to the rows is taken back; rows off their values are brought there.
        change = jacobian @ wish + rows - values
        away = self._difference(jacobian)
        if self._least is not None and away < self._far:
            forces = self._least.forces_of(jacobian, change)
            if forces is not None:
                trial = point.moved(point.variables + wish - jacobian.T @ forces)
                found = self._by_broyden(trial, values, jacobian)
                if found is not None:
                    return found
            self._far = away
        least = self._renewed(jacobian)
        return None if least is None else self._by_newton(point.moved(point.variables + wish - least(change)), values)

    def _by_broyden(self, point: Point, values: FloatArray, jacobian: sparse.csr_matrix) -> Point | None:
        """Corrections along the slopes given, with older factors: updates teach these how the rows change in truth."""
        assert self._least is not None  # who calls has seen it
        moves: list[FloatArray] = []
        size = np.inf
        for _ in range(PATIENCE):
            residual = self._rows(point) - values
            last, size = size, float(np.abs(residual).max(initial=0.0))
            if _is_rounding(size, last):
                return point
            if not size < 1.0:
                return None
            move = -(jacobian.T @ self._least.forces(residual))
            for before, after in pairwise(moves):
                move += after * (before @ move) / (before @ before)
            if moves:
                move /= max(1 - (moves[-1] @ move) / (moves[-1] @ moves[-1]), 0.5)  # no leaps
            moves.append(move)
            point = point.moved(point.variables + move)
        return None

    def _by_newton(self, point: Point, values: FloatArray) -> Point | None:
        """Corrections with factors of a place near by, renewed where these get stuck."""
        size = np.inf
        for k in range(3 * CHORDS):
            residual = self._rows(point) - values
            last, size = size, float(np.abs(residual).max(initial=0.0))
            if _is_rounding(size, last):
                return point
            if not np.isfinite(size) or (size > last and size > 1.0):
                return None
            if k % CHORDS == CHORDS - 1 or size > STUCK * last:
                self._renewed(self._linearized(point)[1])
            if self._least is None:
                return None
            point = point.moved(point.variables - self._least(residual))
        return None

    def _difference(self, jacobian: sparse.csr_matrix) -> float:
        """By how much slopes differ from those that the factors are of."""
        if len(self._slopes) != len(jacobian.data):
            return float("inf")
        return float(np.linalg.norm(jacobian.data - self._slopes) / np.linalg.norm(self._slopes))

    def _renewed(self, jacobian: sparse.csr_matrix) -> LeastMove | None:
        """New factors; the order of the rows is found once."""
        order = self.order
        if order is not None and len(order) < jacobian.shape[0]:
            order = np.concatenate([order, np.arange(len(order), jacobian.shape[0])])
        self._least, self._slopes = LeastMove.of(jacobian, order), jacobian.data
        self.factorizations += 1
        if self.order is None and self._least is not None:
            self.order = self._least.order
        return self._least

    def _rows(self, point: Point) -> FloatArray:
        return np.concatenate([part.rows(point) for part in self.parts])

    def _linearized(self, point: Point) -> tuple[FloatArray, sparse.csr_matrix]:
        rows, jacobians = zip(*(part.linearized(point) for part in self.parts), strict=True)
        return np.concatenate(rows), jacobians[0] if len(jacobians) == 1 else sparse.vstack(jacobians, format="csr")


def _is_rounding(size: float, last: float) -> bool:
    """Whether a residual is as small as it gets, after one of another size."""
    return size <= ENOUGH or (size <= 1e3 * ENOUGH and size > STUCK * last)
