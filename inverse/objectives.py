"""Objectives: fit to a target, coverage of it, fairness of the mesh. A term is one function and its registration."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import casadi
import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.model import DesignModel
from inverse.nlp.kernels import Elements, Kernel
from inverse.nlp.term import Objective
from inverse.origami import geometry
from inverse.origami.pattern import B
from inverse.surfaces import Target
from inverse.surfaces.tube import TubeTarget
from inverse.terms import tube_fit
from inverse.terms.packed import Packed
from inverse.terms.rim import rim_places

# Of the coverage: sixteenths of the model that a rim facet may move freely, factors of the pull within and beyond.
SLACK, WEAK, STRONG = 0.5, 0.3, 3.0

FitPoints = Literal["facets", "layer", "vertices"]


@dataclass(frozen=True)
class Goal:
    """What objectives may look at.

    Attributes:
        model: the model.
        target: the target surface.
        fit_points: which points of the mesh are fitted.
        packed: states whose extents are measured or limited, with variables of their own.
        origin: (3,) point of the specification's coordinates that those of model and target are relative to.
    """

    model: DesignModel
    target: Target
    fit_points: FitPoints
    packed: tuple[Packed, ...] = ()
    origin: FloatArray = field(default_factory=lambda: np.zeros(3))

    @property
    def n_variables(self) -> int:
        """Length of the vector of variables: the model's, then those of the packed states."""
        return self.model.n_variables + sum(state.n_variables for state in self.packed)

    @cached_property
    def seed_variables(self) -> FloatArray:
        """Variables (n_variables,) of the placed seed."""
        return self.start(self.model.seed.vertices_coords)

    def start(self, points: FloatArray) -> FloatArray:
        """Variables (n_variables,) of a design with vertices (V, 3) in the seed's unit; packed states are folded."""
        own = self.model.to_dimensionless(points)
        return np.concatenate([own.ravel(), *(state.start(own) for state in self.packed)])

    @property
    def tube(self) -> TubeTarget | None:
        """The target where rings of facets around its axis are fitted, else None."""
        return self.target if isinstance(self.target, TubeTarget) and tube_fit.is_tube(self.model.pattern) else None

    @property
    def is_exact(self) -> bool:
        """Whether the target enters by its own expression; else closest points must be refreshed."""
        return self.target.residual(casadi.SX.zeros(3)) is not None


Build = Callable[[Goal], list[Elements]]


@dataclass(frozen=True)
class Term:
    """A registered objective: builds its elements; several blocks share the weight by their sizes."""

    build: Build
    default_weight: float
    tube_weight: float


OBJECTIVES: dict[str, Term] = {}


def objective(name: str, default_weight: float = 0.0, tube_weight: float | None = None) -> Callable[[Build], Build]:
    """Register an objective under a name that specifications may use.

    Args:
        name: key under ``objectives`` in a specification.
        default_weight: weight where the specification gives none.
        tube_weight: the same for tubes, where it is another one.
    """

    def add(build: Build) -> Build:
        OBJECTIVES[name] = Term(build, default_weight, default_weight if tube_weight is None else tube_weight)
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


def fit_vertices(model: DesignModel, fit_points: FitPoints) -> list[IntArray]:
    """Vertices whose mean is a fitted point, as arrays (N, k) grouped by k.

    Args:
        model: the model.
        fit_points: ``facets`` (their centroids: the mid-surface), ``layer`` (every second vertex both ways) or
            ``vertices``.

    Raises:
        InputError: a layer of a mesh that is no grid.
    """
    pattern = model.pattern
    if fit_points == "vertices":
        return [np.arange(pattern.n_vertices)[:, None]]
    if fit_points == "layer":
        if pattern.grid is None:
            raise InputError("fit points 'layer' need a grid", hint="Use 'facets' or 'vertices'.")
        _, n = pattern.grid
        i, j = np.divmod(np.arange(pattern.n_vertices), n + 1)
        return [np.flatnonzero((i % 2 == 0) & (j % 2 == 0))[:, None]]
    by_sides: dict[int, list[tuple[int, ...]]] = {}
    for face in pattern.faces_vertices:
        by_sides.setdefault(len(face), []).append(face)
    return [np.array(group, np.int64) for group in by_sides.values()]


def mean_points(points: FloatArray, groups: list[IntArray]) -> FloatArray:
    """Means (N, 3) of groups of vertices, ``points`` (V, 3)."""
    return np.concatenate([points[group].mean(axis=1) for group in groups])


@objective("fit", default_weight=1.0)
def fit(goal: Goal) -> list[Elements]:
    """Distance of the fitted points from the target: exact for smooth targets, else from tangent planes.

    Distances are in sixteenths of the model, like all lengths here (``DesignModel.refinement``).
    """
    model = goal.model
    if goal.tube is not None:
        return tube_fit.fit(model, goal.tube)
    blocks: list[Elements] = []
    for group in fit_vertices(model, goal.fit_points):
        k = group.shape[1]
        name = "fit" if not blocks else f"fit_{k}"

        def exact(q: casadi.SX, _: casadi.SX, k: int = k) -> casadi.SX:
            distance = goal.target.residual(_mean(q, k) * model.scale + model.centre)
            assert distance is not None  # this kernel is for exact targets only
            return casadi.SX(distance / (model.scale * model.refinement))

        def to_foot(q: casadi.SX, p: casadi.SX, k: int = k) -> casadi.SX:
            return casadi.reshape(p[3:], 3, 3) @ (_mean(q, k) - p[:3])

        variables = model.variables_of(group)
        if goal.is_exact:
            blocks.append(Elements(name, Kernel(name, exact, 3 * k, 0), variables, np.empty((len(group), 0))))
        else:
            # The seed lies flat over the plan, and what is closest to it is the target's crests: the places
            # over the same points of the plan are a better start.
            over_plan = goal.target.over_plan(model.seed.vertices_coords[group].mean(axis=1))
            feet = foot_parameters(goal, over_plan)
            blocks.append(Elements(name, Kernel(name, to_foot, 3 * k, 12), variables, feet))
    return blocks


def foot_parameters(goal: Goal, points: FloatArray) -> FloatArray:
    """Closest points of the target to points (N, 3) and their weights, as (N, 12), dimensionless."""
    closest = goal.target.closest(points)
    weights = closest.weights.transpose(0, 2, 1).reshape(-1, 9)  # column-major, as CasADi reshapes
    return np.column_stack([goal.model.to_dimensionless(closest.feet), weights / goal.model.refinement])


def refreshed(goal: Goal, points: FloatArray) -> dict[str, FloatArray]:
    """New closest points for vertices ``points`` (V, 3), by name of the fit's elements; empty for exact targets."""
    if goal.is_exact:
        return {}
    if goal.tube is not None:
        return {"fit": tube_fit.foot_parameters(goal.model, goal.tube, points)}
    groups = fit_vertices(goal.model, goal.fit_points)
    names = ["fit", *(f"fit_{group.shape[1]}" for group in groups[1:])]
    return {
        name: foot_parameters(goal, mean_points(points, [group])) for name, group in zip(names, groups, strict=True)
    }


@objective("coverage", default_weight=5e-4)
def coverage(goal: Goal) -> list[Elements]:
    """Facets of the rim stay near the places that they have where the seed is spread over the target.

    Fit alone is content with a mesh that has shrunk into a corner of the target. Within ``SLACK`` the pull is
    weak, so that it costs no fit; beyond, where the target's rim would come to lie bare, it is strong.
    """
    model = goal.model
    pattern = model.pattern
    if goal.tube is not None:
        return tube_fit.coverage(model, goal.tube)
    rim = np.unique(pattern.edges_faces[pattern.edges_type == B, 0])
    blocks: list[Elements] = []
    for sides in sorted({len(pattern.faces_vertices[f]) for f in rim}):
        facets = np.array([f for f in rim if len(pattern.faces_vertices[f]) == sides], np.int64)
        group = np.array([pattern.faces_vertices[f] for f in facets], np.int64)
        places = model.to_dimensionless(rim_places(model.seed, goal.target, facets))

        def residual(q: casadi.SX, p: casadi.SX, k: int = sides) -> casadi.SX:
            offset = (_mean(q, k) - p) / model.refinement
            beyond = casadi.fmax(0, casadi.sumsqr(offset) - SLACK**2) / (2 * SLACK)
            return casadi.vertcat(WEAK * offset, STRONG * beyond)

        name = "coverage" if not blocks else f"coverage_{sides}"
        blocks.append(Elements(name, Kernel(name, residual, 3 * sides, 3), model.variables_of(group), places))
    return blocks


@objective("fairness", default_weight=5e-5, tube_weight=5e-4)  # a tube's section is flattened easily
def fairness(goal: Goal) -> list[Elements]:
    """Second differences, at every second vertex along a line, of the displacement from the seed (a tube's bent).

    Every second vertex, because a corrugation moves its two layers apart: each layer by itself is to be even. They
    are divided by the squared distance of the vertices, so that a smooth displacement counts the same at every
    number of facets.
    """
    model = goal.model
    triples = [triple for line in model.pattern.lines for triple in _every_second(line)]
    vertices = np.array(triples, np.int64).reshape(-1, 3)
    seed = model.seed_points if goal.tube is None else tube_fit.bent(model, goal.tube)
    a, b, c = seed[vertices].transpose(1, 0, 2)
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


def _mean(q: casadi.SX, k: int) -> casadi.SX:
    """Mean of k points given one after the other."""
    return casadi.SX(casadi.sum2(casadi.reshape(q, 3, k)) / k)


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
        weight = weights.get(name, term.default_weight if goal.tube is None else term.tube_weight)
        if weight > 0:
            blocks = term.build(goal)
            total = sum(e.count for e in blocks)
            terms += [Objective(e, weight * e.count / total) for e in blocks]
    return terms
