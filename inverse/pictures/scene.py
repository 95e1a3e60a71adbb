"""What a 3D picture shows, as plain arrays: coloured facets, lines, captions and a camera."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from inverse._types import FloatArray, IntArray
from inverse.pictures.camera import Camera

Colours = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Facets:
    """Polygons of one colour each, shown as they are: light and shade are in the colours.

    Attributes:
        points: (N, 3).
        cells: polygons as VTK stores them, each its number of vertices followed by the vertices.
        colours: (F, 3) uint8.
        opacity: 1 hides what is behind.
    """

    points: FloatArray
    cells: IntArray
    colours: Colours
    opacity: float = 1.0


@dataclass(frozen=True, eq=False)
class Lines:
    """Straight lines of one width.

    Attributes:
        points: (N, 3).
        ends: (S, 2) int.
        colours: (S, 3) uint8.
        width: in pixels of the finished picture.
    """

    points: FloatArray
    ends: IntArray
    colours: Colours
    width: float


@dataclass(frozen=True)
class Caption:
    """A centred line of text; x and y in pixels of the finished picture, from its lower left corner."""

    text: str
    x: float
    y: float
    size: int


@dataclass(frozen=True, eq=False)
class Scene:
    """A picture to be rendered.

    Attributes:
        size: width and height in pixels, multiples of 16.
        camera: where it is seen from.
        facets: drawn with hidden surfaces removed.
        lines: drawn where they are not hidden.
        captions: drawn over everything.
    """

    size: tuple[int, int]
    camera: Camera
    facets: list[Facets] = field(default_factory=list)
    lines: list[Lines] = field(default_factory=list)
    captions: list[Caption] = field(default_factory=list)


def cells_of(polygons: tuple[tuple[int, ...], ...] | IntArray) -> IntArray:
    """Polygons as VTK stores them: each its number of vertices followed by the vertices."""
    if isinstance(polygons, np.ndarray):
        return np.insert(polygons, 0, polygons.shape[1], axis=1).ravel().astype(np.int64)
    return np.array([number for polygon in polygons for number in (len(polygon), *polygon)], np.int64)
