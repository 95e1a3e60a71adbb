"""One nonlinear program from terms: functions with hand-assembled sparse derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import casadi
import numpy as np
import scipy.sparse as sparse

from inverse._types import FloatArray, IntArray
from inverse.nlp.kernels import Elements, scatter
from inverse.nlp.term import Constraint, Objective


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
        names = [elements.name for elements in self._elements]
        if len(set(names)) < len(names):
            raise ValueError(f"terms must have unique names, given {sorted(names)}")
        self.lower = np.concatenate([c.lower.ravel() for c in self.constraints])
        self.upper = np.concatenate([c.upper.ravel() for c in self.constraints])

    @property
    def n_rows(self) -> int:
        """Number of constraint rows, R."""
        return len(self.lower)

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

    @property
    def n_objective_parameters(self) -> int:
        """Number of parameters that belong to the objectives; they come first."""
        return len(self.objectives) + sum(o.elements.parameters.size for o in self.objectives)

    def parameters(self, replaced: dict[str, FloatArray] | None = None) -> FloatArray:
        """The parameter vector: objective weights, every term's element parameters, and the share of curvature.

        The last entry multiplies the constraints in the Lagrangian's Hessian: 1 for Newton's method, 0 to take
        the constraints as linear (see :meth:`linearized`).

        Args:
            replaced: new element parameters (N, m) by term name, for example refreshed closest points.
        """
        replaced = replaced or {}
        weights = [objective.weight for objective in self.objectives]
        blocks = [replaced.get(e.name, e.parameters).ravel() for e in self._elements]
        return np.concatenate([weights, *blocks, [1.0]])

    @staticmethod
    def linearized(parameters: FloatArray) -> FloatArray:
        """The same parameters with a Hessian that leaves the curvature of the constraints out."""
        return np.append(parameters[:-1], 0.0)

    @property
    def _elements(self) -> list[Elements]:
        return [*(o.elements for o in self.objectives), *(c.elements for c in self.constraints)]

    @cached_property
    def functions(self) -> dict[str, casadi.Function]:
        """CasADi functions in the form that ``nlpsol`` takes: nlp, grad_f, jac_g, hess_lag."""
        x = casadi.MX.sym("x", self.n_variables)
        n_weights = len(self.objectives)
        sizes = [e.parameters.size for e in self._elements]
        p = casadi.MX.sym("p", n_weights + sum(sizes) + 1)
        offsets = np.cumsum([n_weights, *sizes])
        local = {
            e.name: (
                e.local(x),
                casadi.reshape(p[int(start) : int(start) + e.parameters.size], e.kernel.n_parameters, e.count),
            )
            for e, start in zip(self._elements, offsets, strict=False)
        }

        n = self.n_variables
        lam_f, lam_g = casadi.MX.sym("lam_f"), casadi.MX.sym("lam_g", self.n_rows)
        f = casadi.MX(0)
        gradient, jacobian, hessian = _Triplets(), _Triplets(), _Triplets()
        for k, objective in enumerate(self.objectives):
            e, kernel = objective.elements, objective.elements.kernel
            factor = p[k] / (e.count * kernel.n_residuals)
            f += factor * casadi.sum1(e.mapped(kernel.square, *local[e.name]))
            places = e.variables.ravel()
            gradient.add(factor * e.mapped(kernel.gradient, *local[e.name]), places, np.zeros_like(places))
            curvature = e.mapped(kernel.square_curvature, *local[e.name])
            hessian.add(lam_f * factor * curvature, *e.curvature_places(kernel.square_curvature))

        values, row = [], 0
        for constraint in self.constraints:
            e, kernel = constraint.elements, constraint.elements.kernel
            height = e.count * kernel.n_residuals
            values.append(e.mapped(kernel.value, *local[e.name]))
            rows, columns = e.matrix_places()
            jacobian.add(e.mapped(kernel.jacobian, *local[e.name]), rows + row, columns)
            multipliers = p[-1] * casadi.reshape(lam_g[row : row + height], kernel.n_residuals, e.count)
            curvature = e.mapped(kernel.curvature, *local[e.name], multipliers)
            hessian.add(curvature, *e.curvature_places(kernel.curvature))
            row += height

        g = casadi.vertcat(*values)
        slopes = casadi.densify(gradient.matrix((n, 1)))
        return {
            "nlp": casadi.Function("nlp", {"x": x, "p": p, "f": f, "g": g}, ["x", "p"], ["f", "g"]),
            "grad_f": casadi.Function("nlp_grad_f", [x, p], [f, slopes], ["x", "p"], ["f", "grad:f:x"]),
            "jac_g": casadi.Function(
                "nlp_jac_g", [x, p], [g, jacobian.matrix((self.n_rows, n))], ["x", "p"], ["g", "jac:g:x"]
            ),
            "hess_lag": casadi.Function(
                "nlp_hess_l",
                [x, p, lam_f, lam_g],
                [hessian.matrix((n, n))],
                ["x", "p", "lam:f", "lam:g"],
                ["triu:hess:gamma:x:x"],
            ),
        }

    def rows(self, x: FloatArray, parameters: FloatArray) -> FloatArray:
        """Constraint rows (R,)."""
        return np.asarray(self.functions["nlp"](x, parameters)[1]).ravel()

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

    def violation(self, x: FloatArray, parameters: FloatArray) -> float:
        """Largest violation of all constraint rows, dimensionless."""
        return float(self.excess(x, parameters).max(initial=0.0))

    def violations(self, x: FloatArray, parameters: FloatArray) -> dict[str, tuple[float, str]]:
        """Largest violation of every constraint, dimensionless, and the element where it is."""
        excess = self.excess(x, parameters)
        found, start = {}, 0
        for constraint in self.constraints:
            count, k = constraint.lower.shape
            own = excess[start : start + count * k].reshape(count, k).max(axis=1)
            worst = int(np.argmax(own)) if count else 0
            found[constraint.name] = (float(own[worst]), constraint.labels[worst]) if count else (0.0, "")
            start += count * k
        return found

    def not_a_number(self, x: FloatArray, parameters: FloatArray) -> tuple[str, str] | None:
        """Name and element of a term whose value or derivatives are not finite, or None where all are."""
        start = len(self.objectives)
        labels = [None] * start + [c.labels for c in self.constraints]
        for k, e in enumerate(self._elements):
            own = parameters[start : start + e.parameters.size].reshape(e.count, -1).T
            start += e.parameters.size
            kernel, local = e.kernel, x[e.variables].T
            ones = np.ones((kernel.n_residuals, e.count))
            values = [np.asarray(f.map(e.count)(local, own)) for f in (kernel.value, kernel.jacobian)]
            values.append(np.asarray(kernel.curvature.map(e.count)(local, own, ones)))
            bad = [np.flatnonzero(~np.isfinite(v).all(axis=0)) for v in values]
            columns = [int(b[0]) // (v.shape[1] // e.count) for b, v in zip(bad, values, strict=True) if len(b)]
            if columns:
                names = labels[k]
                return e.name, _vertices(e.variables[columns[0]]) if names is None else names[columns[0]]
            if k < len(self.objectives):
                largest = max(float(np.abs(v).max(initial=0.0)) for v in values)
                with np.errstate(over="ignore"):
                    if not np.isfinite(parameters[k] * e.count * largest**2):
                        return e.name, "all elements, for its weight is too large"
        return None

    def excess(self, x: FloatArray, parameters: FloatArray) -> FloatArray:
        """By how much every row (R,) is beyond its bounds."""
        rows = self.rows(x, parameters)
        return np.asarray(np.maximum(np.maximum(self.lower - rows, rows - self.upper), 0.0))

    def _terms(self, x: FloatArray, parameters: FloatArray) -> list[float]:
        start = len(self.objectives)
        values = []
        for weight, objective in zip(parameters[:start], self.objectives, strict=True):
            e = objective.elements
            own = parameters[start : start + e.parameters.size].reshape(e.count, -1)
            squares = e.kernel.square.map(e.count)(x[e.variables].T, own.T)
            with np.errstate(over="ignore", invalid="ignore"):  # told as what has no number
                values.append(float(weight * np.sum(np.asarray(squares)) / (e.count * e.kernel.n_residuals)))
            start += e.parameters.size
        return values


def _vertices(variables: IntArray) -> str:
    """The vertices that an element is made of, for messages."""
    numbers = np.unique(variables // 3)
    some = ", ".join(str(v) for v in numbers[:4])
    return f"vertex {some}" if len(numbers) == 1 else f"vertices {some}{', ...' if len(numbers) > 4 else ''}"


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
