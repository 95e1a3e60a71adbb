"""The functions of a problem, called with arrays and answered in arrays.

CasADi's own matrices would be made and copied at every call, which takes longer than many of the functions.
"""

from __future__ import annotations

import threading
from functools import cached_property

import casadi
import numpy as np
import scipy.sparse as sparse

from inverse._types import FloatArray, IntArray


class Evaluations:
    """What a problem is at given variables and parameters.

    Args:
        functions: of the problem, see :attr:`inverse.nlp.problem.Problem.functions`.
    """

    def __init__(self, functions: dict[str, casadi.Function]) -> None:
        self._functions = functions

    def rows(self, x: FloatArray, p: FloatArray) -> FloatArray:
        """Constraint rows (R,)."""
        return self._nlp(x, p)[1]

    def slope(self, x: FloatArray, p: FloatArray) -> tuple[float, FloatArray]:
        """The objective and its gradient (n,)."""
        value, gradient = self._grad_f(x, p)
        return float(value[0]), gradient

    def linearized(self, x: FloatArray, p: FloatArray) -> tuple[FloatArray, sparse.csr_matrix]:
        """Constraint rows (R,) and their Jacobian (R, n)."""
        rows, values = self._jac_g(x, p)
        order, columns, ends = self._places
        shape = self._functions["jac_g"].size_out(1)
        return rows, sparse.csr_matrix((values[order], columns, ends), shape)

    def curvature(self, x: FloatArray, p: FloatArray, weight: float, multipliers: FloatArray) -> FloatArray:
        """Nonzeros (K,) of the Lagrangian's Hessian, the objective times ``weight``, in the order of its pattern."""
        return self._hess_lag(x, p, np.array([weight]), multipliers)[0]

    @cached_property
    def jacobian_pattern(self) -> tuple[IntArray, IntArray]:
        """Rows and columns (K,) of the nonzeros of the Jacobian, row by row."""
        _, columns, ends = self._places
        return np.repeat(np.arange(len(ends) - 1), np.diff(ends)), columns.astype(np.int64)

    @cached_property
    def hessian_pattern(self) -> tuple[IntArray, IntArray]:
        """Rows and columns (K,) of the nonzeros of the Hessian's upper triangle, column by column."""
        rows, columns = self._functions["hess_lag"].sparsity_out(0).get_triplet()
        return np.array(rows, np.int64), np.array(columns, np.int64)

    @cached_property
    def _hess_lag(self) -> Call:
        return Call(self._functions["hess_lag"])

    @cached_property
    def _nlp(self) -> Call:
        return Call(self._functions["nlp"])

    @cached_property
    def _grad_f(self) -> Call:
        return Call(self._functions["grad_f"])

    @cached_property
    def _jac_g(self) -> Call:
        return Call(self._functions["jac_g"])

    @cached_property
    def _places(self) -> tuple[IntArray, IntArray, IntArray]:
        """Of the Jacobian's nonzeros by rows: their places among those by columns, their columns, and the rows' ends.

        The arrays are shared by all Jacobians, and cannot be written to.
        """
        pattern = self._functions["jac_g"].sparsity_out(1)
        by_columns = (np.arange(pattern.nnz()), np.array(pattern.row()), np.array(pattern.colind()))
        by_rows = sparse.csc_matrix(by_columns, pattern.size()).tocsr()
        for shared in (by_rows.indices, by_rows.indptr):
            shared.flags.writeable = False
        return by_rows.data, by_rows.indices, by_rows.indptr


class Call:
    """One function with its working memory; one thread at a time.

    Args:
        function: the function.
    """

    def __init__(self, function: casadi.Function) -> None:
        self._buffer, self._evaluate = function.buffer()
        self._sizes = [function.nnz_out(k) for k in range(function.n_out())]
        self._lock = threading.Lock()

    def __call__(self, *arguments: FloatArray) -> list[FloatArray]:
        """Nonzeros of every output, by columns.

        Args:
            arguments: for every input its nonzeros, by columns.

        Raises:
            RuntimeError: the function could not be evaluated.
        """
        given = [np.ascontiguousarray(argument, np.float64) for argument in arguments]
        results = [np.empty(size) for size in self._sizes]
        with self._lock:
            for k, array in enumerate(given):
                self._buffer.set_arg(k, array.data)  # type: ignore[call-arg]  # a buffer brings its size
            for k, array in enumerate(results):
                self._buffer.set_res(k, array.data)  # type: ignore[call-arg]
            self._evaluate()
            if self._buffer.ret():
                raise RuntimeError("a function of the problem could not be evaluated")
        return results
