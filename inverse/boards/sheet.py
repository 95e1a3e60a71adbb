"""A drawing on paper: areas, lines and words in millimetres, whatever file it is written to."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from inverse._types import FloatArray
from inverse.errors import InputError
from inverse.words import did_you_mean

INK, GREY, PALE = "#1d1d1b", "#8b8a86", "#c9c7c1"
# Short and long side in mm.
PAPERS = {
    "A0": (841.0, 1189.0),
    "A1": (594.0, 841.0),
    "A2": (420.0, 594.0),
    "A3": (297.0, 420.0),
    "A4": (210.0, 297.0),
}


@dataclass(frozen=True)
class Pen:
    """How a line is drawn.

    Attributes:
        width: in mm.
        colour: as #rrggbb.
        dash: lengths in mm of dashes and gaps in turn; none for a full line.
    """

    width: float
    colour: str = INK
    dash: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class Area:
    """A polygon of one colour.

    Attributes:
        rings: the outer ring and then the holes, each (n, 2), the last point not repeated.
        fill: its colour as #rrggbb.
    """

    rings: tuple[FloatArray, ...]
    fill: str


@dataclass(frozen=True, eq=False)
class Stroke:
    """Lines of one pen.

    Attributes:
        lines: polylines, each (n, 2); closed ones end where they begin.
        pen: what they are drawn with.
    """

    lines: tuple[FloatArray, ...]
    pen: Pen


@dataclass(frozen=True, eq=False)
class Text:
    """A line of words.

    Attributes:
        words: what is written.
        place: (x, y) of the beginning, middle or end of the base line.
        size: of the font in mm; capitals are 0.72 of it high.
        align: which of these it is.
        turned: a quarter turn counter-clockwise, to be read from the right.
        bold: whether the font is.
        colour: as #rrggbb.
    """

    words: str
    place: tuple[float, float]
    size: float
    align: Literal["start", "middle", "end"] = "start"
    turned: bool = False
    bold: bool = False
    colour: str = INK


Item = Area | Stroke | Text


@dataclass(eq=False)
class Sheet:
    """A page.

    Attributes:
        width: in mm.
        height: in mm.
        title: of the file.
        items: what is drawn, the first one lowest; y goes up from the lower left corner.
    """

    width: float
    height: float
    title: str
    items: list[Item] = field(default_factory=list)


def line(*points: Sequence[float], pen: Pen) -> Stroke:
    """One polyline through points (x, y)."""
    return Stroke((np.array(points, np.float64),), pen)


def box(low: Sequence[float], high: Sequence[float], pen: Pen) -> Stroke:
    """The outline of a rectangle."""
    (x, y), (right, top) = low, high
    return line((x, y), (right, y), (right, top), (x, top), (x, y), pen=pen)


def moved(items: Iterable[Item], scale: float, shift: FloatArray, weight: float = 1.0) -> list[Item]:
    """The same drawing elsewhere: p -> scale p + shift, pens being ``weight`` times as wide. Words keep their size."""
    found: list[Item] = []
    for item in items:
        if isinstance(item, Area):
            found.append(replace(item, rings=tuple(ring * scale + shift for ring in item.rings)))
        elif isinstance(item, Stroke):
            pen = replace(item.pen, width=item.pen.width * weight)
            found.append(Stroke(tuple(points * scale + shift for points in item.lines), pen))
        else:
            x, y = item.place
            found.append(replace(item, place=(float(x * scale + shift[0]), float(y * scale + shift[1]))))
    return found


def paper_size(name: str) -> tuple[float, float]:
    """Width and height in mm of a paper that lies.

    Raises:
        InputError: there is no such paper.
    """
    known = {paper.lower(): paper for paper in PAPERS}
    if name.lower() not in known:
        raise InputError(
            f"{name!r} is no paper: there are {', '.join(PAPERS)}.{did_you_mean(name, PAPERS)}",
            hint="Give one of them as --paper.",
        )
    short, long = PAPERS[known[name.lower()]]
    return long, short
