"""Buildings as named sets of flat surfaces, in metres from a local origin."""

from __future__ import annotations

import difflib
from dataclasses import dataclass

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.context.triangles import triangulate
from inverse.errors import InputError


@dataclass(frozen=True, eq=False)
class Surface:
    """A flat polygon of a building.

    Attributes:
        kind: "RoofSurface", "WallSurface", "GroundSurface", another semantic type of CityJSON, or "".
        rings: the outer ring, then the holes, each (n, 3) in metres, the last point not repeated.
    """

    kind: str
    rings: tuple[FloatArray, ...]


@dataclass(frozen=True, eq=False)
class Building:
    """A building with all its parts.

    Attributes:
        name: its identifier in the file it was read from.
        surfaces: roofs, walls and grounds of all its parts.
    """

    name: str
    surfaces: tuple[Surface, ...]

    @property
    def points(self) -> FloatArray:
        """All ring points, (N, 3) in metres; a point shared by surfaces is there once for each."""
        return np.concatenate([ring for surface in self.surfaces for ring in surface.rings])

    def of_kind(self, kind: str) -> tuple[Surface, ...]:
        """The surfaces of one semantic type, for example "RoofSurface"."""
        return tuple(surface for surface in self.surfaces if surface.kind == kind)


@dataclass(frozen=True, eq=False)
class Context:
    """The buildings around a design.

    Attributes:
        buildings: in the order of the file.
        origin: (3,) point of the file's reference system that was subtracted, in metres.
        ground: local height of the lowest ground surface, in metres.
    """

    buildings: tuple[Building, ...]
    origin: FloatArray
    ground: float

    def building(self, name: str) -> Building:
        """The building of that name.

        Raises:
            InputError: there is none.
        """
        for building in self.buildings:
            if building.name == name:
                return building
        names = [building.name for building in self.buildings]
        near = difflib.get_close_matches(name, names, n=1)
        hint = f"did you mean {near[0]}?" if near else f"there are: {', '.join(names[:20])}"
        raise InputError(f"no building is named {name}", hint=hint)


def triangulated(context: Context) -> tuple[FloatArray, IntArray, IntArray]:
    """Triangles of all surfaces, for pictures.

    Args:
        context: the buildings.

    Returns:
        Vertices (V, 3) in metres, triangles (T, 3) as vertex indices, turning as their surface's outer ring
        does (CityJSON asks: counter-clockwise seen from outside), and for each triangle the index (T,) of its
        building. Surfaces share no vertices, so that edges stay sharp when shaded.
    """
    triangles: list[IntArray] = []
    owners: list[IntArray] = []
    first = 0
    for index, building in enumerate(context.buildings):
        for surface in building.surfaces:
            triangles.append(triangulate(surface.rings) + first)
            owners.append(np.full(len(triangles[-1]), index))
            first += sum(len(ring) for ring in surface.rings)
    vertices = np.concatenate([building.points for building in context.buildings])
    return vertices, np.concatenate(triangles), np.concatenate(owners)
