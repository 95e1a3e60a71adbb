"""Some rows of a problem as a problem of their own, so that the others need not be evaluated."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse

from inverse._types import FloatArray, IntArray
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem


class Part:
    """Some rows of a problem.

    Args:
        problem: with all rows.
        rows: (k,) int, which, in ascending order.
    """

    def __init__(self, problem: Problem, rows: IntArray) -> None:
        chosen = np.zeros(problem.n_rows, bool)
        chosen[rows] = True
        places = np.arange(problem.layout.size, dtype=np.float64)
        constraints, own, taken, start = [], [], [], 0
        for constraint in problem.constraints:
            count, k = constraint.lower.shape
            of_rows = chosen[start : start + count * k].reshape(count, k)
            elements = np.asarray(of_rows.any(axis=1))
            if elements.any():
                constraints.append(constraint.only(elements))
                own.append(of_rows[elements].ravel())
                taken.append(problem.layout.of(constraint.elements, places)[elements].ravel())
            start += count * k
        self._problem = Problem(problem.n_variables, [], constraints)
        self._own = np.flatnonzero(np.concatenate(own))
        self._taken = np.concatenate([*taken, places[-1:]]).astype(np.int64)

    def rows(self, point: Point) -> FloatArray:
        """The rows (k,) at a point of the whole problem."""
        return np.asarray(self._at(point).rows[self._own])

    def linearized(self, point: Point) -> tuple[FloatArray, sparse.csr_matrix]:
        """The rows (k,) and their Jacobian (k, n) at a point of the whole problem."""
        at = self._at(point)
        jacobian = at.jacobian  # first: it brings the rows along
        if len(self._own) < jacobian.shape[0]:
            jacobian = jacobian[self._own]
        return np.asarray(at.rows[self._own]), jacobian

    def _at(self, point: Point) -> Point:
        return Point(self._problem, point.variables, point.parameters[self._taken])
