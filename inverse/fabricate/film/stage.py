"""What an animation shows: the frames of a motion, what stands around it, and where all of it is seen from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.fabricate.film.poses import Poses, poses
from inverse.fabricate.film.surroundings import PERSON, Surface, Surroundings, check_unit, person
from inverse.fabricate.units import metres
from inverse.origami import geometry
from inverse.origami.pattern import Design
from inverse.pictures import colours, drawing
from inverse.pictures.camera import Camera, basis, clear_view, hidden_share, perspective
from inverse.pictures.design_state import wished_view
from inverse.pictures.states import has_layers

# Flat states are drawn this much before they are reached (1.1 degrees), so that their layers hide one another, and
# edges grow faint on the way to a stack of layers.
NEARLY, _STACKED = 0.02, np.radians(10.0)
FILL, FILL_AMONG_BUILDINGS = 0.84, 0.5  # share of the picture that the motion takes


@dataclass(frozen=True, eq=False)
class Solid:
    """A thing that stands still.

    Attributes:
        name: what it is.
        vertices: (V, 3).
        triangles: (T, 3).
        shades: its darkest and its brightest colour.
        opacity: 1 hides what is behind.
    """

    name: str
    vertices: FloatArray
    triangles: IntArray
    shades: colours.Shades
    opacity: float = 1.0


@dataclass(frozen=True, eq=False)
class Stage:
    """An animation before it is drawn.

    Attributes:
        design: the mesh in its design state.
        t: (S,) folding amounts in radians, as they are told.
        frames: the states that are drawn, the flat ones ``NEARLY`` so.
        surroundings: what stands around.
        figure: a person, if one stands there.
        view: right, up and towards the viewer, rows of (3, 3); the same in all frames.
        ground: height that shadows fall on, that of the lowest vertex or of the lowest building.
    """

    design: Design
    t: FloatArray
    frames: Poses
    surroundings: Surroundings
    figure: Surface | None
    view: FloatArray
    ground: float

    @property
    def points(self) -> FloatArray:
        """(N, 3) vertices of all frames: what the picture must have room for."""
        return self.frames.vertices_coords.reshape(-1, 3)

    @property
    def shown(self) -> FloatArray:
        """(N, 3) all that the picture should have room for: the motion, the person, a target of about its size."""
        parts = [self.points]
        if self.figure is not None:
            parts.append(self.figure[0])
        target = self.surroundings.target
        if target is not None and geometry.diagonal(target[0]) < 2 * geometry.diagonal(self.points):
            parts.append(target[0])
        return np.concatenate(parts)

    @property
    def faint(self) -> FloatArray:
        """(S,) from 0 to 1, how faintly the edges of every frame are drawn."""
        t, faint = self.frames.t, np.zeros(len(self.t))
        for flat in (0.0, np.pi):
            if has_layers(self.design, flat):
                faint = np.maximum(faint, 1 - (np.abs(t - flat) - NEARLY) / _STACKED)
        return np.minimum(faint, 1.0)

    @property
    def solids(self) -> list[Solid]:
        """What stands around, the translucent target last."""
        found = []
        if self.surroundings.context is not None:
            vertices, triangles = self.surroundings.context
            roof = drawing.are_roofs(vertices, triangles)
            found.append(Solid("walls", vertices, triangles[~roof], colours.WALL))
            found.append(Solid("roofs", vertices, triangles[roof], colours.ROOF))
        if self.figure is not None:
            found.append(Solid("person", *self.figure, colours.PERSON))
        if self.surroundings.target is not None:
            found.append(Solid("target", *self.surroundings.target, colours.TARGET, colours.TARGET_OPACITY))
        return [solid for solid in found if len(solid.triangles)]

    def camera(self, size: tuple[int, int]) -> Camera:
        """One camera for all frames, pictures being so many pixels wide and high."""
        fill = FILL if self.surroundings.context is None else FILL_AMONG_BUILDINGS
        return perspective(self.shown, self.view, size, fill)


def set_stage(design: Design, t: FloatArray, surroundings: Surroundings) -> Stage:
    """Fold a design to every frame and look for a view of all of them.

    Args:
        design: the mesh in its design state.
        t: (S,) folding amounts in radians within [0, pi].
        surroundings: what stands around.

    Raises:
        InputError: a person is wanted and the design has no unit of length.
    """
    if surroundings.person:
        check_unit(design.unit)
    frames = poses(design, np.clip(t, NEARLY, np.pi - NEARLY))
    wish = wished_view(design.vertices_coords)
    context = surroundings.context
    view = basis(*wish) if context is None else clear_view(design.vertices_coords, wish, *context)
    points = frames.vertices_coords.reshape(-1, 3)
    ground = float((points if context is None else context[0])[:, 2].min())
    figure = None
    if surroundings.person:
        facing = np.cross([0.0, 0.0, -1.0], view[0])  # the viewer
        figure = person(design.unit, _foothold(points, view, facing, ground, design.unit, context), facing)
    return Stage(design, t, frames, surroundings, figure, view, ground)


def _foothold(
    points: FloatArray, view: FloatArray, facing: FloatArray, ground: float, unit: str, context: Surface | None
) -> FloatArray:
    """Where a person stands, (3,): on the right of all that moves, or anywhere around it in sight among buildings."""
    height = PERSON / metres(unit)
    along = points @ view[0]
    aside, near = along.max() + 0.6 * height, np.median(points[along >= np.quantile(along, 0.8)] @ facing)
    first = aside * view[0] + near * facing + [0.0, 0.0, ground]
    if context is None:
        return np.asarray(first)
    middle = points.mean(axis=0) * [1.0, 1.0, 0.0] + [0.0, 0.0, ground]
    angles = np.radians(np.arange(0.0, 360.0, 15.0))
    round_about = np.cos(angles)[:, None] * view[0] + np.sin(angles)[:, None] * facing
    reach = geometry.diagonal(points[:, :2])
    places = [first, *(middle + radius * reach * way for radius in (0.5, 0.7, 0.9) for way in round_about)]
    corners = context[0][context[1]]
    some = points[:: max(1, len(points) // 1000)]

    def hidden(place: FloatArray) -> float:
        body = person(unit, place, facing)[0]
        eye = perspective(np.concatenate([some, body]), view, (16, 9), FILL_AMONG_BUILDINGS).position
        x, y, z = np.array(eye) - place
        seen_from = basis(np.arctan2(y, x), np.arctan2(z, np.hypot(x, y)))
        room = (body[::7] - place) * [6.0, 6.0, 1.5] + place  # seen well, not through a gap
        return hidden_share(room, seen_from, corners)

    return np.asarray(min(places, key=lambda place: round(hidden(place), 1)))
