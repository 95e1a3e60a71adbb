"""Meshes with holes as targets: facets over a hole follow a smooth filling, and are no part of the design."""

from __future__ import annotations

import numpy as np
from scipy.spatial import QhullError

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.surfaces.base import ClosestPoints, Frame, Target
from inverse.surfaces.mesh import MeshTarget
from inverse.surfaces.polygon import checked, filled
from inverse.surfaces.sheet import Borders, borders_of, hole_loops

NEIGHBOURS = 60  # vertices of the mesh that a height within a hole is made of
ACROSS = 12  # places along the side of the box around a hole at which its filling has heights


class HoledTarget(Target):
    """A mesh with holes: it is fitted as if they were filled, and is shown and measured as it is.

    Args:
        mesh: the mesh.
        filled: the same without holes.
    """

    has_kinks = True

    def __init__(self, mesh: MeshTarget, filled: MeshTarget) -> None:
        self.mesh, self.filled = mesh, filled

    @classmethod
    def of(cls, mesh: MeshTarget) -> HoledTarget | None:
        """A mesh with its holes filled in plan; None where it has none that are seen there."""
        vertices, triangles = mesh.triangles()
        borders, frame = borders_of(triangles), mesh.frame
        loops = hole_loops(vertices, borders)
        local = (vertices - frame.origin) @ frame.axes.T
        points, fillings = [vertices], [triangles]
        for loop in loops:
            corners = _ordered(borders, loop)
            filling = None if corners is None else _filling(local, corners)
            if corners is None or filling is None:
                continue
            inside, cells = filling
            first = sum(len(part) for part in points)
            fillings.append(np.r_[corners, first + np.arange(len(inside))][cells])
            points.append(inside @ frame.axes + frame.origin)
        if len(fillings) == 1:
            return None
        return cls(mesh, MeshTarget(np.concatenate(points), np.concatenate(fillings)))

    def closest(self, points: FloatArray) -> ClosestPoints:
        """See :meth:`Target.closest`: of the filled surface."""
        return self.filled.closest(points)

    def triangles(self) -> tuple[FloatArray, IntArray]:
        """See :meth:`Target.triangles`: with the holes."""
        return self.mesh.triangles()

    @property
    def frame(self) -> Frame:
        """See :meth:`Target.frame`."""
        return self.filled.frame

    def over_plan(self, points: FloatArray) -> FloatArray:
        """See :meth:`Target.over_plan`: of the filled surface."""
        return self.filled.over_plan(points)

    def flattened(self, share: float) -> Target:
        """See :meth:`Target.flattened`."""
        flat = self.filled.flattened(share)
        assert isinstance(flat, MeshTarget)  # a mesh flattened is a mesh
        return HoledTarget(self.mesh, flat)

    def moved(self, origin: FloatArray) -> HoledTarget:
        """See :meth:`Target.moved`."""
        return HoledTarget(self.mesh.moved(origin), self.filled.moved(origin)) if origin.any() else self


def _ordered(borders: Borders, loop: int) -> IntArray | None:
    """Vertices (n,) along a closed border, whichever way its facets turn; None where it touches itself."""
    beside: dict[int, list[int]] = {}
    for a, b in borders.edges[borders.loop == loop].tolist():
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    if any(len(both) != 2 for both in beside.values()):
        return None
    start = next(iter(beside))
    found = [start, beside[start][0]]
    while (after := next(v for v in beside[found[-1]] if v != found[-2])) != start:
        found.append(after)
    return np.array(found, np.int64)


def _filling(local: FloatArray, corners: IntArray) -> tuple[FloatArray, IntArray] | None:
    """Points (k, 3) within a hole, at heights that go on from around it, and triangles of its corners and them.

    Args:
        local: (V, 3) vertices of the mesh in the frame of its plan.
        corners: (n,) vertices along the hole's border.

    Returns:
        The points and triangles, or None for a hole that is not seen in plan.
    """
    from scipy.interpolate import RBFInterpolator

    rim = local[corners, :2]
    size = float(np.ptp(rim, axis=0).max())
    try:
        checked(rim, "the hole")
        plan, cells = filled(rim, size / ACROSS)
    except (InputError, QhullError):
        return None
    if not len(plan):
        return np.empty((0, 3)), cells
    # Upright parts of the mesh have several heights at a place: their mean.
    places, number = np.unique(np.round(local[:, :2] / (1e-6 * size)), axis=0, return_inverse=True)
    heights = np.bincount(number.ravel(), local[:, 2]) / np.bincount(number.ravel())
    count = min(NEIGHBOURS, len(places))
    around = RBFInterpolator(places * (1e-6 * size), heights, neighbors=count)
    return np.column_stack([plan, around(plan)]), cells
