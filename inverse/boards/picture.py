"""One view as lines and areas in the design's unit, hidden ones removed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.boards.body import NONE, Body, normals, together
from inverse.boards.hidden import Facets, rest_of
from inverse.boards.overlay import less, union
from inverse.boards.shapes import along, filled, framed, is_inside, joined, opened, polylines, portions, silhouette
from inverse.boards.sheet import GREY, Area, Item, Pen, Stroke
from inverse.fabricate.extras import needed
from inverse.pictures import colours

Style = Literal["line", "shaded", "shadow"]
STYLES = {
    "line": "lines alone",
    "shaded": "facets lit from the upper left",
    "shadow": "the same, with the shadow on the ground where it is seen",
}
CUT, OUTLINE, PROFILE, FOLD = Pen(0.7), Pen(0.45), Pen(0.22), Pen(0.12)
CONTEXT, CONTEXT_CUT = Pen(0.13, GREY), Pen(0.4, "#5b5a57")
HIDDEN = Pen(0.1, GREY, (0.9, 0.7))
TARGET = Pen(0.2, "#2f7fb5", (2.4, 0.7, 0.4, 0.7))
SHADOW, POCHE, BODY = "#d5d3cd", "#a3a19c", "#55534f"
TOP: colours.Shades = ("#b9b4a9", "#fffdf8")
UNDER: colours.Shades = ("#8d9aa6", "#e4e9ed")
WALL: colours.Shades = ("#d9d8d4", "#f7f7f5")
SKEW = 0.03  # of the design's depth: buildings whose edge is not quite square to an elevation are cut whole
SLIVER = 50.0  # times the length below which things touch: narrower remains of areas are rounding
SHORT = 1e-4  # of the picture's size: parts of lines that are shorter are rounding


@dataclass(frozen=True, eq=False)
class Picture:
    """A drawn view, in the design's unit.

    Attributes:
        items: what is drawn, the first one lowest.
        low: (2,) lower left corner of all of it.
        high: (2,) upper right corner.
        measured: the same of the design alone, (2, 2), where its size is told.
        apart: edge of squares whose lines are as dense as those of the design.
        supports: (N, 2) where it is held.
        words: what is written at places of it, with the place of the middle of their base line.
        marks: places (2, 2) of the two ends of a line where a section is cut, by its letter, and the way it looks.
        north: direction (2,) of +y in a plan that is turned.
        compass: the word for it.
        figure: whether a person is in it.
    """

    items: list[Item]
    low: FloatArray
    high: FloatArray
    measured: FloatArray | None = None
    apart: float = 1.0
    supports: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    words: tuple[tuple[str, FloatArray], ...] = ()
    marks: tuple[tuple[str, FloatArray, FloatArray], ...] = ()
    north: FloatArray | None = None
    compass: str = "y"
    figure: bool = False


@dataclass(frozen=True, eq=False)
class Scene:
    """What a view shows, in space.

    Attributes:
        design: the mesh.
        context: buildings.
        target: vertices (V, 3), triangles (T, 3) and rim (R, 2, 3) of the target surface.
        figure: triangles of a person, (N, 3, 3).
        ground: height of the ground for shadows and ground lines; None where there is none.
        sun: (3,) towards the light that throws the shadows.
        turned: whether the lower sides of facets are those that are seen first, as the outside of some tubes.
    """

    design: Body
    context: Body | None = None
    target: tuple[FloatArray, IntArray, FloatArray] | None = None
    figure: FloatArray | None = None
    ground: float | None = None
    sun: FloatArray = field(default_factory=lambda: np.array([-1.0, -1.0, 1.0]))
    turned: bool = False


def draw(
    scene: Scene, view: FloatArray, style: Style, *, depth: float | None = None, frame: FloatArray | None = None,
    hidden: bool = False, upright: bool = False,
) -> Picture:  # fmt: skip
    """Draw a scene without perspective.

    Args:
        scene: what is drawn.
        view: right, up and towards the viewer, rows of (3, 3).
        style: how.
        depth: of a plane across the line of sight that cuts the design; what is in front of it is left out.
        frame: (2, 2) lower left and upper right corner of what is shown of buildings.
        hidden: dash the hidden lines of the design.
        upright: the ground is seen edge on, and drawn as a line.
    """
    design = scene.design.seen(view)
    context, across = None, np.zeros((0, 2, 2))
    if scene.context is not None and frame is not None:
        context = scene.context.seen(view)
        if upright:  # what stands before the design is cut off
            near, far = design.points[:, 2].max(), design.points[:, 2].min()
            front = float(near - SKEW * (near - far)) if depth is None else depth
            across = context.cut(front)
            context = context.behind(front)
        context = _near_frame(context, frame)
    whole, cuts = design, np.zeros((0, 2, 2))
    if depth is not None:
        cuts, design = design.cut(depth), design.behind(depth)
    size = float(np.linalg.norm(np.ptp(whole.points[:, :2], axis=0)))
    items: list[Item] = []
    every = design if context is None else together([design, context])
    facets = Facets(every.polygons)
    if style == "shadow" and scene.ground is not None and not upright:
        items += _shadow(scene, scene.ground, view, facets, frame)
    if style != "line":
        items += _areas(scene, every, facets, len(design.polygons), view, frame)
    if context is not None:
        sharp = framed(_visible(context.edges, facets)[0], frame)
        long = np.linalg.norm(sharp[:, 1] - sharp[:, 0], axis=1) > 10 * SHORT * size
        items.append(Stroke(tuple(sharp[long]), CONTEXT))
    lines, apart = _lines(design, facets, size, hidden)
    items += [*lines, *_cut_buildings(across, frame), Stroke(joined(cuts), CUT)]
    if scene.target is not None:
        items.append(Stroke(_target(scene.target, view, depth), TARGET))
    flat = whole.points[:, :2]
    measured = np.array([flat.min(axis=0), flat.max(axis=0)])
    corners = [measured, *_corners(items)]
    if scene.figure is not None:
        shape = silhouette(scene.figure @ view.T)
        items += filled(shape, BODY)
        corners.append(np.array(shape.bounds).reshape(2, 2))
    low, high = np.min([c[0] for c in corners], axis=0), np.max([c[1] for c in corners], axis=0)
    if context is not None and frame is not None:
        low, high = frame
    high = np.maximum(high, low + 1e-3 * size)  # a sheet seen edge on
    if upright and scene.ground is not None and low[1] - 1e-6 * size <= scene.ground <= high[1]:
        reach = 0.06 * (high[0] - low[0])
        low, high = low - np.array([reach, 0.0]), high + np.array([reach, 0.0])
        items.append(Stroke((np.array([[low[0], scene.ground], [high[0], scene.ground]]),), Pen(0.35)))
    return Picture(items, low, high, measured, apart, figure=scene.figure is not None)


def light_of(view: FloatArray, sun: FloatArray) -> FloatArray:
    """Unit vector (3,) to the light: the sun seen from above, else from the viewer's upper left."""
    light = sun if view[2, 2] > 0.1 else view.T @ np.array([-0.55, 0.6, 0.75])
    return np.asarray(light / np.linalg.norm(light))


def _near_frame(body: Body, frame: FloatArray) -> Body:
    """The facets and lines of a seen body that may be within a frame."""
    low = np.array([polygon[:, :2].min(axis=0) for polygon in body.polygons])
    high = np.array([polygon[:, :2].max(axis=0) for polygon in body.polygons])
    there = ((low <= frame[1]) & (high >= frame[0])).all(axis=1)
    edges = body.edges[:, :, :2]
    kept = ((edges.min(axis=1) <= frame[1]) & (edges.max(axis=1) >= frame[0])).all(axis=1)
    polygons = tuple(polygon for polygon, keep in zip(body.polygons, there, strict=True) if keep)
    return Body(polygons, body.edges[kept], np.full((int(kept.sum()), 2), NONE))


def _visible(edges: FloatArray, facets: Facets) -> tuple[FloatArray, IntArray, FloatArray]:
    """Visible parts (N, 2, 2) of lines (S, 2, 3), the line of each (N,), and hidden parts (M, 2, 2)."""
    owners, parts = facets.hidden(edges)
    kept, rest = rest_of(len(edges), owners, parts)
    return portions(edges, kept, rest), kept, portions(edges, owners, parts)


def _lines(design: Body, facets: Facets, size: float, hidden: bool) -> tuple[list[Item], float]:
    """Folds thin, profiles heavier, the outline of the whole heaviest; and the edge of squares that are as dense."""
    lines, owner, behind = _visible(design.edges, facets)
    long = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) > SHORT * size
    lines, owner = lines[long], owner[long]
    front = np.append(normals(design.polygons)[:, 2] > 0, False)
    one, two = design.sides.T
    profile = (one == NONE) | (two == NONE) | (front[one] != front[two])
    whole = union(facets.areas[: len(design.polygons)], facets.near)
    outline = whole.boundary
    apart = 2 * whole.area / max(float(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum()), 1e-9 * size)
    heavy = along(lines[profile[owner]], outline, 1e-5 * size)
    heavy = heavy[np.linalg.norm(heavy[:, 1] - heavy[:, 0], axis=1) > SHORT * size]
    items: list[Item] = []
    if hidden:
        items.append(Stroke(tuple(behind), HIDDEN))
    items.append(Stroke(tuple(lines[~profile[owner]]), FOLD))
    items.append(Stroke(tuple(lines[profile[owner]]), PROFILE))
    items.append(Stroke(tuple(heavy), OUTLINE))
    return items, apart


def _areas(
    scene: Scene, body: Body, facets: Facets, n_design: int, view: FloatArray, frame: FloatArray | None
) -> list[Item]:
    """Facets in the colours of the light that falls on them."""
    shapely = needed("shapely")
    normal = normals(body.polygons)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    top = normal[:, 2] > 0
    share = (np.where(top[:, None], normal, -normal) @ view @ light_of(view, scene.sun) + 0.25) / 1.25
    building = np.arange(len(body.polygons)) >= n_design
    tones = np.where((top != scene.turned)[:, None], colours.blend(TOP, share), colours.blend(UNDER, share))
    tones = np.where(building[:, None], colours.blend(WALL, share), tones)
    # What is left of hidden facets through gaps as wide as rounding goes.
    shapes = opened(facets.visible_areas(), SLIVER * facets.near)
    items: list[Item] = []
    # Of a building only whole surfaces have lines around them: their triangles are put together by their tone.
    walls: dict[tuple[int, ...], list[Any]] = {}
    for shape, tone, wall in zip(shapes, map(tuple, tones.tolist()), building, strict=True):
        if wall:
            walls.setdefault(tone, []).append(shape)
        else:
            items += filled(shape, "#" + bytes(tone).hex())
    window = None if frame is None else shapely.box(*frame.ravel())
    for tone, parts in walls.items():
        whole = union(shapely.buffer(parts, 5 * facets.near, join_style="mitre"), facets.near)
        whole = shapely.buffer(opened(whole, SLIVER * facets.near), 10 * facets.near, join_style="mitre")
        items += filled(whole if window is None else shapely.intersection(whole, window), "#" + bytes(tone).hex())
    return items


def _shadow(scene: Scene, ground: float, view: FloatArray, facets: Facets, frame: FloatArray | None) -> list[Item]:
    """What is seen of the shadow on the ground."""
    shapely = needed("shapely")
    bodies = [scene.design] if scene.context is None else [scene.design, scene.context]
    fallen = []
    for polygon in (one for body in bodies for one in body.polygons):
        away = polygon - np.outer((polygon[:, 2] - ground) / scene.sun[2], scene.sun)
        fallen.append(shapely.MultiPoint((away @ view.T)[:, :2]).convex_hull)
    shape = union([one for one in fallen if one.area > 0], facets.near)
    shape = less(shape, union(facets.areas, facets.near), facets.near)
    if frame is not None:
        shape = shapely.intersection(shape, shapely.box(*frame.ravel()))
    return filled(shape, SHADOW)


def _cut_buildings(segments: FloatArray, frame: FloatArray | None) -> list[Item]:
    """Buildings where they are cut: filled where the lines close."""
    if not len(segments):
        return []
    shapely = needed("shapely")
    grid = 1e-6 * float(np.ptp(segments.reshape(-1, 2), axis=0).max())
    lines = shapely.node(shapely.set_precision(shapely.multilinestrings(list(shapely.linestrings(segments))), grid))
    closed = shapely.get_parts(shapely.polygonize([lines]))
    within = is_inside(shapely.get_coordinates(shapely.point_on_surface(closed)), segments)
    whole = shapely.union_all(closed[within])
    if frame is not None:
        whole = shapely.intersection(whole, shapely.box(*frame.ravel()))
    return [*filled(whole, POCHE), Stroke(joined(framed(segments, frame)), CONTEXT_CUT)]


def _target(
    target: tuple[FloatArray, IntArray, FloatArray], view: FloatArray, depth: float | None
) -> tuple[FloatArray, ...]:
    """The outline and the rim of a target, or where a plane cuts it."""
    vertices, triangles, rim = target
    corners = (vertices @ view.T)[triangles]
    if depth is not None:
        return joined(Body(tuple(corners), np.zeros((0, 2, 3)), np.zeros((0, 2), np.int64)).cut(depth))
    outline = silhouette(corners).boundary
    return (*polylines(outline, 0.0), *tuple((rim @ view.T)[:, :, :2]))


def _corners(items: Sequence[Item]) -> list[FloatArray]:
    """Lower left and upper right corner (2, 2) of every item that has any."""
    found = []
    for item in items:
        parts = () if not isinstance(item, Area | Stroke) else item.rings if isinstance(item, Area) else item.lines
        if len(parts):
            points = np.concatenate(parts)
            found.append(np.array([points.min(axis=0), points.max(axis=0)]))
    return found
