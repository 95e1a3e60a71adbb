"""A place in the space of a problem's variables, and what the problem is there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sparse

from inverse._types import FloatArray, IntArray
from inverse.nlp.kernels import Elements
from inverse.nlp.problem import Problem

PLAIN = 1e50  # what is smaller has finite squares, also summed and weighted


@dataclass(frozen=True, eq=False)
class Point:
    """Variables with the problem, parameters and multipliers that belong to them; everything is evaluated once.

    Attributes:
        problem: the problem.
        variables: (n,).
        parameters: parameter vector of the problem.
        multipliers: (R,) of the problem's rows, positive where they push down from an upper bound; None where there
            are none yet.
    """

    problem: Problem
    variables: FloatArray
    parameters: FloatArray
    multipliers: FloatArray | None = None

    def moved(self, variables: FloatArray) -> Point:
        """The same with other variables (n,)."""
        return replace(self, variables=variables)

    def given(self, parameters: FloatArray) -> Point:
        """The same with other parameters."""
        return replace(self, parameters=parameters)

    def pushed(self, multipliers: FloatArray | None) -> Point:
        """The same with other multipliers (R,), or without."""
        return replace(self, multipliers=multipliers)

    @property
    def balance(self) -> FloatArray:
        """Multipliers (R,), zero where there are none."""
        return np.zeros(self.problem.n_rows) if self.multipliers is None else self.multipliers

    @cached_property
    def rows(self) -> FloatArray:
        """Constraint rows (R,)."""
        if "_linearized" in vars(self):
            return self._linearized[0]
        return self.problem.evaluations.rows(self.variables, self.parameters)

    @property
    def jacobian(self) -> sparse.csr_matrix:
        """Jacobian (R, n) of the rows."""
        return self._linearized[1]

    @cached_property
    def _linearized(self) -> tuple[FloatArray, sparse.csr_matrix]:
        return self.problem.evaluations.linearized(self.variables, self.parameters)

    @cached_property
    def _slope(self) -> tuple[float, FloatArray]:
        return self.problem.evaluations.slope(self.variables, self.parameters)

    @property
    def objective(self) -> float:
        """Weighted objective."""
        return self._slope[0]

    @property
    def gradient(self) -> FloatArray:
        """Gradient (n,) of the objective."""
        return self._slope[1]

    @cached_property
    def lagrangian_gradient(self) -> FloatArray:
        """Gradient (n,) of the Lagrangian: zero where the point is stationary."""
        return np.asarray(self.gradient + self.jacobian.T @ self.balance)

    @cached_property
    def excess(self) -> FloatArray:
        """By how much every row (R,) is beyond its bounds."""
        rows, problem = self.rows, self.problem
        return np.asarray(np.maximum(np.maximum(problem.lower - rows, rows - problem.upper), 0.0))

    @property
    def violation(self) -> float:
        """Largest violation of all rows, dimensionless."""
        return float(self.excess.max(initial=0.0))

    @property
    def violations(self) -> dict[str, tuple[float, str]]:
        """Largest violation of every constraint, dimensionless, and the element where it is."""
        found, start = {}, 0
        for constraint in self.problem.constraints:
            count, k = constraint.lower.shape
            own = self.excess[start : start + count * k].reshape(count, k).max(axis=1)
            worst = int(np.argmax(own)) if count else 0
            found[constraint.name] = (float(own[worst]), constraint.labels[worst]) if count else (0.0, "")
            start += count * k
        return found

    @property
    def objective_terms(self) -> dict[str, float]:
        """Weighted value of every objective term."""
        layout, found = self.problem.layout, {}
        for weight, objective in zip(layout.weights(self.parameters), self.problem.objectives, strict=True):
            e = objective.elements
            squares = e.kernel.square.map(e.count)(self.variables[e.variables].T, layout.of(e, self.parameters).T)
            with np.errstate(over="ignore", invalid="ignore"):  # told as what has no number
                found[objective.name] = float(weight * np.sum(np.asarray(squares)) / (e.count * e.kernel.n_residuals))
        return found

    @cached_property
    def not_a_number(self) -> tuple[str, str] | None:
        """Name and element of a term whose value or derivatives are not finite, or None where all are."""
        return None if self._is_finite else self._first_not_finite()

    @property
    def _is_finite(self) -> bool:
        """Whether all values and derivatives are finite, and so far from the largest number that no term can be it."""
        curvature = self.problem.evaluations.curvature(
            self.variables, self.parameters, 1.0, np.ones(self.problem.n_rows)
        )
        given = [self.problem.layout.weights(self.parameters), self.rows, self.jacobian.data, curvature, self.gradient]
        for objective in self.problem.objectives:  # CasADi knows a root's square without the root
            e = objective.elements
            local, own = self.variables[e.variables].T, self.problem.layout.of(e, self.parameters).T
            given += [np.asarray(f.map(e.count)(local, own)) for f in (e.kernel.value, e.kernel.jacobian)]
        largest = [float(np.abs(values).max(initial=0.0)) for values in given]
        return all(size < PLAIN for size in largest)  # not where one is no number either

    def _first_not_finite(self) -> tuple[str, str] | None:
        """The same element by element."""
        problem, layout = self.problem, self.problem.layout
        weights = dict(zip((o.name for o in problem.objectives), layout.weights(self.parameters), strict=True))
        terms: list[tuple[Elements, tuple[str, ...] | None]] = [(o.elements, None) for o in problem.objectives]
        terms += [(c.elements, c.labels) for c in problem.constraints]
        for e, names in terms:
            kernel, local, own = e.kernel, self.variables[e.variables].T, layout.of(e, self.parameters).T
            ones = np.ones((kernel.n_residuals, e.count))
            values = [np.asarray(f.map(e.count)(local, own)) for f in (kernel.value, kernel.jacobian)]
            values.append(np.asarray(kernel.curvature.map(e.count)(local, own, ones)))
            bad = [np.flatnonzero(~np.isfinite(v).all(axis=0)) for v in values]
            columns = [int(b[0]) // (v.shape[1] // e.count) for b, v in zip(bad, values, strict=True) if len(b)]
            if columns:
                return e.name, _vertices(e.variables[columns[0]]) if names is None else names[columns[0]]
            if names is None:
                largest = max(float(np.abs(v).max(initial=0.0)) for v in values)
                with np.errstate(over="ignore"):
                    if not np.isfinite(weights[e.name] * e.count * largest**2):
                        return e.name, "all elements, for its weight is too large"
        return None


def _vertices(variables: IntArray) -> str:
    """The vertices that an element is made of, for messages."""
    numbers = np.unique(variables // 3)
    some = ", ".join(str(v) for v in numbers[:4])
    return f"vertex {some}" if len(numbers) == 1 else f"vertices {some}{', ...' if len(numbers) > 4 else ''}"
