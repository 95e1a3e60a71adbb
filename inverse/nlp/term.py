"""Terms of a program: hard constraints and weighted objectives on elements."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from inverse._types import FloatArray
from inverse.nlp.kernels import Elements


@dataclass(frozen=True, eq=False)
class Constraint:
    """Hard bounds on the residuals of some elements. Constraints have no weight.

    Attributes:
        elements: kernel and elements.
        lower: (N, k) lower bounds, -inf where there is none.
        upper: (N, k) upper bounds; where equal to ``lower`` the row is an equation.
        labels: name of each element for messages, for example ``vertex 12``.
        implies_others: whether equations of other constraints follow from it, so that they have no multipliers of
            their own.
    """

    elements: Elements
    lower: FloatArray
    upper: FloatArray
    labels: tuple[str, ...]
    implies_others: bool = False

    @property
    def name(self) -> str:
        """Unique name of the term."""
        return self.elements.name

    @property
    def is_equation(self) -> bool:
        """Whether every row is an equation."""
        return bool((self.lower == self.upper).all())

    def only(self, kept: NDArray[np.bool_], name: str | None = None) -> Constraint:
        """The constraint on some elements only.

        Args:
            kept: (N,) which.
            name: another name.
        """
        elements = replace(
            self.elements,
            name=name or self.name,
            variables=self.elements.variables[kept],
            parameters=self.elements.parameters[kept],
        )
        labels = tuple(label for label, keep in zip(self.labels, kept.tolist(), strict=True) if keep)
        return replace(self, elements=elements, lower=self.lower[kept], upper=self.upper[kept], labels=labels)


@dataclass(frozen=True, eq=False)
class Objective:
    """A weighted mean square of the residuals of some elements.

    Attributes:
        elements: kernel and elements.
        weight: factor of the mean square.
    """

    elements: Elements
    weight: float

    @property
    def name(self) -> str:
        """Unique name of the term."""
        return self.elements.name
