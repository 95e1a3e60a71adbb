"""Points of a mesh fitted to a surface: by its own expression where it is smooth, else by tangent planes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import casadi
import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.model import DesignModel
from inverse.nlp.constants import lifted
from inverse.nlp.kernels import Elements, Kernel
from inverse.origami import geometry
from inverse.origami.pattern import B
from inverse.terms.fitting import Fitting
from inverse.terms.rim import rim_places

# Of the coverage: sixteenths of the model that a rim facet may move freely, factors of the pull within and beyond; and
# by how many its place is nearer to the rim than in the seed, since facets in that freedom rather move inward.
SLACK, WEAK, STRONG = 0.25, 0.3, 3.0
OUTWARD = 0.15

FitPoints = Literal["facets", "layer", "vertices"]


@dataclass(frozen=True, eq=False)
class SurfaceFitting(Fitting):
    """Centroids or vertices that lie on a surface.

    Attributes:
        fitted: which points of the mesh.
    """

    fitted: FitPoints = "facets"

    @property
    def points(self) -> str:
        """See :attr:`Fitting.points`."""
        return self.fitted

    @property
    def is_exact(self) -> bool:
        """See :attr:`Fitting.is_exact`."""
        return self.target.residual(casadi.SX.zeros(3)) is not None

    def elements(self) -> list[Elements]:
        """See :meth:`Fitting.elements`."""
        model = self.model
        blocks: list[Elements] = []
        for group in fit_vertices(model, self.fitted):
            k = group.shape[1]
            name = "fit" if not blocks else f"fit_{k}"

            def exact(q: casadi.SX, k: int = k) -> casadi.SX:
                distance = self.target.residual(_mean(q, k) * model.scale + model.centre)
                assert distance is not None  # this kernel is for exact targets only
                return casadi.SX(distance / (model.scale * model.refinement))

            def to_foot(q: casadi.SX, p: casadi.SX, k: int = k) -> casadi.SX:
                return casadi.reshape(p[3:], 3, 3) @ (_mean(q, k) - p[:3])

            variables = model.variables_of(group)
            if self.is_exact:
                residual, numbers = lifted(exact, 3 * k)
                parameters = np.tile(numbers, (len(group), 1))
                blocks.append(Elements(name, Kernel(name, residual, 3 * k, len(numbers)), variables, parameters))
            else:
                # The seed lies flat over the plan, and what is closest to it is the target's crests: the places
                # over the same points of the plan are a better start.
                over_plan = self.target.over_plan(model.seed.vertices_coords[group].mean(axis=1))
                feet = self._feet(over_plan)
                blocks.append(Elements(name, Kernel(name, to_foot, 3 * k, 12), variables, feet))
        return blocks

    def refreshed(self, points: FloatArray) -> dict[str, FloatArray]:
        """See :meth:`Fitting.refreshed`."""
        if self.is_exact:
            return {}
        groups = fit_vertices(self.model, self.fitted)
        names = ["fit", *(f"fit_{group.shape[1]}" for group in groups[1:])]
        return {name: self._feet(mean_points(points, [group])) for name, group in zip(names, groups, strict=True)}

    def covering(self) -> list[Elements]:
        """Facets of the rim stay near the places that they have where the seed is spread over the target.

        Fit alone is content with a mesh that has shrunk into a corner of the target. Within ``SLACK`` the pull is
        weak, so that it costs no fit; beyond, where the target's rim would come to lie bare, it is strong.
        """
        model, pattern = self.model, self.model.pattern
        rim = np.unique(pattern.edges_faces[pattern.edges_type == B, 0])
        blocks: list[Elements] = []
        for sides in sorted({len(pattern.faces_vertices[f]) for f in rim}):
            facets = np.array([f for f in rim if len(pattern.faces_vertices[f]) == sides], np.int64)
            group = np.array([pattern.faces_vertices[f] for f in facets], np.int64)
            outward = OUTWARD * model.scale * model.refinement
            places = model.to_dimensionless(rim_places(model.seed, self.target, facets, outward, trimmed=model.trimmed))

            def residual(q: casadi.SX, p: casadi.SX, k: int = sides) -> casadi.SX:
                offset = (_mean(q, k) - p) / model.refinement
                beyond = casadi.fmax(0, casadi.sumsqr(offset) - SLACK**2) / (2 * SLACK)
                return casadi.vertcat(WEAK * offset, STRONG * beyond)

            name = "coverage" if not blocks else f"coverage_{sides}"
            blocks.append(Elements(name, Kernel(name, residual, 3 * sides, 3), model.variables_of(group), places))
        return blocks

    def fair_points(self) -> FloatArray:
        """See :meth:`Fitting.fair_points`: the seed."""
        return self.model.seed_points

    def followed(self, points: FloatArray, before: Fitting) -> FloatArray:
        """See :meth:`Fitting.followed`: with the seed, and then up or down with the target."""
        moved = super().followed(points, before)
        return moved + (self.target.over_plan(moved) - before.target.over_plan(points)) - (moved - points)

    def distances(self, points: FloatArray) -> FloatArray:
        """See :meth:`Fitting.distances`; of vertices of the model, or of its design, which may lack facets."""
        if not len(self.model.left_out):
            return self.target.distances(mean_points(points, fit_vertices(self.model, self.fitted)))
        pattern, used = self.model.rest
        points = points[used] if len(points) == self.model.pattern.n_vertices else points
        if self.fitted == "facets":
            return self.target.distances(geometry.facet_centroids(pattern, points))
        (fitted,) = fit_vertices(self.model, self.fitted)
        return self.target.distances(points[np.isin(used, fitted[:, 0])])

    def _feet(self, points: FloatArray) -> FloatArray:
        """Closest points of the target to points (N, 3) and their weights, as (N, 12), dimensionless."""
        closest = self.target.closest(points)
        weights = closest.weights.transpose(0, 2, 1).reshape(-1, 9)  # column-major, as CasADi reshapes
        return np.column_stack([self.model.to_dimensionless(closest.feet), weights / self.model.refinement])


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
    facets = pattern.faces_by_sides.values()
    return [np.array([pattern.faces_vertices[f] for f in some], np.int64) for some in facets]


def mean_points(points: FloatArray, groups: list[IntArray]) -> FloatArray:
    """Means (N, 3) of groups of vertices, ``points`` (V, 3)."""
    return np.concatenate([points[group].mean(axis=1) for group in groups])


def _mean(q: casadi.SX, k: int) -> casadi.SX:
    """Mean of k points given one after the other."""
    return casadi.SX(casadi.sum2(casadi.reshape(q, 3, k)) / k)
