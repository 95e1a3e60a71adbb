"""The footprint of a design in each of its states: the rectangle or box that it fits into, measured by folding it."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from inverse._types import FloatArray
from inverse.origami import geometry
from inverse.origami.folding import fold
from inverse.origami.pattern import Design

FLAT_STATES = {"developed": 0.0, "flat-folded": float(np.pi)}
SKEW = np.array([1.0, 0.618, 0.271])  # across no axis that a design is likely to have
BOUND = 1e-9  # by which rounding may raise a bound
FLAT = 1e-9  # thickness, relative to the length, up to which a state has no hull in space


def laid_out(design: Design, t: float) -> FloatArray:
    """A state of a design with its first facet in the plane z = 0.

    Args:
        design: the mesh in its design state.
        t: folding amount in radians within [0, pi].

    Returns:
        (V, 3) vertices in the design's unit: the first one of facet 0 in the origin, the second one on the x axis,
        the third one beside it where y is positive.
    """
    coords = fold(design, np.array([t])).vertices_coords[0]
    a, b, c = coords[list(design.pattern.faces_vertices[0][:3])]
    x, z = geometry.unit(b - a), geometry.unit(np.cross(b - a, c - a))
    return np.asarray((coords - a) @ np.stack([x, np.cross(z, x), z], axis=1))


def box_axes(points: FloatArray) -> FloatArray:
    """Directions of the smallest box around points: one that lies on a side of their convex hull.

    Args:
        points: (N, 2) for the rectangle of least area, (N, 3) for the box of least volume.

    Returns:
        (d, d) unit vectors, row by row; the points extend farthest along the first and least along the last.
    """
    axes = _rectangle(points) if points.shape[1] == 2 else _box(points)
    axes = axes * np.sign(axes @ SKEW[: points.shape[1]])[:, None]  # of a line's two directions always the same
    return np.asarray(axes[np.argsort(-extents(points, axes), kind="stable")])


def _rectangle(points: FloatArray) -> FloatArray:
    try:
        across = ConvexHull(points).equations[:, :2]
    except QhullError:  # they lie on a line, within rounding
        return np.asarray(np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2])
    along = np.column_stack([-across[:, 1], across[:, 0]])
    best = np.argmin(np.ptp(points @ across.T, axis=0) * np.ptp(points @ along.T, axis=0))
    return np.array([along[best], across[best]])


def _box(points: FloatArray) -> FloatArray:
    _, sizes, directions = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    if sizes[2] <= FLAT * sizes[0]:
        return np.vstack([_rectangle(points @ directions[:2].T) @ directions[:2], directions[2]])
    hull = ConvexHull(points)
    corners, normals = points[hull.vertices], hull.equations[:, :3]

    def on_side(normal: FloatArray) -> tuple[float, FloatArray]:
        across = np.linalg.svd(normal[None])[2][1:]
        axes = np.vstack([_rectangle(corners @ across.T) @ across, normal])
        return float(np.prod(extents(corners, axes))), axes

    def least(some: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Of some sides the first one with the smallest box, and its axes."""
        # No box is smaller than what it holds seen along a side: the hull's area there, times how thick it is.
        shadows = np.abs(some @ areas.T).sum(axis=1) / 2
        bounds = shadows * np.ptp(corners @ some.T, axis=0) * (1 - BOUND)
        found: list[tuple[float, int, FloatArray]] = []
        smallest = np.inf
        for k in np.argsort(bounds, kind="stable").tolist():
            if bounds[k] > smallest:
                break
            volume, axes = on_side(some[k])
            found.append((volume, k, axes))
            smallest = min(smallest, volume)
        _, k, axes = min(found, key=lambda box: box[:2])
        return some[k], axes

    a, b, c = points[hull.simplices].transpose(1, 0, 2)
    areas = np.cross(b - a, c - a) / 2
    # A smooth hull has thousands of sides: a few degrees apart first, then those next to the best.
    best, _ = least(normals[np.unique(np.round(normals, 1), axis=0, return_index=True)[1]])
    return least(normals[np.linalg.norm(normals - best, axis=1) < 0.1])[1]


def extents(points: FloatArray, axes: FloatArray) -> FloatArray:
    """How far points (N, d) extend along axes (k, d): (k,) in their unit."""
    return np.asarray(np.ptp(points @ axes.T, axis=0))


def measured(design: Design, states: dict[str, float]) -> dict[str, Any]:
    """What every report tells of the footprint, in the design's unit.

    Args:
        design: the mesh in its design state.
        states: folding amounts in radians, by the names that the states are reported under.

    Returns:
        ``deployed``: extents [length, width, height] and area (length times width) of the smallest box around
        the design state; under each state's name the same, for a flat one [length, width] of the rectangle of
        least area; ``deployed_to_packed``: the design state's length, width and area divided by each state's.
    """
    deployed = _entry(design.vertices_coords)
    packed = {
        name: _entry(laid_out(design, t)[:, : 2 if t in FLAT_STATES.values() else 3]) for name, t in states.items()
    }
    ratios = {
        name: {
            "length": deployed["extents"][0] / entry["extents"][0],
            "width": deployed["extents"][1] / entry["extents"][1],
            "area": deployed["area"] / entry["area"],
        }
        for name, entry in packed.items()
    }
    return {"deployed": deployed, **packed, "deployed_to_packed": ratios}


def _entry(points: FloatArray) -> dict[str, Any]:
    sizes = extents(points, box_axes(points)).tolist()
    return {"extents": sizes, "area": sizes[0] * sizes[1]}
