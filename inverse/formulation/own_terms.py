"""Objectives by their weights and constraints of one's own, as a specification and its caller ask for them."""

from __future__ import annotations

from functools import partial

import numpy as np

from inverse import objectives
from inverse.formulation.given import Given, bounds_of
from inverse.formulation.within import within
from inverse.nlp.term import Constraint, Objective
from inverse.objectives import OBJECTIVES, OwnObjective
from inverse.spec import Loaded
from inverse.terms.goal import Goal
from inverse.terms.own_constraints import CONSTRAINTS, Range


def minimized(loaded: Loaded, goal: Goal, given: Given) -> tuple[Goal, list[Objective]]:
    """All objectives, and the goal with the variables that carry values of the whole mesh.

    Raises:
        InputError: with the place in the specification.
    """
    asked = loaded.specification.objectives
    for name in asked:
        within(loaded, ("objectives", name), partial(OBJECTIVES.find, name), at_key=True)
    weights = objectives.weighted(goal, {**asked, **given.weights})
    # A term that only the caller names, or nobody, has no place in the file.
    places = {n: ("objectives", n) if isinstance(OBJECTIVES[n], OwnObjective) else ("fit",) for n in weights}
    places = {n: place for n, place in places.items() if n in asked or place == ("fit",)}
    for name in weights:
        goal = within(loaded, places.get(name), partial(objectives.carrying, goal, name), at_key=True)
    terms: list[Objective] = []
    for name, weight in weights.items():
        terms += within(loaded, places.get(name), partial(objectives.build, goal, {name: weight}), at_key=True)
    return goal, terms


def constrained(loaded: Loaded, goal: Goal, given: Given) -> list[Constraint]:
    """All constraints of one's own, and the equations of the goal's carried values.

    Raises:
        InputError: with the place in the specification.
    """
    bounds, asked = dict[str, Range](), loaded.specification.constraints.own
    for name, keys in asked.items():
        place = ("constraints", "own", name)
        term = within(loaded, place, partial(CONSTRAINTS.find, name), at_key=True)
        factor = np.pi / 180 if term.unit == "angle" else 1.0  # specifications have degrees, terms radians
        own = [None if bound is None else float(factor * bound) for bound in keys or ()]
        bounds[name] = within(loaded, place, partial(bounds_of, term, *own), at_key=keys is None)
    found = [carried.equation() for carried in goal.carried]
    for name, limits in {**bounds, **given.bounds}.items():
        build = partial(CONSTRAINTS[name].build, goal.model, goal.origin, limits)
        found += within(loaded, ("constraints", "own", name) if name in asked else None, build, at_key=True)
    return found
