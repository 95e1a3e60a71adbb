"""Target surfaces given as triangle or quad meshes."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.files.meshes import Polygons, read_mesh_file
from inverse.surfaces.base import ClosestPoints, Frame, Target
from inverse.surfaces.edges import edges_of


def without_repetitions(vertices: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray, FloatArray]:
    """A mesh with repeated vertices merged (every STL has them), so that borders are found by their edges.

    Args:
        vertices: (V, 3).
        triangles: (T, 3) int.

    Returns:
        Vertices, triangles without those that have no area, and unit normals (T, 3) of these.

    Raises:
        InputError: no triangles, numbers that are not finite, or no extent.
    """
    vertices = np.ascontiguousarray(vertices, np.float64)
    triangles = np.ascontiguousarray(triangles, np.int64)
    if len(triangles) == 0:
        raise InputError("the target mesh has no facets")
    if not np.isfinite(vertices[triangles]).all():
        bad = int(triangles.ravel()[np.argmax(~np.isfinite(vertices[triangles]).all(axis=2).ravel())])
        raise InputError(f"vertex {bad} of the target mesh is not finite: {vertices[bad].tolist()}")
    used, number = _in_order(triangles, len(vertices))
    places = vertices[used]
    size = float(np.linalg.norm(np.ptp(places, axis=0)))
    if size == 0:
        raise InputError("the target mesh has no size: all its vertices coincide")
    first, merged = _distinct(np.round((places - vertices[triangles.ravel()].mean(axis=0)) / (1e-9 * size)))
    triangles = merged[number[triangles]]
    a, b, c = places[first][triangles].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    area = np.linalg.norm(normals, axis=1)
    keep = area > 1e-14 * size**2
    if not keep.any():
        raise InputError("the target mesh has no area: all its facets are degenerate")
    return (
        np.ascontiguousarray(places[first]),
        np.ascontiguousarray(triangles[keep]),
        np.asarray(normals[keep] / area[keep, None]),
    )


def _in_order(triangles: IntArray, count: int) -> tuple[IntArray, IntArray]:
    """Vertices that triangles have, in the order in which these name them, and the place (count,) of each there."""
    corners = triangles.ravel()
    first = np.full(count, -1)
    first[corners[::-1]] = np.arange(len(corners))[::-1]
    used = corners[np.sort(first[first >= 0])]
    number = np.full(count, -1)
    number[used] = np.arange(len(used))
    return used, number


def _distinct(rows: FloatArray) -> tuple[IntArray, IntArray]:
    """The first ones of equal rows (N, 3), in the order of their numbers, and which of them each row (N,) is."""
    order = np.lexsort(rows.T[::-1])
    new = np.r_[True, (np.diff(rows[order], axis=0) != 0).any(axis=1)]
    merged = np.empty(len(rows), np.int64)
    merged[order] = np.cumsum(new) - 1
    return order[new], merged


class MeshTarget(Target):
    """A triangle mesh.

    Args:
        vertices: (V, 3).
        triangles: (T, 3) int.

    Raises:
        InputError: no triangles, numbers that are not finite, or no extent.
    """

    has_kinks = True

    def __init__(self, vertices: FloatArray, triangles: IntArray) -> None:
        self._vertices, self._triangles, self._normals = without_repetitions(vertices, triangles)

    def moved(self, origin: FloatArray) -> MeshTarget:
        """See :meth:`Target.moved`."""
        return MeshTarget(self._vertices - origin, self._triangles) if origin.any() else self

    def triangles(self) -> tuple[FloatArray, IntArray]:
        """See :meth:`Target.triangles`."""
        return self._vertices, self._triangles

    def closest(self, points: FloatArray) -> ClosestPoints:
        """See :meth:`Target.closest`."""
        _, facet, feet = self.nearest.find(points)
        normal = self._normals[facet]
        weights = normal[:, :, None] * normal[:, None, :]
        for k, edge in self._touched_borders(facet, feet).items():
            a, b = self._vertices[list(edge)]
            along = (b - a) / np.linalg.norm(b - a)
            inside = 1e-9 < float((feet[k] - a) @ along) / float(np.linalg.norm(b - a)) < 1 - 1e-9
            weights[k] = np.eye(3) - np.outer(along, along) if inside else np.eye(3)
        return ClosestPoints(feet, weights)

    def _touched_borders(self, facet: IntArray, feet: FloatArray) -> dict[int, tuple[int, int]]:
        """Border edge on which a foot lies, by the number of the foot."""
        touched = {}
        beside = np.flatnonzero(self._is_border[facet].any(axis=1))
        facet, feet = facet[beside], feet[beside]
        corners = self._vertices[self._triangles[facet]]
        size = np.linalg.norm(np.ptp(corners, axis=1), axis=1)
        for side in range(3):
            a, b = corners[:, side], corners[:, (side + 1) % 3]
            along = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
            distance = np.linalg.norm(np.cross(feet - a, along), axis=1)
            for k in np.flatnonzero((distance < 1e-9 * size) & self._is_border[facet, side]).tolist():
                row = self._triangles[facet[k]]
                touched[int(beside[k])] = int(row[side]), int(row[(side + 1) % 3])
        return touched

    @cached_property
    def _is_border(self) -> NDArray[np.bool_]:
        """(T, 3): which sides of the triangles are on the border."""
        edge, count = edges_of(self._triangles)
        return np.asarray(count[edge] == 1)

    @cached_property
    def frame(self) -> Frame:
        """The best-fit plane, with the smallest rectangle around the mesh in it; z upward where it can be."""
        points, areas = self.samples()
        centre = points.T @ areas / areas.sum()
        spread = (points - centre).T @ ((points - centre) * areas[:, None])
        z = np.linalg.eigh(spread)[1][:, 0]
        z = z if z[2] > 1e-6 or (abs(z[2]) <= 1e-6 and z[np.argmax(np.abs(z))] > 0) else -z
        x = np.eye(3)[np.argmin(np.abs(z))]
        x = x - (x @ z) * z
        x /= np.linalg.norm(x)
        y = np.cross(z, x)
        plan = (self._vertices - centre) @ np.stack([x, y], axis=1)
        turns = np.radians(np.arange(0.0, 90.0, 0.5))
        best = (np.inf, np.eye(2), plan.min(axis=0), plan.max(axis=0))
        for turn in turns:
            rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
            turned = plan @ rotation
            low, high = turned.min(axis=0), turned.max(axis=0)
            area = float(np.prod(high - low))
            if area < best[0] * (1 - 1e-9):
                best = (area, rotation, low, high)
        _, rotation, low, high = best
        axes = np.vstack([rotation.T @ np.stack([x, y]), z])
        middle = (low + high) / 2
        extent = high - low
        return Frame(centre + middle @ axes[:2], axes, (float(extent[0]), float(extent[1])))


def read_mesh(path: Path) -> MeshTarget:
    """Read a target mesh; polygons are cut into triangles around their centroids.

    Args:
        path: an OBJ, PLY, STL, OFF, GLB or glTF file.

    Raises:
        InputError: missing, empty, damaged or too large a file, unknown format, or a mesh that is none.
    """
    vertices, triangles = _triangulated(read_mesh_file(path))
    try:
        return MeshTarget(vertices, triangles)
    except InputError as error:
        raise InputError(error.message, where=str(path), hint=error.hint) from None


def _triangulated(mesh: Polygons) -> tuple[FloatArray, IntArray]:
    """Triangles as they are; a polygon of more sides, planar or not, around its centroid (no diagonal is preferred)."""
    vertices, sizes, corners = mesh.vertices, mesh.sizes, mesh.corners
    first = np.cumsum(sizes) - sizes
    facet = np.repeat(np.arange(len(sizes)), sizes)
    following = np.roll(corners, -1)
    following[first + sizes - 1] = corners[first]
    plain, cut = sizes == 3, sizes > 3
    centres = np.add.reduceat(vertices[corners], first)[cut] / sizes[cut, None]
    centre_of = len(vertices) + np.cumsum(cut) - 1
    sides = cut[facet]
    fans = np.stack([corners[sides], following[sides], centre_of[facet[sides]]], axis=1)
    triangles = np.concatenate([corners[first[plain, None] + np.arange(3)], fans])
    order = np.argsort(np.concatenate([np.flatnonzero(plain), facet[sides]]), kind="stable")
    return np.concatenate([vertices, centres]), triangles[order]
