"""Target meshes over outlines of many kinds, and how much of one mesh lies under another."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from inverse._types import FloatArray, IntArray

Height = Callable[[FloatArray, FloatArray], FloatArray]
Mesh = tuple[FloatArray, list[tuple[int, ...]]]


def bow(x: FloatArray, y: FloatArray) -> FloatArray:
    """A shallow dome."""
    return 1.5 - 0.015 * ((x - 6) ** 2 + (y - 5) ** 2)


def level(x: FloatArray, y: FloatArray) -> FloatArray:
    """A plane."""
    return 0 * x


def squares(mask: FloatArray | Sequence[Sequence[int]], size: float = 0.5, height: Height = level) -> Mesh:
    """The squares of a mask (m, n) of truth values."""
    wanted = np.array(mask, bool)
    m, n = wanted.shape
    x, y = (k.ravel() * size for k in np.meshgrid(np.arange(m + 1), np.arange(n + 1), indexing="ij"))
    i, j = np.nonzero(wanted)
    first = i * (n + 1) + j
    faces = np.stack([first, first + n + 1, first + n + 2, first + 1], axis=1)
    used, number = np.unique(faces, return_inverse=True)
    points = np.column_stack([x, y, height(x, y)])[used]
    return points, [tuple(face) for face in number.reshape(-1, 4).tolist()]


def block(m: int, n: int, *without: tuple[int, int, int, int]) -> np.ndarray:
    """All (m, n) true but blocks (i0, i1, j0, j1)."""
    mask = np.ones((m, n), bool)
    for i0, i1, j0, j1 in without:
        mask[i0:i1, j0:j1] = False
    return mask


ELL = block(24, 20, (10, 24, 8, 20))
CROSS = block(24, 20, (0, 8, 0, 7), (16, 24, 0, 7), (0, 8, 13, 20), (16, 24, 13, 20))
YOU = block(24, 20, (8, 16, 8, 20))
COURT = block(24, 20, (8, 16, 7, 13))


def rings(radii: Sequence[float] | FloatArray, count: int, height: Height = level) -> Mesh:
    """Rings of quads around the origin, triangles within the first."""
    angle = 2 * np.pi * np.arange(count) / count
    flat = np.concatenate([np.zeros((1, 2)), *(r * np.stack([np.cos(angle), np.sin(angle)], 1) for r in radii)])
    k = np.arange(count)
    after = (k + 1) % count
    faces: list[tuple[int, ...]] = [(0, 1 + a, 1 + b) for a, b in zip(k.tolist(), after.tolist(), strict=True)]
    for ring in range(len(radii) - 1):
        o = 1 + ring * count
        quads = np.stack([o + k, o + count + k, o + count + after, o + after], axis=1)
        faces += [tuple(quad) for quad in quads.tolist()]
    return np.column_stack([flat, height(flat[:, 0], flat[:, 1])]), faces


def patch(corners: Sequence[tuple[float, float]], count: int, height: Height = level) -> Mesh:
    """Quads of a four-sided outline, count along every side."""
    share = np.linspace(0, 1, count + 1)
    a, b = (k.ravel()[:, None] for k in np.meshgrid(share, share, indexing="ij"))
    c = np.array(corners)
    flat = (1 - a) * (1 - b) * c[0] + a * (1 - b) * c[1] + a * b * c[2] + (1 - a) * b * c[3]
    _, faces = squares(np.ones((count, count)))
    return np.column_stack([flat, height(flat[:, 0], flat[:, 1])]), faces


def box(sides: Sequence[float], *, bottom: bool = True) -> Mesh:
    """A box standing on z = 0, of quads."""
    corner = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)], np.float64) * sides
    faces = [(1, 5, 7, 3), (0, 4, 5, 1), (4, 6, 7, 5), (6, 2, 3, 7), (2, 0, 1, 3)]
    return corner, [*faces, *([(0, 2, 6, 4)] if bottom else [])]


def joined(*meshes: Mesh) -> Mesh:
    """Several meshes as one, their vertices apart."""
    points: list[FloatArray] = []
    faces: list[tuple[int, ...]] = []
    for vertices, own in meshes:
        first = sum(map(len, points))
        faces += [tuple(v + first for v in face) for face in own]
        points.append(vertices)
    return np.concatenate(points), faces


def moved(mesh: Mesh, by: Sequence[float]) -> Mesh:
    """A mesh elsewhere."""
    return mesh[0] + np.array(by), mesh[1]


def write(path: Path, mesh: Mesh) -> Path:
    """A mesh as OBJ."""
    points, faces = mesh
    vertices = "".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in points)
    path.write_text(vertices + "".join("f " + " ".join(str(v + 1) for v in face) + "\n" for face in faces))
    return path


def triangles(faces: Sequence[Sequence[int]]) -> IntArray:
    """Facets as fans of triangles."""
    return np.array([(face[0], b, c) for face in faces for b, c in pairwise(face[1:])], np.int64)


def in_plan(points: FloatArray, cells: IntArray, places: FloatArray) -> np.ndarray:
    """Which places (N, 2) of the plan lie under some triangle."""
    found = np.zeros(len(places), bool)
    for a, b, c in points[cells][..., :2]:
        sides = np.column_stack([b - a, c - a])
        if abs(np.linalg.det(sides)) > 1e-12:
            u, v = np.linalg.solve(sides, (places - a).T)
            found |= (u >= 0) & (v >= 0) & (u + v <= 1)
    return found


def covered(
    mesh: tuple[FloatArray, IntArray], target: tuple[FloatArray, IntArray], count: int = 120
) -> tuple[float, float]:
    """Share of a target's plan under a mesh, and the mesh's plan beside it as a share of the target's.

    Places (count, count) are counted.
    """
    everything = np.concatenate([mesh[0], target[0]])[:, :2]
    sides = [np.linspace(low, high, count) for low, high in zip(everything.min(0), everything.max(0), strict=True)]
    places = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 2)
    own, wanted = in_plan(*mesh, places), in_plan(*target, places)
    return float((own & wanted).sum() / wanted.sum()), float((own & ~wanted).sum() / wanted.sum())
