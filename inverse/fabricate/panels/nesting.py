"""Flat pieces laid onto sheets in shelves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.origami import geometry


@dataclass(frozen=True, eq=False)
class Placed:
    """A piece on a sheet.

    Attributes:
        number: of the piece.
        sheet: from 0 on.
        outline: (k, 2) on the sheet, whose lower left corner is the origin.
    """

    number: int
    sheet: int
    outline: FloatArray


def nested(
    outlines: list[FloatArray], names: list[str], sheet: tuple[float, float], gap: float, unit: str
) -> list[Placed]:
    """Lay convex pieces onto as few sheets as a simple rule finds.

    Every piece is turned into its smallest box, the long side across if it fits, and the boxes are set side by side in
    shelves, the tallest first, each on the first shelf that has room.

    Args:
        outlines: (k, 2) of every piece; none is turned over.
        names: of the pieces, for messages.
        sheet: width and height.
        gap: between pieces, and to the edges of the sheet.
        unit: of lengths, for messages.

    Returns:
        The pieces in the order of the outlines.

    Raises:
        InputError: the sheet's size is not positive, or a piece is too large for it: the message names the largest one.
    """
    if not all(np.isfinite(side) and side > 0 for side in sheet):
        raise InputError(f"the sheet is {sheet[0]:g} x {sheet[1]:g}: both must be greater than 0")
    room = np.array(sheet) - gap
    lying = [_in_its_box(outline) for outline in outlines]
    sizes = np.array([outline.max(axis=0) for outline in lying]) + gap
    for k, size in enumerate(sizes):
        if size[0] > room[0] or (size[1] > room[1] and size[0] <= room[1] and size[1] <= room[0]):
            lying[k], sizes[k] = np.stack([size[1] - gap - lying[k][:, 1], lying[k][:, 0]], axis=1), size[::-1]
    too_large = np.flatnonzero((sizes > room).any(axis=1))
    if len(too_large):
        raise _too_large(sizes - gap, names, too_large, sheet, gap, unit)
    corners = _shelves(sizes, room)
    return [
        Placed(k, number, outline + gap + corner)
        for k, (outline, (number, corner)) in enumerate(zip(lying, corners, strict=True))
    ]


def _in_its_box(outline: FloatArray) -> FloatArray:
    """The outline turned so that its box is smallest and lies on its long side at the origin."""
    best, least = outline, np.inf
    for along in geometry.unit(np.roll(outline, -1, axis=0) - outline):
        turned = outline @ np.array([[along[0], -along[1]], [along[1], along[0]]])
        turned = turned - turned.min(axis=0)
        width, height = turned.max(axis=0)
        if width * height < least * (1 - 1e-9):
            best, least = turned, width * height
    width, height = best.max(axis=0)
    return best if width >= height else np.stack([height - best[:, 1], best[:, 0]], axis=1)


def _shelves(sizes: FloatArray, room: FloatArray) -> list[tuple[int, FloatArray]]:
    """Sheet and lower left corner of every box."""
    shelves: list[tuple[int, float, float]] = []  # sheet, y, height
    filled: list[float] = []  # width that is taken on every shelf
    tops: list[float] = []  # height that is taken on every sheet
    found: dict[int, tuple[int, FloatArray]] = {}
    for k in np.lexsort((-sizes[:, 0], -sizes[:, 1])).tolist():
        width, height = sizes[k].tolist()
        shelf = next((s for s, taken in enumerate(filled) if taken + width <= room[0]), None)
        if shelf is None:
            sheet = next((s for s, top in enumerate(tops) if top + height <= room[1]), len(tops))
            if sheet == len(tops):
                tops.append(0.0)
            shelf = len(shelves)
            shelves.append((sheet, tops[sheet], height))
            filled.append(0.0)
            tops[sheet] += height
        sheet, y, _ = shelves[shelf]
        found[k] = sheet, np.array([filled[shelf], y])
        filled[shelf] += width
    return [found[k] for k in range(len(sizes))]


def _too_large(
    sizes: FloatArray, names: list[str], too_large: IntArray, sheet: tuple[float, float], gap: float, unit: str
) -> InputError:
    largest = int(too_large[np.argmax(sizes[too_large].prod(axis=1))])
    width, height = sizes[largest]
    others = f", nor do {len(too_large) - 1} others" if len(too_large) > 1 else ""
    return InputError(
        f"panel {names[largest]} does not fit on a sheet of {sheet[0]:g} x {sheet[1]:g}{unit}{others}: it measures "
        f"{max(width, height):.4g} x {min(width, height):.4g}{unit}",
        hint=f"A margin of {gap:.3g}{unit} is left on every side.",
    )
