"""City objects of CityJSON as buildings: parts, geometries, surfaces with their semantics."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from inverse._types import FloatArray
from inverse.context.building import Building, Surface

# Coordinates beyond this, in metres, are no place on Earth.
FARTHEST = 1e9
# What is seen from outside; rooms and furniture are not.
_OUTER = {"Building", "BuildingPart", "BuildingInstallation", "BuildingConstructiveElement"}
# How many lists lie between a geometry's boundaries and its surfaces.
_NESTING = {"MultiSurface": 0, "CompositeSurface": 0, "Solid": 1, "MultiSolid": 2, "CompositeSolid": 2}


class MalformedError(Exception):
    """A fault in one feature, told without its place."""


def buildings_of(feature: dict[str, Any], scale: FloatArray) -> list[Building]:
    """The buildings of one feature (or of a whole file) with the surfaces of all their parts.

    Args:
        feature: a JSON object with "CityObjects" and "vertices".
        scale: (3,) metres per unit of the vertices.

    Returns:
        The buildings, in metres from the file's own offset ("translate").

    Raises:
        MalformedError: it is not laid out as CityJSON asks; other faults come as the errors Python raises.
    """
    objects = feature["CityObjects"]
    vertices = np.array(feature["vertices"], dtype=np.float64).reshape(-1, 3) * scale
    if not np.all(np.abs(vertices) < FARTHEST):
        raise MalformedError("vertices must be finite numbers, in metres, of a size found on Earth")
    found = []
    for name, root in objects.items():
        if root["type"] == "Building":
            surfaces = tuple(s for part in _parts(name, objects) for s in _surfaces(part, vertices))
            if surfaces:
                found.append(Building(name, surfaces))
    return found


def _parts(root: str, objects: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """A building and all its outer parts, parts of parts too."""
    names = [root]
    for name in names:  # the list grows on the way
        if objects[name]["type"] in _OUTER:
            yield objects[name]
            names += [child for child in objects[name].get("children", []) if child not in names]


def _surfaces(part: dict[str, Any], vertices: FloatArray) -> Iterator[Surface]:
    """The surfaces of a part's best geometry."""
    usable = [g for g in part.get("geometry", []) if g["type"] in _NESTING]
    if not usable:
        return
    best = max(usable, key=lambda g: (float(g.get("lod", 0)), "semantics" in g))
    semantics = best.get("semantics") or {"surfaces": [], "values": None}
    kinds = [str(surface["type"]) for surface in semantics["surfaces"]]
    for rings, value in _flat(best["boundaries"], semantics["values"], _NESTING[best["type"]]):
        if not rings:
            raise MalformedError("a surface must have a ring")
        yield Surface("" if value is None else kinds[value], tuple(_ring(ring, vertices) for ring in rings))


def _flat(boundaries: list[Any], values: list[Any] | None, depth: int) -> Iterator[tuple[list[Any], int | None]]:
    """Surfaces as lists of rings, each with the index of its semantics or None."""
    for boundary, value in zip(boundaries, [None] * len(boundaries) if values is None else values, strict=True):
        if depth:
            yield from _flat(boundary, value, depth - 1)
        else:
            yield boundary, value


def _ring(ring: list[Any], vertices: FloatArray) -> FloatArray:
    if len(ring) < 3 or not all(isinstance(k, int) and 0 <= k < len(vertices) for k in ring):
        raise MalformedError(f"a ring must be three or more vertex numbers from 0 to {len(vertices) - 1}, not {ring}")
    return np.asarray(vertices[ring])
