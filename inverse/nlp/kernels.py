"""Residuals of one element with their exact derivatives, written once and mapped over all elements.

This file holds the performance rule of the project: an element's residual, Jacobian and Hessian are small SX
functions of a few local variables, mapped over the elements and scattered into matrices whose sparsity is known
beforehand. Nothing is derived from the assembled graph, so that building costs stay linear in the facets.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import casadi
import numpy as np

from inverse._types import FloatArray, IntArray

SHARING = 5000  # operations of an expression up to which repeated ones are sought

Residual = Callable[[casadi.SX, casadi.SX], casadi.SX]


class Kernel:
    """One element's residual r(q, p) with derivatives, each made when it is first asked for.

    Args:
        name: for messages and function names.
        residual: function of the local variables q (n,) and parameters p (m,) that returns residuals (k,).
        n_variables: n.
        n_parameters: m.
        is_curved: False to leave second derivatives of the residuals out (the Gauss-Newton idea), where they would be
            dense in many variables.
    """

    def __init__(
        self, name: str, residual: Residual, n_variables: int, n_parameters: int = 0, *, is_curved: bool = True
    ) -> None:
        self._q = casadi.SX.sym("q", n_variables)
        self._p = casadi.SX.sym("p", n_parameters)
        self._residuals = casadi.densify(casadi.vertcat(residual(self._q, self._p)))
        self._is_curved = is_curved
        self.name = name
        self.n_variables, self.n_parameters, self.n_residuals = n_variables, n_parameters, self._residuals.numel()

    @cached_property
    def form(self) -> str:
        """What the kernel computes, as text: kernels of one form have the same functions."""
        return f"{self._is_curved} {casadi.Function('form', [self._q, self._p], [self._residuals]).serialize()}"

    @cached_property
    def value(self) -> casadi.Function:
        """r."""
        return self._function("value", self._residuals)

    @cached_property
    def jacobian(self) -> casadi.Function:
        """(k, n) of r by q."""
        return self._function("jacobian", casadi.jacobian(self._residuals, self._q))

    @cached_property
    def curvature(self) -> casadi.Function:
        """Upper triangle (n, n) of the Hessian of r times weights (k,), its third argument."""
        weight = casadi.SX.sym("weight", self.n_residuals)
        if self._is_curved:
            curvature = casadi.triu(casadi.hessian(casadi.dot(weight, self._residuals), self._q)[0])
        else:
            curvature = casadi.SX(self.n_variables, self.n_variables)
        return self._function("curvature", curvature, weight)

    @cached_property
    def square(self) -> casadi.Function:
        """The sum of squares of r: what an objective adds per element, but for a factor."""
        return self._function("square", casadi.sumsqr(self._residuals))

    @cached_property
    def gradient(self) -> casadi.Function:
        """(n,) of the sum of squares."""
        return self._function("gradient", casadi.densify(casadi.gradient(casadi.sumsqr(self._residuals), self._q)))

    @cached_property
    def square_curvature(self) -> casadi.Function:
        """Upper triangle (n, n) of the Hessian of the sum of squares."""
        curvature = casadi.hessian(casadi.sumsqr(self._residuals), self._q)[0]
        # Slopes and curvatures share much, of a target's own expression two thirds; finding it takes longer than it
        # saves where the expression is large and the elements are few.
        if casadi.n_nodes(curvature) < SHARING:
            curvature = casadi.cse(curvature)
        return self._function("square_curvature", casadi.triu(curvature))

    def _function(self, name: str, value: casadi.SX, *more: casadi.SX) -> casadi.Function:
        return casadi.Function(f"{self.name}_{name}", [self._q, self._p, *more], [value])


@dataclass(frozen=True, eq=False)
class Elements:
    """A kernel with the elements it acts on.

    Attributes:
        name: unique name of the term.
        kernel: the element's residual.
        variables: (N, n) int, places of each element's variables in the vector of all variables.
        parameters: (N, m) float64, default values of each element's parameters.
    """

    name: str
    kernel: Kernel
    variables: IntArray
    parameters: FloatArray

    def __post_init__(self) -> None:
        n, m = self.kernel.n_variables, self.kernel.n_parameters
        if self.variables.shape[1:] != (n,) or self.parameters.shape != (len(self.variables), m):
            raise ValueError(
                f"term {self.name}: elements of {n} variables and {m} parameters are needed, "
                f"given arrays of shape {self.variables.shape} and {self.parameters.shape}"
            )

    @property
    def count(self) -> int:
        """Number of elements, N."""
        return len(self.variables)

    def local(self, x: casadi.MX) -> casadi.MX:
        """Each element's variables as a column of an (n, N) matrix."""
        return casadi.reshape(x[self.variables.ravel().tolist()], self.kernel.n_variables, self.count)

    def mapped(self, function: casadi.Function, *arguments: casadi.MX) -> casadi.MX:
        """Nonzeros of a kernel function over all elements, element by element."""
        mapped = function.map(self.count)
        # CasADi drops nonzeros of an output that it knows to be zero; their places are still counted on.
        out = casadi.project(mapped(*arguments), mapped.sparsity_out(0))
        return casadi.vec(out.nz[:])  # nz of a row vector would be a row

    def matrix_places(self) -> tuple[IntArray, IntArray]:
        """Rows and columns, in the residual Jacobian of these elements, of the mapped nonzeros."""
        row, column = (np.array(k, np.int64) for k in self.kernel.jacobian.sparsity_out(0).get_triplet())
        rows = np.arange(self.count)[:, None] * self.kernel.n_residuals + row
        return rows.ravel(), self.variables[:, column].ravel()

    def curvature_places(self, function: casadi.Function) -> tuple[IntArray, IntArray]:
        """Rows and columns, in the upper triangle of the Hessian, of a mapped curvature's nonzeros."""
        row, column = (np.array(k, np.int64) for k in function.sparsity_out(0).get_triplet())
        rows, columns = self.variables[:, row].ravel(), self.variables[:, column].ravel()
        return np.minimum(rows, columns), np.maximum(rows, columns)


def scatter(values: casadi.MX, rows: IntArray, columns: IntArray, shape: tuple[int, int]) -> casadi.MX:
    """A sparse matrix from nonzeros; those that share a place add up.

    Args:
        values: (K,) nonzeros.
        rows: (K,) their rows.
        columns: (K,) their columns.
        shape: of the matrix.
    """
    key = columns * shape[0] + rows  # column-major, like CasADi
    unique, place = np.unique(key, return_inverse=True)
    # Compressed columns from the start: half the time of triplets, which CasADi would sort again.
    first = np.searchsorted(unique, np.arange(shape[1] + 1) * shape[0])
    pattern = casadi.Sparsity(shape[0], shape[1], first.tolist(), (unique % shape[0]).tolist())
    k = len(key)
    summing = casadi.Sparsity(len(unique), k, list(range(k + 1)), place.tolist())
    return casadi.MX(pattern, casadi.mtimes(casadi.DM(summing, 1.0), values))
