"""Every facet's own frame, in which the outlines of its panel are given."""

from __future__ import annotations

import numpy as np

from inverse._types import FloatArray
from inverse.origami import folding, geometry
from inverse.origami.pattern import Design, Pattern


def frames(pattern: Pattern, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Frames of all facets at vertices (V, 3): axes x, y, z as rows, (F, 3, 3), and origins, (F, 3).

    The origin is the facet's first vertex, x points to its second one, z to the top side.
    """
    first, second = np.array([face[:2] for face in pattern.faces_vertices]).T
    z = geometry.facet_normals(pattern, points)
    along = points[second] - points[first]
    x = geometry.unit(along - (along * z).sum(axis=1, keepdims=True) * z)
    return np.stack([x, np.cross(z, x), z], axis=1), points[first]


def poses(design: Design, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Frames at folding amounts ``t`` (S,), radians: axes as rows (S, F, 3, 3), origins (S, F, 3); facet 0 rests."""
    found = [frames(design.pattern, points) for points in folding.fold(design, t).vertices_coords]
    return np.array([axes for axes, _ in found]), np.array([origins for _, origins in found])


def local_corners(design: Design) -> list[FloatArray]:
    """Corners of every facet, (k, 2), in its own frame."""
    axes, origins = frames(design.pattern, design.vertices_coords)
    return [
        (design.vertices_coords[list(face)] - origin) @ own[:2].T
        for face, own, origin in zip(design.pattern.faces_vertices, axes, origins, strict=True)
    ]
