"""What a workshop needs: sheets as DXF with the outlines of all layers on them, and a cut list."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from inverse._types import FloatArray
from inverse.errors import InputError
from inverse.fabricate.dxf_file import content_of
from inverse.fabricate.extras import needed
from inverse.fabricate.panels.nesting import Placed, nested
from inverse.fabricate.panels.panels import Panels, panels
from inverse.fabricate.panels.thickness import Thickness
from inverse.fabricate.units import metres
from inverse.origami.pattern import Design

_CUT, _ENGRAVE, _SHEET = "cut", "engrave", "sheet"
_COLOURS = {_CUT: 1, _ENGRAVE: 5, _SHEET: 8}  # of AutoCAD's index: red, blue, grey
_UNITS = {"in": 1, "mm": 4, "cm": 5, "m": 6, "um": 13, "nm": 12}  # $INSUNITS
_LETTER = 0.9  # width of a letter, of its height
_GAP = 1.0  # between pieces, of their thickness


@dataclass(frozen=True, eq=False)
class Blank:
    """One layer of one panel as it is cut.

    Attributes:
        name: of the panel and the layer.
        layer: ``upper`` or ``lower``.
        outline: (k, 2) counter-clockwise, seen from the side that is outside when built.
        area: in square units of the design.
        mass: in kilograms; None without a density.
    """

    name: str
    layer: str
    outline: FloatArray
    area: float
    mass: float | None


def dxf(
    design: Design, *, thickness: Thickness, sheet: tuple[float, float], density: float | None = None
) -> dict[str, bytes]:
    """Sheets to be cut, and the list of what is on them.

    Every layer of every panel is a closed polyline on the layer ``cut``, with its name on the layer ``engrave``, seen
    from its outside. A hinge sheet is not cut into panels: it is cut by the crease pattern.

    Args:
        design: the mesh.
        thickness: of the layers, delta and the hinge sheet.
        sheet: width and height in the design's unit.
        density: kilograms in a cubic metre (in a cubic unit where the design's unit is not known); None leaves the
            masses out.

    Returns:
        ``sheet_1.dxf`` and so on, and ``cut_list.csv``, by name.

    Raises:
        InputError: ezdxf is missing, the design cannot be made that thick, a panel is larger than the sheet, or a
            size or the density is not positive.
    """
    thick = panels(design, thickness)
    pieces = pieces_of(thick, density)
    unit = "" if design.unit == "unit" else f" {design.unit}"
    gap = _GAP * thickness.thickness
    placed = nested([piece.outline for piece in pieces], [piece.name for piece in pieces], sheet, gap, unit)
    count = max(place.sheet for place in placed) + 1
    files = {
        f"sheet_{number + 1:0{len(str(count))}d}.dxf": _sheet(
            [(pieces[place.number], place) for place in placed if place.sheet == number], sheet, design
        )
        for number in range(count)
    }
    names = list(files)
    return files | {"cut_list.csv": cut_list(thick, pieces, [names[place.sheet] for place in placed])}


def pieces_of(thick: Panels, density: float | None) -> list[Blank]:
    """The layers of all panels.

    Raises:
        InputError: the density is not positive.
    """
    if density is not None and not (np.isfinite(density) and density > 0):
        raise InputError(f"the density is {density:g}: it must be greater than 0")
    factor = None if density is None else density * thick.thickness.thickness * metres(thick.design.unit) ** 3
    pieces = []
    for name, outlines, areas in zip(thick.names, thick.outlines, thick.areas.tolist(), strict=True):
        for layer, outline, area in zip(("upper", "lower"), outlines, areas, strict=False):
            seen = outline if layer == "upper" else outline[::-1] * [-1.0, 1.0]
            pieces.append(Blank(f"{name} {layer}", layer, seen, area, None if factor is None else factor * area))
    return pieces


def cut_list(thick: Panels, pieces: Iterable[Blank], sheets: Iterable[str]) -> bytes:
    """The pieces as CSV: name, layer, thickness, area, mass, sheet and outline, ``x y`` of every corner."""
    unit = thick.design.unit
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(
        ["name", "layer", f"thickness [{unit}]", f"area [{unit}^2]", "mass [kg]", "sheet", f"outline [{unit}]"]
    )
    for piece, sheet in zip(pieces, sheets, strict=True):
        mass = "" if piece.mass is None else f"{piece.mass:.6g}"
        rounded = piece.outline.round(9) + 0.0  # no negative zeros
        outline = "; ".join(f"{x:.9g} {y:.9g}" for x, y in rounded.tolist())
        thickness = f"{thick.thickness.thickness:.9g}"
        writer.writerow([piece.name, piece.layer, thickness, f"{piece.area:.9g}", mass, sheet, outline])
    return text.getvalue().encode()


def _sheet(placed: list[tuple[Blank, Placed]], size: tuple[float, float], design: Design) -> bytes:
    ezdxf: Any = needed("ezdxf")
    document = ezdxf.new("R2010", units=_UNITS.get(design.unit, 0))
    for layer, colour in _COLOURS.items():
        document.layers.add(layer, color=colour)
    space = document.modelspace()
    width, height = size
    border = [(0, 0), (width, 0), (width, height), (0, height)]
    space.add_lwpolyline(border, close=True, dxfattribs={"layer": _SHEET})
    for piece, place in placed:
        space.add_lwpolyline(place.outline.tolist(), close=True, dxfattribs={"layer": _CUT})
        middle, radius = _middle(place.outline)
        letters = 2 * radius / np.hypot(_LETTER * len(piece.name), 1.0)
        text = space.add_text(piece.name, height=0.9 * letters, dxfattribs={"layer": _ENGRAVE})
        text.set_placement(tuple(middle.tolist()), align=ezdxf.enums.TextEntityAlignment.MIDDLE_CENTER)
    return content_of(document)


def _middle(outline: FloatArray) -> tuple[FloatArray, float]:
    """A point well inside a convex outline, and its distance from the outline."""
    ahead = np.roll(outline, -1, axis=0)
    cross = outline[:, 0] * ahead[:, 1] - ahead[:, 0] * outline[:, 1]
    middle = ((outline + ahead) * cross[:, None]).sum(axis=0) / (3 * cross.sum())
    along = ahead - outline
    normals = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.linalg.norm(along, axis=1, keepdims=True)
    return middle, float((normals * (middle - outline)).sum(axis=1).min())
