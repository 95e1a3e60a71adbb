"""Renders scenes off screen: run as a program of its own, because VTK without a usable GL kills its process.

It opens its window, says ``ready``, and then reads jobs from stdin until that is closed, each a line with the name of
a file in JSON. The file holds dictionaries from one pickler, made by :mod:`inverse.pictures.rendering`, each with the
name of a picture, which it says once that is there. Knows nothing of the package, so that it starts fast and from any
folder.

The picture is the mean of some renderings that are shifted by parts of a pixel, each in bands. With a software GL this
takes a fifth of the time and of the memory of a picture with four times the pixels and several samples in each.
"""

from __future__ import annotations

import json
import os
import pickle
import sys
from pathlib import Path
from typing import Any, TextIO

import numpy as np

# One rendering for each, in pixels: no two in one row or column, so that edges near to level have as many shades.
SHIFTS = [((8 - 2 * k - 1) / 16, ((10 * k + 3) % 16 - 7.5) / 16) for k in range(8)]
BAND = 512  # pixels that are rendered at a time are so many high
INK = (0x2B / 255, 0x2B / 255, 0x2B / 255)  # of captions
# Facets step back, the more the steeper they are seen, so that the lines on them are not half hidden. VTK's own steps
# are the same at all slopes, which lets lines behind a facet show through.
STEP = 0.75


class Window:
    """A render window off screen, opened once: what it needs of OpenGL is loaded by then."""

    def __init__(self) -> None:
        import vtkmodules.vtkRenderingFreeType
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  VTK finds its parts by their being loaded
        from vtkmodules.vtkRenderingCore import vtkMapper, vtkRenderWindow

        vtkMapper.SetResolveCoincidentTopologyToPolygonOffset()
        vtkMapper.SetResolveCoincidentTopologyPolygonOffsetParameters(STEP, 0.0)
        self._window = vtkRenderWindow()
        self._window.SetOffScreenRendering(1)
        self._window.SetMultiSamples(0)
        self.render(_first_scene())

    def render(self, scene: dict[str, Any]) -> np.ndarray:
        """The picture, (height, width, 3) uint8."""
        from vtkmodules.vtkRenderingCore import vtkRenderer

        width, height = scene["size"]
        tall = min(BAND, height)
        renderer = vtkRenderer()
        renderer.SetBackground(1.0, 1.0, 1.0)
        renderer.SetUseOIT(False)  # translucent facets are blended in their order
        self._window.SetSize(width, tall)
        self._window.AddRenderer(renderer)
        for item in scene["facets"]:
            renderer.AddActor(_flat(item["points"], item["cells"], item["colours"], item["opacity"]))
        camera = _set_up(renderer, scene)
        for item in scene["lines"]:
            points, cells, seen = _ribbons(item, scene, camera.GetClippingRange()[0])
            if seen.any():  # a closed surface has no rim
                renderer.AddActor(_flat(points, cells, item["colours"][seen], forward=STEP))
        captions = [_caption(item) for item in scene["captions"]]
        for caption in captions:
            renderer.AddActor(caption)
        renderer.ResetCameraClippingRange()
        # The camera is turned to a band by moving the middle of its picture, which keeps the perspective.
        if scene["camera"]["parallel_scale"]:
            camera.SetParallelScale(scene["camera"]["parallel_scale"] * tall / height)
        else:
            half = np.tan(np.radians(scene["view_angle"] / 2)) * tall / height
            camera.SetViewAngle(2 * np.degrees(np.arctan(half)))
        picture = np.empty((height, width, 3), np.uint8)
        for low in range(0, height, tall):
            for caption, item in zip(captions, scene["captions"], strict=True):
                caption.SetPosition(item["x"], item["y"] - low)
            band = np.zeros((tall, width, 3), np.uint16)
            for across, upwards in SHIFTS:
                camera.SetWindowCenter(2 * across / width, (2 * (low + upwards) - height) / tall + 1)
                band += self._seen(width, tall)
            mean = ((band + len(SHIFTS) // 2) // len(SHIFTS)).astype(np.uint8)
            high = min(low + tall, height)
            picture[height - high : height - low] = mean[: high - low][::-1]
        self._window.RemoveRenderer(renderer)
        renderer.ReleaseGraphicsResources(self._window)
        return picture

    def _seen(self, width: int, height: int) -> np.ndarray:
        """What the window shows now, (height, width, 3) uint8 from below."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

        self._window.Render()
        pixels = vtkUnsignedCharArray()
        self._window.GetPixelData(0, 0, width - 1, height - 1, 0, pixels, 0)
        return np.asarray(vtk_to_numpy(pixels).reshape(height, width, 3))


def _flat(
    points: np.ndarray, cells: np.ndarray, colours: np.ndarray, opacity: float = 1.0, forward: float = 0.0
) -> Any:
    """Facets in their colours as they are, brought forward by so many of their steps."""
    import pyvista
    from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

    counts, corners = _unpacked(cells)
    mesh = pyvista.PolyData(np.asarray(points, np.float64)[corners], faces=_packed(counts))
    mesh.point_data["colours"] = np.repeat(colours, counts, axis=0)
    mesh.set_active_scalars("colours", preference="point")
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(mesh)
    mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(-forward, 0.0)
    actor = vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().LightingOff()
    actor.GetProperty().SetOpacity(opacity)
    return actor


def _unpacked(cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of corners of polygons as VTK stores them, and all corners in a row."""
    counts, heads, at = [], [], 0
    while at < len(cells):
        heads.append(at)
        counts.append(cells[at])
        at += cells[at] + 1
    return np.array(counts, np.int64), np.delete(cells, heads)


def _packed(counts: np.ndarray) -> np.ndarray:
    """Polygons of so many corners each, no two of which have one in common, as VTK stores them."""
    starts = np.cumsum(counts) - counts
    return np.insert(np.arange(counts.sum()), starts, counts)


def _caption(item: dict[str, Any]) -> Any:
    from vtkmodules.vtkRenderingCore import vtkTextActor

    actor = vtkTextActor()
    actor.SetInput(item["text"])
    text = actor.GetTextProperty()
    text.SetFontSize(item["size"])
    text.SetColor(*INK)
    text.SetJustificationToCentered()
    return actor


def _set_up(renderer: Any, scene: dict[str, Any]) -> Any:
    camera = renderer.GetActiveCamera()
    camera.SetPosition(scene["camera"]["position"])
    camera.SetFocalPoint(scene["camera"]["focus"])
    camera.SetViewUp(0.0, 0.0, 1.0)
    camera.SetViewAngle(scene["view_angle"])
    if scene["camera"]["parallel_scale"]:
        camera.ParallelProjectionOn()
        camera.SetParallelScale(scene["camera"]["parallel_scale"])
    renderer.ResetCameraClippingRange()
    return camera


def _ribbons(item: dict[str, Any], scene: dict[str, Any], near: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lines as strips of constant width on the picture: GL's own are of whole pixels, and on some machines of one.

    Args:
        item: lines.
        scene: where they are seen from.
        near: least distance in front of the camera that is seen.

    Returns:
        Vertices, cells, and which lines (S,) are seen.
    """
    camera = scene["camera"]
    position = np.array(camera["position"], np.float64)
    gaze = np.array(camera["focus"]) - position
    gaze /= np.linalg.norm(gaze)
    right = np.cross(gaze, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(right, gaze)])
    ends = np.asarray(item["points"], np.float64)[item["ends"]]  # (S, 2, 3)
    depth = (ends - position) @ gaze
    seen = (depth > near).any(axis=1)
    ends, depth = ends[seen], depth[seen]
    # What is behind the camera would come out on the wrong side of the picture.
    step, fall = ends[:, ::-1] - ends, depth[:, ::-1] - depth
    share = np.where(depth < near, (near - depth) / np.where(depth < near, fall, 1.0), 0.0)
    ends, depth = ends + share[..., None] * step, np.maximum(depth, near)
    height = scene["size"][1]
    if camera["parallel_scale"]:
        pixel = np.full_like(depth, 2 * camera["parallel_scale"] / height)
    else:
        pixel = depth * (2 * np.tan(np.radians(scene["view_angle"] / 2)) / height)
    places = (ends - position) @ axes.T / pixel[..., None]
    along = places[:, 1] - places[:, 0]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    aside = np.stack([-along[:, 1], along[:, 0]], axis=1) @ axes * (item["width"] / 2)
    half = aside[:, None] * pixel[..., None]
    corners = np.concatenate([ends - half, (ends + half)[:, ::-1]], axis=1)  # (S, 4, 3), around
    cells = np.insert(np.arange(4 * len(corners)).reshape(-1, 4), 0, 4, axis=1).ravel()
    return corners.reshape(-1, 3), cells, seen


def _first_scene() -> dict[str, Any]:
    """A scene with something of every kind, so that nothing is left to be compiled when the first one comes."""
    points, colours = np.array([[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [0.0, 0.0, 1.0]]), np.zeros((1, 3), np.uint8)
    facets = [{"points": points, "cells": np.array([3, 0, 1, 2]), "colours": colours, "opacity": o} for o in (1.0, 0.3)]
    lines = [{"points": points, "ends": np.array([[0, 1]]), "colours": colours, "width": 1.0}]
    captions = [{"text": "a", "x": 8.0, "y": 8.0, "size": 28}]
    camera = {"position": (0.0, -9.0, 0.0), "focus": (0.0, 0.0, 0.0), "parallel_scale": 0.0}
    return {"size": (64, 64), "view_angle": 24.0, "camera": camera, "facets": facets, "lines": lines,
            "captions": captions}  # fmt: skip


def main() -> None:
    """Open the window, and render what is asked for until nobody asks any more."""
    from PIL import Image

    told = _apart()
    window = Window()
    print("ready", file=told, flush=True)
    for line in sys.stdin:
        with Path(json.loads(line)).open("rb") as file:
            scenes = pickle.Unpickler(file)
            while file.peek(1):
                scene = scenes.load()
                Image.fromarray(window.render(scene)).save(scene["picture"], compress_level=4)
                print(scene["picture"], file=told, flush=True)


def _apart() -> TextIO:
    """Where answers go: what libraries print on stdout must not be taken for one."""
    told = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    return told


if __name__ == "__main__":
    main()
