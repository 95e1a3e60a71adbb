"""Drawings as PDF at 1 : 1, on as many sheets of paper as they need."""

from __future__ import annotations

import io
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from inverse._types import FloatArray
from inverse.errors import InputError
from inverse.fabricate.cut.plan import LAYERS, Line, Plan, Text
from inverse.fabricate.extras import needed
from inverse.pictures.colours import INK, rgb
from inverse.words import did_you_mean

# Width and height in mm.
PAPERS = {
    "A0": (841.0, 1189.0),
    "A1": (594.0, 841.0),
    "A2": (420.0, 594.0),
    "A3": (297.0, 420.0),
    "A4": (210.0, 297.0),
    "letter": (215.9, 279.4),
    "tabloid": (279.4, 431.8),
}
EDGE = 10.0  # mm at every side that printers do not reach
FOOT = 14.0  # mm below the drawing for scale bar and words
OVERLAP = 10.0  # mm that neighbouring tiles have in common
BAR = 100.0  # mm
MOST_PAGES = 500
WIDTH = 0.2  # mm, of lines
_POINT = 72 / 25.4  # points in a millimetre


@dataclass(frozen=True)
class Tile:
    """A part of the drawing that one page shows.

    Attributes:
        name: column and row, such as B2; A1 is the lower left one.
        corner: lower left corner in the drawing, mm.
        size: width and height in mm.
    """

    name: str
    corner: tuple[float, float]
    size: tuple[float, float]


def pdf(plan: Plan, paper: str = "A4") -> bytes:
    """The content of a PDF file: tiles that overlap, each with marks at its corners, its name and a scale bar.

    Args:
        plan: the drawing.
        paper: a word of :data:`PAPERS`; pages lie or stand, whichever needs fewer.

    Raises:
        InputError: an unknown paper, a drawing that needs too many pages; reportlab is missing.
    """
    canvases: Any = needed("reportlab.pdfgen.canvas")
    page, shown = tiles(plan, paper)
    stream = io.BytesIO()
    canvas = canvases.Canvas(stream, pagesize=(page[0] * _POINT, page[1] * _POINT), invariant=1)
    canvas.setTitle(plan.title)
    canvas.setCreator("inverse")
    ends, rooms = _ends(plan), np.array([_room(text) for text in plan.texts]).reshape(-1, 2, 2)
    for number, tile in enumerate(shown, 1):
        canvas.scale(_POINT, _POINT)
        _frame(canvas, plan, tile, f"{plan.title}, tile {tile.name}, page {number} of {len(shown)}")
        canvas.saveState()
        clip = canvas.beginPath()
        clip.rect(EDGE, EDGE + FOOT, *tile.size)
        canvas.clipPath(clip, stroke=0, fill=0)
        canvas.translate(EDGE - tile.corner[0], EDGE + FOOT - tile.corner[1])
        low, high = np.array(tile.corner) - WIDTH, np.array(tile.corner) + tile.size + WIDTH
        lines = [plan.lines[k] for k in np.flatnonzero(_meets(ends, low, high))]
        near = ((rooms[:, 0] <= high) & (rooms[:, 1] >= low)).all(axis=1)
        _draw(canvas, lines, [plan.texts[k] for k in np.flatnonzero(near)])
        canvas.restoreState()
        canvas.showPage()
    canvas.save()
    return stream.getvalue()


def tiles(plan: Plan, paper: str) -> tuple[tuple[float, float], list[Tile]]:
    """The size of pages in mm, and the tiles; those without a line are left out.

    Raises:
        InputError: an unknown paper, or too many pages.
    """
    if paper not in PAPERS:
        known = ", ".join(PAPERS)
        raise InputError(f"{paper!r} is no paper: there are {known}.{did_you_mean(paper, PAPERS)}")
    low, high = PAPERS[paper]
    found = min((_tiled(plan, page) for page in ((low, high), (high, low))), key=lambda one: one[1].prod())
    page, counts, room = found
    if counts.prod() > MOST_PAGES:
        raise InputError(
            f"a drawing of {plan.size[0]:.0f} x {plan.size[1]:.0f} mm needs {counts.prod()} pages of {paper}: at most"
            f" {MOST_PAGES} are made",
            hint="Choose a larger paper, or a smaller scale.",
        )
    ends = _ends(plan)
    shown = []
    for row in range(counts[1]):
        for column in range(counts[0]):
            corner = np.array([column, row]) * (room - OVERLAP)
            if _meets(ends, corner, corner + room).any():
                name = f"{_letters(column)}{row + 1}"
                shown.append(Tile(name, (float(corner[0]), float(corner[1])), (float(room[0]), float(room[1]))))
    return page, shown


def _tiled(plan: Plan, page: tuple[float, float]) -> tuple[tuple[float, float], Any, FloatArray]:
    room = np.array(page) - 2 * EDGE - [0.0, FOOT]
    counts = np.maximum(np.ceil((np.array(plan.size) - OVERLAP) / (room - OVERLAP)), 1).astype(int)
    return page, counts, room


def _ends(plan: Plan) -> FloatArray:
    """Ends (N, 2, 2) of all lines."""
    return np.array([line.ends for line in plan.lines])


def _room(text: Text) -> FloatArray:
    """Lower left and upper right corner (2, 2) of a square around a word, however it is turned."""
    reach = text.height * (len(text.words) + 1)  # twice what digits need
    return np.array([text.place - reach, text.place + reach])


def _meets(ends: FloatArray, low: FloatArray, high: FloatArray) -> NDArray[np.bool_]:
    """Which lines (N, 2, 2) have a point in a rectangle, (N,)."""
    start, along = ends[:, 0], ends[:, 1] - ends[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        first, last = (low - start) / along, (high - start) / along
    # Parallel to a side: anywhere along it if within, else nowhere.
    within = (start >= low) & (start <= high)
    enter = np.where(along == 0, np.where(within, -np.inf, np.inf), np.minimum(first, last)).max(axis=1)
    leave = np.where(along == 0, np.where(within, np.inf, -np.inf), np.maximum(first, last)).min(axis=1)
    return np.asarray(np.maximum(enter, 0) <= np.minimum(leave, 1))


def _letters(column: int) -> str:
    """A to Z, then AA, AB, ..."""
    head, last = divmod(column, 26)
    return (_letters(head - 1) if head else "") + chr(ord("A") + last)


def _frame(canvas: Any, plan: Plan, tile: Tile, words: str) -> None:
    """What surrounds the drawing: corner marks, scale bar, words, and where the tile lies in the whole."""
    ink = rgb(INK) / 255
    canvas.setStrokeColorRGB(*ink)
    canvas.setFillColorRGB(*ink)
    canvas.setLineWidth(0.1)
    low, (width, height) = (EDGE, EDGE + FOOT), tile.size
    for x, out in ((low[0], -1), (low[0] + width, 1)):
        for y, up in ((low[1], -1), (low[1] + height, 1)):
            canvas.line(x, y, x + 4 * out, y)
            canvas.line(x, y, x, y + 4 * up)
    canvas.setLineWidth(0.3)
    bar = min(BAR, 10 * np.floor(width / 10))
    canvas.line(EDGE, EDGE + 2, EDGE + bar, EDGE + 2)
    for k in range(int(bar / 10) + 1):
        canvas.line(EDGE + 10 * k, EDGE + 1, EDGE + 10 * k, EDGE + 3)
    canvas.setFont("Helvetica", 3)
    canvas.drawString(EDGE, EDGE + 4.5, f"{bar:g} mm at 1 : 1.  {words}")
    # The whole in small, this tile filled.
    scale = min(30 / plan.size[0], 10 / plan.size[1])
    left, bottom = EDGE + width - scale * plan.size[0], EDGE
    canvas.setLineWidth(0.1)
    canvas.rect(left, bottom, scale * plan.size[0], scale * plan.size[1])
    part = np.minimum(np.array(tile.corner) + tile.size, plan.size) - tile.corner
    canvas.setFillGray(0.8)
    canvas.rect(left + scale * tile.corner[0], bottom + scale * tile.corner[1], *(scale * part), stroke=0, fill=1)


def _draw(canvas: Any, lines: list[Line], texts: list[Text]) -> None:
    canvas.setLineCap(1)
    for layer, colour in LAYERS.items():
        shade = rgb(colour) / 255
        canvas.setStrokeColorRGB(*shade)
        canvas.setFillColorRGB(*shade)
        canvas.setLineWidth(WIDTH)
        for line in lines:
            if line.layer == layer:
                canvas.line(*line.ends.ravel().tolist())
        for text in texts:
            if text.layer == layer:
                canvas.saveState()
                canvas.translate(*text.place.tolist())
                canvas.rotate(float(np.degrees(text.angle)))
                canvas.setFont("Helvetica", text.height / 0.72)  # whose capitals are 0.72 of its size high
                canvas.drawCentredString(0, -text.height / 2, text.words)
                canvas.restoreState()
