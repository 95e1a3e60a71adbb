"""Drawings as SVG, in millimetres."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from inverse._types import FloatArray
from inverse.boards.sheet import Area, Sheet, Stroke, Text

SEAM = 0.04  # mm: areas are drawn so much larger that no white shows between neighbours


def svg(sheet: Sheet) -> bytes:
    """The content of an SVG file.

    Args:
        sheet: the drawing.
    """
    root = ET.Element("svg", xmlns="http://www.w3.org/2000/svg")
    root.set("width", f"{sheet.width:g}mm")
    root.set("height", f"{sheet.height:g}mm")
    root.set("viewBox", f"0 0 {sheet.width:g} {sheet.height:g}")
    root.set("font-family", "Helvetica, Arial, sans-serif")
    root.set("stroke-linecap", "round")
    root.set("stroke-linejoin", "round")
    ET.SubElement(root, "title").text = sheet.title
    ET.SubElement(root, "rect", width="100%", height="100%", fill="#ffffff")
    for item in sheet.items:
        if isinstance(item, Area):
            area = ET.SubElement(root, "path", d="".join(_path(ring, sheet.height) + "Z" for ring in item.rings))
            area.attrib |= {"fill": item.fill, "fill-rule": "evenodd", "stroke": item.fill, "stroke-width": str(SEAM)}
        elif isinstance(item, Stroke):
            if not item.lines:
                continue
            path = ET.SubElement(root, "path", d="".join(_path(points, sheet.height) for points in item.lines))
            path.attrib |= {"fill": "none", "stroke": item.pen.colour, "stroke-width": f"{item.pen.width:.3f}"}
            if item.pen.dash:
                path.set("stroke-dasharray", " ".join(f"{length:g}" for length in item.pen.dash))
        else:
            _write(root, item, sheet.height)
    ET.indent(root, "")
    return ('<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n").encode()


def _path(points: FloatArray, height: float) -> str:
    return "M" + "L".join(f"{x:.3f} {height - y:.3f}" for x, y in points.tolist())


def _write(root: ET.Element, text: Text, height: float) -> None:
    x, y = text.place
    element = ET.SubElement(root, "text", fill=text.colour)
    turn = " rotate(-90)" if text.turned else ""
    element.set("transform", f"translate({x:.3f} {height - y:.3f}){turn}")
    element.set("font-size", f"{text.size:.3f}")
    if text.align != "start":
        element.set("text-anchor", text.align)
    if text.bold:
        element.set("font-weight", "bold")
    element.text = text.words
