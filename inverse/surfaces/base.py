"""What every target surface offers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import casadi
import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.surfaces.nearest import Nearest

SQUEEZE = np.array([1.0, 1.0, 1e-4])  # of the plan and of heights over it


@dataclass(frozen=True, eq=False)
class ClosestPoints:
    """Closest points of a target and what a small move of the given points changes.

    Attributes:
        feet: (N, 3) closest points on the target.
        weights: (N, 3, 3) projections W such that |W (p - foot)| is, where the surface is smooth, the distance
            to first order: n n^T inside (tangent-plane distance), I - t t^T on a border with direction t, I at a
            corner. At the ridges inside a mesh it is the distance from one of the facets there.
    """

    feet: FloatArray
    weights: FloatArray


@dataclass(frozen=True, eq=False)
class Frame:
    """The plan of a target: where a seed is placed.

    Attributes:
        origin: (3,) centre of the plan at the target's mean height.
        axes: (3, 3) rows x, y (in plan) and z (up).
        extent: size of the plan along x and y.
    """

    origin: FloatArray
    axes: FloatArray
    extent: tuple[float, float]


class Target(ABC):
    """A bounded surface in the specification's length unit.

    Attributes:
        has_kinks: whether its normal jumps, as a mesh's does from facet to facet.
    """

    has_kinks = False

    @abstractmethod
    def closest(self, points: FloatArray) -> ClosestPoints:
        """Closest points of the surface, border included, to points (N, 3)."""

    @abstractmethod
    def triangles(self) -> tuple[FloatArray, IntArray]:
        """Vertices (V, 3) and triangles (T, 3) of the surface, for measuring areas and for pictures."""

    @property
    @abstractmethod
    def frame(self) -> Frame:
        """The plan that a placed seed covers."""

    def residual(self, point: casadi.SX) -> casadi.SX | None:
        """Distance residuals (k,) as an expression of a point (3,) if the surface is smooth, else None."""
        return None

    def distances(self, points: FloatArray) -> FloatArray:
        """Distances (N,) of points (N, 3) from the surface, border included."""
        return np.asarray(np.linalg.norm(points - self.closest(points).feet, axis=1))

    @cached_property
    def nearest(self) -> Nearest:
        """The triangulated surface, for closest points of it."""
        return Nearest(*self.triangles())

    def over_plan(self, points: FloatArray) -> FloatArray:
        """Points (N, 3) of the surface, or of its triangles, over the same places of the plan, or nearest to them."""
        frame = self.frame
        _, _, feet = self._flat.find((points - frame.origin) @ frame.axes.T * SQUEEZE)
        return np.asarray((feet / SQUEEZE) @ frame.axes + frame.origin)

    @cached_property
    def _flat(self) -> Nearest:
        """The surface nearly flattened onto its plan: what is closest there is straight above or below."""
        from inverse.surfaces.mesh import without_repetitions  # a mesh is a target itself

        frame, (vertices, triangles) = self.frame, self.triangles()
        vertices, triangles, _ = without_repetitions((vertices - frame.origin) @ frame.axes.T * SQUEEZE, triangles)
        return Nearest(vertices, triangles)

    def flattened(self, share: float) -> Target:
        """The surface with its heights over its plan lowered to a share of themselves, on the way from a flat seed.

        Args:
            share: 0 for the plan itself, 1 for the surface.
        """
        from inverse.surfaces.mesh import MeshTarget

        frame, (vertices, triangles) = self.frame, self.triangles()
        heights = (vertices - frame.origin) @ frame.axes[2]
        return MeshTarget(vertices - (1 - share) * heights[:, None] * frame.axes[2], triangles)

    def moved(self, origin: FloatArray) -> Target:
        """The surface in coordinates relative to a point (3,) of its own."""
        return _Moved(self, origin) if origin.any() else self

    def samples(self) -> tuple[FloatArray, FloatArray]:
        """Centroids (T, 3) of the surface's triangles and their areas (T,)."""
        return self._parts

    @cached_property
    def _parts(self) -> tuple[FloatArray, FloatArray]:
        vertices, triangles = self.triangles()
        a, b, c = vertices[triangles].transpose(1, 0, 2)
        return (a + b + c) / 3, np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)


class _Moved(Target):
    """A surface that knows only its own coordinates, in others."""

    def __init__(self, target: Target, origin: FloatArray) -> None:
        self._target, self._origin = target, origin

    @property
    def has_kinks(self) -> bool:  # type: ignore[override]
        """As the surface's."""
        return self._target.has_kinks

    def closest(self, points: FloatArray) -> ClosestPoints:
        """See :meth:`Target.closest`."""
        found = self._target.closest(points + self._origin)
        return ClosestPoints(found.feet - self._origin, found.weights)

    def over_plan(self, points: FloatArray) -> FloatArray:
        """See :meth:`Target.over_plan`."""
        return self._target.over_plan(points + self._origin) - self._origin

    def triangles(self) -> tuple[FloatArray, IntArray]:
        """See :meth:`Target.triangles`."""
        vertices, triangles = self._target.triangles()
        return vertices - self._origin, triangles

    @property
    def frame(self) -> Frame:
        """See :meth:`Target.frame`."""
        frame = self._target.frame
        return Frame(frame.origin - self._origin, frame.axes, frame.extent)

    def residual(self, point: casadi.SX) -> casadi.SX | None:
        """See :meth:`Target.residual`."""
        return self._target.residual(point + casadi.DM(self._origin))

    def flattened(self, share: float) -> Target:
        """See :meth:`Target.flattened`."""
        return _Moved(self._target.flattened(share), self._origin)
