"""What a caller gives besides a specification: terms of its own, a target, a seed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from inverse.errors import InputError
from inverse.objectives import OwnObjective
from inverse.origami.pattern import Design
from inverse.surfaces import Target
from inverse.terms.own import finite
from inverse.terms.own_constraints import OwnConstraint, Range, check_bounds

GivenObjective = OwnObjective | tuple[OwnObjective, float]
GivenConstraint = OwnConstraint | tuple[OwnConstraint, float | None, float | None]


@dataclass(frozen=True, eq=False)
class Given:
    """Things in place of, or besides, what a specification names.

    Attributes:
        weights: of objectives, by name.
        bounds: of constraints, in the specification's unit and radians, by name.
        target: the target surface.
        design: the pattern's seed, to be placed.
    """

    weights: Mapping[str, float] = field(default_factory=dict)
    bounds: Mapping[str, Range] = field(default_factory=dict)
    target: Target | None = None
    design: Design | None = None

    @classmethod
    def of(
        cls,
        objectives: Sequence[GivenObjective] = (),
        constraints: Sequence[GivenConstraint] = (),
        target: Target | None = None,
        design: Design | None = None,
    ) -> Given:
        """The same from what callers write.

        Raises:
            InputError: something is not what it should be.
        """
        for what, one, kind in (("target", target, Target), ("design", design, Design)):
            if one is not None and not isinstance(one, kind):
                raise InputError(f"the {what} is a {type(one).__name__}: a {kind.__name__} is wanted")
        weights = dict(_weight(one) for one in objectives)
        bounds = dict(_bounds(one) for one in constraints)
        return cls(weights, bounds, target, design)


NOTHING = Given()


def _weight(given: object) -> tuple[str, float]:
    term, *more = given if isinstance(given, tuple) else (given,)
    if not isinstance(term, OwnObjective) or len(more) > 1:
        raise InputError(
            f"{_shown(term)} is no objective: a term that @inverse.objective made is wanted, or (term, weight)"
        )
    weight = finite(more[0], f"the weight of {term}") if more else term.weight
    if weight < 0 or not (weight or more):
        raise InputError(f"{term} has the weight {weight:g}", hint="Give (term, weight) with a weight above 0.")
    return term.name, weight


def _bounds(given: object) -> tuple[str, Range]:
    term, *more = given if isinstance(given, tuple) else (given,)
    if not isinstance(term, OwnConstraint) or len(more) not in (0, 2):
        raise InputError(
            f"{_shown(term)} is no constraint: a term that @inverse.constraint made is wanted, or (term, lower, upper)"
        )
    return term.name, bounds_of(term, *more)


def bounds_of(term: OwnConstraint, *given: float | None) -> Range:
    """Bounds given for a constraint, None for none on a side; nothing for its own.

    Raises:
        InputError: they bound nothing, or are no bounds.
    """
    low, high = given or (term.lower, term.upper)
    bounds = check_bounds(term, -np.inf if low is None else low, np.inf if high is None else high)
    if bounds == (-np.inf, np.inf):
        raise InputError(f"{term} has no bounds", hint="Give it a lower or an upper one.")
    return bounds


def _shown(given: object) -> str:
    """What a caller gave, without the addresses that functions are printed with."""
    return str(getattr(given, "__name__", given))
