"""Flat drawings with lines, dots and words, as SVG and as PNG from the same list of marks."""

from __future__ import annotations

import io
import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from inverse._types import FloatArray
from inverse.pictures.colours import INK

OVERSAMPLING = 2  # every pixel of the PNG is the mean of this many squared


@dataclass(frozen=True, eq=False)
class Line:
    """A polyline, or an area where it is filled.

    Attributes:
        points: (n, 2) pixels from the upper left corner.
        colour: of the line, #rrggbb; empty for none.
        width: in pixels.
        fill: colour of the area; empty for none.
        dash: length of dashes in pixels, 0 for a whole line.
    """

    points: FloatArray
    colour: str
    width: float = 1.0
    fill: str = ""
    dash: float = 0.0


@dataclass(frozen=True, eq=False)
class Dot:
    """A disc.

    Attributes:
        at: (2,) pixels.
        radius: in pixels.
        fill: colour inside.
        colour: of its rim.
    """

    at: FloatArray
    radius: float
    fill: str
    colour: str = INK


@dataclass(frozen=True, eq=False)
class Word:
    """A text, centred on its place or beginning there.

    Attributes:
        text: what it says.
        at: (2,) pixels, at half the height of the letters.
        size: of the letters in pixels.
        colour: its colour.
        is_centred: or begins at its place.
        is_bold: for names.
    """

    text: str
    at: FloatArray
    size: float
    colour: str = INK
    is_centred: bool = True
    is_bold: bool = False


Mark = Line | Dot | Word


@dataclass(eq=False)
class Drawing:
    """A page.

    Attributes:
        title: of the page.
        width: in pixels.
        height: in pixels.
        marks: what is on it, the lowest first.
    """

    title: str
    width: int
    height: int
    marks: list[Mark] = field(default_factory=list)

    def svg(self) -> str:
        """The page as SVG; the same page gives the same text."""
        root = ET.Element(
            "svg", xmlns="http://www.w3.org/2000/svg", width=str(self.width), height=str(self.height),
            viewBox=f"0 0 {self.width} {self.height}",
        )  # fmt: skip
        root.set("font-family", "Helvetica, Arial, sans-serif")
        ET.SubElement(root, "title").text = self.title
        ET.SubElement(root, "rect", width="100%", height="100%", fill="#ffffff")
        for mark in self.marks:
            _svg_mark(root, mark)
        ET.indent(root, " ")
        return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"

    def png(self) -> bytes:
        """The page as PNG."""
        size = OVERSAMPLING * self.width, OVERSAMPLING * self.height
        image = Image.new("RGB", size, "#ffffff")
        pen = ImageDraw.Draw(image)
        for mark in self.marks:
            _png_mark(pen, mark)
        out = io.BytesIO()
        image.resize((self.width, self.height), Image.Resampling.BOX).save(out, "PNG")
        return out.getvalue()


def _svg_mark(root: ET.Element, mark: Mark) -> None:
    if isinstance(mark, Line):
        path = " ".join(f"{_px(x)},{_px(y)}" for x, y in mark.points.tolist())
        element = ET.SubElement(root, "polyline", points=path, fill=mark.fill or "none")
        if mark.colour:
            element.set("stroke", mark.colour)
            element.set("stroke-width", _px(mark.width))
            element.set("stroke-linecap", "butt" if mark.dash else "round")
        if mark.dash:
            element.set("stroke-dasharray", _px(mark.dash))
    elif isinstance(mark, Dot):
        x, y = mark.at.tolist()
        ET.SubElement(
            root, "circle", cx=_px(x), cy=_px(y), r=_px(mark.radius), fill=mark.fill, stroke=mark.colour
        )  # fmt: skip
    else:
        x, y = mark.at.tolist()
        element = ET.SubElement(root, "text", x=_px(x), y=_px(y + 0.36 * mark.size), fill=mark.colour)
        element.set("font-size", _px(mark.size))
        if mark.is_centred:
            element.set("text-anchor", "middle")
        if mark.is_bold:
            element.set("font-weight", "bold")
        element.text = mark.text


def _png_mark(pen: ImageDraw.ImageDraw, mark: Mark) -> None:
    k = OVERSAMPLING
    if isinstance(mark, Line):
        points = [(k * x, k * y) for x, y in mark.points.tolist()]
        if mark.fill:
            pen.polygon(points, fill=mark.fill)
        if mark.colour:
            width = max(1, round(k * mark.width))
            for part in _dashes(mark) if mark.dash else [mark.points]:
                pen.line([(k * x, k * y) for x, y in part.tolist()], fill=mark.colour, width=width, joint="curve")
    elif isinstance(mark, Dot):
        (x, y), r = (k * mark.at).tolist(), k * mark.radius
        pen.ellipse((x - r, y - r, x + r, y + r), fill=mark.fill, outline=mark.colour, width=k)
    else:
        x, y = (k * mark.at).tolist()
        font = ImageFont.load_default(k * mark.size)
        pen.text(
            (x, y), mark.text, fill=mark.colour, font=font, anchor="mm" if mark.is_centred else "lm",
            stroke_width=k // 2 if mark.is_bold else 0,
        )  # fmt: skip


def _dashes(line: Line) -> list[FloatArray]:
    """The drawn parts of a dashed line, which begin anew at every corner."""
    found: list[FloatArray] = []
    for a, b in zip(line.points[:-1], line.points[1:], strict=True):
        length = float(np.linalg.norm(b - a))
        for start in np.arange(0.0, length, 2 * line.dash):
            end = min(start + line.dash, length)
            found.append(np.stack([a + start / length * (b - a), a + end / length * (b - a)]))
    return found


def scale_bar(longest: float) -> float:
    """A length of 1, 2 or 5 times a power of ten, at most the longest."""
    power = 10.0 ** math.floor(math.log10(longest))
    return max(step * power for step in (1, 2, 5) if step * power <= longest)


def wrapped(words: Sequence[str], width: int) -> list[str]:
    """Words joined by commas in lines of at most so many letters."""
    lines = [""]
    for word in words:
        if lines[-1] and len(lines[-1]) + len(word) + 2 > width:
            lines[-1] += ","
            lines.append(word)
        else:
            lines[-1] += f", {word}" if lines[-1] else word
    return lines


def _px(x: float) -> str:
    text = f"{x:.2f}"
    return text.rstrip("0").rstrip(".") if "." in text else text
