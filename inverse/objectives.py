"""Objectives: fit to a target, coverage of it, fairness of the mesh. A term is one function and its registration."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import casadi
import numpy as np

from inverse.errors import InputError
from inverse.extending.registry import Registry
from inverse.nlp.kernels import Elements, Kernel
from inverse.nlp.term import Objective
from inverse.origami import geometry
from inverse.terms.carried import Carried
from inverse.terms.goal import Goal
from inverse.terms.own import Function, Own, Per, finite

Build = Callable[[Goal], list[Elements]]


@dataclass(frozen=True)
class Term:
    """An objective of the framework: builds its elements; several blocks share the weight by their sizes."""

    build: Build
    weight: float


@dataclass(frozen=True, eq=False)
class OwnObjective(Own):
    """An objective of a user: the mean square of the residuals over all elements.

    Attributes:
        weight: where the specification gives none.
    """

    weight: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if finite(self.weight, f"the weight of {self}") < 0:
            raise InputError(f"the weight of {self} is {self.weight:g}: it must be at least 0")

    def build(self, goal: Goal) -> list[Elements]:
        """Its residuals, or the variables that carry them; lengths in sixteenths of the model."""
        for carried in goal.carried:
            if carried.own is self:
                return [carried.elements()]
        model = goal.model
        return self.elements(model, goal.origin, model.scale * model.refinement)


OBJECTIVES: Registry[Term | OwnObjective] = Registry("an objective")


def objective(
    name: str, *, per: Per = "vertex", unit: str = "1", weight: float = 0.0
) -> Callable[[Function], OwnObjective]:
    """Register a function as an objective that specifications may name: the mean square of its residuals.

    Args:
        name: key under ``objectives`` in a specification.
        per: what it is called for: every ``vertex``, ``edge`` or ``facet``, or once for the whole ``mesh``.
        unit: of what it returns: ``1``, ``length``, ``length^2``, ``length^3``, ``1/length`` or ``angle`` (radians).
            Lengths are measured in sixteenths of the model, so that a weight means the same in mm and km and at every
            number of facets.
        weight: where the specification gives none; above 0 the objective counts in every solve.

    Returns:
        A decorator of functions ``f(points, seed)`` of the element's points and those of the placed seed, CasADi
        expressions (k, 3) in the specification's unit, that return an expression or a CasADi vector of residuals.

    Raises:
        InputError: the name is taken or no word; another fault of the arguments.
    """

    def add(function: Function) -> OwnObjective:
        own = OwnObjective("objective", name, function, per, unit, weight)
        OBJECTIVES.add(name, own)
        return own

    return add


def _term(name: str, weight: float = 0.0) -> Callable[[Build], Build]:
    """Register an objective of the framework."""

    def add(build: Build) -> Build:
        OBJECTIVES.add(name, Term(build, weight))
        return build

    return add


@_term("fit", weight=1.0)
def fit(goal: Goal) -> list[Elements]:
    """Distance of the fitted points from the target, in sixteenths of the model (``DesignModel.refinement``)."""
    return goal.fitting.elements()


@_term("coverage", weight=5e-4)
def coverage(goal: Goal) -> list[Elements]:
    """The mesh reaches over the whole target."""
    return goal.fitting.covering()


@_term("fairness", weight=5e-5)
def fairness(goal: Goal) -> list[Elements]:
    """Second differences, at every second vertex along a line, of the displacement from the seed (a tube's bent).

    Every second vertex, because a corrugation moves its two layers apart: each layer by itself is to be even. They
    are divided by the squared distance of the vertices, so that a smooth displacement counts the same at every
    number of facets.
    """
    model = goal.model
    triples = [triple for line in model.pattern.lines for triple in _every_second(line)]
    vertices = np.array(triples, np.int64).reshape(-1, 3)
    a, b, c = goal.fitting.fair_points()[vertices].transpose(1, 0, 2)
    # The difference is a length, the distance squared: one factor of the refinement is left.
    kernel = Kernel("fairness", lambda q, p: model.refinement * (q[:3] - 2 * q[3:6] + q[6:] - p), 9, 3)
    return [Elements("fairness", kernel, model.variables_of(vertices), a - 2 * b + c)] if triples else []


def _every_second(line: tuple[int, ...]) -> list[tuple[int, int, int]]:
    """Vertices two apart along a line; around a closed one, which repeats its first vertex, without an end."""
    if line[0] != line[-1]:
        return [(line[k - 2], line[k], line[k + 2]) for k in range(2, len(line) - 2)]
    ring = line[:-1]
    n = len(ring)
    step = 2 if n > 4 else 1  # two before and two after are the same of four vertices around
    return [(ring[k - step], ring[k], ring[(k + step) % n]) for k in range(n)]


@_term("evenness", weight=6e-5)
def evenness(goal: Goal) -> list[Elements]:
    """Edges keep the seed's lengths as far as they can: no narrow facets beside wide ones."""
    model = goal.model
    edges = model.pattern.edges_vertices
    lengths = geometry.edge_lengths(model.pattern, model.seed_points)
    kernel = Kernel("evenness", lambda q, p: (casadi.sumsqr(q[3:] - q[:3]) * p - 1) / 2, 6, 1)
    return [Elements("evenness", kernel, model.variables_of(edges), lengths[:, None] ** -2)]


@_term("footprint")
def footprint(goal: Goal) -> list[Elements]:
    """Extents or area of the box around a packed state, relative to those of the seed's."""
    return [elements for state in goal.packed for elements in state.measured()]


def weighted(goal: Goal, given: Mapping[str, float]) -> dict[str, float]:
    """Weights of all terms that count, by name: those given, and defaults of the others.

    Raises:
        InputError: a name that is not registered.
    """
    for name in given:
        OBJECTIVES.find(name)
    found = {n: given.get(n, goal.fitting.weights.get(n, term.weight)) for n, term in OBJECTIVES.items()}
    return {name: weight for name, weight in found.items() if weight > 0}


def carrying(goal: Goal, name: str) -> Goal:
    """The goal with variables for the values of an objective, if these depend on all vertices at once.

    Raises:
        InputError: a function that cannot be used.
    """
    term = OBJECTIVES[name]
    if not (isinstance(term, OwnObjective) and term.is_coupled(goal.model, goal.origin)):
        return goal
    return replace(goal, carried=(*goal.carried, Carried(goal.model, term, goal.origin, goal.n_variables)))


def build(goal: Goal, weights: Mapping[str, float]) -> list[Objective]:
    """The objective terms of registered names, each with its weight.

    Raises:
        InputError: a function that cannot be used.
    """
    terms = []
    for name, weight in weights.items():
        if weight > 0:
            blocks = OBJECTIVES[name].build(goal)
            total = sum(e.count for e in blocks)
            terms += [Objective(e, weight * e.count / total) for e in blocks]
    return terms
