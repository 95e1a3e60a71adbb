"""The views that can be drawn, each by its name: where it is seen from, and what is in it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from inverse._types import FloatArray
from inverse.boards.body import Body, body_of, solid
from inverse.boards.picture import Picture, Scene, Style, draw
from inverse.boards.sheet import Item, moved
from inverse.fabricate.film.motion import check_motion
from inverse.fabricate.film.poses import poses
from inverse.fabricate.film.surroundings import PERSON, Surface, person
from inverse.fabricate.units import METRES, metres
from inverse.origami import geometry
from inverse.origami.footprint import box_axes, extents
from inverse.origami.pattern import Design
from inverse.pictures import colours, drawing
from inverse.pictures.camera import basis, clear_view

LONG = 1.1  # of the shorter side: what is longer has a longer side
TURNED = 0.98  # a plan is turned where its rectangle then has less than this share of the area
ASIDE, ABOVE = 0.2, 0.3  # of the design's width and height, shown of buildings on every side
APART = 1.3  # exploded: distances of the panels' middles, compared with those of the design
NEARLY = 0.02  # radians: flat states are drawn so much before, so that their layers hide one another
GAP = 0.12  # between states, of the widest one


@dataclass(frozen=True, eq=False)
class Subject:
    """What is to be drawn, and how.

    Attributes:
        design: the design.
        target: vertices and triangles of its target surface, if it is shown.
        context: vertices and triangles of buildings, if they are shown.
        supports: numbers of vertices that are held.
        style: of all views; None for what suits each.
        at: where sections cut, as a share of the design from 0 to 1.
        states: number of states of the motion.
        free: folding amounts in degrees between which facets do not meet, if that is known.
        hidden: whether hidden lines are dashed.
        verdicts: names and values that a report tells beside the design.
        tell: told what is being drawn, before each part of it.
    """

    design: Design
    target: Surface | None = None
    context: Surface | None = None
    supports: tuple[int, ...] = ()
    style: Style | None = None
    at: float = 0.5
    states: int = 5
    free: tuple[float, float] | None = None
    hidden: bool = False
    verdicts: tuple[tuple[str, str], ...] = ()
    tell: Callable[[str], None] = lambda _: None

    def picture(self, name: str) -> Picture:
        """A view by its name; drawn once, on however many sheets it is."""
        if name not in self._pictures:
            self.tell(name)
            self._pictures[name] = VIEWS[name].draw(self)
        return self._pictures[name]

    @cached_property
    def _pictures(self) -> dict[str, Picture]:
        return {}

    @cached_property
    def turn(self) -> float:
        """Angle in radians from the x axis to the design's own one in plan, along its longer side if it has one."""
        flat = self.design.vertices_coords[:, :2]
        axes = box_axes(flat)
        long, short = extents(flat, axes)
        if long < LONG * short and long * short > TURNED * np.prod(np.ptp(flat, axis=0)):
            return 0.0
        angle = float(np.arctan2(axes[0, 1], axes[0, 0]))
        if long < LONG * short:
            return (angle + np.pi / 4) % (np.pi / 2) - np.pi / 4
        angle = (angle + np.pi / 2 - 1e-6) % np.pi - np.pi / 2 + 1e-6
        return 0.0 if abs(angle) < 1e-6 else angle

    @cached_property
    def body(self) -> Body:
        """The design."""
        return body_of(self.design.pattern, self.design.vertices_coords)

    @cached_property
    def turned_over(self) -> bool:
        """Whether lower sides are what is seen from outside."""
        points = self.design.vertices_coords
        sides = drawing.sides_of(self.design.pattern, points, basis(self.turn - np.radians(60.0), np.radians(30.0)))
        return sides[0] is colours.COOL

    @cached_property
    def buildings(self) -> Body | None:
        """The buildings."""
        return None if self.context is None else solid(*self.context)

    @cached_property
    def height(self) -> float:
        """Of a person, in the design's unit; 0 where that has no length, or where the design is no larger."""
        size = float(np.ptp(self.design.vertices_coords, axis=0).max())
        tall = PERSON / metres(self.design.unit)
        return tall if self.design.unit in METRES and 0.8 * size > tall > 5e-3 * size else 0.0

    def ground(self) -> float:
        """Height of the ground: that of the buildings, else the design's lowest vertex."""
        points = self.design.vertices_coords if self.context is None else self.context[0]
        return float(points[:, 2].min())

    def scene(self, *, among: bool = True, figure: FloatArray | None = None) -> Scene:
        """All that views show."""
        target = None
        if self.target is not None:
            rim = drawing.target(*self.target, basis(0.3, 0.3))[1]
            target = (*self.target, rim.points[rim.ends])
        sun = np.array([-1.0, -1.0, 1.0])
        c, s = np.cos(self.turn), np.sin(self.turn)
        sun[:2] = [c * sun[0] - s * sun[1], s * sun[0] + c * sun[1]]
        context = self.buildings if among else None
        return Scene(self.body, context, target, figure, self.ground(), sun, self.turned_over)

    def frame(self, view: FloatArray) -> FloatArray | None:
        """Lower left and upper right corner (2, 2) of what is shown of buildings, if any are."""
        if self.context is None:
            return None
        seen = (self.design.vertices_coords @ view.T)[:, :2]
        low, high = seen.min(axis=0), seen.max(axis=0)
        reach = np.maximum((high - low) * [ASIDE, ABOVE], 0.08 * (high - low).max())
        return np.array([low - reach, high + reach])

    def person(self, view: FloatArray) -> FloatArray | None:
        """Triangles (N, 3, 3) of a person who stands on the ground, to the right of the design as it is seen."""
        if not self.height or self.context is not None:
            return None
        facing = view[2] * [1.0, 1.0, 0.0]
        facing = facing / np.linalg.norm(facing)
        points = self.design.vertices_coords
        if view[2, 2] == 0:  # level: on the right of the design
            right, near = points @ view[0], points @ facing
            foot = (right.max() + 0.5 * self.height) * view[0] + near.max() * facing
        else:  # in front of it, near the corner that is nearest
            axes = _axes(self)
            x, y = (points[:, :2] @ axes.T).T
            aside = -0.12 * np.ptp(x) if np.ptp(x) > 3 * self.height else 0.6 * self.height
            place = [x.max() + aside, y.min() - 0.5 * self.height]
            foot = np.append(np.array(place) @ axes, 0.0)
        vertices, triangles = person(self.design.unit, foot + np.array([0.0, 0.0, self.ground()]), facing)
        return vertices[triangles]


def _plan(subject: Subject) -> Picture:
    view = basis(subject.turn - np.pi / 2, np.pi / 2)
    picture = _drawn(subject, view, "shadow")
    c, s = np.cos(subject.turn), np.sin(subject.turn)
    compass = "y" if subject.context is None else "N"
    north = np.array([s, c]) if subject.turn or subject.context is not None else None
    return replace(picture, marks=(_mark(subject, view, along=False),), north=north, compass=compass)


def _elevation(azimuth: float, *, own: bool = True) -> Callable[[Subject], Picture]:
    """Seen level from an azimuth in degrees: of the design's own axes, or of the compass."""

    def made(subject: Subject) -> Picture:
        view = basis(np.radians(azimuth) + (subject.turn if own else 0.0), 0.0)
        return _drawn(subject, view, "shaded", upright=True, figure=subject.person(view))

    return made


def _section(along: bool) -> Callable[[Subject], Picture]:
    def made(subject: Subject) -> Picture:
        view, depth = _plane(subject, along)
        return _drawn(subject, view, "shaded", upright=True, depth=depth, figure=subject.person(view))

    return made


def _axonometric(subject: Subject) -> Picture:
    wish = subject.turn - np.radians(60.0), np.radians(32.0)
    view = basis(*wish)
    if subject.context is not None:
        view = clear_view(subject.design.vertices_coords, wish, *subject.context)
    return replace(_drawn(subject, view, "shadow", figure=subject.person(view)), measured=None)


def _worms_eye(subject: Subject) -> Picture:
    view = basis(subject.turn - np.radians(60.0), np.radians(-32.0))
    return replace(_drawn(subject, view, "shaded", among=False), measured=None)


def _exploded(subject: Subject) -> Picture:
    body = subject.body
    middles = np.array([polygon.mean(axis=0) for polygon in body.polygons])
    away = (APART - 1) * (middles - middles.mean(axis=0))
    polygons = tuple(polygon + step for polygon, step in zip(body.polygons, away, strict=True))
    ends = [np.stack([p, np.roll(p, -1, axis=0)], axis=1) for p in polygons]
    owner = np.repeat(np.arange(len(polygons)), [len(p) for p in polygons])
    apart = Body(polygons, np.concatenate(ends), np.stack([owner, np.full(len(owner), -1)], axis=1))
    scene = Scene(apart, turned=subject.turned_over)
    view = basis(subject.turn - np.radians(60.0), np.radians(32.0))
    return replace(draw(scene, view, subject.style or "shaded"), measured=None)


def _motion(subject: Subject) -> Picture:
    """States side by side on one ground, all at one scale."""
    design = subject.design
    check_motion(design)
    amounts = np.linspace(0.0, np.pi, subject.states)
    found = poses(design, np.clip(amounts, NEARLY, np.pi - NEARLY)).vertices_coords
    view = basis(subject.turn - np.radians(60.0), np.radians(32.0))
    pictures = []
    for number, points in enumerate(found, 1):
        subject.tell(f"motion, state {number} of {len(found)}")
        points = points - points.mean(axis=0) * [1.0, 1.0, 0.0] - [0.0, 0.0, points[:, 2].min()]
        scene = Scene(body_of(design.pattern, points), turned=subject.turned_over)
        pictures.append(draw(scene, view, subject.style or "shaded"))
    gap = GAP * max(float(np.ptp([one.low, one.high], axis=0)[0]) for one in pictures)
    middle = max(float(one.high[1] - one.low[1]) for one in pictures) / 2
    apart = float(np.median([one.apart for one in pictures]))
    items: list[Item] = []
    words, x = [], 0.0
    for amount, one in zip(amounts, pictures, strict=True):
        size = one.high - one.low
        items += moved(one.items, 1.0, np.array([x, middle - size[1] / 2]) - one.low, min(1.0, one.apart / apart))
        words.append((state_words(float(np.degrees(amount)), subject.free), np.array([x + size[0] / 2, 0.0])))
        x += size[0] + gap
    low, high = np.zeros(2), np.array([x - gap, 2 * middle])
    return Picture(items, low, high, apart=apart, words=tuple(words))


def state_words(degrees: float, free: tuple[float, float] | None) -> str:
    """A state of the motion in words."""
    named = {0.0: "flat as developed", 90.0: "deployed", 180.0: "packed (flat-folded)"}
    words = named.get(round(degrees, 6), f"{degrees:.0f}°")
    within = free is None or free[0] - 0.5 <= degrees <= free[1] + 0.5
    return words if within else f"{words}, facets would meet"


def _drawn(
    subject: Subject, view: FloatArray, style: Style, *, among: bool = True, upright: bool = False,
    depth: float | None = None, figure: FloatArray | None = None,
) -> Picture:  # fmt: skip
    frame = subject.frame(view) if among else None
    scene = subject.scene(among=among, figure=figure)
    picture = draw(
        scene, view, subject.style or style, depth=depth, frame=frame, hidden=subject.hidden, upright=upright
    )
    seen = subject.design.vertices_coords[list(subject.supports)] @ view.T
    if depth is not None:
        seen = seen[seen[:, 2] <= depth + 1e-9 * geometry.diagonal(subject.design.vertices_coords)]
    return replace(picture, supports=seen[:, :2])


def _plane(subject: Subject, along: bool) -> tuple[FloatArray, float]:
    """The view of a section and the depth of its plane: across the longer side in plan, or along it."""
    size = extents(subject.design.vertices_coords[:, :2], _axes(subject))
    across_x = (size[0] >= size[1]) != along
    azimuth = 0.0 if across_x else -np.pi / 2
    view = basis(subject.turn + azimuth, 0.0)
    depths = subject.design.vertices_coords @ view[2]
    return view, float(depths.min() + (1 - subject.at) * np.ptp(depths))


def _axes(subject: Subject) -> FloatArray:
    """Unit vectors (2, 2) along and across the design in plan."""
    c, s = np.cos(subject.turn), np.sin(subject.turn)
    return np.array([[c, s], [-s, c]])


def _mark(subject: Subject, plan: FloatArray, *, along: bool) -> tuple[str, FloatArray, FloatArray]:
    """The line of a section in a plan: its letter, its ends and the way that it looks."""
    view, depth = _plane(subject, along)
    seen = subject.design.vertices_coords @ view.T
    reach = 0.03 * float(np.ptp(seen[:, 0]))
    ends = [[x, 0.0, depth] for x in (seen[:, 0].min() - reach, seen[:, 0].max() + reach)]
    return ("B" if along else "A"), np.array(ends) @ view @ plan.T[:, :2], -(plan @ view[2])[:2]


@dataclass(frozen=True)
class View:
    """A view by its name.

    Attributes:
        caption: its title on paper.
        words: what it is, for help.
        draw: draws it.
    """

    caption: str
    words: str
    draw: Callable[[Subject], Picture]


VIEWS = {
    "plan": View("Plan", "from above", _plan),
    "front": View("Front elevation", "level, from the design's own front", _elevation(-90)),
    "back": View("Back elevation", "level, from behind", _elevation(90)),
    "left": View("Left elevation", "level, from the left", _elevation(180)),
    "right": View("Right elevation", "level, from the right", _elevation(0)),
    "north": View("North elevation", "level, from +y, whichever way the design lies", _elevation(90, own=False)),
    "east": View("East elevation", "level, from +x", _elevation(0, own=False)),
    "south": View("South elevation", "level, from -y", _elevation(-90, own=False)),
    "west": View("West elevation", "level, from -x", _elevation(180, own=False)),
    "section": View("Section A-A", "cut across the longer side", _section(False)),
    "long-section": View("Section B-B", "cut along it", _section(True)),
    "axonometric": View("Axonometric", "from above, without perspective", _axonometric),
    "worms-eye": View("Worm's eye", "the same from below", _worms_eye),
    "motion": View("Motion", "states from flat to packed, side by side", _motion),
    "exploded": View("Exploded panels", "every panel moved away from the middle", _exploded),
}
