"""Drawings as PDF, true to scale, on as many sheets of paper as they need."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from inverse._types import FloatArray
from inverse.fabricate.cut.pages import EDGE, FOOT, Page, Placed, ends_of, laid_out, meets, paper_size, room_of
from inverse.fabricate.cut.plan import LAYERS, Line, Plan, Text
from inverse.fabricate.extras import needed
from inverse.pictures.colours import INK, rgb

BAR = 100.0  # mm
WIDTH = 0.2  # mm, of lines
_POINT = 72 / 25.4  # points in a millimetre
_WORDS = 2.6  # mm, size of the words at the foot
_LONGEST = 40  # letters of a title
_RUNS = 6  # numbers of pieces, or of runs of them, that a page has room to name
_MEANINGS = {"flap": "flap: cut, fold and glue", "label": ""}  # of layers whose names do not say it


def pdf(plan: Plan, paper: str = "A4") -> bytes:
    """The content of a PDF file: pages that stand, each with a scale bar, the model's scale and a legend.

    Args:
        plan: the drawing.
        paper: a word of :data:`inverse.fabricate.cut.pages.PAPERS`.

    Raises:
        InputError: an unknown paper, a drawing that needs too many pages; reportlab is missing.
    """
    canvases: Any = needed("reportlab.pdfgen.canvas")
    pages, (width, height), room = laid_out(plan, paper), paper_size(paper), room_of(paper)
    stream = io.BytesIO()
    canvas = canvases.Canvas(stream, pagesize=(width * _POINT, height * _POINT), invariant=1)
    canvas.setTitle(plan.title)
    canvas.setCreator("inverse")
    ends, owner = ends_of(plan), np.array([line.piece for line in plan.lines])
    pieces = int(owner.max()) + 1
    title = plan.title if len(plan.title) <= _LONGEST else f"{plan.title[: _LONGEST - 3]}..."
    for number, page in enumerate(pages, 1):
        canvas.scale(_POINT, _POINT)
        words = f"{title}, {_shown(page, pieces)}, page {number} of {len(pages)}"
        _foot(canvas, plan, room, words)
        if not page.is_whole:
            _marks(canvas, room)
            _map(canvas, page, room)
        for placed in page.placed:
            canvas.saveState()
            clip = canvas.beginPath()
            clip.rect(EDGE, EDGE + FOOT, *room)
            canvas.clipPath(clip, stroke=0, fill=0)
            lines = np.flatnonzero(owner == placed.piece)
            inside = meets(ends[lines] @ placed.turn.T + placed.shift, np.full(2, -WIDTH), room + WIDTH)
            _draw(canvas, placed, [plan.lines[k] for k in lines[inside]], _near(plan, placed, room))
            canvas.restoreState()
        canvas.showPage()
    canvas.save()
    return stream.getvalue()


def _shown(page: Page, pieces: int) -> str:
    """Which pieces a page shows, or which part of one, counted from 1 on."""
    numbers = sorted(placed.piece + 1 for placed in page.placed)
    if not page.is_whole:
        return f"piece {numbers[0]} of {pieces}, part {page.part_name}"
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    if len(runs) > _RUNS:
        return f"{len(numbers)} pieces of {pieces}"
    words = ", ".join(f"{run[0]} to {run[-1]}" if len(run) > 1 else str(run[0]) for run in runs)
    return f"piece{'s' if len(numbers) > 1 else ''} {words} of {pieces}"


def _near(plan: Plan, placed: Placed, room: FloatArray) -> list[Text]:
    """Words of a piece that reach into the room of a page."""
    found = []
    for text in plan.texts:
        if text.piece == placed.piece:
            place = placed.turn @ text.place + placed.shift
            reach = text.height * (len(text.words) + 1)  # twice what digits need
            if ((place > -reach) & (place < room + reach)).all():
                found.append(text)
    return found


def _foot(canvas: Any, plan: Plan, room: FloatArray, words: str) -> None:
    """Scale bar, words and legend below the drawing."""
    ink = rgb(INK) / 255
    canvas.setStrokeColorRGB(*ink)
    canvas.setFillColorRGB(*ink)
    canvas.setLineWidth(0.3)
    bar = min(BAR, 10 * np.floor(room[0] / 10))
    canvas.line(EDGE, EDGE + 2, EDGE + bar, EDGE + 2)
    for k in range(int(bar / 10) + 1):
        canvas.line(EDGE + 10 * k, EDGE + 1, EDGE + 10 * k, EDGE + 3)
    canvas.setFont("Helvetica", _WORDS)
    model = f"Model {plan.scale}.  " if plan.scale else ""
    canvas.drawString(EDGE, EDGE + 4.5, f"{bar:g} mm, printed true to scale.  {model}{words}")
    _legend(canvas, {line.layer for line in plan.lines}, room)


def _legend(canvas: Any, layers: set[str], room: FloatArray) -> None:
    """A piece of every kind of line that the drawing has, and what it means; in two rows where the page is narrow."""
    x, y = EDGE, EDGE + 9.5
    for layer, colour in LAYERS.items():
        words = _MEANINGS.get(layer, layer)
        if layer not in layers or not words:
            continue
        width = 8 + 1.5 + canvas.stringWidth(words, "Helvetica", _WORDS) + 4
        if x + width > EDGE + room[0] and x > EDGE:
            x, y = EDGE, y + 4
        canvas.setStrokeColorRGB(*(rgb(colour) / 255))
        canvas.setLineWidth(0.5)
        canvas.line(x, y + 0.9, x + 8, y + 0.9)
        canvas.drawString(x + 9.5, y, words)
        x += width


def _marks(canvas: Any, room: FloatArray) -> None:
    """Corners of what a page shows of a piece, to lay its neighbours over."""
    canvas.setStrokeColorRGB(*(rgb(INK) / 255))
    canvas.setLineWidth(0.1)
    for x, out in ((EDGE, -1), (EDGE + room[0], 1)):
        for y, up in ((EDGE + FOOT, -1), (EDGE + FOOT + room[1], 1)):
            canvas.line(x, y, x + 4 * out, y)
            canvas.line(x, y, x, y + 4 * up)


def _map(canvas: Any, page: Page, room: FloatArray) -> None:
    """All parts of a piece in small, this one filled."""
    columns, rows = page.parts
    size = min(30 / columns / room[0], 7 / rows / room[1]) * room
    left, bottom = EDGE + room[0] - columns * size[0], EDGE
    canvas.setLineWidth(0.1)
    canvas.setFillGray(0.8)
    canvas.rect(left + page.part[0] * size[0], bottom + page.part[1] * size[1], *size, stroke=0, fill=1)
    for column in range(columns):
        for row in range(rows):
            canvas.rect(left + column * size[0], bottom + row * size[1], *size)


def _draw(canvas: Any, placed: Placed, lines: Sequence[Line], texts: Sequence[Text]) -> None:
    (a, b), (c, d) = placed.turn.T.tolist()
    x, y = placed.shift.tolist()
    canvas.transform(a, b, c, d, EDGE + x, EDGE + FOOT + y)
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
