"""One nonlinear program from terms: functions with hand-assembled sparse derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import casadi
import numpy as np
import scipy.sparse as sparse

from inverse.kernels import Elements, scatter
from inverse.model import Constraint, Objective
from inverse.pattern import FloatArray


class Problem:
    """Minimize weighted mean squares subject to bounds; everything numeric is a parameter.

    Args:
        n_variables: length of the vector of variables.
        objectives: terms of the objective.
        constraints: hard constraints.

    Attributes:
        lower: (R,) lower bounds of all constraint rows.
        upper: (R,) upper bounds.
    """

    def __init__(self, n_variables: int, objectives: Sequence[Objective], constraints: Sequence[Constraint]) -> None:
        self.n_variables = n_variables
        self.objectives, self.constraints = tuple(objectives), tuple(constraints)
        names = [term.name for term in (*self.objectives, *self.constraints)]
        if len(set(names)) < len(names):
            raise ValueError(f"terms must have unique names, given {sorted(names)}")
        self.lower = np.concatenate([c.lower.ravel() for c in self.constraints])
        self.upper = np.concatenate([c.upper.ravel() for c in self.constraints])

    @property
    def n_rows(self) -> int:
        """Number of constraint rows, R."""
        return len(self.lower)

    def parameters(self, replaced: dict[str, FloatArray] | None = None) -> FloatArray:
        """The parameter vector: objective weights, then every term's element parameters.

        Args:
            replaced: new element parameters (N, m) by term name, for example refreshed closest points.
        """
        replaced = replaced or {}
        weights = [objective.weight for objective in self.objectives]
        blocks = [replaced.get(e.name, e.parameters).ravel() for e in self._elements]
        return np.concatenate([weights, *blocks])

    @property
    def _elements(self) -> list[Elements]:
        return [term.elements for term in (*self.objectives, *self.constraints)]

    @cached_property
    def functions(self) -> dict[str, casadi.Function]:
        """CasADi functions in the form that ``nlpsol`` takes: nlp, grad_f, jac_g, hess_lag."""
        x = casadi.MX.sym("x", self.n_variables)
        n_weights = len(self.objectives)
        sizes = [e.parameters.size for e in self._elements]
        p = casadi.MX.sym("p", n_weights + sum(sizes))
        offsets = np.cumsum([n_weights, *sizes])
        local = {
            e.name: (e.local(x), casadi.reshape(p[int(start) : int(start) + e.parameters.size], e.kernel.n_parameters, e.count))
            for e, start in zip(self._elements, offsets, strict=False)
        }

        f, gradient = casadi.MX(0), casadi.MX.zeros(self.n_variables)
        curvature, rows, columns = [], [], []
        lam_f, lam_g = casadi.MX.sym("lam_f"), casadi.MX.sym("lam_g", self.n_rows)
        for k, objective in enumerate(self.objectives):
            e = objective.elements
            factor = p[k] / (e.count * e.kernel.n_residuals)
            f += factor * casadi.sum1(e.mapped(e.kernel.square, *local[e.name]))
            slopes = e.mapped(e.kernel.gradient, *local[e.name])
            places = e.variables.ravel()
            gradient += factor * casadi.densify(
                scatter(slopes, places, np.zeros_like(places), (self.n_variables, 1))
            )
            curvature.append(lam_f * factor * e.mapped(e.kernel.square_curvature, *local[e.name]))
            _extend(rows, columns, e.curvature_places(e.kernel.square_curvature))

        g, jacobian, jacobian_rows, jacobian_columns = [], [], [], []
        row = 0
        for constraint in self.constraints:
            e = constraint.elements
            height = e.count * e.kernel.n_residuals
            g.append(e.mapped(e.kernel.value, *local[e.name]))
            jacobian.append(e.mapped(e.kernel.jacobian, *local[e.name]))
            r, c = e.matrix_places()
            _extend(jacobian_rows, jacobian_columns, (r + row, c))
            if e.kernel.curvature.nnz_out(0):
                multipliers = casadi.reshape(lam_g[row : row + height], e.kernel.n_residuals, e.count)
                curvature.append(e.mapped(e.kernel.curvature, *local[e.name], multipliers))
                _extend(rows, columns, e.curvature_places(e.kernel.curvature))
            row += height

        n = self.n_variables
        values = casadi.vertcat(*g)
        jac_g = scatter(casadi.vertcat(*jacobian), np.concatenate(jacobian_rows), np.concatenate(jacobian_columns), (self.n_rows, n))
        hessian = scatter(casadi.vertcat(*curvature), np.concatenate(rows), np.concatenate(columns), (n, n))
        return {
            "nlp": casadi.Function("nlp", {"x": x, "p": p, "f": f, "g": values}, ["x", "p"], ["f", "g"]),
            "grad_f": casadi.Function("nlp_grad_f", [x, p], [f, gradient], ["x", "p"], ["f", "grad:f:x"]),
            "jac_g": casadi.Function("nlp_jac_g", [x, p], [values, jac_g], ["x", "p"], ["g", "jac:g:x"]),
            "hess_lag": casadi.Function(
                "nlp_hess_l", [x, p, lam_f, lam_g], [hessian], ["x", "p", "lam:f", "lam:g"], ["triu:hess:gamma:x:x"]
            ),
        }

    def rows_and_jacobian(self, x: FloatArray, parameters: FloatArray) -> tuple[FloatArray, sparse.csr_matrix]:
        """Constraint rows (R,) and their Jacobian (R, n)."""
        rows, jacobian = self.functions["jac_g"](x, parameters)
        return np.asarray(rows).ravel(), jacobian.sparse().tocsr()

    def objective_and_gradient(self, x: FloatArray, parameters: FloatArray) -> tuple[float, FloatArray]:
        """Weighted objective and its gradient (n,)."""
        value, gradient = self.functions["grad_f"](x, parameters)
        return float(value), np.asarray(gradient).ravel()

    def objective_terms(self, x: FloatArray, parameters: FloatArray) -> dict[str, float]:
        """Weighted value of every objective term."""
        return dict(zip((o.name for o in self.objectives), self._terms(x, parameters), strict=True))

    def violations(self, x: FloatArray, parameters: FloatArray) -> dict[str, tuple[float, str]]:
        """Largest violation of every constraint, dimensionless, and the element where it is."""
        rows, _ = self.rows_and_jacobian(x, parameters)
        excess = np.maximum(np.maximum(self.lower - rows, rows - self.upper), 0.0)
        found, start = {}, 0
        for constraint in self.constraints:
            count, k = constraint.lower.shape
            own = excess[start : start + count * k].reshape(count, k).max(axis=1)
            worst = int(np.argmax(own)) if count else 0
            found[constraint.name] = (float(own[worst]), constraint.labels[worst]) if count else (0.0, "")
            start += count * k
        return found

    def _terms(self, x: FloatArray, parameters: FloatArray) -> list[float]:
        start = len(self.objectives)
        values = []
        for weight, objective in zip(parameters[:start], self.objectives, strict=True):
            e = objective.elements
            own = parameters[start : start + e.parameters.size].reshape(e.count, -1)
            squares = e.kernel.square.map(e.count)(x[e.variables].T, own.T)
            values.append(float(weight * np.sum(np.asarray(squares)) / (e.count * e.kernel.n_residuals)))
            start += e.parameters.size
        return values


def _extend(rows: list, columns: list, places: tuple) -> None:  # type: ignore[type-arg]
    rows.append(places[0])
    columns.append(places[1])
