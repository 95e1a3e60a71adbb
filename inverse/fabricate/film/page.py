"""The motion as one HTML page with a slider: everything is in the file, nothing is fetched."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from inverse._types import FloatArray, IntArray
from inverse.fabricate.film.stage import Solid, Stage
from inverse.origami import folding, geometry
from inverse.origami.footprint import box_axes, extents
from inverse.pictures import colours, drawing
from inverse.pictures.camera import VIEW_ANGLE

_TEMPLATE = Path(__file__).with_name("page.html")


def motion_page(stage: Stage, rate: float) -> str:
    """The page, as text.

    Args:
        stage: what is shown; every frame is a place of the slider.
        rate: frames a second when it plays.
    """
    return _TEMPLATE.read_text(encoding="utf-8").replace("%DATA%", _quoted(_data(stage, rate)))


def _data(stage: Stage, rate: float) -> dict[str, Any]:
    design, view = stage.design, stage.view
    home = stage.points.mean(axis=0)  # near it, single precision is fine
    shown = stage.shown - home
    centre = (shown.min(axis=0) + shown.max(axis=0)) / 2
    reach = [shown, *(solid.vertices - home for solid in stage.solids)]
    top, bottom = drawing.sides_of(design.pattern, design.vertices_coords, view)
    light = drawing.light_of(view)
    return {
        "name": design.name,
        "unit": "" if design.unit == "unit" else design.unit,
        "rate": rate,
        "degrees": np.degrees(stage.t).tolist(),
        "extents": _extents(stage),
        "first": int(np.argmin(np.abs(stage.t - np.pi / 2))),
        "positions": _base64(stage.frames.vertices_coords - home, np.float32),
        "triangles": _base64(_fans(design.pattern.faces_vertices), np.uint32),
        "edges": _base64(design.pattern.edges_vertices, np.uint32),
        "solids": [_solid(solid, home) for solid in stage.solids],
        "top": top,
        "bottom": bottom,
        "ink": [colours.FACET_EDGE, colours.LAYER_EDGE],
        "faint": stage.faint.tolist(),
        "shadow": colours.SHADOW,
        "light": light.tolist(),
        "sun": drawing.sun_of(view).tolist(),
        "ground": stage.ground - float(home[2]),
        "azimuth": float(np.arctan2(view[2, 1], view[2, 0])),
        "elevation": float(np.arcsin(view[2, 2])),
        "view_angle": VIEW_ANGLE,
        "centre": centre.tolist(),
        "radius": float(np.linalg.norm(shown - centre, axis=1).max()),
        "reach": max(float(np.linalg.norm(points - centre, axis=1).max()) for points in reach),
    }


def _extents(stage: Stage) -> list[list[str]]:
    """Length, width and height of the smallest box around every frame, as words; exact in the flat states."""
    digits = 2 - int(np.floor(np.log10(geometry.diagonal(stage.design.vertices_coords))))
    states = folding.fold(stage.design, stage.t).vertices_coords
    sizes = [extents(points, box_axes(points)) for points in states]
    return [[f"{abs(round(size, digits)):.{max(0, digits)}f}" for size in row.tolist()] for row in sizes]


def _solid(solid: Solid, home: FloatArray) -> dict[str, Any]:
    used, triangles = np.unique(solid.triangles, return_inverse=True)
    return {
        "positions": _base64(solid.vertices[used] - home, np.float32),
        "triangles": _base64(triangles, np.uint32),
        "colours": solid.shades,
        "opacity": solid.opacity,
    }


def _fans(faces: tuple[tuple[int, ...], ...]) -> IntArray:
    """Triangles (T, 3) of convex facets."""
    return np.array([(face[0], face[k], face[k + 1]) for face in faces for k in range(1, len(face) - 1)], np.int64)


def _base64(values: NDArray[Any], kind: type[np.float32 | np.uint32]) -> str:
    little = np.dtype(kind).newbyteorder("<")
    return base64.b64encode(np.ascontiguousarray(values, little).tobytes()).decode("ascii")


def _quoted(data: dict[str, Any]) -> str:
    """JSON that cannot end the script element it stands in."""
    return json.dumps(data, allow_nan=False).replace("<", "\\u003c")
