"""Vertices and polygons as they stand in a mesh file, and what every format is held to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.limits import check_coordinates

MAX_BYTES = 100_000_000
MAX_FACETS = 200_000
MAX_CORNERS = 4 * MAX_FACETS
MAX_SIDES = 1_000
SIMPLER = "Give a simpler or a coarser mesh."


@dataclass(frozen=True, eq=False)
class Polygons:
    """A mesh of polygons.

    Attributes:
        vertices: (V, 3) float64.
        sizes: (F,) int64, numbers of sides.
        corners: (sum of sizes,) int64, the vertices of one polygon after those of the other.
    """

    vertices: FloatArray
    sizes: IntArray
    corners: IntArray


def check_counts(vertices: int, facets: int, where: str) -> None:
    """Refuse what would take too long, before anything is made of it.

    Raises:
        InputError: too many vertices or facets.
    """
    for count, most, what in ((vertices, 3 * MAX_FACETS, "vertices"), (facets, MAX_FACETS, "facets")):
        if count > most:
            raise InputError(f"the mesh has {count} {what}: up to {most} are read", where=where, hint=SIMPLER)


def check_sides(sides: int, where: str) -> None:
    """Refuse a polygon of too few or too many sides.

    Raises:
        InputError: fewer than three sides, or more than :data:`MAX_SIDES`.
    """
    if not 3 <= sides <= MAX_SIDES:
        raise InputError(f"a facet has {sides} sides: 3 to {MAX_SIDES} are allowed", where=where, hint=SIMPLER)


def check_corners(corners: int, where: str) -> None:
    """Refuse polygons that together have too many sides.

    Raises:
        InputError: more than :data:`MAX_CORNERS`.
    """
    if corners > MAX_CORNERS:
        raise InputError(f"the facets have more than {MAX_CORNERS} sides together", where=where, hint=SIMPLER)


def checked(vertices: FloatArray, sizes: IntArray, corners: IntArray, path: Path) -> Polygons:
    """A mesh whose facets name vertices that are there, whose used vertices are finite and not absurdly far away.

    Args:
        vertices: (V, 3).
        sizes: (F,) numbers of sides.
        corners: (sum of sizes,) vertices of the facets, counted from 0.
        path: the file, for messages.

    Raises:
        InputError: there are no facets, or one is wrong; facets are counted from 1 in messages.
    """
    where = str(path)
    if not len(sizes):
        raise InputError("the mesh has no facets", where=where)
    check_counts(len(vertices), len(sizes), where)
    check_corners(len(corners), where)
    for sides in (int(sizes.min()), int(sizes.max())):
        check_sides(sides, where)
    wrong = (corners < 0) | (corners >= len(vertices))
    if wrong.any():
        k = int(np.argmax(wrong))
        facet = int(np.searchsorted(np.cumsum(sizes), k, side="right"))
        raise InputError(
            f"facet {facet + 1} names vertex {corners[k]}, but the {len(vertices)} vertices have numbers from 0",
            where=where, hint="The file is damaged: export the mesh anew.",
        )  # fmt: skip
    loose = np.ones(len(vertices), bool)  # vertices of no facet may stand anywhere
    loose[corners] = False
    check_coordinates(np.where(loose[:, None], 0.0, vertices), where)
    return Polygons(vertices, sizes, corners)
