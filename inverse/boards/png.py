"""Drawings as PNG of any size, drawn in bands so that large ones need little memory."""

from __future__ import annotations

import io
from functools import cache
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from inverse._types import FloatArray
from inverse.boards import fonts
from inverse.boards.sheet import Area, Item, Sheet, Stroke, Text
from inverse.errors import InputError
from inverse.pictures.colours import rgb

SIZE, LEAST, MOST = 2400, 200, 20000  # pixels of the longer side
_FINER = 4  # every pixel is the mean of this many squared
_BAND = 256  # rows of pixels at a time


def png(sheet: Sheet, size: int = SIZE) -> bytes:
    """The content of a PNG file.

    Args:
        sheet: the drawing.
        size: pixels of its longer side.

    Raises:
        InputError: a size that cannot be.
    """
    check_size(size)
    pixels = size / max(sheet.width, sheet.height)
    width, height = (max(1, round(side * pixels)) for side in (sheet.width, sheet.height))
    fine = pixels * _FINER
    boxes = [_box(item) for item in sheet.items]
    picture = Image.new("RGB", (width, height), "white")
    for top in range(0, height, _BAND):
        rows = min(_BAND, height - top)
        band = Image.new("RGB", (width * _FINER, rows * _FINER), "white")
        high, low = sheet.height - top / pixels, sheet.height - (top + rows) / pixels
        pen = ImageDraw.Draw(band)
        for item, (bottom, up) in zip(sheet.items, boxes, strict=True):
            if up >= low and bottom <= high:
                _draw(band, pen, item, fine, np.array([0.0, high]))
        picture.paste(band.resize((width, rows), Image.Resampling.BOX), (0, top))
    stream = io.BytesIO()
    dots = round(pixels * 25.4)
    picture.save(stream, "PNG", dpi=(dots, dots), compress_level=6)
    return stream.getvalue()


def check_size(size: int) -> None:
    """Refuse a number of pixels that cannot be.

    Raises:
        InputError: it says what can.
    """
    if not LEAST <= size <= MOST:
        raise InputError(f"a picture of {size} pixels: from {LEAST} to {MOST} are possible", hint="Change --size.")


def _box(item: Item) -> tuple[float, float]:
    """Lowest and highest y of an item, with room for pens and letters."""
    if isinstance(item, Text):
        reach = item.size * (len(item.words) + 1) if item.turned else 1.5 * item.size
        return item.place[1] - reach, item.place[1] + reach
    parts = item.rings if isinstance(item, Area) else item.lines
    if not parts:
        return np.inf, -np.inf
    width = item.pen.width if isinstance(item, Stroke) else 0.0
    return min(float(p[:, 1].min()) for p in parts) - width, max(float(p[:, 1].max()) for p in parts) + width


def _draw(band: Image.Image, pen: ImageDraw.ImageDraw, item: Item, fine: float, corner: FloatArray) -> None:
    """Draw an item on a band whose upper left corner is ``corner`` in mm, with ``fine`` dots in a mm."""

    def dots(points: FloatArray) -> list[tuple[float, float]]:
        return [(x, y) for x, y in ((points - corner) * [fine, -fine]).tolist()]

    if isinstance(item, Area):
        rings = [dots(ring) for ring in item.rings]
        if len(rings) == 1:
            pen.polygon(rings[0], fill=item.fill, outline=item.fill)
        else:
            mask = Image.new("1", band.size)
            stencil = ImageDraw.Draw(mask)
            stencil.polygon(rings[0], fill=1, outline=1)
            for hole in rings[1:]:
                stencil.polygon(hole, fill=0)
            band.paste(tuple(rgb(item.fill).tolist()), mask=mask)
    elif isinstance(item, Stroke):
        width = max(1, round(item.pen.width * fine))
        lines = item.lines if not item.pen.dash else [d for one in item.lines for d in _dashes(one, item.pen.dash)]
        for points in lines:
            path = dots(points)
            pen.line(path, fill=item.pen.colour, width=width, joint="curve" if width > 2 else None)
            if width > 4:  # round ends, as in the other files
                r = (width - 1) / 2
                for x, y in (path[0], path[-1]):
                    pen.ellipse((x - r, y - r, x + r, y + r), fill=item.pen.colour)
    else:
        _write(band, pen, item, fine, dots(np.array([item.place]))[0])


def _write(band: Image.Image, pen: ImageDraw.ImageDraw, text: Text, fine: float, place: tuple[float, float]) -> None:
    font = _font(max(1, round(text.size * fonts.SMALLER[text.bold] * fine)), text.bold)
    words = fonts.in_vera(text.words)
    anchor = {"start": "ls", "middle": "ms", "end": "rs"}[text.align]
    if not text.turned:
        pen.text(place, words, fill=text.colour, font=font, anchor=anchor)
        return
    left, top, right, bottom = font.getbbox(words, anchor=anchor)
    room = 4
    mask = Image.new("L", (round(right - left) + 2 * room, round(bottom - top) + 2 * room))
    ImageDraw.Draw(mask).text((room - left, room - top), words, 255, font, anchor)
    turned = mask.transpose(Image.Transpose.ROTATE_90)
    corner = round(place[0] + top - room), round(place[1] - right - room)
    band.paste(text.colour, (*corner, corner[0] + turned.width, corner[1] + turned.height), turned)


def _dashes(points: FloatArray, dash: tuple[float, ...]) -> list[FloatArray]:
    """The parts of a polyline that a dashed pen draws."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    along = np.concatenate([[0.0], np.cumsum(steps)])
    period = dash if len(dash) % 2 == 0 else dash * 2
    ends = np.concatenate([[0.0], np.cumsum(period)])
    found = []
    for start in np.arange(0.0, along[-1], ends[-1]):
        for a, b in zip(start + ends[:-1:2], start + ends[1::2], strict=True):
            if a < along[-1]:
                stops = [a, *along[(along > a) & (along < b)], min(b, along[-1])]
                found.append(np.stack([np.interp(stops, along, points[:, k]) for k in (0, 1)], axis=1))
    return found


@cache
def _font(size: int, bold: bool) -> Any:
    return ImageFont.truetype(str(fonts.vera(bold=bold)), size)
