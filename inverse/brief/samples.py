"""Points spread over a surface, each with the area that it stands for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inverse._types import FloatArray, IntArray

FINENESS = 4096  # samples on a surface, at least about so many


@dataclass(frozen=True, eq=False)
class Samples:
    """Points of a surface.

    Attributes:
        points: (N, 3).
        areas: (N,) of the parts of the surface that the points stand for.
        normals: (N, 3) unit normals there.
        triangles: (N,) int, triangle that each lies on.
    """

    points: FloatArray
    areas: FloatArray
    normals: FloatArray
    triangles: IntArray


def spread(vertices: FloatArray, triangles: IntArray) -> Samples:
    """Samples of a surface: every triangle is cut into equal ones, more of them the larger it is.

    Args:
        vertices: (V, 3).
        triangles: (T, 3) int.
    """
    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1) / 2
    normals = normals / np.maximum(2 * areas, np.finfo(float).tiny)[:, None]
    parts = np.maximum(np.ceil(np.sqrt(areas * FINENESS / areas.sum())), 1).astype(np.int64)
    points, owners = [], []
    for count in np.unique(parts).tolist():
        own = np.flatnonzero(parts == count)
        shares = _centres(count)
        points.append(np.einsum("sk,tkx->tsx", shares, corners[own]).reshape(-1, 3))
        owners.append(np.repeat(own, len(shares)))
    owner = np.concatenate(owners)
    return Samples(np.concatenate(points), areas[owner] / parts[owner] ** 2, normals[owner], owner)


def _centres(count: int) -> FloatArray:
    """Barycentric coordinates (count^2, 3) of the centroids of the equal parts of a triangle."""
    i, j = np.meshgrid(np.arange(count), np.arange(count), indexing="ij")
    upright = i + j < count
    turned = i + j < count - 1
    first = np.stack([i[upright] + 1 / 3, j[upright] + 1 / 3], axis=1)
    second = np.stack([i[turned] + 2 / 3, j[turned] + 2 / 3], axis=1)
    b = np.concatenate([first, second]) / count
    return np.column_stack([b, 1 - b.sum(axis=1)])
