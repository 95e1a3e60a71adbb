"""Residuals of one element with their exact derivatives, written once and mapped over all elements.

This file holds the performance rule of the project: an element's residual, Jacobian and Hessian are small SX
functions of a few local variables, mapped over the elements and scattered into matrices whose sparsity is known
beforehand. Nothing is derived from the assembled graph, so that building costs stay linear in the facets.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import casadi
import numpy as np

from inverse._types import FloatArray, IntArray

Residual = Callable[[casadi.SX, casadi.SX], casadi.SX]


class Kernel:
    """One element's residual r(q, p) with derivatives.

    Args:
        name: for messages and function names.
        residual: function of the local variables q (n,) and parameters p (m,) that returns residuals (k,).
        n_variables: n.
        n_parameters: m.
    """

    def __init__(self, name: str, residual: Residual, n_variables: int, n_parameters: int = 0) -> None:
        q = casadi.SX.sym("q", n_variables)
        p = casadi.SX.sym("p", n_parameters)
        r = casadi.densify(casadi.vertcat(residual(q, p)))
        weight = casadi.SX.sym("weight", r.numel())
        jacobian = casadi.jacobian(r, q)
        curvature = casadi.triu(casadi.hessian(casadi.dot(weight, r), q)[0])
        # Sum of squares with a factor: what an objective adds per element.
        square = casadi.sumsqr(r)
        gradient = casadi.densify(casadi.gradient(square, q))
        square_curvature = casadi.triu(casadi.hessian(square, q)[0])
        self.name = name
        self.n_variables, self.n_parameters, self.n_residuals = n_variables, n_parameters, r.numel()
        self.value = casadi.Function(f"{name}_value", [q, p], [r])
        self.jacobian = casadi.Function(f"{name}_jacobian", [q, p], [jacobian])
        self.curvature = casadi.Function(f"{name}_curvature", [q, p, weight], [curvature])
        self.square = casadi.Function(f"{name}_square", [q, p], [square])
        self.gradient = casadi.Function(f"{name}_gradient", [q, p], [gradient])
        self.square_curvature = casadi.Function(f"{name}_square_curvature", [q, p], [square_curvature])


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
    pattern, summing = _places(rows.astype(np.int64).tobytes(), columns.astype(np.int64).tobytes(), shape)
    return casadi.MX(pattern, casadi.mtimes(summing, values))


@lru_cache(maxsize=9)  # a sweep over one topology builds the same few matrices again and again
def _places(rows: bytes, columns: bytes, shape: tuple[int, int]) -> tuple[casadi.Sparsity, casadi.DM]:
    """The sparsity of a matrix, and the matrix of ones that adds up nonzeros that share a place."""
    key = np.frombuffer(columns, np.int64) * shape[0] + np.frombuffer(rows, np.int64)  # column-major, like CasADi
    unique, place = np.unique(key, return_inverse=True)
    # Compressed columns from the start: half the time of triplets, which CasADi would sort again.
    first = np.searchsorted(unique, np.arange(shape[1] + 1) * shape[0])
    pattern = casadi.Sparsity(shape[0], shape[1], first.tolist(), (unique % shape[0]).tolist())
    k = len(key)
    summing = casadi.Sparsity(len(unique), k, list(range(k + 1)), place.tolist())
    return pattern, casadi.DM(summing, 1.0)
