"""One sheet that composes the views: axonometric and plan above, elevations and section, the motion, figures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from inverse._types import FloatArray
from inverse.boards.furniture import SMALL, placed, room_of
from inverse.boards.numbers import figures
from inverse.boards.page import BLOCK, EDGE, INSIDE, Layout, caption_of, fitted, letters_of, title_block
from inverse.boards.picture import Picture
from inverse.boards.scales import ANY, Scale, largest_scale, read_scale
from inverse.boards.sheet import GREY, Item, Pen, Sheet, Text, line, paper_size
from inverse.boards.views import Subject
from inverse.errors import InputError

TRUE = ("plan", "front", "right", "section")  # drawn at one scale
_TITLE = 14.0  # mm above the views for the name, times the size of letters
_GAP = 8.0  # mm between cells, times the same


@dataclass(frozen=True, eq=False)
class _Cell:
    """A place on the sheet for a view: lower left corner and size in mm."""

    low: FloatArray
    size: FloatArray


def board(subject: Subject, layout: Layout) -> Sheet:
    """A sheet with all that a competition asks for.

    Args:
        subject: what is drawn.
        layout: paper, A1 by default, the scale of plan, elevations and section, and a date.

    Raises:
        InputError: a scale or paper that cannot be, or at which the views have no room.
    """
    paper = layout.paper or "A1"
    size = paper_size(paper)
    letters = letters_of(size)
    unit = subject.design.unit
    pictures = {name: subject.picture(name) for name in (*TRUE, "axonometric", "motion")}
    low = letters * np.array([EDGE + INSIDE, EDGE + INSIDE + BLOCK])
    inner = np.array(size) - low - letters * np.array([EDGE + INSIDE, EDGE + INSIDE + _TITLE])
    scale, cells = _arranged(pictures, low, inner, letters, unit, layout.scale, paper)
    sheet = Sheet(*size, f"{subject.design.name}: board {scale.words}")
    sheet.items += fitted(
        subject.design.name or "unnamed", (float(low[0]), float(low[1] + inner[1]) + 4.5 * letters), 11.0 * letters,
        float(inner[0]), bold=True,
    )  # fmt: skip
    for name, picture in pictures.items():
        sheet.items += _in_cell(subject, name, picture, cells[name], scale if name in TRUE else None, letters)
    sheet.items += _figures(subject, cells["figures"], letters)
    sheet.items += title_block(size, letters, subject, "Board", scale.words, paper, layout.date)
    return sheet


def _taken(picture: Picture, factor: float, letters: float) -> FloatArray:
    """Width and height in mm of a view with what surrounds it."""
    room = room_of(picture, letters)
    return factor * (picture.high - picture.low) + [room.left + room.right, room.bottom + room.top]


def _arranged(
    pictures: dict[str, Picture], low: FloatArray, inner: FloatArray, letters: float, unit: str, asked: str | None,
    paper: str,
) -> tuple[Scale, dict[str, _Cell]]:  # fmt: skip
    """The scale of the true views, and a cell for every one.

    Below lies the strip of the motion with the figures beside it. Above it stand the true views in rows, the plan on
    the right of the axonometric, the elevations and the section in a row between.
    """
    gap = letters * _GAP
    strip = pictures["motion"]
    beside = letters * 78.0  # for figures
    motion_factor = (inner[0] - beside - gap - room_of(strip, letters).left * 2) / (strip.high - strip.low)[0]
    motion = float(np.clip(_taken(strip, motion_factor, letters)[1], 0.16 * inner[1], 0.24 * inner[1]))
    motion = max(motion, letters * 50.0)
    rest = inner[1] - motion - 2 * gap
    row = ("front", "right", "section")

    def fits(factor: float) -> bool:
        plan = _taken(pictures["plan"], factor, letters)
        sizes = [_taken(pictures[name], factor, letters) for name in row]
        wide, tall = sum(one[0] for one in sizes) + 2 * gap, max(one[1] for one in sizes)
        return bool(wide <= inner[0] and tall + plan[1] <= rest and plan[0] <= 0.56 * inner[0] and tall <= 0.6 * rest)

    most = _largest(fits, float(inner.max() / (pictures["front"].high - pictures["front"].low).max()))
    if not most:
        raise InputError(f"the board has no room on {paper.upper()}", hint="Choose a larger --paper, up to A0.")
    scale = largest_scale(most, unit)
    if asked is not None:
        scale = read_scale(asked, unit)
        if not fits(scale.factor):
            raise InputError(
                f"at {scale.words} the board has no room on {paper.upper()}",
                hint=f"--scale {largest_scale(most, unit).words} fits on this paper.",
            )
    sizes = {name: _taken(pictures[name], scale.factor, letters) for name in TRUE}
    tall = max(sizes[name][1] for name in row)
    spare = rest - tall - sizes["plan"][1]
    tall = tall + min(0.35 * max(spare, 0.0), 0.3 * tall)
    cells = {
        "motion": _Cell(low, np.array([inner[0] - beside - gap, motion])),
        "figures": _Cell(low + np.array([inner[0] - beside, 0.0]), np.array([beside, motion])),
    }
    free = inner[0] - 2 * gap - sum(sizes[name][0] for name in row)
    x, y = float(low[0]), float(low[1] + motion + gap)
    for name in row:
        wide = sizes[name][0] + free / 3
        cells[name] = _Cell(np.array([x, y]), np.array([wide, tall]))
        x += wide + gap
    upper = float(y + tall + gap)
    high = float(low[1] + inner[1] - upper)
    wide = min(max(sizes["plan"][0] * 1.06, 0.34 * inner[0]), 0.56 * inner[0])
    cells["plan"] = _Cell(np.array([low[0] + inner[0] - wide, upper]), np.array([wide, high]))
    cells["axonometric"] = _Cell(np.array([low[0], upper]), np.array([inner[0] - wide - gap, high]))
    return scale, cells


def _largest(fits: Callable[[float], bool], most: float) -> float:
    """The largest factor that fits, by halving; 0 where none does."""
    low, high = 0.0, most
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (middle, high) if fits(middle) else (low, middle)
    return low


def _in_cell(
    subject: Subject, name: str, picture: Picture, cell: _Cell, scale: Scale | None, letters: float
) -> list[Item]:
    """A view in the middle of its cell, standing on its foot; at the largest usual scale if it has none."""
    room = room_of(picture, letters)
    around = np.array([room.left + room.right, room.bottom + room.top])
    unit = subject.design.unit
    if scale is None:
        scale = largest_scale(float(((cell.size - around) / (picture.high - picture.low)).min()), unit, ANY)
    drawn = scale.factor * (picture.high - picture.low)
    aside = (cell.size - around - drawn) / 2
    rise = aside[1] if name in ("plan", "axonometric") else 0.0
    corner = cell.low + np.array([room.left + aside[0], room.bottom + rise])
    return placed(picture, scale, unit, corner, caption_of(name, subject), letters, tall=subject.height)


def _figures(subject: Subject, cell: _Cell, letters: float) -> list[Item]:
    """A column of names and values."""
    rows = figures(subject)
    step = min(6.0 * letters, float(cell.size[1]) / (len(rows) + 1))
    x, top = float(cell.low[0]), float(cell.low[1]) + step * (len(rows) + 0.5)
    items: list[Item] = []
    for k, (name, value) in enumerate(rows):
        y = top - (k + 1) * step
        items.append(Text(name, (x, y), SMALL * letters, colour=GREY))
        items += fitted(value, (x + 30 * letters, y), SMALL * letters, float(cell.size[0]) - 30 * letters)
        items.append(
            line((x, y - 0.35 * step), (x + float(cell.size[0]), y - 0.35 * step), pen=Pen(0.08 * letters, GREY))
        )
    return items
