"""Values of the whole mesh as variables of their own, so that a function of all vertices leaves the Hessian sparse.

The square of a function f of all vertices has a Hessian of all pairs. With variables y and the equations f(x) = y the
square is one of y alone, and what is left of f is a dense row of the Jacobian, which the solvers can do with. The
curvature of f itself enters where it is sparse; a dense one is left out, as in the method of Gauss and Newton.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi
import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.model import DesignModel
from inverse.nlp.kernels import Elements, Kernel
from inverse.nlp.point import Point
from inverse.nlp.term import Constraint
from inverse.terms.own import Own, has_sparse_curvature


@dataclass(frozen=True, eq=False)
class Carried:
    """The variables that carry the value of one function.

    Attributes:
        model: the model.
        own: the function.
        origin: (3,) that the model's coordinates are relative to.
        first: place of its first variable in the vector of all variables.
    """

    model: DesignModel
    own: Own
    origin: FloatArray
    first: int

    @property
    def name(self) -> str:
        """The function's."""
        return self.own.name

    @property
    def n_variables(self) -> int:
        """How many values there are."""
        return int(self._values.numel_out())

    def start(self, points: FloatArray) -> FloatArray:
        """Values (n_variables,) of a design with dimensionless vertices (V, 3); zero where there is none."""
        values = np.asarray(self._values(points.ravel())).ravel()
        # The equation without a value is told by its name; objectives of these variables are not to hide it.
        return np.where(np.isfinite(values), values, 0.0)

    def elements(self) -> Elements:
        """The values as residuals of the objective."""
        kernel = Kernel("carried", lambda q, _: q, self.n_variables)
        return Elements(self.name, kernel, self._places[None], np.empty((1, 0)))

    def equation(self) -> Constraint:
        """The variables are the values."""
        n, k = self.model.n_variables, self.n_variables
        is_curved = has_sparse_curvature(self._function, n)
        kernel = Kernel("carrying", lambda q, _: self._function(q[:n]) - q[n:], n + k, is_curved=is_curved)
        variables = np.concatenate([np.arange(n), self._places])[None]
        elements = Elements(f"{self.name} of the mesh", kernel, variables, np.empty((1, 0)))
        return Constraint(elements, np.zeros((1, k)), np.zeros((1, k)), ("all vertices",))

    def brought_back(self, gradient: FloatArray, point: Point) -> FloatArray:
        """A gradient (n,) by all variables at a point as one where these variables follow the vertices."""
        n = self.model.n_variables
        found = gradient.copy()
        slopes = self._slopes(point.variables[:n]).sparse()
        found[:n] += slopes.T @ found[self._places]
        found[self._places] = 0.0
        return found

    @property
    def _places(self) -> IntArray:
        return self.first + np.arange(self.n_variables)

    def _function(self, q: casadi.SX) -> casadi.SX:
        return self.own.of_all(self.model, self.origin, self.model.scale * self.model.refinement)(q)

    @cached_property
    def _values(self) -> casadi.Function:
        q = casadi.SX.sym("q", self.model.n_variables)
        return casadi.Function("values", [q], [casadi.densify(self._function(q))])

    @cached_property
    def _slopes(self) -> casadi.Function:
        q = casadi.SX.sym("q", self.model.n_variables)
        return casadi.Function("slopes", [q], [casadi.jacobian(self._function(q), q)])
