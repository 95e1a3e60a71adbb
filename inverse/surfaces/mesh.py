"""Target surfaces given as triangle or quad meshes."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.files.meshes import Polygons, read_mesh_file
from inverse.surfaces.base import ClosestPoints, Frame, Target


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
        vertices = np.ascontiguousarray(vertices, np.float64)
        triangles = np.ascontiguousarray(triangles, np.int64)
        if len(triangles) == 0:
            raise InputError("the target mesh has no facets")
        if not np.isfinite(vertices[triangles]).all():
            bad = int(triangles.ravel()[np.argmax(~np.isfinite(vertices[triangles]).all(axis=2).ravel())])
            raise InputError(f"vertex {bad} of the target mesh is not finite: {vertices[bad].tolist()}")
        # Repeated vertices (every STL has them) are merged, so that borders are found by their edges.
        used = vertices[triangles.ravel()]
        size = float(np.linalg.norm(np.ptp(used, axis=0)))
        if size == 0:
            raise InputError("the target mesh has no size: all its vertices coincide")
        _, first, merged = np.unique(
            np.round((used - used.mean(axis=0)) / (1e-9 * size)), axis=0, return_index=True, return_inverse=True
        )
        triangles = merged.reshape(-1, 3).astype(np.int64)
        a, b, c = used[first][triangles].transpose(1, 0, 2)
        normals = np.cross(b - a, c - a)
        area = np.linalg.norm(normals, axis=1)
        keep = area > 1e-14 * size**2
        if not keep.any():
            raise InputError("the target mesh has no area: all its facets are degenerate")
        self._vertices = np.ascontiguousarray(used[first])
        self._triangles = np.ascontiguousarray(triangles[keep])
        self._normals = normals[keep] / area[keep, None]

    def moved(self, origin: FloatArray) -> MeshTarget:
        """See :meth:`Target.moved`."""
        return MeshTarget(self._vertices - origin, self._triangles) if origin.any() else self

    def triangles(self) -> tuple[FloatArray, IntArray]:
        """See :meth:`Target.triangles`."""
        return self._vertices, self._triangles

    def closest(self, points: FloatArray) -> ClosestPoints:
        """See :meth:`Target.closest`."""
        import igl  # loaded when used: the package itself must import fast

        _, facet, feet = igl.point_mesh_squared_distance(
            np.ascontiguousarray(points, np.float64), self._vertices, self._triangles
        )
        facet, feet = np.asarray(facet).ravel(), np.asarray(feet).reshape(-1, 3)
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
        corners = self._vertices[self._triangles[facet]]
        size = np.linalg.norm(np.ptp(corners, axis=1), axis=1)
        for side in range(3):
            a, b = corners[:, side], corners[:, (side + 1) % 3]
            along = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
            distance = np.linalg.norm(np.cross(feet - a, along), axis=1)
            for k in np.flatnonzero(distance < 1e-9 * size).tolist():
                row = self._triangles[facet[k]]
                edge = (int(row[side]), int(row[(side + 1) % 3]))
                if frozenset(edge) in self._border:
                    touched[k] = edge
        return touched

    @cached_property
    def _border(self) -> set[frozenset[int]]:
        edges = np.sort(self._triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        unique, count = np.unique(edges, axis=0, return_counts=True)
        return {frozenset(e) for e in unique[count == 1].tolist()}

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
