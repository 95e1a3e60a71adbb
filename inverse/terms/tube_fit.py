"""Fit of a tube, ring by ring: its rings of facets lie around the target's axis and are as wide as the target there.

A tube's section is a polygon with notches, whose facets lie at different distances from the axis. What is fitted is
therefore the ring: the mean of its facets' centroids lies on the axis, and their rms distance from it is the radius.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import casadi
import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.model import DesignModel
from inverse.nlp.kernels import Elements, Kernel
from inverse.origami import geometry
from inverse.origami.pattern import Pattern
from inverse.surfaces.tube import TubeTarget
from inverse.terms.fitting import Fitting

ALONG = 0.1  # factor of the distance of a ring from its place along the axis
ENDS = 3.0  # factor of the distance of the open ends from those of the axis


def is_tube(pattern: Pattern) -> bool:
    """Whether facets lie in rings: a cylinder in the numbering of a grid."""
    return pattern.n_holes == 1 and pattern.grid is not None


def ring_facets(pattern: Pattern) -> IntArray:
    """Facets of every ring, (R, k) int, in order around."""
    k, rows = pattern.grid or (0, 0)
    return np.arange(k * rows).reshape(k, rows).T


def ring_vertices(pattern: Pattern) -> IntArray:
    """Vertices along every line around, (R + 1, k) int; the first and the last are the open ends."""
    k, rows = pattern.grid or (0, 0)
    return np.arange(k * (rows + 1)).reshape(k, rows + 1).T


def ring_centroids(pattern: Pattern, points: FloatArray) -> FloatArray:
    """Centroids (R, k, 3) of the facets of every ring, of vertices (V, 3)."""
    return geometry.facet_centroids(pattern, points)[ring_facets(pattern)]


def deviations(target: TubeTarget, centroids: FloatArray) -> tuple[FloatArray, FloatArray]:
    """How far rings are from where they belong.

    Args:
        target: the target.
        centroids: (R, k, 3) of the facets of every ring.

    Returns:
        Offsets (R,) of the rings' centroids from the axis, and by how much the rms distances (R,) of their facets
        from the axis exceed the target's radii.
    """
    count, k, _ = centroids.shape
    rings = centroids.mean(axis=1)
    at = target.stations(rings)
    offsets = np.linalg.norm(_across(rings - at.points, at.tangents), axis=1)
    flat = centroids.reshape(-1, 3)
    own = target.stations(flat)
    distances = np.linalg.norm(_across(flat - own.points, own.tangents), axis=1)
    return offsets, np.sqrt((distances.reshape(count, k) ** 2).mean(axis=1)) - at.radii


@dataclass(frozen=True)
class RingFit:
    """What is told of a tube's fit besides the distances of its rings.

    Attributes:
        mean_over_radius: mean distance of the rings, each relative to the target's radius there.
        max_over_radius: the largest.
        facets_rms: rms distance of the facets' centroids from the target by themselves, in length units.
        facets_max: the largest.
        ends: fractions of the axis that the two open ends reach.
    """

    mean_over_radius: float
    max_over_radius: float
    facets_rms: float
    facets_max: float
    ends: tuple[float, float]


@dataclass(frozen=True, eq=False)
class TubeFitting(Fitting):
    """Rings of facets that lie around an axis."""

    weights: ClassVar[Mapping[str, float]] = {"fairness": 5e-4}  # a tube's section is flattened easily

    @property
    def points(self) -> str:
        """See :attr:`Fitting.points`."""
        return "rings"

    @property
    def is_exact(self) -> bool:
        """See :attr:`Fitting.is_exact`: places on the axis are refreshed."""
        return False

    @property
    def tube(self) -> TubeTarget:
        """The target."""
        assert isinstance(self.target, TubeTarget)  # formulation chose this fitting for it
        return self.target

    def elements(self) -> list[Elements]:
        """Per ring: offset of its centroid across the axis (3), its radius (1), weakly its place along the axis (1).

        Places, directions and radii of the axis are parameters: those nearest to the ring, and nearest to each facet.
        """
        model, pattern = self.model, self.model.pattern
        k = pattern.grid[0] if pattern.grid else 0
        ends = ring_vertices(pattern)
        vertices = np.hstack([ends[:-1], ends[1:]])

        def residual(q: casadi.SX, p: casadi.SX) -> casadi.SX:
            low, high = (casadi.reshape(part, 3, k) for part in (q[: 3 * k], q[3 * k :]))
            foot, tangent, radius, slope, lag = p[:3], p[3:6], p[6], p[7], p[8]
            feet, tangents = casadi.reshape(p[9 : 9 + 3 * k], 3, k), casadi.reshape(p[9 + 3 * k :], 3, k)
            squares = []
            total = casadi.SX.zeros(3)
            for i in range(k):
                after = (i + 1) % k
                centroid = (low[:, i] + high[:, i] + low[:, after] + high[:, after]) / 4
                offset = centroid - feet[:, i]
                squares.append(casadi.sumsqr(offset - casadi.dot(offset, tangents[:, i]) * tangents[:, i]))
                total += centroid / k
            beside = total - foot
            along = casadi.dot(beside, tangent)
            wide = casadi.sqrt(sum(squares) / k) - radius - slope * along
            return casadi.vertcat(beside - along * tangent, wide, ALONG * (along + lag)) / model.refinement

        kernel = Kernel("fit", residual, 6 * k, 9 + 6 * k)
        parameters = self._feet(model.seed.vertices_coords)
        return [Elements("fit", kernel, model.variables_of(vertices), parameters)]

    def _feet(self, points: FloatArray) -> FloatArray:
        """What the target asks of every ring of vertices ``points`` (V, 3): (R, 9 + 6k), dimensionless."""
        model, target = self.model, self.tube
        centroids = ring_centroids(model.pattern, points)
        count = len(centroids)
        at, own = target.stations(centroids.mean(axis=1)), target.stations(centroids.reshape(-1, 3))
        places = ring_fractions(model, ring_centroids(model.pattern, model.seed.vertices_coords).mean(axis=1))
        lag = (at.fractions - places) * target.axis.length
        return np.column_stack(
            [
                model.to_dimensionless(at.points), at.tangents, at.radii / model.scale, at.slopes, lag / model.scale,
                model.to_dimensionless(own.points).reshape(count, -1), own.tangents.reshape(count, -1),
            ]
        )  # fmt: skip

    def covering(self) -> list[Elements]:
        """The mean vertices of the two open ends lie beside the ends of the axis."""
        model, target = self.model, self.tube
        k = model.pattern.grid[0] if model.pattern.grid else 0
        ends = np.array([0.0, 1.0])
        tangents = target.axis.tangents(ends)
        parameters = np.column_stack([model.to_dimensionless(target.axis.at(ends)), tangents])

        def residual(q: casadi.SX, p: casadi.SX) -> casadi.SX:
            mean = casadi.sum2(casadi.reshape(q, 3, k)) / k
            return ENDS * casadi.dot(mean - p[:3], p[3:]) / model.refinement

        vertices = ring_vertices(model.pattern)[[0, -1]]
        return [Elements("coverage", Kernel("coverage", residual, 3 * k, 6), model.variables_of(vertices), parameters)]

    def fair_points(self) -> FloatArray:
        """The seed's vertices, (V, 3) dimensionless, carried along when its axis is bent into the target's.

        Every section is turned from the seed's direction into that of the axis and grows as the radius does. Angles and
        planes are not kept: it is what a fair design resembles, not a design.
        """
        model, target = self.model, self.tube
        points, rings = model.seed.vertices_coords, ring_centroids(model.pattern, model.seed.vertices_coords)
        centre, along = rings.mean(axis=(0, 1)), _direction(model)
        radius = np.sqrt(np.mean(np.sum(np.cross(rings - centre, along) ** 2, axis=2)))
        t = ring_fractions(model, points)
        beside = points - centre
        beside = beside - (beside @ along)[:, None] * along
        tangents = target.axis.tangents(t)
        turned = beside - (np.einsum("ij,ij->i", beside, tangents) / (1 + tangents @ along))[:, None] * (
            along + tangents
        )
        return model.to_dimensionless(target.axis.at(t) + (target.radii(t) / radius)[:, None] * turned)

    def refreshed(self, points: FloatArray) -> dict[str, FloatArray]:
        """See :meth:`Fitting.refreshed`."""
        return {"fit": self._feet(points)}

    def distances(self, points: FloatArray) -> FloatArray:
        """Of every ring its offset from the axis and the excess of its radius, by Pythagoras."""
        return np.asarray(np.hypot(*deviations(self.tube, ring_centroids(self.model.pattern, points))))

    def told(self, points: FloatArray) -> RingFit:
        """See :meth:`Fitting.told`."""
        centroids = ring_centroids(self.model.pattern, points)
        relative = self.distances(points) / self.tube.stations(centroids.mean(axis=1)).radii
        facets = self.tube.distances(centroids.reshape(-1, 3))
        ends = points[ring_vertices(self.model.pattern)[[0, -1]]].mean(axis=1)
        reached = self.tube.stations(ends).fractions
        return RingFit(
            float(relative.mean()),
            float(relative.max()),
            float(np.sqrt(np.mean(facets**2))),
            float(facets.max()),
            (float(reached[0]), float(reached[1])),
        )


def _direction(model: DesignModel) -> FloatArray:
    """Unit vector (3,) along the seed's straight axis."""
    rings = ring_centroids(model.pattern, model.seed.vertices_coords).mean(axis=1)
    return geometry.unit(rings[-1] - rings[0])


def ring_fractions(model: DesignModel, points: FloatArray) -> FloatArray:
    """Fractions (N,) of the seed's length beside which points (N, 3) lie."""
    along = _direction(model)
    first, last = (
        model.seed.vertices_coords[ring].mean(axis=0) @ along for ring in ring_vertices(model.pattern)[[0, -1]]
    )
    return np.asarray((points @ along - first) / (last - first))


def _across(offsets: FloatArray, tangents: FloatArray) -> FloatArray:
    """The part of offsets (N, 3) across tangents (N, 3)."""
    return np.asarray(offsets - np.einsum("ij,ij->i", offsets, tangents)[:, None] * tangents)
