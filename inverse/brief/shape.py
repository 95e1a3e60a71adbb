"""How even the facets of a mesh are, and how large."""

from __future__ import annotations

import numpy as np

from inverse._types import FloatArray
from inverse.origami.pattern import Pattern


def slenderness(pattern: Pattern, points: FloatArray) -> FloatArray:
    """Width of every facet over its length, (F,): least distance of two parallels around it over its diameter."""
    found = np.empty(len(pattern.faces_vertices))
    for facets in pattern.faces_by_sides.values():
        corners = points[np.array([pattern.faces_vertices[f] for f in facets])]
        apart = np.linalg.norm(corners[:, :, None] - corners[:, None, :], axis=3)
        edges = np.roll(corners, -1, axis=1) - corners
        edges /= np.maximum(np.linalg.norm(edges, axis=2, keepdims=True), 1e-300)
        offsets = corners[:, None, :, :] - corners[:, :, None, :]
        heights = np.linalg.norm(np.cross(edges[:, :, None, :], offsets), axis=3).max(axis=2)
        found[facets] = heights.min(axis=1) / np.maximum(apart.max(axis=(1, 2)), 1e-300)
    return found


def diameters(pattern: Pattern, points: FloatArray) -> FloatArray:
    """Largest distance of two corners of every facet, (F,)."""
    found = np.empty(len(pattern.faces_vertices))
    for facets in pattern.faces_by_sides.values():
        corners = points[np.array([pattern.faces_vertices[f] for f in facets])]
        found[facets] = np.linalg.norm(corners[:, :, None] - corners[:, None, :], axis=3).max(axis=(1, 2))
    return found
