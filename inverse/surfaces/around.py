"""Surfaces around an axis, measured: how far from it they are, place by place along it."""

from __future__ import annotations

from collections.abc import Callable

import casadi
import numpy as np

from inverse._types import FloatArray
from inverse.errors import InputError
from inverse.surfaces.axis import Axis
from inverse.surfaces.mesh import MeshTarget

STATIONS, RAYS = 49, 32  # places along the axis, and directions looked in at each
INSET = 1e-4  # of the length: a surface that ends where the axis ends is met a little before
SAMPLES = 240  # along a ray, where the sign of an implicit surface is looked for
REACH = 2.0  # length of a ray, in lengths of the axis
ENOUGH = 0.9  # part of the rays that have to meet the surface; some may slip through between two triangles

# Distances (N,) along rays, of starts and directions (N, 3); not finite where nothing is met.
Met = Callable[[FloatArray, FloatArray], FloatArray]


def of_mesh(axis: Axis, mesh: MeshTarget) -> FloatArray:
    """The profile of a mesh around an axis: pairs (fraction of the length, mean distance), (S, 2).

    Raises:
        InputError: the mesh is not around the axis somewhere along it.
    """
    import igl  # loaded when used: the package itself must import fast

    vertices, triangles = mesh.triangles()

    def met(start: FloatArray, direction: FloatArray) -> FloatArray:
        # All hits are asked for: where there is none, the first one comes back all the same.
        hits = [igl.ray_mesh_intersect(a, d, vertices, triangles) for a, d in zip(start, direction, strict=True)]
        return np.array([hit[0][1] if hit else np.inf for hit in hits])

    return _profile(axis, met)


def of_implicit(axis: Axis, value: casadi.Function, origin: FloatArray | None = None) -> FloatArray:
    """The profile of the surface f(x, y, z) = 0 around an axis: pairs (fraction of the length, mean distance), (S, 2).

    Args:
        axis: the centre line.
        value: f, of three numbers.
        origin: (3,) point of the coordinates of f that the axis' are relative to, or None where they are the same.

    Raises:
        InputError: the surface is not around the axis somewhere along it.
    """

    def at(points: FloatArray) -> FloatArray:
        x, y, z = (points.reshape(-1, 3) + (0.0 if origin is None else origin)).T
        values = np.asarray(value(x[None], y[None], z[None])).reshape(points.shape[:-1])
        return np.where(np.isfinite(values), values, np.nan)

    def met(start: FloatArray, direction: FloatArray) -> FloatArray:
        along = np.linspace(0, REACH * axis.length, SAMPLES + 1)
        values = at(start[:, None] + along[:, None] * direction[:, None])
        crosses = np.sign(values[:, 1:]) * np.sign(values[:, :1]) < 0
        first = np.argmax(crosses, axis=1)
        low, high = along[first], along[first + 1]
        for _ in range(50):
            middle = (low + high) / 2
            beyond = np.sign(at(start + middle[:, None] * direction)) * np.sign(values[:, 0]) < 0
            low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
        return np.where(crosses.any(axis=1), high, np.inf)

    return _profile(axis, met)


def _profile(axis: Axis, met: Met) -> FloatArray:
    fractions = np.linspace(0, 1, STATIONS)
    # Not in the planes of a mesh's own rings, where a ray slips through between triangles.
    inside = 0.618 * INSET + (1 - 1.618 * INSET) * fractions
    centres, tangents = axis.at(inside), axis.tangents(inside)
    first = np.cross(tangents, np.eye(3)[np.argmin(np.abs(tangents), axis=1)])
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(tangents, first)
    angle = 2 * np.pi * (np.arange(RAYS) + 0.382) / RAYS  # along no edge that a mesh is likely to have
    outward = first[:, None] * np.cos(angle)[:, None] + second[:, None] * np.sin(angle)[:, None]
    starts = np.repeat(centres, RAYS, axis=0)
    distances = met(starts, np.ascontiguousarray(outward.reshape(-1, 3))).reshape(STATIONS, RAYS)
    hit = np.isfinite(distances)
    bare = np.flatnonzero(hit.mean(axis=1) < ENOUGH)
    if len(bare):
        raise InputError(
            f"the surface is not all around the axis at the fraction {fractions[bare[0]]:.3g} of its length",
            hint="Lay the axis inside the surface, and let it end where the surface ends.",
        )
    radii = np.where(hit, distances, 0.0).sum(axis=1) / hit.sum(axis=1)
    return np.column_stack([fractions, radii])
