"""The crease pattern as SVG: the developed state in the paper's four colours, true to scale."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.files.atomic import write_atomically
from inverse.origami import geometry
from inverse.origami.pattern import CFL, Design
from inverse.pictures.colours import EDGE_COLOURS, INK, PAPER, edge_kinds
from inverse.pictures.sheets import Sheet, lay_out, stacked

# The page, in pixels.
_DRAWING = (1400.0, 1000.0)  # the drawing fits into this box
_MARGIN, _HEAD, _FOOT, _LEAST_WIDTH = 48.0, 78.0, 92.0, 1100.0
_LEAST_TEXT = 5.0
_LOWEST_SEEN = 0.25  # share of the lowest layer's ink that is seen through all others


def crease_pattern_picture(design: Design, path: Path) -> None:
    """Write the crease pattern of a design as SVG.

    The developed state is drawn in its four colours, one group of lines per kind of edge. Where it doubles back at
    complementary foldlines, its layers are laid side by side, all with the top side up, and equal numbers mark
    the two sides of a seam. Coordinates inside the groups are lengths in the design's unit. The same design gives
    the same bytes.

    Args:
        design: the design.
        path: the SVG file to write.
    """
    sheets = lay_out(design)
    note = "Developed state (t = 0°), seen from the top side."
    if len(sheets) > 1:
        note = (
            f"Developed state (t = 0°) in {len(sheets)} sheets, laid side by side with the top side up. "
            "Equal numbers are joined by a complementary foldline."
        )
    write_atomically(path, _document(design, "crease pattern", sheets, note, in_layers=False))


def layers_picture(design: Design, path: Path) -> None:
    """Write the developed state of a design as SVG with its layers where they lie, like the paper's Figure 9.

    Every layer is a group of its own, translucent, with its lines in their four colours, the lowest layer first.

    Args:
        design: the design.
        path: the SVG file to write.
    """
    sheets = stacked(design)
    note = f"Developed state (t = 0°), its {len(sheets)} layers where they lie, seen from above the uppermost."
    write_atomically(path, _document(design, "layers", sheets, note, in_layers=True))


@dataclass(frozen=True)
class _Page:
    """Scale and place of the drawing on the page: x -> left + scale x, y -> base - scale y."""

    scale: float
    left: float
    base: float
    width: float
    height: float

    def at(self, point: FloatArray) -> tuple[float, float]:
        return self.left + self.scale * float(point[0]), self.base - self.scale * float(point[1])


def _document(design: Design, what: str, sheets: list[Sheet], note: str, *, in_layers: bool) -> str:
    kinds = edge_kinds(design.pattern, geometry.fold_angles(design.pattern, design.vertices_coords))
    edge_length = float(np.median(geometry.edge_lengths(design.pattern, design.vertices_coords)))
    page = _page(sheets)
    stroke = min(2.4, max(0.9, 0.04 * page.scale * edge_length))

    svg = ET.Element(
        "svg", xmlns="http://www.w3.org/2000/svg", width=_px(page.width), height=_px(page.height),
        viewBox=f"0 0 {_px(page.width)} {_px(page.height)}",
    )  # fmt: skip
    svg.set("font-family", "Helvetica, Arial, sans-serif")
    ET.SubElement(svg, "title").text = f"{design.name}: {what}"
    ET.SubElement(svg, "rect", width="100%", height="100%", fill="#ffffff")
    drawing = ET.SubElement(
        svg, "g", id=what.replace(" ", "-"),
        transform=f"translate({_px(page.left)} {_px(page.base)}) scale({page.scale:.9g} {-page.scale:.9g})",
    )  # fmt: skip
    if in_layers:
        opacity = 1 - _LOWEST_SEEN ** (1 / max(1, len(sheets) - 1))
        for k, sheet in enumerate(sheets):
            layer = ET.SubElement(drawing, "g", id=f"layer-{k + 1}")
            _draw(layer, design, [sheet], kinds, stroke / page.scale, f"layer-{k + 1}-", opacity=opacity)
    else:
        _draw(drawing, design, sheets, kinds, stroke / page.scale)
        _number_seams(svg, design, sheets, page, page.scale * edge_length)
    _head(svg, design, note)
    _legend(svg, page)
    _scale_bar(svg, page, design.unit)
    ET.indent(svg, " ")
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(svg, encoding="unicode") + "\n"


def _page(sheets: list[Sheet]) -> _Page:
    points = np.concatenate([s.points for s in sheets])
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    scale = float(min(_DRAWING[0] / size[0], _DRAWING[1] / size[1]))
    drawn = scale * size
    width = math.ceil(max(_LEAST_WIDTH, drawn[0] + 2 * _MARGIN))
    left = (width - drawn[0]) / 2 - scale * low[0]
    base = _HEAD + drawn[1] + scale * low[1]
    return _Page(scale, float(left), float(base), width, math.ceil(_HEAD + drawn[1] + _FOOT))


def _draw(
    drawing: ET.Element, design: Design, sheets: list[Sheet], kinds: IntArray, stroke: float, prefix: str = "",
    opacity: float = 1.0,
) -> None:  # fmt: skip
    """Sheets of paper and, over them, one group of lines per kind of edge; lengths in the design's unit."""
    size = float(np.ptp(np.concatenate([s.points for s in sheets]), axis=0).max())
    digits = max(0, 7 - math.floor(math.log10(size)))

    def number(x: float) -> str:
        text = f"{x:.{digits}f}"
        text = text.rstrip("0").rstrip(".") if "." in text else text
        return "0" if text == "-0" else text

    faces = design.pattern.faces_vertices
    papers = ET.SubElement(drawing, "g", id=f"{prefix}sheets", fill=PAPER)
    if opacity < 1:
        papers.set("fill-opacity", f"{opacity:.3g}")
    for sheet in sheets:
        outlines = (sheet.place_of(np.array(faces[f])).tolist() for f in sheet.faces)
        parts = ("M" + "L".join(f"{number(x)} {number(y)}" for x, y in outline) + "Z" for outline in outlines)
        ET.SubElement(papers, "path", d="".join(parts))
    # Folds first, so that the outline lies over their ends.
    for kind, (name, colour) in enumerate(EDGE_COLOURS.items()):
        group = ET.SubElement(drawing, "g", id=prefix + name.replace(" ", "-"), stroke=colour)
        group.set("stroke-width", f"{stroke:.6g}")
        group.set("stroke-linecap", "round")
        for sheet in sheets:
            edges = sheet.edges[kinds[sheet.edges] == kind]
            for (x1, y1), (x2, y2) in sheet.place_of(design.pattern.edges_vertices[edges]).tolist():
                ET.SubElement(group, "line", x1=number(x1), y1=number(y1), x2=number(x2), y2=number(y2))


def _number_seams(svg: ET.Element, design: Design, sheets: list[Sheet], page: _Page, edge_px: float) -> None:
    """Equal small numbers on the two sides of every seam, on every edge or as many as stay legible."""
    pattern = design.pattern
    number = _seam_numbers(design, 1 if edge_px > 30 else math.ceil(80 / edge_px))
    if not number:
        return
    size = min(11.0, max(_LEAST_TEXT, 0.2 * edge_px))
    group = ET.SubElement(svg, "g", id="seams", fill=INK)
    group.set("text-anchor", "middle")
    for sheet in sheets:
        facets = set(sheet.faces.tolist())
        for edge in sheet.edges.tolist():
            if edge not in number:
                continue
            face = next(f for f in pattern.edges_faces[edge].tolist() if f in facets)
            inside = sheet.place_of(np.array(pattern.faces_vertices[face])).mean(axis=0)
            _label(group, sheet.place_of(pattern.edges_vertices[edge]), inside, str(number[edge]), page, size)


def _seam_numbers(design: Design, stride: int) -> dict[int, int]:
    """Numbers of every ``stride``-th edge of the complementary foldlines, counted along one line after another."""
    pattern = design.pattern
    numbers: dict[int, int] = {}
    count = 0
    for edges in pattern.lines_edges:
        if pattern.edges_type[edges[0]] == CFL:
            numbers |= {edge: count + k + 1 for k, edge in enumerate(edges) if k % stride == 0}
            count += len(edges)
    return numbers


def _label(group: ET.Element, ends: FloatArray, inside: FloatArray, text: str, page: _Page, size: float) -> None:
    """A number along an edge, on the side of the facet with centre ``inside``."""
    a, b, c = (np.array(page.at(p)) for p in (*ends, inside))
    along = (b - a) / np.linalg.norm(b - a)
    if along[0] < -1e-9 or (abs(along[0]) <= 1e-9 and along[1] > 0):
        along = -along
    inwards = np.array([-along[1], along[0]])
    depth = float((c - a) @ inwards)  # to the middle of the facet, where a number on its other side begins
    size = max(_LEAST_TEXT, min(size, 0.8 * abs(depth)))
    # The base line lies below the middle of the digits, which are 0.7 of the size high.
    x, y = (a + b) / 2 + inwards * (math.copysign(0.7, depth) + 0.35) * size
    angle = math.degrees(math.atan2(along[1], along[0]))
    label = ET.SubElement(group, "text", transform=f"translate({_px(x)} {_px(y)}) rotate({_px(angle)})")
    label.set("font-size", _px(size))
    label.text = text


def _head(svg: ET.Element, design: Design, note: str) -> None:
    _text(svg, design.name, _MARGIN, 34, 20, bold=True)
    _text(svg, note, _MARGIN, 56, 13)


def _legend(svg: ET.Element, page: _Page) -> None:
    group = ET.SubElement(svg, "g", id="legend")
    x, y = _MARGIN, page.height - 34
    for name, colour in EDGE_COLOURS.items():
        line = ET.SubElement(group, "line", x1=_px(x), y1=_px(y), x2=_px(x + 34), y2=_px(y), stroke=colour)
        line.set("stroke-width", "3")
        _text(group, name, x + 42, y + 4.5, 13)
        x += 42 + 7.4 * len(name) + 24


def _scale_bar(svg: ET.Element, page: _Page, unit: str) -> None:
    """A bar of 1, 2 or 5 times a power of ten, at the right of the legend."""
    longest = 200 / page.scale
    power = 10.0 ** math.floor(math.log10(longest))
    length = max(step * power for step in (1, 2, 5) if step * power <= longest)
    right, y = page.width - _MARGIN, page.height - 34
    left = right - length * page.scale
    group = ET.SubElement(svg, "g", id="scale-bar", stroke=INK, fill="none")
    group.set("stroke-width", "1.5")
    ET.SubElement(group, "path", d=f"M{_px(left)} {_px(y - 5)}V{_px(y)}H{_px(right)}V{_px(y - 5)}")
    words = f"{length:g} {unit}" if unit != "unit" else f"{length:g} units"
    label = _text(group, words, (left + right) / 2, y - 8, 13)
    label.set("stroke", "none")
    label.set("text-anchor", "middle")


def _text(parent: ET.Element, text: str, x: float, y: float, size: float, *, bold: bool = False) -> ET.Element:
    element = ET.SubElement(parent, "text", x=_px(x), y=_px(y), fill=INK)
    element.set("font-size", _px(size))
    if bold:
        element.set("font-weight", "bold")
    element.text = text
    return element


def _px(x: float) -> str:
    return f"{x:.2f}".rstrip("0").rstrip(".")
