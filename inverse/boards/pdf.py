"""Drawings as PDF, one page each, true to scale."""

from __future__ import annotations

import io
from typing import Any

from inverse.boards import fonts
from inverse.boards.sheet import Area, Sheet, Stroke, Text
from inverse.boards.svg import SEAM
from inverse.fabricate.extras import needed

POINT = 72 / 25.4  # points in a millimetre


def pdf(sheet: Sheet) -> bytes:
    """The content of a PDF file; the same drawing gives the same bytes.

    Args:
        sheet: the drawing.

    Raises:
        InputError: reportlab is missing.
    """
    stream = io.BytesIO()
    canvas = needed("reportlab.pdfgen.canvas").Canvas(
        stream, pagesize=(sheet.width * POINT, sheet.height * POINT), invariant=1, pageCompression=1
    )
    canvas.setTitle(sheet.title)
    canvas.setCreator("inverse")
    canvas.scale(POINT, POINT)
    canvas.setLineCap(1)
    canvas.setLineJoin(1)
    for item in sheet.items:
        if isinstance(item, Area):
            _fill(canvas, item)
        elif isinstance(item, Stroke):
            _stroke(canvas, item)
        else:
            _write(canvas, item)
    canvas.showPage()
    canvas.save()
    return stream.getvalue()


def _fill(canvas: Any, area: Area) -> None:
    path = canvas.beginPath()
    for ring in area.rings:
        _follow(path, ring.tolist())
        path.close()
    canvas.setFillColor(_colour(area.fill))
    canvas.setStrokeColor(_colour(area.fill))
    canvas.setLineWidth(SEAM)
    canvas.setDash()
    canvas.drawPath(path, stroke=1, fill=1, fillMode=0)


def _stroke(canvas: Any, stroke: Stroke) -> None:
    canvas.setStrokeColor(_colour(stroke.pen.colour))
    canvas.setLineWidth(stroke.pen.width)
    canvas.setDash(list(stroke.pen.dash))
    path = canvas.beginPath()
    for points in stroke.lines:
        _follow(path, points.tolist())
    canvas.drawPath(path, stroke=1, fill=0)


def _write(canvas: Any, text: Text) -> None:
    canvas.setFillColor(_colour(text.colour))
    canvas.saveState()
    canvas.translate(*text.place)
    if text.turned:
        canvas.rotate(90)
    words = text.words
    if fonts.in_helvetica(words):
        canvas.setFont("Helvetica-Bold" if text.bold else "Helvetica", text.size)
    else:
        words = fonts.in_vera(words)
        canvas.setFont(_vera(text.bold), text.size * fonts.SMALLER[text.bold])
    draw = {"start": canvas.drawString, "middle": canvas.drawCentredString, "end": canvas.drawRightString}
    draw[text.align](0, 0, words)
    canvas.restoreState()


def _vera(bold: bool) -> str:
    """The name of a font that is known to reportlab from then on."""
    name = "Vera-Bold" if bold else "Vera"
    metrics, kinds = needed("reportlab.pdfbase.pdfmetrics"), needed("reportlab.pdfbase.ttfonts")
    if name not in metrics.getRegisteredFontNames():
        metrics.registerFont(kinds.TTFont(name, str(fonts.vera(bold=bold))))
    return name


def _follow(path: Any, points: list[list[float]]) -> None:
    path.moveTo(*points[0])
    for point in points[1:]:
        path.lineTo(*point)


def _colour(word: str) -> Any:
    return needed("reportlab.lib.colors").HexColor(word)
