"""Constraints of users: bounds on the residuals of every element."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from inverse._types import FloatArray
from inverse.errors import InputError
from inverse.extending.registry import Registry
from inverse.model import DesignModel
from inverse.nlp.term import Constraint
from inverse.terms.own import Function, Own, Per

Range = tuple[float, float]


@dataclass(frozen=True, eq=False)
class OwnConstraint(Own):
    """A constraint of a user: bounds on the residuals of every element.

    Attributes:
        lower: in the specification's unit, radians; -inf where there is none.
        upper: the same; inf where there is none.
    """

    lower: float = -np.inf
    upper: float = np.inf

    def __post_init__(self) -> None:
        super().__post_init__()
        check_bounds(self, self.lower, self.upper)

    def build(self, model: DesignModel, origin: FloatArray, bounds: Range) -> list[Constraint]:
        """Its rows, lengths in mean edges, with bounds in the specification's unit."""
        lower, upper = (bound / self.size(model.scale) for bound in bounds)
        labels = {
            "vertex": [f"vertex {v}" for v in range(model.pattern.n_vertices)],
            "edge": [f"edge {a}-{b}" for a, b in model.pattern.edges_vertices.tolist()],
            "facet": [f"facet {f}" for facets in model.pattern.faces_by_sides.values() for f in facets],
            "mesh": ["all vertices"],
        }[self.per]
        found: list[Constraint] = []
        for elements in self.elements(model, origin, model.scale):
            named, labels = labels[: elements.count], labels[elements.count :]
            shape = (elements.count, elements.kernel.n_residuals)
            found.append(Constraint(elements, np.full(shape, lower), np.full(shape, upper), tuple(named)))
        return found


CONSTRAINTS: Registry[OwnConstraint] = Registry("a constraint")


def constraint(
    name: str, *, per: Per = "vertex", unit: str = "1", lower: float = -np.inf, upper: float = np.inf
) -> Callable[[Function], OwnConstraint]:
    """Register a function as a constraint that specifications may name under ``constraints: own``.

    Args:
        name: key under ``own``.
        per: what it is called for: every ``vertex``, ``edge`` or ``facet``, or once for the whole ``mesh``.
        unit: of what it returns: ``1``, ``length``, ``length^2``, ``length^3``, ``1/length`` or ``angle`` (radians).
        lower: least value of every residual, in the specification's unit of length and radians.
        upper: largest value; the same as ``lower`` for an equation.

    Returns:
        A decorator of functions as :func:`inverse.objective` takes them.

    Raises:
        InputError: the name is taken or no word; another fault of the arguments.
    """

    def add(function: Function) -> OwnConstraint:
        own = OwnConstraint("constraint", name, function, per, unit, lower, upper)
        CONSTRAINTS.add(name, own)
        return own

    return add


def check_bounds(term: OwnConstraint, lower: object, upper: object) -> Range:
    """Bounds as numbers.

    Raises:
        InputError: they are none, or the lower one is above the upper one.
    """
    for bound in (lower, upper):
        if isinstance(bound, bool) or not isinstance(bound, int | float | np.number) or np.isnan(bound):
            raise InputError(f"{term} has the bound {bound!r}: it must be a number, -inf or inf for none")
    low, high = float(lower), float(upper)  # type: ignore[arg-type]
    if low > high or low == np.inf or high == -np.inf:
        raise InputError(f"{term} has the bounds {low:g} and {high:g}: the lower one must not be above the upper one")
    return low, high
