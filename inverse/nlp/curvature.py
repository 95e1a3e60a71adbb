"""The Lagrangian's Hessian element by element, without those that no multiplier pushes.

In the function that solvers are given every bound has its share, also where its multiplier is zero. Where few bounds
push, as at a solution, most of that work is for nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

import casadi
import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.nlp.evaluation import Call
from inverse.nlp.kernels import Elements
from inverse.nlp.layout import Layout

BATCH = 16  # elements of a constraint that are evaluated together


class Curvature:
    """Nonzeros of the upper triangle of a Lagrangian's Hessian.

    Args:
        layout: of the parameters.
        objectives: elements of the objectives.
        constraints: elements of the constraints.
        pattern: rows and columns (K,) of the nonzeros.
    """

    def __init__(
        self,
        layout: Layout,
        objectives: Sequence[Elements],
        constraints: Sequence[Elements],
        pattern: tuple[IntArray, IntArray],
    ) -> None:
        self._layout, self._size = layout, len(pattern[0])
        self._objectives = [_Term(e, e.kernel.square_curvature, e.count, pattern) for e in objectives]
        self._constraints = [_Term(e, e.kernel.curvature, BATCH, pattern) for e in constraints]

    def __call__(
        self, variables: FloatArray, parameters: FloatArray, weight: float, multipliers: FloatArray
    ) -> FloatArray:
        """The nonzeros (K,).

        Args:
            variables: (n,).
            parameters: parameter vector.
            weight: of the objective.
            multipliers: (R,) of the rows.
        """
        found, row = np.zeros(self._size), 0
        for factor, term in zip(self._layout.weights(parameters), self._objectives, strict=True):
            e = term.elements
            share = weight * factor / (e.count * e.kernel.n_residuals)
            term.add(found, share, np.arange(e.count), variables, self._layout.of(e, parameters))
        for term in self._constraints:
            e = term.elements
            height = e.count * e.kernel.n_residuals
            own = multipliers[row : row + height].reshape(e.count, -1)
            pushed = np.flatnonzero(own.any(axis=1))
            term.add(found, parameters[-1], pushed, variables, self._layout.of(e, parameters), own)
            row += height
        return found


class _Term:
    """One term's elements."""

    def __init__(
        self, elements: Elements, function: casadi.Function, batch: int, pattern: tuple[IntArray, IntArray]
    ) -> None:
        self.elements, self._batch = elements, min(batch, elements.count)
        self._curvature = Call(function.map(self._batch))
        # The pattern is sorted by columns, then by rows.
        n = int(max(side.max(initial=0) for side in pattern)) + 1
        own, whole = (columns * n + rows for rows, columns in (elements.curvature_places(function), pattern))
        self._places = np.searchsorted(whole, own).reshape(elements.count, -1)

    def add(self, found: FloatArray, share: float, some: IntArray, *arguments: FloatArray) -> None:
        """Add the curvature of some elements (k,), times a share."""
        if not len(some) or not self._places.size:
            return
        variables, *others = arguments
        for first in range(0, len(some), self._batch):
            own = some[first : first + self._batch]
            padded = np.resize(own, self._batch)
            values = self._curvature(variables[self.elements.variables[padded]], *(one[padded] for one in others))[0]
            values = values.reshape(self._batch, -1)[: len(own)]
            found += np.bincount(self._places[own].ravel(), share * values.ravel(), len(found))
