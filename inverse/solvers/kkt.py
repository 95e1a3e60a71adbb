"""The linear system of a Newton step: Hessian and Jacobian of the rows that are held, factorized together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import SuperLU, splu

from inverse._types import FloatArray, IntArray
from inverse.nlp.problem import Problem

# In the place of zeros under the Jacobian, negative: the matrix is then quasi-definite where the Hessian is positive
# on the moves that keep the rows, which any order of elimination without pivots is good for, and rows that follow from
# others do no harm. IPOPT's value.
REGULARIZED = 1e-8
REFINEMENTS = 2  # corrections of a solution by its residual: from 3e-4 to 2e-12 at 16 x 16 facets
KEPT = 4  # structures of one problem, for different rows


@dataclass(frozen=True, eq=False)
class Structure:
    """Where the numbers of a Newton step's matrix lie, in an order in which its factors stay sparse.

    Attributes:
        sources: (K,) int, for every nonzero its place among those of the Hessian, of the Jacobian, and two more: zero,
            and the regularization.
        diagonal: (n,) int, the nonzeros that are the variables' diagonal.
        indices: (K,) int, its row.
        starts: (N + 1,) int, where each column begins.
        order: (N,) int, variables and then rows in the order of elimination.
    """

    sources: IntArray
    diagonal: IntArray
    indices: IntArray
    starts: IntArray
    order: IntArray

    @classmethod
    def of(cls, problem: Problem, held: IntArray, hessian: FloatArray, jacobian: FloatArray) -> Structure:
        """The structure for held rows (k,), kept with the problem; its order is found with the first numbers."""
        kept = problem.compiled.kept.setdefault(cls, {})
        key = held.tobytes()
        if key not in kept:
            if len(kept) >= KEPT:
                kept.pop(next(iter(kept)))
            kept[key] = cls._made(problem, held, hessian, jacobian)
        found: Structure = kept[key]
        return found

    @classmethod
    def _made(cls, problem: Problem, held: IntArray, hessian: FloatArray, jacobian: FloatArray) -> Structure:
        n = problem.n_variables
        i, j = problem.evaluations.hessian_pattern
        upper = np.arange(len(i))
        mirrored = i != j
        lacking = np.setdiff1d(np.arange(n), i[~mirrored])
        row, column = problem.evaluations.jacobian_pattern
        place = np.full(problem.n_rows, -1)
        place[held] = n + np.arange(len(held))
        own = np.flatnonzero(place[row] >= 0)
        row, column, own = place[row[own]], column[own], own + len(i)
        zero = len(i) + len(jacobian)
        ends = n + np.arange(len(held))
        rows = np.concatenate([i, j[mirrored], lacking, row, column, ends])
        columns = np.concatenate([j, i[mirrored], lacking, column, row, ends])
        sources = np.concatenate(
            [upper, upper[mirrored], np.full(len(lacking), zero), own, own, np.full(len(ends), zero + 1)]
        )
        first = cls._sorted(rows, columns, sources, np.arange(n + len(held)), n)
        factors = _factorized(first.matrix(hessian, jacobian, 1.0), "MMD_AT_PLUS_A")
        return cls._sorted(rows, columns, sources, np.argsort(factors.perm_c), n)

    @classmethod
    def _sorted(cls, rows: IntArray, columns: IntArray, sources: IntArray, order: IntArray, n: int) -> Structure:
        """Nonzeros sorted by columns when rows and columns are in this order."""
        place = np.argsort(order)
        rows, columns = place[rows], place[columns]
        by_columns = np.lexsort((rows, columns))
        rows, columns = rows[by_columns], columns[by_columns]
        starts = np.searchsorted(columns, np.arange(len(order) + 1))
        diagonal = np.flatnonzero((rows == columns) & (order[columns] < n))
        return cls(sources[by_columns], diagonal, rows.astype(np.int32), starts.astype(np.int32), order)

    def matrix(self, hessian: FloatArray, jacobian: FloatArray, shift: float) -> sparse.csc_matrix:
        """The matrix with nonzeros of the Hessian's upper triangle and of the whole Jacobian.

        Args:
            hessian: (H,) in the order of the problem's pattern.
            jacobian: (J,) row by row.
            shift: multiple of the identity that is added to the Hessian.
        """
        values = np.concatenate([hessian, jacobian, [0.0, -REGULARIZED]])[self.sources]
        values[self.diagonal] += shift
        n = len(self.order)
        return sparse.csc_matrix((values, self.indices, self.starts), shape=(n, n))


class Factors:
    """Factors of a Newton step's matrix.

    Args:
        problem: the problem.
        held: (k,) int, rows that are kept where they are.
        hessian: nonzeros of the Lagrangian's Hessian, as ``Compiled.curvature`` has them.
        jacobian: nonzeros of the Jacobian of all rows, row by row.
        shift: multiple of the identity that is added to the Hessian.

    Raises:
        RuntimeError: there are none: a number that is not finite, a pivot of zero.
    """

    def __init__(
        self, problem: Problem, held: IntArray, hessian: FloatArray, jacobian: FloatArray, shift: float
    ) -> None:
        self._n, self._n_held = problem.n_variables, len(held)
        structure = Structure.of(problem, held, hessian, jacobian)
        self._order = structure.order
        self._matrix = structure.matrix(hessian, jacobian, shift)
        self._factors = _factorized(self._matrix, "NATURAL")

    @property
    def is_minimum(self) -> bool:
        """Whether the Hessian is positive on all moves that keep the rows: as many pivots are negative as rows held.

        By Sylvester's law of inertia, which holds for pivots on the diagonal alone.
        """
        factors = self._factors
        on_diagonal = bool((factors.perm_r == factors.perm_c).all())
        return on_diagonal and int((factors.U.diagonal() < 0).sum()) == self._n_held

    def step(self, slope: FloatArray, off: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The move (n,) and the change of multipliers (k,) that take away a slope (n,) and what rows (k,) are off."""
        right = -np.concatenate([slope, off])[self._order]
        solution = self._factors.solve(right)
        for _ in range(REFINEMENTS):
            solution += self._factors.solve(right - self._matrix @ solution)
        found = np.empty_like(solution)
        found[self._order] = solution
        return found[: self._n], found[self._n :]


def _factorized(matrix: sparse.csc_matrix, order: str) -> SuperLU:
    """Factors with pivots on the diagonal wherever these are not zero."""
    return splu(matrix, permc_spec=order, diag_pivot_thresh=0.0, options={"SymmetricMode": True})
