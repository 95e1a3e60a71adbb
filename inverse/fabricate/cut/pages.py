"""Pieces of a drawing on sheets of paper: whole where they fit, several on one sheet, else in parts that overlap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from inverse._types import BoolArray, FloatArray
from inverse.errors import InputError
from inverse.fabricate.cut.plan import Plan, Text
from inverse.fabricate.extras import needed
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
EDGE = 7.0  # mm at every side that printers do not reach
FOOT = 18.0  # mm below the drawing for scale bar, words and legend
OVERLAP = 10.0  # mm that neighbouring parts have in common
BETWEEN = 4.0  # mm between pieces on one page
MOST_PAGES = 500
_SPARE = 0.5  # mm, for the width of lines


@dataclass(frozen=True, eq=False)
class Placed:
    """A piece on a page: a point p of the drawing comes to ``turn p + shift``, from the lower left of the page's room.

    Attributes:
        piece: its number in the drawing.
        turn: (2, 2) rotation.
        shift: (2,) mm.
    """

    piece: int
    turn: FloatArray
    shift: FloatArray


@dataclass(frozen=True, eq=False)
class Page:
    """What one page shows.

    Attributes:
        placed: its pieces; a single one where it shows a part.
        part: column and row of the part, from 0 on, where the piece is larger than a page; A1 is the lower left one.
        parts: numbers of columns and rows of all its parts.
    """

    placed: tuple[Placed, ...]
    part: tuple[int, int] = (0, 0)
    parts: tuple[int, int] = (1, 1)

    @property
    def is_whole(self) -> bool:
        """Whether its pieces are shown whole."""
        return self.parts == (1, 1)

    @property
    def part_name(self) -> str:
        """Column and row, such as B2."""
        return f"{_letters(self.part[0])}{self.part[1] + 1}"


def paper_size(paper: str) -> tuple[float, float]:
    """Width and height of a paper that stands, mm.

    Raises:
        InputError: there is no such paper.
    """
    if paper not in PAPERS:
        known = ", ".join(PAPERS)
        raise InputError(f"{paper!r} is no paper: there are {known}.{did_you_mean(paper, PAPERS)}")
    return PAPERS[paper]


def room_of(paper: str) -> FloatArray:
    """Width and height (2,) in mm of what a page has for the drawing."""
    return np.array(paper_size(paper)) - 2 * EDGE - [0.0, FOOT]


def laid_out(plan: Plan, paper: str) -> list[Page]:
    """Pages for all pieces, those with whole pieces first; pages without a line are left out.

    A piece that fits on a page is turned so that it does, and cut nowhere; one that does not is turned so that it has
    the fewest parts.

    Args:
        plan: the drawing.
        paper: a word of :data:`PAPERS`.

    Raises:
        InputError: an unknown paper, or too many pages.
    """
    room = room_of(paper)
    boxes: list[_Box] = []
    large: list[tuple[_Box, tuple[int, int]]] = []
    for piece, corners in enumerate(_corners(plan)):
        turned = _turned(piece, corners)
        fitting = [box for box in turned if (box.size <= room).all()]
        if fitting:
            boxes.append(min(fitting, key=lambda box: float(box.size[1])))
        else:
            best = min(turned, key=lambda box: _counts(box, room).prod())
            columns, rows = _counts(best, room).tolist()
            large.append((best, (columns, rows)))
    pages = [Page(tuple(placed)) for placed in _in_shelves(boxes, room)]
    count = len(pages) + sum(columns * rows for _, (columns, rows) in large)
    if count > MOST_PAGES:
        raise InputError(
            f"a drawing of {plan.size[0]:.0f} x {plan.size[1]:.0f} mm needs {count} pages of {paper}: at most"
            f" {MOST_PAGES} are made",
            hint="Choose a larger paper, or a smaller scale.",
        )
    ends, owner = ends_of(plan), np.array([line.piece for line in plan.lines])
    for box, parts in large:
        own = ends[owner == box.piece] @ box.turn.T
        slack = (room - OVERLAP) * parts + OVERLAP - box.size
        for row in range(parts[1]):
            for column in range(parts[0]):
                shift = slack / 2 - box.low - (room - OVERLAP) * [column, row]
                if meets(own + shift, np.zeros(2), room).any():
                    pages.append(Page((Placed(box.piece, box.turn, shift),), (column, row), parts))
    return pages


def fitting_share(plan: Plan, paper: str, constant: float) -> float:
    """By which factor the drawing has to be scaled so that every piece fits on a page; 1 or more if they do.

    Args:
        plan: the drawing.
        paper: a word of :data:`PAPERS`.
        constant: mm by which pieces stick out at every side whatever the scale, as flaps do.
    """
    room = room_of(paper) - 2 * (constant + _SPARE)
    shares = [
        max(float((room / np.maximum(box.size, 1e-300)).min()) for box in _turned(piece, corners))
        for piece, corners in enumerate(_corners(plan))
    ]
    return min(shares)


def ends_of(plan: Plan) -> FloatArray:
    """Ends (N, 2, 2) of all lines."""
    return np.array([line.ends for line in plan.lines]).reshape(-1, 2, 2)


def meets(ends: FloatArray, low: FloatArray, high: FloatArray) -> BoolArray:
    """Which lines (N, 2, 2) have a point in a rectangle, (N,)."""
    start, along = ends[:, 0], ends[:, 1] - ends[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        first, last = (low - start) / along, (high - start) / along
    # Parallel to a side: anywhere along it if within, else nowhere.
    within = (start >= low) & (start <= high)
    enter = np.where(along == 0, np.where(within, -np.inf, np.inf), np.minimum(first, last)).max(axis=1)
    leave = np.where(along == 0, np.where(within, np.inf, -np.inf), np.maximum(first, last)).min(axis=1)
    return np.asarray(np.maximum(enter, 0) <= np.minimum(leave, 1))


@dataclass(frozen=True, eq=False)
class _Box:
    """A turned piece: the lower left corner (2,) of its box in the turned drawing, and its size (2,), mm."""

    piece: int
    turn: FloatArray
    low: FloatArray
    size: FloatArray


def _corners(plan: Plan) -> list[FloatArray]:
    """Points (N, 2) around every piece with its words."""
    count = 1 + max(line.piece for line in plan.lines)
    found: list[list[FloatArray]] = [[] for _ in range(count)]
    for line in plan.lines:
        found[line.piece].append(line.ends)
    for text in plan.texts:
        found[text.piece].append(_around(text))
    return [np.concatenate(points) for points in found]


def _around(text: Text) -> FloatArray:
    """Corners (4, 2) of the room that a word takes."""
    along = np.array([np.cos(text.angle), np.sin(text.angle)])
    half = 0.3 * text.height * len(text.words) / 0.7 * along
    up = 0.5 * text.height * np.array([-along[1], along[0]])
    return np.asarray(text.place + np.array([-half - up, half - up, half + up, up - half]))


def _turned(piece: int, corners: FloatArray) -> list[_Box]:
    """A piece as it is, turned by a right angle, and with every side of its hull level or upright."""
    hull: Any = needed("shapely").MultiPoint(corners).convex_hull
    outline = np.array(getattr(hull, "exterior", hull).coords)
    sides = np.diff(outline, axis=0)
    angles = np.unique(np.round(np.r_[0.0, -np.arctan2(sides[:, 1], sides[:, 0])] % (np.pi / 2), 9))
    boxes = []
    for angle in np.r_[angles, angles + np.pi / 2]:
        c, s = np.cos(angle), np.sin(angle)
        turn = np.array([[c, -s], [s, c]])
        points = outline @ turn.T
        boxes.append(_Box(piece, turn, points.min(axis=0), np.ptp(points, axis=0) + _SPARE))
    return boxes


def _counts(box: _Box, room: FloatArray) -> Any:
    return np.maximum(np.ceil((box.size - OVERLAP) / (room - OVERLAP)), 1).astype(int)


def _in_shelves(boxes: Sequence[_Box], room: FloatArray) -> list[list[Placed]]:
    """Boxes side by side in shelves, the tallest first, each on the first shelf of the first page that has room."""
    pages: list[list[Placed]] = []
    shelves: list[list[float]] = []  # page, height where it begins, its height, width used
    tops: list[float] = []
    for box in sorted(boxes, key=lambda box: (-round(float(box.size[1]), 6), box.piece)):
        width, height = box.size.tolist()
        shelf = next((s for s in shelves if s[3] + width <= room[0] and height <= s[2]), None)
        if shelf is None:
            page = next((k for k, top in enumerate(tops) if top + height <= room[1]), len(tops))
            if page == len(tops):
                tops.append(0.0)
                pages.append([])
            shelf = [page, tops[page], height, 0.0]
            shelves.append(shelf)
            tops[page] += height + BETWEEN
        corner = np.array([shelf[3], shelf[1]]) + _SPARE / 2
        pages[int(shelf[0])].append(Placed(box.piece, box.turn, corner - box.low))
        shelf[3] += width + BETWEEN
    return pages


def _letters(column: int) -> str:
    """A to Z, then AA, AB, ..."""
    head, last = divmod(column, 26)
    return (_letters(head - 1) if head else "") + chr(ord("A") + last)
