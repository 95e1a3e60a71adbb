"""Target surfaces given as triangle or quad meshes."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path

import numpy as np

from inverse.errors import InputError
from inverse.target.base import ClosestPoints, FloatArray, Frame, IntArray, Target

FORMATS = (".obj", ".ply", ".stl", ".glb", ".gltf", ".off")


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
        InputError: missing, empty or unreadable file, unknown format, or a mesh that is none.
    """
    if not path.exists():
        raise InputError("there is no such target mesh file", where=str(path))
    if path.suffix.lower() not in FORMATS:
        raise InputError(
            f"{path.suffix or 'a file without an ending'} is no mesh format: allowed are {', '.join(FORMATS)}",
            where=str(path),
        )
    if not path.is_file() or path.stat().st_size == 0:
        raise InputError("the target mesh file is empty", where=str(path))
    try:
        vertices, polygons = _obj(path) if path.suffix.lower() == ".obj" else _by_library(path)
        return MeshTarget(*_triangulated(vertices, polygons))
    except InputError as error:
        raise InputError(error.message, where=str(path), hint=error.hint) from None


def _by_library(path: Path) -> tuple[FloatArray, list[list[int]]]:
    if path.suffix.lower() in (".glb", ".gltf", ".off"):
        import trimesh

        try:
            mesh = trimesh.load(path, force="mesh")
        except Exception as error:  # the reader raises whatever its parsers do
            raise InputError(f"the target mesh cannot be read: {error}") from None
        return np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces).tolist()
    import pyvista

    try:
        grid = pyvista.read(path)
        surface = grid if isinstance(grid, pyvista.PolyData) else grid.extract_surface()
    except Exception as error:
        raise InputError(f"the target mesh cannot be read: {error}") from None
    return np.asarray(surface.points, np.float64), [list(map(int, face)) for face in surface.irregular_faces]


def _obj(path: Path) -> tuple[FloatArray, list[list[int]]]:
    """Vertices and polygons of an OBJ file in double precision, faults with their line."""
    vertices: list[list[float]] = []
    polygons: list[list[int]] = []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        words = line.split("#")[0].split()
        if not words or words[0] not in ("v", "f"):
            continue
        try:
            if words[0] == "v":
                vertices.append([float(w) for w in words[1:4]])
                if len(vertices[-1]) != 3 or not np.isfinite(vertices[-1]).all():
                    raise ValueError
            else:
                index = [int(w.split("/")[0]) for w in words[1:]]
                polygons.append([k - 1 if k > 0 else len(vertices) + k for k in index])
                if len(index) < 3 or 0 in index:
                    raise ValueError
        except ValueError:
            raise InputError(
                f"line {number} is no {'vertex' if words[0] == 'v' else 'facet'}: {line.strip()!r}"
            ) from None
    if polygons and not all(0 <= k < len(vertices) for face in polygons for k in face):
        raise InputError("a facet of the target mesh names a vertex that is not there")
    if not polygons:
        raise InputError("the target mesh has no facets")
    return np.array(vertices, np.float64), polygons


def _triangulated(vertices: FloatArray, polygons: list[list[int]]) -> tuple[FloatArray, IntArray]:
    """Triangles as they are; a polygon of more sides, planar or not, around its centroid (no diagonal is preferred)."""
    used = np.unique(np.array([v for face in polygons for v in face], np.int64))
    bad = used[~np.isfinite(vertices[used]).all(axis=1)]
    if len(bad):
        raise InputError(f"vertex {bad[0]} of the target mesh is not finite: {vertices[bad[0]].tolist()}")
    extra: list[FloatArray] = []
    triangles: list[list[int]] = []
    for face in polygons:
        if len(face) == 3:
            triangles.append(face)
            continue
        centre = len(vertices) + len(extra)
        extra.append(vertices[face].mean(axis=0))
        triangles += [[face[k], face[(k + 1) % len(face)], centre] for k in range(len(face))]
    points = np.vstack([vertices, *extra]) if extra else vertices
    return points, np.array(triangles, np.int64).reshape(-1, 3)
