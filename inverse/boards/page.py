"""A page with one view: its scale, its frame and the title block."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inverse.boards import fonts
from inverse.boards.furniture import Room, placed, room_of
from inverse.boards.picture import Picture
from inverse.boards.scales import Scale, largest_scale, read_scale
from inverse.boards.sheet import GREY, PAPERS, Item, Pen, Sheet, Text, box, line, paper_size
from inverse.boards.views import VIEWS, Subject
from inverse.errors import InputError

BLOCK = 15.0  # mm, height of the title block, times the size of letters
EDGE = 8.0  # mm from the edge of the paper to the frame, times the same
INSIDE = 5.0  # mm from the frame to the drawing, times the same


@dataclass(frozen=True)
class Layout:
    """How pages are laid out.

    Attributes:
        paper: a word of ``PAPERS``; A3 if None, A1 for boards.
        scale: such as 1:50; the largest usual one that fits if None.
        date: written into the title block as it is; nothing if None.
    """

    paper: str | None = None
    scale: str | None = None
    date: str | None = None


def page(subject: Subject, name: str, layout: Layout) -> Sheet:
    """A page with one view.

    Args:
        subject: what is drawn.
        name: of the view.
        layout: paper, scale and date.

    Raises:
        InputError: a scale or paper that cannot be, or at which the view has no room.
    """
    paper = layout.paper or "A3"
    lying = paper_size(paper)
    picture = subject.picture(name)
    letters = letters_of(lying)
    room = room_of(picture, letters)
    unit = subject.design.unit
    sizes = [lying, lying[::-1]]
    fits = [_factor(picture, room, size, letters) for size in sizes]
    size, most = (sizes[1], fits[1]) if fits[1] > 1.15 * fits[0] else (sizes[0], fits[0])
    if layout.scale is None:
        scale = largest_scale(most, unit)
    else:
        scale = read_scale(layout.scale, unit)
        size, most = max(zip(sizes, fits, strict=True), key=lambda pair: pair[1])
        if scale.factor > most * (1 + 1e-9):
            raise InputError(_too_large(picture, scale, paper, unit, most), hint=_what_fits(picture, scale, unit, most))
    caption = caption_of(name, subject)
    sheet = Sheet(*size, f"{subject.design.name}: {caption} {scale.words}")
    inner = np.array([size[0], size[1]]) - 2 * letters * (EDGE + INSIDE) - [0.0, letters * BLOCK]
    taken = scale.factor * (picture.high - picture.low) + [room.left + room.right, room.bottom + room.top]
    corner = (
        letters * (EDGE + INSIDE)
        + np.array([0.0, letters * BLOCK])
        + (inner - taken) / 2
        + np.array([room.left, room.bottom])
    )
    sheet.items += placed(picture, scale, unit, corner, caption, letters, tall=subject.height)
    sheet.items += title_block(size, letters, subject, caption, scale.words, paper, layout.date)
    return sheet


def caption_of(name: str, subject: Subject) -> str:
    """The title of a view in words."""
    caption = VIEWS[name].caption
    if name == "motion":
        if subject.states == 2:
            return f"{caption}: flat as developed, packed (flat-folded)"
        return f"{caption}: flat as developed, deployed, packed (flat-folded)" if subject.states % 2 else caption
    if name == "exploded":
        return f"{len(subject.design.pattern.faces_vertices)} panels, drawn apart"
    return caption


def letters_of(size: tuple[float, float]) -> float:
    """Size of letters and pens on a paper, 1 on A3."""
    return float(np.clip((min(size) / 297.0) ** 0.6, 0.75, 1.9))


def title_block(
    size: tuple[float, float], letters: float, subject: Subject, caption: str, scale: str, paper: str, date: str | None
) -> list[Item]:
    """The frame of a page and, at its foot, what it is."""
    edge, block = letters * EDGE, letters * BLOCK
    width, height = size
    thin = Pen(0.15 * letters)
    items: list[Item] = [
        box((edge, edge), (width - edge, height - edge), Pen(0.3 * letters)),
        line((edge, edge + block), (width - edge, edge + block), pen=thin),
    ]
    unit = subject.design.unit
    fields = [
        ("Project", subject.design.name or "unnamed", 0.30),
        ("Drawing", caption, 0.34),
        ("Scale", f"{scale}  ({paper.upper()})", 0.16),
        ("Lengths in", unit if unit != "unit" else "units of the design", 0.12),
    ] + ([("Date", date, 0.12)] if date else [])
    total = sum(share for *_, share in fields)
    x = edge
    for k, (title, words, share) in enumerate(fields):
        if k:
            line_at = line((x, edge), (x, edge + block), pen=thin)
            items.append(line_at)
        wide = share / total * (width - 2 * edge)
        items.append(Text(title, (x + 2.5 * letters, edge + 10.4 * letters), 2.3 * letters, colour=GREY))
        items += fitted(words, (x + 2.5 * letters, edge + 4.0 * letters), 4.4 * letters, wide - 5 * letters, bold=not k)
        x += wide
    return items


def fitted(words: str, place: tuple[float, float], size: float, room: float, *, bold: bool = False) -> list[Item]:
    """Words as large as they can be, up to a size; what has no room at half of it is cut short."""
    wide = fonts.width(words, size, bold=bold)
    if wide > room:
        size *= max(0.5, room / wide)
        while fonts.width(words, size, bold=bold) > room and len(words) > 4:
            words = words[:-4] + "..." if words.endswith("...") else words[:-2] + "..."
    return [Text(words, place, size, bold=bold)]


def _factor(picture: Picture, room: Room, size: tuple[float, float], letters: float) -> float:
    """Largest scale in mm per unit at which a picture fits on a page."""
    inner = np.array(size) - 2 * letters * (EDGE + INSIDE) - [0.0, letters * BLOCK]
    left = inner - [room.left + room.right, room.bottom + room.top]
    return float((left / (picture.high - picture.low)).min())


def _too_large(picture: Picture, scale: Scale, paper: str, unit: str, most: float) -> str:
    wide, high = scale.factor * (picture.high - picture.low)
    return f"at {scale.words} the drawing is {wide:.0f} x {high:.0f} mm, which has no room on {paper.upper()}"


def _what_fits(picture: Picture, scale: Scale, unit: str, most: float) -> str:
    """A scale for this paper, and a paper for this scale."""
    words = f"--scale {largest_scale(most, unit).words} fits on this paper"
    for paper in reversed(PAPERS):
        lying = paper_size(paper)
        letters = letters_of(lying)
        room = room_of(picture, letters)
        if scale.factor <= max(_factor(picture, room, size, letters) for size in (lying, lying[::-1])):
            return f"{words}, and --paper {paper} has room for this scale."
    return f"{words}; no paper up to A0 has room for this scale."
