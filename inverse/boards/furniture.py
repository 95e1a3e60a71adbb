"""What surrounds a view on paper: caption, scale bar with a person, dimensions, supports, marks of sections."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from inverse._types import FloatArray
from inverse.boards import fonts
from inverse.boards.picture import BODY, Picture
from inverse.boards.scales import Scale, round_length
from inverse.boards.sheet import GREY, INK, Area, Item, Pen, Stroke, Text, line, moved
from inverse.fabricate.extras import needed
from inverse.fabricate.film.surroundings import PERSON, person
from inverse.fabricate.units import METRES, metres

THIN = Pen(0.1)
CAPTION, SMALL = 4.2, 2.8  # mm, of letters
BELOW, ABOVE = 17.0, 5.0  # mm beside a view for caption and scale bar, and above it
DIMENSIONS = 11.0  # mm below and to the left of a view for its dimensions
MARKS = 10.0  # mm around a plan for the marks of sections
_BAR = 34.0  # mm, of a scale bar at most


@dataclass(frozen=True)
class Room:
    """What a view needs around it in mm, times the size of letters.

    Attributes:
        left, right, bottom, top: mm.
    """

    left: float
    right: float
    bottom: float
    top: float


def room_of(picture: Picture, letters: float) -> Room:
    """The room that caption, dimensions, words and marks take."""
    measured = DIMENSIONS if picture.measured is not None else 2.0
    words = 2 * SMALL if picture.words else 0.0
    marks = MARKS if picture.marks else 0.0
    return Room(letters * (measured + marks), letters * (2.0 + marks), letters * (BELOW + words + measured + marks),
                letters * (ABOVE + marks))  # fmt: skip


def placed(
    picture: Picture, scale: Scale, unit: str, corner: FloatArray, caption: str, letters: float, *, tall: float = 0.0
) -> list[Item]:
    """A view on paper with all that surrounds it.

    Args:
        picture: the view.
        scale: its scale.
        unit: of the design.
        corner: (2,) mm, where the lower left corner of the picture itself is.
        caption: its title.
        letters: size of letters and pens, 1 on A3.
        tall: height of a person in the design's unit; 0 for none.
    """
    factor = scale.factor
    shift = corner - factor * picture.low
    weight = letters * float(np.clip(picture.apart * factor / (9 * letters), 0.25, 1.0))
    items = moved(picture.items, factor, shift, weight)
    for letter, ends, way in picture.marks:
        items += _section_mark(letter, ends * factor + shift, way, letters)
    items += _supports(picture.supports * factor + shift, letters, flat=bool(picture.marks))
    if picture.measured is not None:
        items += _dimensions(picture.measured, picture, scale, unit, shift, letters)
    room = room_of(picture, letters)
    items += _under(picture, factor, shift, letters)
    base = float(corner[1]) - room.bottom + letters * 3.0
    left = float(corner[0])
    items.append(Text(caption, (left, base + letters * 5.2), letters * CAPTION, bold=True))
    items.append(Text(scale.words, (left, base + letters * 0.8), letters * SMALL, colour="#5b5a57"))
    wide = max(fonts.width(scale.words, letters * SMALL), fonts.width(caption, letters * CAPTION, bold=True))
    start = left + max(letters * 30.0, wide + letters * 6)
    high = tall * factor / letters
    figure = tall if 2.2 < high < 14 and not picture.figure else 0.0
    items += scale_bar(scale, unit, (start, base + letters * 2.2), letters, figure)
    if picture.north is not None:
        right = start + letters * (_BAR + 16)
        items += _north(np.array([right, base + 4.2 * letters]), picture.north, letters, picture.compass)
    return items


def _under(picture: Picture, factor: float, shift: FloatArray, letters: float) -> list[Item]:
    """The words of a picture under their places, apart from each other, smaller where they are many."""
    size, space = letters * SMALL, letters * SMALL
    wide = [fonts.width(words, size) + space for words, _ in picture.words]
    share = min(1.0, factor * float(picture.high[0] - picture.low[0]) / max(sum(wide), 1e-9))
    items: list[Item] = []
    end = -np.inf
    for (words, place), long in zip(picture.words, wide, strict=True):
        x, y = place * factor + shift
        middle = max(float(x), end + share * long / 2)
        items.append(Text(words, (middle, float(y) - 1.8 * size), share * size, "middle"))
        end = middle + share * long / 2
    return items


def scale_bar(scale: Scale, unit: str, place: tuple[float, float], letters: float, tall: float) -> list[Item]:
    """A bar of a round length, with a person on it."""
    length = round_length(letters * _BAR / scale.factor)
    x, y = place
    end, high = x + length * scale.factor, letters * 1.1
    items: list[Item] = []
    for k in range(0, 4, 2):
        a, b = x + (end - x) * k / 4, x + (end - x) * (k + 1) / 4
        items.append(Area((np.array([[a, y], [b, y], [b, y + high], [a, y + high]]),), INK))
    items.append(line((x, y), (end, y), (end, y + high), (x, y + high), (x, y), pen=Pen(0.1 * letters)))
    under = y - letters * 1.15 * SMALL
    items.append(Text("0", (x, under), letters * SMALL, "middle"))
    items.append(Text(f"{length:g} {unit}", (end, under), letters * SMALL, "middle"))
    if tall:
        foot = np.array([end + letters * 1.0 + 0.3 * tall * scale.factor, y])
        items += moved([Area((ring,), BODY) for ring in _figure()], tall * scale.factor, foot)
    return items


@cache
def _figure() -> tuple[FloatArray, ...]:
    """Outline of a standing person of height 1, feet at the origin."""
    shapely = needed("shapely")
    vertices, triangles = person("m", np.zeros(3), np.array([0.0, -1.0, 0.0]))
    flat = vertices[triangles][:, :, [0, 2]] / PERSON
    parts = shapely.union_all([shapely.MultiPoint(one).convex_hull for one in flat])
    shape = max(shapely.get_parts(parts), key=lambda part: part.area) if parts.geom_type != "Polygon" else parts
    return (np.array(shape.exterior.coords)[:-1],)


def person_height(unit: str) -> float:
    """Of a person, in a unit; 0 where it has no length."""
    return PERSON / metres(unit) if unit in METRES else 0.0


def _dimensions(
    measured: FloatArray, picture: Picture, scale: Scale, unit: str, shift: FloatArray, letters: float
) -> list[Item]:
    """Dimension lines for the whole width below and the whole height on the left."""
    (left, bottom), (right, top) = measured * scale.factor + shift
    low = picture.low * scale.factor + shift
    size = measured[1] - measured[0]
    away, tick, over = letters * (6.5 + (MARKS if picture.marks else 0.0)), letters * 0.9, letters * 1.2
    pen, slash = Pen(0.1 * letters), Pen(0.28 * letters)
    y, x = float(low[1]) - away, float(low[0]) - away
    items: list[Item] = [
        Stroke((np.array([[left - over, y], [right + over, y]]), np.array([[x, bottom - over], [x, top + over]])), pen),
        Stroke(
            tuple(np.array([[end, y - over], [end, min(bottom, low[1]) - 1.5 * letters]]) for end in (left, right))
            + tuple(np.array([[x - over, end], [min(left, low[0]) - 1.5 * letters, end]]) for end in (bottom, top)),
            pen,
        ),
    ]
    places = [(left, y), (right, y), (x, bottom), (x, top)]
    items.append(Stroke(tuple(np.array([[a - tick, b - tick], [a + tick, b + tick]]) for a, b in places), slash))
    wide, high = (length_words(float(value), unit) for value in size)
    for words, low_end, high_end, turned in ((wide, left, right, False), (high, bottom, top, True)):
        # What is longer than its line stands beyond the end of it.
        inside = fonts.width(words, letters * SMALL) < high_end - low_end - 2 * letters
        at = float(low_end + high_end) / 2 if inside else float(high_end) + 1.8 * letters
        place = (x - letters * 0.8, at) if turned else (at, y + letters * 0.8)
        items.append(Text(words, place, letters * SMALL, "middle" if inside else "start", turned=turned))
    return items


def length_words(length: float, unit: str) -> str:
    """A length as it is written beside a dimension line."""
    digits = 2 if unit in ("m", "unit") and length < 1000 else 1 if length < 100 else 0
    if length < 0.1:
        return f"{length:.3g}" if unit == "unit" else f"{length:.3g} {unit}"
    return f"{length:.{digits}f}" if unit == "unit" else f"{length:.{digits}f} {unit}"


def _supports(places: FloatArray, letters: float, *, flat: bool) -> list[Item]:
    """Where the design is held: dots in plan, triangles under the places elsewhere."""
    if not len(places):
        return []
    size = letters * (1.5 if len(places) <= 60 else 1.0)
    if flat:
        angle = np.linspace(0, 2 * np.pi, 17)[:-1]
        ring = 0.55 * size * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    else:
        ring = size * np.array([[0.0, 0.0], [-0.55, -1.0], [0.55, -1.0]])
    outlines = tuple(place + np.vstack([ring, ring[:1]]) for place in places)
    areas: list[Item] = [Area((place + ring,), "#c8102e") for place in places]
    return [*areas, Stroke(outlines, Pen(0.1 * letters, "#ffffff"))]


def _section_mark(letter: str, ends: FloatArray, way: FloatArray, letters: float) -> list[Item]:
    """Two short heavy lines outside the plan, each with an arrow that looks as the section does."""
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    items: list[Item] = []
    for end, out in ((ends[0], -along), (ends[1], along)):
        tip = end + 5.0 * letters * out
        items.append(Stroke((np.array([end + 0.5 * letters * out, tip]),), Pen(0.5 * letters)))
        side = np.array([-way[1], way[0]])
        head = np.array([tip + 2.6 * letters * way, tip + 1.1 * letters * side, tip - 1.1 * letters * side])
        items.append(Area((head,), INK))
        x, y = tip - 2.6 * letters * way + letters * np.array([0.0, -1.2])
        items.append(Text(letter, (float(x), float(y)), letters * 3.2, "middle", bold=True))
    items.append(Stroke((ends,), Pen(0.12 * letters, GREY, (4.0, 1.0, 0.8, 1.0))))
    return items


def _north(centre: FloatArray, north: FloatArray, letters: float, word: str) -> list[Item]:
    """An arrow in a circle."""
    angle = np.linspace(0, 2 * np.pi, 49)
    radius = 3.4 * letters
    ring = centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    side = np.array([-north[1], north[0]])
    arrow = centre + radius * np.array([north, -0.75 * north + 0.5 * side, -0.45 * north, -0.75 * north - 0.5 * side])
    x, y = centre + 1.45 * radius * north - [0.0, 0.36 * SMALL * letters]
    return [
        Stroke((ring,), Pen(0.12 * letters)),
        Area((arrow,), INK),
        Text(word, (float(x), float(y)), SMALL * letters, "middle"),
    ]
