"""Where a 3D picture is seen from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inverse._types import FloatArray, IntArray

VIEW_ANGLE = 24.0  # degrees, vertical; a long lens, so that parallel lines stay nearly parallel


@dataclass(frozen=True)
class Camera:
    """A camera that stands upright.

    Attributes:
        position: (x, y, z).
        focus: the point in the middle of the picture.
        parallel_scale: half the visible height in a parallel projection, 0 for perspective.
        pixel: length that one pixel covers at the focus.
    """

    position: tuple[float, float, float]
    focus: tuple[float, float, float]
    parallel_scale: float
    pixel: float


def basis(azimuth: float, elevation: float) -> FloatArray:
    """Right, up and towards the viewer, rows of (3, 3), for a viewer in this direction (radians)."""
    ca, sa, ce, se = np.cos(azimuth), np.sin(azimuth), np.cos(elevation), np.sin(elevation)
    return np.array([[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]])


def perspective(points: FloatArray, view: FloatArray, size: tuple[int, int], fill: float) -> Camera:
    """A camera in direction ``view`` that sees points (N, 3) in the middle, over the share ``fill`` of the picture."""
    seen = points @ view.T
    half = np.tan(np.radians(VIEW_ANGLE / 2)) * np.array([size[0] / size[1], 1.0])
    centre = (seen[:, :2].min(axis=0) + seen[:, :2].max(axis=0)) / 2
    distance = 0.0
    for _ in range(20):
        distance = float((seen[:, 2:] + np.abs(seen[:, :2] - centre) / (half * fill)).max())
        slope = (seen[:, :2] - centre) / (distance - seen[:, 2:])
        centre = centre + (slope.min(axis=0) + slope.max(axis=0)) / 2 * (distance - seen[:, 2].mean())
    middle = float(seen[:, 2].mean())
    focus, position = (np.array([*centre, depth]) @ view for depth in (middle, distance))
    pixel = 2 * half[1] * (distance - middle) / size[1]
    return Camera(_triple(position), _triple(focus), 0.0, float(pixel))


def parallel(points: FloatArray, view: FloatArray, pixel: float, centre: FloatArray, height: int) -> Camera:
    """A camera without perspective; ``centre`` (2,) is the middle of the picture along right and up."""
    near = float((points @ view[2]).max())
    far = float((points @ view[2]).min())
    focus = np.array([*centre, (near + far) / 2]) @ view
    position = np.array([*centre, near + 2 * (near - far) + 100 * pixel]) @ view
    return Camera(_triple(position), _triple(focus), pixel * height / 2, pixel)


def hidden_share(points: FloatArray, view: FloatArray, corners: FloatArray) -> float:
    """Share of points (N, 3) that triangles (T, 3, 3) hide from a viewer far away in direction ``view``."""
    seen, triangles = points @ view.T, corners @ view.T
    a, b, c = triangles.transpose(1, 0, 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        area = _cross(b - a, c - a)
        p = seen[:, None]
        v, w = _cross(p - a, c - a) / area, _cross(b - a, p - a) / area
        depth = a[:, 2] + v * (b - a)[:, 2] + w * (c - a)[:, 2]
        hit = (v >= 0) & (w >= 0) & (v + w <= 1) & (depth > p[..., 2])
    return float(hit.any(axis=1).mean())


def clear_view(points: FloatArray, wish: tuple[float, float], vertices: FloatArray, triangles: IntArray) -> FloatArray:
    """The view nearest to the wished azimuth and elevation from which buildings hide little of the points."""
    sample = points[:: max(1, len(points) // 40)]
    corners = vertices[triangles]
    if len(corners) > 4000:
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        corners = corners[np.argsort(-area, kind="stable")[:4000]]
    best, least = basis(*wish), np.inf
    for turn in np.radians(np.arange(-180, 180, 20)):
        for lift in np.radians([0, 10, 20]):
            view = basis(wish[0] + turn, wish[1] + lift)
            cost = 3 * hidden_share(sample, view, corners) + 0.1 * abs(turn) + 0.8 * lift
            if cost < least:
                best, least = view, cost
    return best


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])


def _triple(point: FloatArray) -> tuple[float, float, float]:
    x, y, z = point.tolist()
    return x, y, z
