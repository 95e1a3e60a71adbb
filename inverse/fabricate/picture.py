"""The picture of a thick structure in several states of its range (paper, Figure 13)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from inverse._types import FloatArray
from inverse.fabricate.meshes import COLOURS
from inverse.fabricate.panels.panels import Panels
from inverse.fabricate.parts import Part, panel_parts
from inverse.origami import folding, geometry
from inverse.pictures import colours, drawing
from inverse.pictures.camera import basis, parallel
from inverse.pictures.design_state import wished_view
from inverse.pictures.rendering import render
from inverse.pictures.scene import Caption, Facets, Lines, Scene, cells_of

_WIDTH, _MARGIN, _FOOT, _TEXT = 1600, 40, 56, 26
_GAP = 0.08  # between states, of the widest one
_SHADES = {
    "upper": colours.WARM,
    "lower": colours.COOL,
    "hinge": ("#8a8a86", COLOURS["hinge"]),
}


def panels_picture(panels: Panels, path: Path, *, columns: int = 3, rows: int = 2) -> None:
    """Write a PNG of a thick structure in states spread evenly over its range, both limits included.

    Args:
        panels: the structure.
        path: the PNG file to write.
        columns: pictures side by side.
        rows: of pictures.

    Raises:
        RuntimeError: 3D pictures cannot be rendered here, see :func:`inverse.pictures.can_render`.
    """
    render(panels_scene(panels, columns, rows), path)


def panels_scene(panels: Panels, columns: int, rows: int) -> Scene:
    """What :func:`panels_picture` shows."""
    design = panels.design
    azimuth, elevation = wished_view(design.vertices_coords)
    view = basis(azimuth, max(elevation, np.radians(28.0)))
    back = np.array([-view[2, 0], -view[2, 1], 0.0]) / np.hypot(view[2, 0], view[2, 1])
    t = panels.range.states(columns * rows)
    states = [_standing(panels, float(one), view[0], back) for one in t]
    clouds = [np.concatenate([part.points for part in parts]) for parts, _ in states]
    # All states stand on one ground, each row nearer to the viewer than the one before, with a line for captions.
    right, up = ([cloud @ axis for cloud in clouds] for axis in view[:2])
    wide = (1 + _GAP) * max(np.ptp(values) for values in right)
    pixel = columns * wide / (_WIDTH - 2 * _MARGIN)
    low, high = (np.array([bound(values) for values in up]).reshape(rows, columns) for bound in (np.min, np.max))
    tall = high.max(axis=1) - low.min(axis=1) + 2 * _FOOT * pixel
    height = int(16 * np.ceil((tall.sum() / pixel + 2 * _MARGIN) / 16))
    places = []  # of every state's origin, to the right and up
    for k in range(len(t)):
        row, column = divmod(k, columns)
        places.append(((column + 0.5) * wide, 2 * _FOOT * pixel - tall[: row + 1].sum() - low[row].min()))
    shifts = [x * view[0] + y / (back @ view[1]) * back for x, y in places]
    centre = np.array([columns * wide / 2, -tall.sum() / 2])
    placed = np.concatenate([cloud + shift for cloud, shift in zip(clouds, shifts, strict=True)])
    scene = Scene((_WIDTH, height), parallel(placed, view, pixel, centre, height))
    for k, ((parts, surface), shift) in enumerate(zip(states, shifts, strict=True)):
        count = len(design.pattern.faces_vertices)
        cells = cells_of(design.pattern.faces_vertices)
        scene.facets.append(drawing.shadow(surface + shift, cells, count, view, -2 * pixel))
        facets, lines = bodies(parts, shift, view, pixel)
        scene.facets.append(facets)
        scene.lines.append(lines)
        row = k // columns
        x = (places[k][0] - centre[0]) / pixel + _WIDTH / 2
        y = (-tall[: row + 1].sum() - centre[1]) / pixel + height / 2 + _FOOT / 2
        scene.captions.append(Caption(f"t = {np.degrees(t[k]):.0f}°", float(x), float(y), _TEXT))
    return scene


def _standing(panels: Panels, t: float, right: FloatArray, back: FloatArray) -> tuple[list[Part], FloatArray]:
    """Parts and ideal surface of a state, turned like the design, standing on the ground in the middle."""
    centred = panels.design.vertices_coords - panels.design.vertices_coords.mean(axis=0)
    parts, surface = placed(panels, t, centred)
    cloud = np.concatenate([part.points for part in parts])
    shift = np.array([0.0, 0.0, cloud[:, 2].min()])
    for axis in (right, back):
        shift += (np.min(cloud @ axis) + np.max(cloud @ axis)) / 2 * axis
    return [replace(part, points=part.points - shift) for part in parts], surface - shift


def placed(panels: Panels, t: float, onto: FloatArray) -> tuple[list[Part], FloatArray]:
    """Parts and ideal surface (V, 3) at ``t`` radians, moved as near as can be to vertices ``onto`` (V, 3)."""
    points = folding.fold(panels.design, np.array([t])).vertices_coords[0]
    home, there = points.mean(axis=0), onto.mean(axis=0)
    turn = geometry.turn_onto(points - home, onto - there).T
    parts = [replace(part, points=(part.points - home) @ turn + there) for part in panel_parts(panels, t)]
    return parts, (points - home) @ turn + there


def bodies(parts: list[Part], shift: FloatArray, view: FloatArray, pixel: float) -> tuple[Facets, Lines]:
    """All parts of a state, moved by ``shift`` (3,), as one set of facets and one of lines."""
    light = drawing.light_of(view)
    starts = np.cumsum([0, *(len(part.points) for part in parts)]).tolist()
    points = np.concatenate([part.points for part in parts]) + shift
    cells, shown, ends = [], [], []
    for part, start in zip(parts, starts, strict=False):
        corners = [part.points[list(polygon[:3])] for polygon in part.polygons]
        normals = geometry.unit(np.array([np.cross(b - a, c - b) for a, b, c in corners]))
        shown.append(colours.blend(_SHADES[part.layer], drawing.brightness(normals, light)))
        for polygon in part.polygons:
            numbers = [start + k for k in polygon]
            cells.append(tuple(numbers))
            ends += list(zip(numbers, numbers[1:] + numbers[:1], strict=True))
    once = np.unique(np.sort(np.array(ends, np.int64), axis=1), axis=0)
    length = float(np.median(np.linalg.norm(points[once[:, 0]] - points[once[:, 1]], axis=1)))
    width = float(np.clip(0.02 * length / pixel, 0.3, 1.0))
    ink = np.tile(colours.rgb(colours.FACET_EDGE), (len(once), 1))
    return Facets(points, cells_of(tuple(cells)), np.concatenate(shown)), Lines(points, once, ink, width)
