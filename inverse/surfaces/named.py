"""Target surfaces of users, by the names that specifications use."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import casadi

from inverse._types import FloatArray, IntArray
from inverse.extending.makers import Maker
from inverse.extending.registry import Registry
from inverse.surfaces.base import ClosestPoints, Frame, Target
from inverse.surfaces.mesh import MeshTarget

F = TypeVar("F", bound=Callable[..., Target])

TARGETS: Registry[Maker[Target]] = Registry("a target surface")


def target(name: str) -> Callable[[F], F]:
    """Register a function that makes a target, for ``target: {surface: name, parameter: value, ...}``.

    Args:
        name: behind ``surface`` in a specification.

    Returns:
        A decorator of functions of keyword parameters that return a :class:`Target` in the specification's unit.

    Raises:
        InputError: the name is taken or no word.
    """

    def add(function: F) -> F:
        kind: type[Target] = Target  # type: ignore[type-abstract]  # for isinstance only
        TARGETS.add(name, Maker("the target surface", name, function, kind, taken=("surface",)))
        return function

    return add


def moved(target: Target, origin: FloatArray) -> Target:
    """A target in coordinates relative to a point (3,)."""
    if not origin.any():
        return target
    if isinstance(target, MeshTarget):
        vertices, triangles = target.triangles()
        return MeshTarget(vertices - origin, triangles)
    return _Moved(target, origin)


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
