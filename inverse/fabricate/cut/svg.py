"""Drawings as SVG: millimetres, one group per layer."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np

from inverse.fabricate.cut.plan import LAYERS, Plan

STROKE = 0.1  # mm
_INKSCAPE = "http://www.inkscape.org/namespaces/inkscape"


def svg(plan: Plan) -> bytes:
    """The content of an SVG file, true to scale; coordinates keep every bit.

    Args:
        plan: the drawing.
    """
    width, height = plan.size
    root = ET.Element("svg")
    root.set("xmlns", "http://www.w3.org/2000/svg")
    root.set("xmlns:inkscape", _INKSCAPE)
    root.set("width", f"{width!r}mm")
    root.set("height", f"{height!r}mm")
    root.set("viewBox", f"0 0 {width!r} {height!r}")
    ET.SubElement(root, "title").text = plan.title
    for layer, colour in LAYERS.items():
        lines = [line for line in plan.lines if line.layer == layer]
        texts = [text for text in plan.texts if text.layer == layer]
        if not lines and not texts:
            continue
        group = ET.SubElement(root, "g", {"id": layer.replace(" ", "-")})
        group.set("inkscape:groupmode", "layer")
        group.set("inkscape:label", layer)
        for line in lines:
            (x1, y1), (x2, y2) = line.ends.tolist()
            places = {"x1": x1, "y1": height - y1, "x2": x2, "y2": height - y2}
            stroke = {"stroke": colour, "stroke-width": str(STROKE), "stroke-linecap": "round"}
            ET.SubElement(group, "line", {key: repr(value) for key, value in places.items()} | stroke)
        for text in texts:
            x, y = text.place.tolist()
            element = ET.SubElement(group, "text")
            turn = -np.degrees(text.angle)
            element.set("transform", f"translate({x!r} {height - y!r}) rotate({turn:.6g})")
            # Capitals are 0.7 of the font's size high, and stand on the base line.
            element.set("y", f"{text.height / 2:.6g}")
            element.set("font-size", f"{text.height / 0.7:.6g}")
            element.set("font-family", "sans-serif")
            element.set("text-anchor", "middle")
            element.set("fill", colour)
            element.text = text.words
    return (ET.tostring(root, encoding="unicode") + "\n").encode()
