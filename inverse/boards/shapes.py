"""Shapes and lines in the plane: outlines, parts within a frame, what meets put together."""

from __future__ import annotations

from typing import Any

import numpy as np

from inverse._types import BoolArray, FloatArray, IntArray
from inverse.boards.hidden import united
from inverse.boards.overlay import union
from inverse.boards.sheet import Area, Item
from inverse.fabricate.extras import needed


def portions(edges: FloatArray, owners: IntArray, shares: FloatArray) -> FloatArray:
    """Parts (N, 2, 2) of lines (S, 2, 2 or 3), each between two shares (N, 2) of the length of its owner (N,)."""
    start, step = edges[owners, 0, :2], (edges[:, 1] - edges[:, 0])[owners, :2]
    return np.asarray(np.stack([start + shares[:, k, None] * step for k in (0, 1)], axis=1))


def along(lines: FloatArray, outline: Any, near: float) -> FloatArray:
    """The parts (M, 2, 2) of segments (N, 2, 2) that lie along an outline."""
    shapely = needed("shapely")
    rings = polylines(outline, 0.0)
    if not rings or not len(lines):
        return np.zeros((0, 2, 2))
    sides = np.concatenate([np.stack([ring[:-1], ring[1:]], axis=1) for ring in rings])
    k, j = shapely.STRtree(shapely.linestrings(sides)).query(shapely.buffer(shapely.linestrings(lines), near))
    start, step = lines[k, 0], lines[k, 1] - lines[k, 0]
    length = np.linalg.norm(step, axis=1)
    across = np.stack([-step[:, 1], step[:, 0]], axis=1) / length[:, None]
    off = np.abs(((sides[j] - start[:, None]) * across[:, None]).sum(axis=2)).max(axis=1)
    shares = ((sides[j] - start[:, None]) * step[:, None]).sum(axis=2) / length[:, None] ** 2
    low, high = shares.min(axis=1).clip(0, 1), shares.max(axis=1).clip(0, 1)
    found = (off <= near) & (low < high)
    owner, shares = united(k[found], np.stack([low, high], axis=1)[found])
    return portions(lines, owner, shares)


def opened(shapes: Any, width: float) -> Any:
    """Shapes without parts that are narrower than twice a width."""
    shapely = needed("shapely")
    return shapely.buffer(shapely.buffer(shapes, -width, join_style="mitre"), width, join_style="mitre")


def silhouette(corners: FloatArray) -> Any:
    """The silhouette of triangles (N, 3, 3) as they are seen."""
    shapely = needed("shapely")
    a, b, c = corners[:, :, :2].transpose(1, 0, 2)
    area = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    seen = area > 1e-9 * area.max(initial=1e-300)
    return union(shapely.polygons(corners[seen, :, :2]), 1e-7 * float(np.ptp(corners, axis=(0, 1)).max()))


def filled(shape: Any, colour: str) -> list[Item]:
    """Areas of a shape."""
    shapely = needed("shapely")
    parts = [part for part in shapely.get_parts(shape) if part.geom_type == "Polygon" and part.area > 0]
    return [
        Area(tuple(np.array(ring.coords)[:-1, :2] for ring in (part.exterior, *part.interiors)), colour)
        for part in parts
    ]


def polylines(shape: Any, least: float) -> list[FloatArray]:
    """The lines of a shape, but for those shorter than ``least``."""
    shapely = needed("shapely")
    parts = [p for p in shapely.get_parts(shape) if p.geom_type in ("LineString", "LinearRing") and p.length > least]
    return [np.array(part.coords)[:, :2] for part in parts]


def joined(segments: FloatArray) -> tuple[FloatArray, ...]:
    """Segments (N, 2, 2) that meet, as polylines."""
    if not len(segments):
        return ()
    shapely = needed("shapely")
    grid = 1e-9 * float(np.ptp(segments.reshape(-1, 2), axis=0).max())
    lines = shapely.linestrings(np.rint(segments / grid) * grid)
    return tuple(polylines(shapely.line_merge(shapely.union_all(lines)), 0.0))


def framed(segments: FloatArray, frame: FloatArray | None) -> FloatArray:
    """The parts (M, 2, 2) of segments (N, 2, 2) within a frame."""
    if frame is None or not len(segments):
        return segments
    start, step = segments[:, 0], segments[:, 1] - segments[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        shares = (frame[:, None] - start) / step  # (2, N, 2)
    outside = ((step == 0) & ((start < frame[0]) | (start > frame[1]))).any(axis=1)
    shares = np.where(step == 0, np.array([-np.inf, np.inf])[:, None, None], shares)
    low = np.maximum(shares.min(axis=0).max(axis=1), 0.0)
    high = np.minimum(shares.max(axis=0).min(axis=1), 1.0)
    kept: BoolArray = (low < high) & ~outside
    ends = [start + share[:, None] * step for share in (low, high)]
    return np.stack(ends, axis=1)[kept]


def is_inside(points: FloatArray, segments: FloatArray) -> BoolArray:
    """Whether closed outlines, given as segments (N, 2, 2), go around points (M, 2): rays to the right cross them."""
    (x1, y1), (x2, y2) = segments[:, 0].T, segments[:, 1].T
    x, y = points[:, :1], points[:, 1:]
    across = (y1 > y) != (y2 > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = x1 + (y - y1) / (y2 - y1) * (x2 - x1)
    return np.asarray((across & (at > x)).sum(axis=1) % 2 == 1)
