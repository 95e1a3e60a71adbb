"""Least moves that change the rows of a Jacobian, by factors of J J^T."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import LinearOperator, cg, splu

from inverse._types import FloatArray, IntArray

CUT_OFF = 1e-13  # squared: directions in which no row changes by more than 3e-7 of a move are left alone
PRECISE = 1e-10  # of the change: what factors of another Jacobian may leave of it
PATIENCE = 12  # iterations with these, which cost less than making factors anew


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

        cut_off: e, relative to the squares of the rows.

    Attributes:
        order: (R,) int, to be given to the next.
    """

    def __init__(self, jacobian: sparse.csr_matrix, order: IntArray | None = None, cut_off: float = CUT_OFF) -> None:
        given = np.arange(jacobian.shape[0]) if order is None else order
        # Rows of one size: beside a row with a thousandth of an edge in its denominator e would be less than rounding.
        sizes = np.maximum(np.sqrt(jacobian.multiply(jacobian).sum(axis=1)), np.finfo(float).tiny)
        self._scale = 1 / np.asarray(sizes).ravel()[given]
        self._given = given
        self._jacobian = (sparse.diags(self._scale) @ jacobian[given]).tocsr()
        system = self._jacobian @ self._jacobian.T + cut_off * sparse.identity(self._jacobian.shape[0])
        how = "MMD_AT_PLUS_A" if order is None else "NATURAL"
        self._factors = splu(system.tocsc(), permc_spec=how, diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        self.order: IntArray = np.argsort(self._factors.perm_c) if order is None else order

    @classmethod
    def of(
        cls, jacobian: sparse.csr_matrix, order: IntArray | None = None, cut_off: float = CUT_OFF
    ) -> LeastMove | None:
        """The least move, or None where the factors do not exist: a slope that is no number, a pivot of zero."""
        try:
            return cls(jacobian, order, cut_off)
        except RuntimeError:  # SuperLU's word for both
            return None

    def multipliers(self, gradient: FloatArray) -> FloatArray:
        """Multipliers (R,) with which the rows come nearest to balancing a gradient (n,)."""
        balance = np.empty_like(self._scale)
        balance[self._given] = self._scale * self._factors.solve(-(self._jacobian @ gradient))
        return balance

    def forces(self, change: FloatArray) -> FloatArray:
        """How much (R,) of every row's slope the move consists of that changes the rows by ``change`` (R,)."""
        forces = np.empty_like(self._scale)
        forces[self._given] = self._scale * self._factors.solve(self._scale * change[self._given])
        return forces

    def forces_of(self, jacobian: sparse.csr_matrix, change: FloatArray) -> FloatArray | None:
        """The same for another Jacobian (R, n), by conjugate gradients that these factors guide.

        Returns:
            The forces, or None where the Jacobians differ so much that new factors are found sooner.
        """
        cut_off = CUT_OFF * np.asarray(jacobian.multiply(jacobian).sum(axis=1)).ravel()
        size = (len(change), len(change))
        system = LinearOperator(size, lambda forces: jacobian @ (jacobian.T @ forces) + cut_off * forces)
        guide = LinearOperator(size, self.forces)
        forces, unfinished = cg(system, change, rtol=PRECISE, atol=0.0, maxiter=PATIENCE, M=guide)
        return None if unfinished else np.asarray(forces)

    def __call__(self, change: FloatArray) -> FloatArray:
        """The move (n,) that changes the rows by ``change`` (R,)."""
        return np.asarray(self._jacobian.T @ self._factors.solve(self._scale * change[self._given]))
