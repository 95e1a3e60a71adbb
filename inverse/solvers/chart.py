"""Coordinates of the designs that satisfy all equations, around one of them.

The equations of a grid of m x n facets leave 5 (m + n) + 1 degrees of freedom of some 3 m n variables. In coordinates
of this manifold the equations are gone, and what is left is small enough for dense methods.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import SuperLU, splu

from inverse._types import FloatArray
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem

RESIDUAL = 1e-14  # of equations; where rounding does not allow it, no less than TOLERATED
TOLERATED = 1e-10
STEPS = 12  # of Newton's method, to a point of the manifold
REGULARIZED = 1e-12  # keeps equations solvable that repeat each other, as in projection.LeastMove


class Functions:
    """The functions of a problem at given parameters, and the time that they take.

    Args:
        problem: the problem.
        parameters: its parameter vector.

    Attributes:
        seconds: spent in the functions so far.
    """

    def __init__(self, problem: Problem, parameters: FloatArray) -> None:
        self.problem, self._parameters = problem, parameters
        self.seconds = 0.0

    def rows(self, x: FloatArray) -> tuple[FloatArray, sparse.csr_matrix]:
        """Constraint rows (R,) and their Jacobian (R, n)."""
        began = time.perf_counter()
        point = Point(self.problem, x, self._parameters)
        jacobian = point.jacobian  # first: it brings the rows along
        found = point.rows, jacobian
        self.seconds += time.perf_counter() - began
        return found

    def objective(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Objective and its gradient (n,)."""
        began = time.perf_counter()
        point = Point(self.problem, x, self._parameters)
        found = point.objective, point.gradient
        self.seconds += time.perf_counter() - began
        return found

    def hessian(self, x: FloatArray, multipliers: FloatArray) -> sparse.csr_matrix:
        """Hessian (n, n) of the Lagrangian."""
        began = time.perf_counter()
        upper = self.problem.functions["hess_lag"](x, self._parameters, 1.0, multipliers).sparse().tocsr()
        self.seconds += time.perf_counter() - began
        return upper + sparse.triu(upper, 1).T


@dataclass(frozen=True, eq=False)
class ChartPoint:
    """A point of a chart.

    Attributes:
        variables: (n,).
        objective: its value.
        gradient: (n,) of the objective.
        rows: (R,) constraint rows.
        jacobian: (R, n) of the rows.
    """

    variables: FloatArray
    objective: float
    gradient: FloatArray
    rows: FloatArray
    jacobian: sparse.csr_matrix


class Chart:
    """Points x = origin + tangent + J0^T w where the equations have a given share of the residual at the origin.

    Args:
        functions: of the problem.
        origin: (n,) the point that the chart belongs to.

    Attributes:
        place: the origin.
        residual: (E,) of the equations at the origin; zero where the origin is on the manifold.
        tangents: (n, d) orthonormal, along which the equations keep their residual to first order.
    """

    def __init__(self, functions: Functions, origin: FloatArray) -> None:
        self._functions = functions
        problem = functions.problem
        self._equations = problem.equations
        self.place = ChartPoint(origin, *functions.objective(origin), *functions.rows(origin))
        self._normals = self.place.jacobian[self._equations]
        left = self._residual(self.place.rows)
        self.residual = left if np.abs(left).max(initial=0.0) > TOLERATED else np.zeros_like(left)
        self._factors = self._factorized(self._normals)
        self.tangents = self._tangents()

    @cached_property
    def correction(self) -> FloatArray:
        """(n,) the least move that removes the residual to first order."""
        return np.asarray(-self._normals.T @ self._factors.solve(self.residual))

    def multipliers(self, gradient: FloatArray) -> FloatArray:
        """Multipliers (E,) of the equations that make a gradient (n,) tangential at the origin, or nearly so."""
        return np.asarray(-self._factors.solve(self._normals @ gradient))

    def at(self, tangent: FloatArray, share: float) -> ChartPoint | None:
        """The point over a tangent vector (n,), or None where Newton's method finds none.

        Args:
            tangent: move from the origin, a combination of the tangents.
            share: what is left of the residual, from 1 to 0.
        """
        x = self.place.variables + tangent
        wanted = share * self.residual
        last = np.inf
        for _ in range(STEPS):
            rows, jacobian = self._functions.rows(x)
            missing = self._residual(rows) - wanted
            size = float(np.abs(missing).max(initial=0.0))
            if size <= RESIDUAL or 0.5 * last <= size <= TOLERATED:
                return ChartPoint(x, *self._functions.objective(x), rows, jacobian)
            if not size <= 2 * last:  # not a number included
                return None
            last = size
            try:
                factors = self._factorized(jacobian[self._equations])
            except RuntimeError:  # exactly singular
                return None
            x = x - self._normals.T @ factors.solve(missing)
        return None

    def slopes(self, place: ChartPoint, vectors: sparse.csr_matrix, directions: FloatArray) -> FloatArray:
        """Slopes of functions along the manifold.

        Args:
            place: where.
            vectors: (K, n) gradients of the functions.
            directions: (n, d) combinations of the tangents.

        Returns:
            (K, d + 1): along the directions, and the last by the share of the residual.
        """
        jacobian = place.jacobian[self._equations]
        factors, along = self._factorized(jacobian), jacobian @ directions
        if vectors.shape[0] <= directions.shape[1]:  # whichever has fewer right-hand sides
            bent = factors.solve(np.asarray((self._normals @ vectors.T).todense()), "T").T
            return np.column_stack([vectors @ directions - bent @ along, bent @ self.residual])
        moves = -self._normals.T @ factors.solve(np.column_stack([along, -self.residual]))
        moves[:, :-1] += directions
        return np.asarray(vectors @ moves)

    def _residual(self, rows: FloatArray) -> FloatArray:
        return np.asarray(rows[self._equations] - self._functions.problem.lower[self._equations])

    def _factorized(self, jacobian: sparse.csr_matrix) -> SuperLU:
        system = jacobian @ self._normals.T + REGULARIZED * sparse.identity(len(self._equations))
        return splu(system.tocsc())

    def _tangents(self) -> FloatArray:
        """An orthonormal basis of the null space: random vectors, projected; one finds all with enough of them."""
        n = len(self.place.variables)
        wanted = max(n - len(self._equations), 0) + 8
        while True:
            vectors = np.random.default_rng(0).standard_normal((n, min(wanted, n)))
            for _ in range(2):  # the second removes what rounding left
                vectors -= self._normals.T @ self._factors.solve(self._normals @ vectors)
            basis, sizes, _ = np.linalg.svd(vectors, full_matrices=False)
            rank = int(np.sum(sizes > 1e-6 * np.sqrt(n)))
            if rank < wanted:
                return np.asarray(basis[:, :rank])
            wanted *= 2  # equations that repeat each other leave more freedom
