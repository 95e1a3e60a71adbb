"""The footprint of a design in each of its states: the rectangle or box that it fits into, measured by folding it."""

from __future__ import annotations

from typing import Any

import numpy as np

from inverse import geometry
from inverse.folding import fold
from inverse.pattern import Design, FloatArray

FLAT_STATES = {"developed": 0.0, "flat-folded": float(np.pi)}


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
    """Directions of the smallest box around points.

    Args:
        points: (N, 2) for the rectangle of least area, (N, 3) for the box of least volume.

    Returns:
        (d, d) unit vectors, row by row; the points extend farthest along the first and least along the last.
    """
    from trimesh import bounds  # takes longer to load than the rest of the package together

    dimension = points.shape[1]
    onto, _ = bounds.oriented_bounds_2D(points) if dimension == 2 else bounds.oriented_bounds(points)
    axes = np.asarray(onto[:dimension, :dimension])
    return np.asarray(axes[np.argsort(-extents(points, axes), kind="stable")])


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
