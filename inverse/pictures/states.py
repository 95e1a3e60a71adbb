"""The picture of a design's three states side by side: developed, design and flat-folded."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from inverse._types import FloatArray
from inverse.origami import folding, geometry
from inverse.origami.pattern import CFL, FL, Design, Pattern
from inverse.pictures import drawing
from inverse.pictures.camera import basis, parallel
from inverse.pictures.design_state import wished_view
from inverse.pictures.rendering import render
from inverse.pictures.scene import Caption, Scene, cells_of

_WIDTH, _LEAST_HEIGHT, _MARGIN, _FOOT, _TEXT = 2400, 800, 80, 110, 40
_TITLES = ("developed (t = 0°)", "design (t = 90°)", "flat-folded (t = 180°)")
# The layers of a flat state are drawn apart by their order shortly before it, up to this share of its size.
_NEARLY, _THICKNESS = 0.01, 0.02


def states_picture(design: Design, path: Path) -> None:
    """Write a PNG of the developed, the design and the flat-folded state, at one scale on one ground.

    The flat states lie level. Where they have layers, these are drawn slightly apart.

    Args:
        design: the design.
        path: the PNG file to write.

    Raises:
        RuntimeError: 3D pictures cannot be rendered here, see :func:`inverse.pictures.can_render`.
    """
    render(states_scene(design), path)


def states_scene(design: Design) -> Scene:
    """What :func:`states_picture` shows."""
    pattern, points = design.pattern, design.vertices_coords
    azimuth, elevation = wished_view(points)
    view = basis(azimuth, max(elevation, np.radians(32.0)))
    states = [_laid_out(design, 0.0), points, _laid_out(design, np.pi)]
    faint = (has_layers(design, 0.0), False, has_layers(design, np.pi))
    return _in_a_row(pattern, states, _TITLES, faint, view)


def process_picture(designs: Sequence[Design], titles: Sequence[str], path: Path) -> None:
    """Write a PNG of designs of one pattern side by side, such as those on the way from a seed to a result.

    Args:
        designs: of the same pattern, in their order; the view is the one that suits the last.
        titles: one for each.
        path: the PNG file to write.

    Raises:
        RuntimeError: 3D pictures cannot be rendered here, see :func:`inverse.pictures.can_render`.
    """
    azimuth, elevation = wished_view(designs[-1].vertices_coords)
    states = [design.vertices_coords for design in designs]
    faint = [False] * len(states)
    render(_in_a_row(designs[-1].pattern, states, titles, faint, basis(azimuth, elevation)), path)


def _in_a_row(
    pattern: Pattern, states: Sequence[FloatArray], titles: Sequence[str], faint: Sequence[bool], view: FloatArray
) -> Scene:
    """Meshes of one pattern, vertices (V, 3) each, on one ground; ``faint`` ones are stacks of layers."""
    # Side by side as the viewer sees them, the middles on one level line on the ground, each over its caption.
    back = np.array([-view[2, 0], -view[2, 1], 0.0]) / np.hypot(view[2, 0], view[2, 1])
    states = [_centred(state, view[0], back) for state in states]
    cells = cells_of(pattern.faces_vertices)
    fallen = [drawing.shadow(state, cells, len(pattern.faces_vertices), view, 0.0).points for state in states]
    across = [np.r_[state, shadow] @ view[0] for state, shadow in zip(states, fallen, strict=True)]
    left, right = -np.array([x.min() for x in across]), np.array([x.max() for x in across])
    words = np.array([0.28 * _TEXT * len(title) for title in titles])  # half their lengths
    upwards = np.concatenate(states) @ view[1]
    gap, tall = 0.12 * max(np.ptp(state @ view[0]) for state in states), float(np.ptp(upwards))
    pixel = least = tall / (_WIDTH - 2 * _MARGIN - _FOOT)
    for _ in range(20):  # the captions' lengths on the ground depend on the scale, and the scale on them
        before, after = (np.maximum(side, words * pixel) + gap / 2 for side in (left, right))
        pixel = max(least, float((before + after).sum() - gap) / (_WIDTH - 2 * _MARGIN))
    middles = np.cumsum(before + after) - after
    placed = [state + x * view[0] for state, x in zip(states, middles, strict=True)]
    height = int(np.clip(16 * np.ceil((tall / pixel + 2 * _MARGIN + _FOOT) / 16), _LEAST_HEIGHT, _WIDTH))
    centre = np.array([(before + after).sum() / 2, (upwards.min() + upwards.max()) / 2 - _FOOT / 2 * pixel])
    camera = parallel(np.concatenate(placed), view, pixel, centre, height)
    scene = Scene((_WIDTH, height), camera)
    sides = drawing.sides_of(pattern, states[len(states) // 2], view)
    for state, title, x, thin in zip(placed, titles, middles, faint, strict=True):
        facets, edges = drawing.structure(pattern, state, view, None, pixel, sides, faint=thin)
        scene.facets.append(drawing.shadow(state, facets.cells, len(pattern.faces_vertices), view, -2 * pixel))
        scene.facets.append(facets)
        scene.lines.append(edges)
        scene.captions.append(Caption(title, float((x - centre[0]) / pixel) + _WIDTH / 2, _MARGIN, _TEXT))
    return scene


def has_layers(design: Design, t: float) -> bool:
    """Whether some edge is folded flat in this flat state."""
    return bool((design.pattern.edges_type == (CFL if t == 0.0 else FL)).any())


def _laid_out(design: Design, t: float) -> FloatArray:
    """A flat state, level, turned like the design and, where it has layers, with these apart."""
    flat = folding.flat_state(design, t)
    if has_layers(design, t):
        near = folding.flat_state(design, abs(t - _NEARLY))
        plane = np.c_[near[:, :2], np.ones(len(near))]
        height = near[:, 2] - plane @ np.linalg.lstsq(plane, near[:, 2], rcond=None)[0]
        flat[:, 2] = height * (_THICKNESS * geometry.diagonal(flat) / max(np.ptp(height), 1e-300))
    return _turned_like(flat, design.vertices_coords)


def _turned_like(flat: FloatArray, points: FloatArray) -> FloatArray:
    """A level state turned about the vertical to match the design seen from above.

    A design that stands upright is first laid on its back.
    """
    centred = points - points.mean(axis=0)
    plan = centred[:, 0] + 1j * centred[:, 1]
    if np.ptp(points[:, 2]) > geometry.diagonal(points[:, :2]):
        back = np.exp(1j * wished_view(points)[0]) * -1
        plan = back * (centred[:, 2] - 1j * (plan * back.conj()).imag)
    z = flat[:, 0] + 1j * flat[:, 1]
    turn = (plan * (z - z.mean()).conj()).sum()
    z = z * (turn / abs(turn)) if abs(turn) > 0 else z
    return np.stack([z.real, z.imag, flat[:, 2]], axis=1)


def _centred(points: FloatArray, right: FloatArray, back: FloatArray) -> FloatArray:
    """Points moved so that they stand on the ground, the middle of their extent at the origin."""
    for axis in (right, back):
        along = points @ axis
        points = points - (along.min() + along.max()) / 2 * axis
    return np.asarray(points - [0.0, 0.0, points[:, 2].min()])
