"""Fit of a tube to a section: every facet and every line along the tube lies on the outline."""

from __future__ import annotations

from dataclasses import dataclass

import casadi
import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.nlp.kernels import Elements, Kernel
from inverse.surfaces.section import SectionTarget
from inverse.terms.tube_fit import ALONG, RingFit, TubeFitting, ring_centroids, ring_fractions, ring_vertices


@dataclass(frozen=True, eq=False)
class SectionFitting(TubeFitting):
    """Facets of a tube and its corners that lie on a swept outline.

    Rows zigzag, so that two rings of vertices lie to either side of the outline: what is fitted of a facet is its
    centroid, and of a line along the tube the middle of its edge in every row.
    """

    @property
    def points(self) -> str:
        """See :attr:`Fitting.points`."""
        return "sections"

    @property
    def section(self) -> SectionTarget:
        """The target."""
        assert isinstance(self.target, SectionTarget)  # formulation chose this fitting for it
        return self.target

    @property
    def _groups(self) -> dict[str, IntArray]:
        """Vertices (N, k) whose means are fitted, by name of the elements."""
        rings = ring_vertices(self.model.pattern)
        low, high = rings[:-1], rings[1:]
        corners = np.stack([low, high], axis=2).reshape(-1, 2)
        facets = np.stack([low, np.roll(low, -1, axis=1), np.roll(high, -1, axis=1), high], axis=2).reshape(-1, 4)
        return {"fit": facets, "fit_corners": corners}

    def elements(self) -> list[Elements]:
        """Distances of facets and corners from the outline, and weakly the places of rings along the axis."""
        model = self.model
        found = []
        for name, group in self._groups.items():
            k = group.shape[1]

            def to_foot(q: casadi.SX, p: casadi.SX, k: int = k) -> casadi.SX:
                mean = casadi.sum2(casadi.reshape(q, 3, k)) / k
                return casadi.reshape(p[3:], 3, 3) @ (mean - p[:3])

            parameters = self._outline_feet(model.seed.vertices_coords[group].mean(axis=1))
            found.append(Elements(name, Kernel(name, to_foot, 3 * k, 12), model.variables_of(group), parameters))
        rings = ring_vertices(model.pattern)
        both = np.hstack([rings[:-1], rings[1:]])

        def place(q: casadi.SX, p: casadi.SX) -> casadi.SX:
            mean = casadi.sum2(casadi.reshape(q, 3, both.shape[1])) / both.shape[1]
            return ALONG * (casadi.dot(mean - p[:3], p[3:6]) + p[6]) / model.refinement

        kernel = Kernel("fit_rings", place, 3 * both.shape[1], 7)
        along = self._places(model.seed.vertices_coords)
        return [*found, Elements("fit_rings", kernel, model.variables_of(both), along)]

    def refreshed(self, points: FloatArray) -> dict[str, FloatArray]:
        """See :meth:`Fitting.refreshed`."""
        feet = {name: self._outline_feet(points[group].mean(axis=1)) for name, group in self._groups.items()}
        return feet | {"fit_rings": self._places(points)}

    def _outline_feet(self, points: FloatArray) -> FloatArray:
        """Closest points of the outline to points (N, 3) and their weights, as (N, 12), dimensionless."""
        closest = self.section.closest(points)
        weights = closest.weights.transpose(0, 2, 1).reshape(-1, 9)  # column-major, as CasADi reshapes
        return np.column_stack([self.model.to_dimensionless(closest.feet), weights / self.model.refinement])

    def _places(self, points: FloatArray) -> FloatArray:
        """Where rings are on the axis, its direction there and how far they lag behind their places, (R, 7)."""
        model = self.model
        at = self.section.stations(ring_centroids(model.pattern, points).mean(axis=1))
        wanted = ring_fractions(model, ring_centroids(model.pattern, model.seed.vertices_coords).mean(axis=1))
        lag = (at.fractions - wanted) * self.section.axis.length / model.scale
        return np.column_stack([model.to_dimensionless(at.points), at.tangents, lag])

    def distances(self, points: FloatArray) -> FloatArray:
        """Distances (N,) of facets and corners from the outline."""
        means = [points[group].mean(axis=1) for group in self._groups.values()]
        return self.section.distances(np.concatenate(means))

    def told(self, points: FloatArray) -> RingFit:
        """See :meth:`Fitting.told`."""
        rings = ring_centroids(self.model.pattern, points)
        beside = self.section.distances(rings.reshape(-1, 3))
        each = np.sqrt((beside.reshape(rings.shape[:2]) ** 2).mean(axis=1))
        relative = each / self.section.stations(rings.mean(axis=1)).radii
        ends = points[ring_vertices(self.model.pattern)[[0, -1]]].mean(axis=1)
        reached = self.section.stations(ends).fractions
        return RingFit(
            float(relative.mean()),
            float(relative.max()),
            float(np.sqrt(np.mean(beside**2))),
            float(beside.max()),
            (float(reached[0]), float(reached[1])),
        )
