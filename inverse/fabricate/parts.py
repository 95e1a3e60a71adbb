"""What the files for other programs hold: named parts, each with corners and polygons."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.crossing import triangles_of
from inverse.errors import InputError
from inverse.fabricate.panels.panels import Panels
from inverse.origami import folding
from inverse.origami.pattern import Design

_ROUNDING = 1e-9  # radians, by which a state may lie outside the range


@dataclass(frozen=True, eq=False)
class Part:
    """One body, or the ideal surface.

    Attributes:
        name: for example ``012 upper``: the panel and its layer.
        layer: ``upper``, ``lower`` or ``hinge``; ``facets`` for the ideal surface.
        points: (N, 3) corners; of a body first those of its lower side, then those above them.
        polygons: convex, counter-clockwise seen from outside.
    """

    name: str
    layer: str
    points: FloatArray
    polygons: tuple[tuple[int, ...], ...]

    @property
    def triangles(self) -> IntArray:
        """(T, 3): the polygons cut into fans."""
        return triangles_of(self.polygons)[0]


def surface_part(design: Design, t: float) -> Part:
    """The ideal surface folded to ``t`` radians."""
    points = folding.fold(design, np.array([t])).vertices_coords[0]
    return Part(design.name, "facets", points, design.pattern.faces_vertices)


def panel_parts(panels: Panels, t: float) -> list[Part]:
    """All layers of all panels, folded to ``t`` radians: watertight prisms.

    Raises:
        InputError: ``t`` is outside the range that delta leaves.
    """
    low, high = panels.range.low, panels.range.high
    if not low - _ROUNDING <= t <= high + _ROUNDING:
        raise InputError(
            f"thick panels do not fold to t = {np.degrees(t):.5g} degrees: delta leaves {np.degrees(low):.5g} to "
            f"{np.degrees(high):.5g} degrees",
            hint="Take a state in that range, or a smaller delta.",
        )
    parts = []
    bodies = panels.bodies_at(np.array([t]))[0]
    for name, outlines, layers in zip(panels.names, panels.outlines, bodies, strict=True):
        for layer, outline, heights, sides in zip(panels.layers, outlines, panels.heights, layers, strict=True):
            below, above = sides[np.argsort(heights), : len(outline)]
            parts.append(Part(f"{name} {layer}", layer, np.concatenate([below, above]), prism(len(outline))))
    return parts


def prism(sides: int) -> tuple[tuple[int, ...], ...]:
    """Polygons of a prism: the lower side, the upper one, and the walls between them."""
    first, second = range(sides), range(sides, 2 * sides)
    walls = ((k, (k + 1) % sides, (k + 1) % sides + sides, k + sides) for k in range(sides))
    return (tuple(reversed(first)), tuple(second), *walls)
