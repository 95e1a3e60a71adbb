"""Objectives: fit to a target, coverage of it, fairness of the mesh. A term is one function and its registration."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import casadi
import numpy as np

from inverse.errors import InputError
from inverse.nlp.kernels import Elements, Kernel
from inverse.nlp.term import Objective
from inverse.origami import geometry
from inverse.terms.goal import Goal

Build = Callable[[Goal], list[Elements]]


@dataclass(frozen=True)
class Term:
    """A registered objective: builds its elements; several blocks share the weight by their sizes."""

    build: Build
    default_weight: float


OBJECTIVES: dict[str, Term] = {}


def objective(name: str, default_weight: float = 0.0) -> Callable[[Build], Build]:
    """Register an objective under a name that specifications may use.

    Args:
        name: key under ``objectives`` in a specification.
        default_weight: weight where the specification gives none.
    """

    def add(build: Build) -> Build:
        OBJECTIVES[name] = Term(build, default_weight)
        return build

    return add


def register(name: str, function: Callable[[casadi.SX], casadi.SX], default_weight: float = 0.0) -> None:
    """Register an objective of one's own: the mean square of residuals of all vertices.

    Args:
        name: key under ``objectives`` in a specification.
        function: takes the vertices as CasADi expressions (V, 3), in the specification's unit, and returns
            residuals (k,) as CasADi expressions.
        default_weight: weight where the specification gives none.
    """

    @objective(name, default_weight)
    def build(goal: Goal) -> list[Elements]:
        model = goal.model
        n, centre = model.pattern.n_vertices, model.centre + goal.origin

        def residual(q: casadi.SX, _: casadi.SX) -> casadi.SX:
            points = casadi.reshape(q, 3, n).T * model.scale + casadi.repmat(casadi.DM(centre).T, n, 1)
            return casadi.vec(function(points))

        kernel = Kernel(name, residual, 3 * n)
        return [Elements(name, kernel, np.arange(3 * n)[None], np.empty((1, 0)))]


@objective("fit", default_weight=1.0)
def fit(goal: Goal) -> list[Elements]:
    """Distance of the fitted points from the target, in sixteenths of the model (``DesignModel.refinement``)."""
    return goal.fitting.elements()


@objective("coverage", default_weight=5e-4)
def coverage(goal: Goal) -> list[Elements]:
    """The mesh reaches over the whole target."""
    return goal.fitting.covering()


@objective("fairness", default_weight=5e-5)
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


@objective("evenness", default_weight=6e-5)
def evenness(goal: Goal) -> list[Elements]:
    """Edges keep the seed's lengths as far as they can: no narrow facets beside wide ones."""
    model = goal.model
    edges = model.pattern.edges_vertices
    lengths = geometry.edge_lengths(model.pattern, model.seed_points)
    kernel = Kernel("evenness", lambda q, p: (casadi.sumsqr(q[3:] - q[:3]) * p - 1) / 2, 6, 1)
    return [Elements("evenness", kernel, model.variables_of(edges), lengths[:, None] ** -2)]


@objective("footprint")
def footprint(goal: Goal) -> list[Elements]:
    """Extents or area of the box around a packed state, relative to those of the seed's."""
    return [elements for state in goal.packed for elements in state.measured()]


def build(goal: Goal, weights: dict[str, float]) -> list[Objective]:
    """The objective terms of given weights; terms that are not named have their default weight.

    Raises:
        InputError: a name that is not registered.
    """
    for name in weights:
        if name not in OBJECTIVES:
            raise InputError(f"{name!r} is no objective: registered are {', '.join(sorted(OBJECTIVES))}")
    terms = []
    for name, term in OBJECTIVES.items():
        weight = weights.get(name, goal.fitting.weights.get(name, term.default_weight))
        if weight > 0:
            blocks = term.build(goal)
            total = sum(e.count for e in blocks)
            terms += [Objective(e, weight * e.count / total) for e in blocks]
    return terms
