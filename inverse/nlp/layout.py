"""Where the parameters of a problem lie in the one vector that CasADi's functions take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import casadi
import numpy as np

from inverse._types import FloatArray
from inverse.nlp.kernels import Elements


class Layout:
    """The parameter vector: weights of the objectives, element parameters of every term, the share of curvature.

    The last entry multiplies the constraints in the Lagrangian's Hessian: 1 for Newton's method, 0 to take them as
    linear (see :meth:`linearized`).

    Args:
        objectives: elements of the objectives, each with a weight.
        constraints: elements of the constraints.

    Attributes:
        size: number of parameters.
        n_weights: number of weights; they come first.
        n_objective: number of parameters that belong to the objectives, weights included; they come first.
    """

    def __init__(self, objectives: Sequence[Elements], constraints: Sequence[Elements]) -> None:
        self._terms = [*objectives, *constraints]
        self.n_weights = len(objectives)
        ends = self.n_weights + np.cumsum([0, *(e.parameters.size for e in self._terms)])
        self._slices = {e.name: slice(int(a), int(b)) for e, a, b in zip(self._terms, ends, ends[1:], strict=False)}
        self.n_objective = int(ends[len(objectives)])
        self.size = int(ends[-1]) + 1

    def vector(self, weights: Sequence[float], replaced: Mapping[str, FloatArray]) -> FloatArray:
        """The parameters, (size,), with Newton's curvature.

        Args:
            weights: of the objectives.
            replaced: new element parameters (N, m) by term name.
        """
        blocks = [replaced.get(e.name, e.parameters).ravel() for e in self._terms]
        return np.concatenate([weights, *blocks, [1.0]])

    def weights(self, vector: FloatArray) -> FloatArray:
        """The weights of the objectives in a parameter vector."""
        return vector[: self.n_weights]

    def of(self, elements: Elements, vector: FloatArray) -> FloatArray:
        """The parameters (N, m) of a term's elements in a parameter vector."""
        return vector[self._slices[elements.name]].reshape(elements.count, -1)

    def columns(self, vector: casadi.MX, elements: Elements) -> casadi.MX:
        """The same of a symbolic vector, each element's parameters as a column of an (m, N) matrix."""
        return casadi.reshape(vector[self._slices[elements.name]], elements.kernel.n_parameters, elements.count)

    @staticmethod
    def linearized(vector: FloatArray, share: float = 0.0) -> FloatArray:
        """The same parameters with a Hessian that leaves the curvature of the constraints out, but for a share."""
        return np.append(vector[:-1], share)
