"""The picture of a design over its target and among its buildings."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.origami import geometry
from inverse.origami.pattern import Design
from inverse.pictures import drawing
from inverse.pictures.camera import basis, clear_view, perspective
from inverse.pictures.rendering import render
from inverse.pictures.scene import Caption, Scene, cells_of

Surface = tuple[FloatArray, IntArray]
_SIZE = (1920, 1440)
_CAPTION = 28  # pixels, of its letters and below it


def design_picture(
    design: Design,
    path: Path,
    *,
    target: Surface | None = None,
    context: Surface | tuple[FloatArray, IntArray, IntArray] | None = None,
    caption: str = "",
) -> None:
    """Write a PNG of the design state, seen from the side that shows most of it, lit from the upper left.

    Args:
        design: the design.
        path: the PNG file to write.
        target: vertices (V, 3) and triangles (T, 3) of its target surface, drawn translucent.
        context: vertices and triangles of buildings around it; a third array, the building of each triangle, is
            not needed. Nearly level triangles are drawn as roofs.
        caption: written below.

    Raises:
        RuntimeError: 3D pictures cannot be rendered here, see :func:`inverse.pictures.can_render`.
    """
    render(design_scene(design, target, context[:2] if context is not None else None, caption), path)


def design_scene(design: Design, target: Surface | None, context: Surface | None, caption: str = "") -> Scene:
    """What :func:`design_picture` shows."""
    points, pattern = design.vertices_coords, design.pattern
    azimuth, elevation = wished_view(points)
    view = basis(azimuth, elevation)
    if context is not None:
        view = clear_view(points, (azimuth, elevation), *context)
    size, cells = geometry.diagonal(points), cells_of(pattern.faces_vertices)
    height = float(points[:, 2].min()) - 0.05 * size if context is None else float(context[0][:, 2].min())
    own_shadow = drawing.shadow(points, cells, len(pattern.faces_vertices), view, height)
    if context is None:
        shown = [points, own_shadow.points]
        if target is not None and geometry.diagonal(target[0]) < 2 * size:
            shown.append(target[0])
        camera = perspective(np.concatenate(shown), view, _SIZE, 0.9)
    else:
        camera = perspective(points, view, _SIZE, 0.48)
    scene = Scene(_SIZE, camera)
    if context is not None:
        walls, corners = drawing.buildings(*context, view)
        reach = max(geometry.diagonal(context[0][:, :2]), size)
        scene.facets.append(drawing.ground(points.mean(axis=0), 1.6 * reach, height - 2e-3 * size))
        scene.facets.append(drawing.shadow(walls.points, walls.cells, len(context[1]), view, height - 1e-3 * size))
        scene.facets.append(walls)
        scene.lines.append(corners)
    sides = drawing.sides_of(pattern, points, view)
    facets, edges = drawing.structure(pattern, points, view, np.array(camera.position), camera.pixel, sides)
    scene.facets.extend([own_shadow, facets])
    scene.lines.append(edges)
    if target is not None:
        surface, rim = drawing.target(*target, view)
        scene.facets.append(surface)
        scene.lines.append(rim)
    if caption:
        scene.captions.append(Caption(caption, _SIZE[0] / 2, _CAPTION, _CAPTION))
    return scene


def wished_view(points: FloatArray) -> tuple[float, float]:
    """Azimuth and elevation of a three-quarter view of points (N, 3): the long side from the lower left."""
    centred = points[:, :2] - points[:, :2].mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    long = axes[:, 1] if axes[0, 1] + 1e-9 * axes[1, 1] >= 0 else -axes[:, 1]
    width, height = geometry.diagonal(points[:, :2]), float(np.ptp(points[:, 2]))
    tall = min(1.0, height / width)
    azimuth = float(np.arctan2(long[1], long[0])) - np.radians(58.0)
    return azimuth, float(np.radians(34.0 - 16.0 * tall))
