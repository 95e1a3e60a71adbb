"""One nonlinear program from terms: functions with hand-assembled sparse derivatives."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from functools import cached_property

import casadi
import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.nlp.compiled import Compiled, Functions, compiled, structure
from inverse.nlp.curvature import Curvature
from inverse.nlp.evaluation import Evaluations
from inverse.nlp.kernels import Elements, scatter
from inverse.nlp.layout import Layout
from inverse.nlp.term import Constraint, Objective


class Problem:
    """Minimize weighted mean squares subject to bounds; everything numeric is a parameter.

    Args:
        n_variables: length of the vector of variables.
        objectives: terms of the objective.
        constraints: hard constraints.
        is_kept: whether its functions are kept for other problems of the same structure; not where there will be none.

    Attributes:
        lower: (R,) lower bounds of all constraint rows.
        upper: (R,) upper bounds.
    """

    def __init__(
        self,
        n_variables: int,
        objectives: Sequence[Objective],
        constraints: Sequence[Constraint],
        *,
        is_kept: bool = True,
    ) -> None:
        self.n_variables = n_variables
        self._is_kept = is_kept
        self.objectives, self.constraints = tuple(objectives), tuple(constraints)
        names = [elements.name for elements in self._elements]
        if len(set(names)) < len(names):
            raise ValueError(f"terms must have unique names, given {sorted(names)}")
        self.lower = np.concatenate([c.lower.ravel() for c in self.constraints])
        self.upper = np.concatenate([c.upper.ravel() for c in self.constraints])

    @property
    def n_rows(self) -> int:
        """Number of constraint rows, R."""
        return len(self.lower)

    def bounded(self, lower: FloatArray, upper: FloatArray) -> Problem:
        """The same functions with other bounds (R,) of the rows."""
        other = copy.copy(self)
        other.lower, other.upper = lower, upper
        return other

    @property
    def equations(self) -> IntArray:
        """(k,) int, the rows that are equations."""
        return np.flatnonzero(self.lower == self.upper)

    @property
    def has_passive_variables(self) -> bool:
        """Whether some variables occur in no objective: they follow the others by equations, and have no curvature."""
        active = np.zeros(self.n_variables, bool)
        for objective in self.objectives:
            active[objective.elements.variables] = True
        return not active.all()

    @property
    def has_redundant_equations(self) -> bool:
        """Whether some equations follow from others, so that their multipliers are not determined."""
        return any(constraint.implies_others for constraint in self.constraints)

    @cached_property
    def layout(self) -> Layout:
        """Where everything lies in the parameter vector."""
        return Layout([o.elements for o in self.objectives], [c.elements for c in self.constraints])

    def parameters(self, replaced: dict[str, FloatArray] | None = None) -> FloatArray:
        """The parameter vector, see :class:`inverse.nlp.layout.Layout`.

        Args:
            replaced: new element parameters (N, m) by term name, for example refreshed closest points.
        """
        return self.layout.vector([objective.weight for objective in self.objectives], replaced or {})

    @property
    def _elements(self) -> list[Elements]:
        return [*(o.elements for o in self.objectives), *(c.elements for c in self.constraints)]

    @property
    def functions(self) -> Functions:
        """CasADi functions in the form that ``nlpsol`` takes: nlp, grad_f, jac_g, hess_lag."""
        return self.compiled.functions

    @cached_property
    def compiled(self) -> Compiled:
        """The functions, shared by all problems of this structure."""
        if not self._is_kept:
            return Compiled(self._made())
        key = structure(self.n_variables, [o.elements for o in self.objectives], [c.elements for c in self.constraints])
        return compiled(key, self.n_rows, self._made)

    @property
    def evaluations(self) -> Evaluations:
        """The same for arrays."""
        return self.compiled.evaluations

    @property
    def curvature(self) -> Curvature:
        """The Lagrangian's Hessian without elements that nothing pushes, shared as well."""
        kept = self.compiled.kept
        if Curvature not in kept:
            objectives, constraints = [o.elements for o in self.objectives], [c.elements for c in self.constraints]
            kept[Curvature] = Curvature(self.layout, objectives, constraints, self.evaluations.hessian_pattern)
        found: Curvature = kept[Curvature]
        return found

    def _made(self) -> Functions:
        x = casadi.MX.sym("x", self.n_variables)
        p = casadi.MX.sym("p", self.layout.size)
        lam_f, lam_g = casadi.MX.sym("lam_f"), casadi.MX.sym("lam_g", self.n_rows)
        hessian = _Triplets()
        f, slopes = self._minimized(x, p, lam_f, hessian)
        g, jacobian = self._constrained(x, p, lam_g, hessian)
        n = self.n_variables
        return {
            "nlp": casadi.Function("nlp", {"x": x, "p": p, "f": f, "g": g}, ["x", "p"], ["f", "g"]),
            "grad_f": casadi.Function("nlp_grad_f", [x, p], [f, slopes], ["x", "p"], ["f", "grad:f:x"]),
            "jac_g": casadi.Function("nlp_jac_g", [x, p], [g, jacobian], ["x", "p"], ["g", "jac:g:x"]),
            "hess_lag": casadi.Function(
                "nlp_hess_l",
                [x, p, lam_f, lam_g],
                [hessian.matrix((n, n))],
                ["x", "p", "lam:f", "lam:g"],
                ["triu:hess:gamma:x:x"],
            ),
        }

    def _minimized(
        self, x: casadi.MX, p: casadi.MX, lam_f: casadi.MX, hessian: _Triplets
    ) -> tuple[casadi.MX, casadi.MX]:
        """The objective and its gradient; its share of the Lagrangian's Hessian is added to ``hessian``."""
        f, gradient = casadi.MX(0), _Triplets()
        for k, objective in enumerate(self.objectives):
            e, kernel = objective.elements, objective.elements.kernel
            local = e.local(x), self.layout.columns(p, e)
            factor = p[k] / (e.count * kernel.n_residuals)
            f += factor * casadi.sum1(e.mapped(kernel.square, *local))
            places = e.variables.ravel()
            gradient.add(factor * e.mapped(kernel.gradient, *local), places, np.zeros_like(places))
            curvature = e.mapped(kernel.square_curvature, *local)
            hessian.add(lam_f * factor * curvature, *e.curvature_places(kernel.square_curvature))
        return f, casadi.densify(gradient.matrix((self.n_variables, 1)))

    def _constrained(
        self, x: casadi.MX, p: casadi.MX, lam_g: casadi.MX, hessian: _Triplets
    ) -> tuple[casadi.MX, casadi.MX]:
        """The rows and their Jacobian; their share of the Lagrangian's Hessian is added to ``hessian``."""
        values, jacobian, row = [], _Triplets(), 0
        for constraint in self.constraints:
            e, kernel = constraint.elements, constraint.elements.kernel
            local = e.local(x), self.layout.columns(p, e)
            height = e.count * kernel.n_residuals
            values.append(e.mapped(kernel.value, *local))
            rows, columns = e.matrix_places()
            jacobian.add(e.mapped(kernel.jacobian, *local), rows + row, columns)
            multipliers = p[-1] * casadi.reshape(lam_g[row : row + height], kernel.n_residuals, e.count)
            hessian.add(e.mapped(kernel.curvature, *local, multipliers), *e.curvature_places(kernel.curvature))
            row += height
        return casadi.vertcat(*values), jacobian.matrix((self.n_rows, self.n_variables))


class _Triplets:
    """Nonzeros of a matrix, collected term by term."""

    def __init__(self) -> None:
        self._values: list[casadi.MX] = [casadi.MX(0, 1)]
        self._rows: list[IntArray] = [np.empty(0, np.int64)]
        self._columns: list[IntArray] = [np.empty(0, np.int64)]

    def add(self, values: casadi.MX, rows: IntArray, columns: IntArray) -> None:
        self._values.append(values)
        self._rows.append(rows)
        self._columns.append(columns)

    def matrix(self, shape: tuple[int, int]) -> casadi.MX:
        return scatter(casadi.vertcat(*self._values), np.concatenate(self._rows), np.concatenate(self._columns), shape)
