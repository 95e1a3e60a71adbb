"""How far convex prisms are apart, or how deep one is in the other, by separating axes."""

from __future__ import annotations

import numpy as np

from inverse._types import FloatArray
from inverse.origami import geometry

_AT_ONCE = 2048  # pairs


def gaps(one: FloatArray, other: FloatArray, *, enough: float = 0.0) -> FloatArray:
    """Width of the widest slab between two convex prisms, negative where they overlap.

    Two convex polyhedra that do not overlap are separated along the normal of a face of one of them, or along a common
    normal of an edge of each.

    Args:
        one: (N, 2, K, 3) bottom and top corners of prisms; corners may be repeated.
        other: the same of the prisms to compare them with.
        enough: common normals of edges are not tried for pairs that face normals separate by this much.

    Returns:
        (N,) the gap; where it is negative, the depth by which the pair would have to be moved apart.
    """
    found = np.empty(len(one))
    for start in range(0, len(one), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        found[part] = _gaps(one[part], other[part], enough)
    return found


def _gaps(one: FloatArray, other: FloatArray, enough: float) -> FloatArray:
    sides_one, normals_one = _directions(one)
    sides_other, normals_other = _directions(other)
    found = _widest(one, other, np.concatenate([normals_one, normals_other], axis=1))
    close = np.flatnonzero(found < enough)
    if not len(close):
        return found
    common = np.cross(sides_one[close, :, None], sides_other[close, None, :])
    found[close] = np.maximum(found[close], _widest(one[close], other[close], common.reshape(len(close), -1, 3)))
    return found


def _directions(prisms: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Directions of a prism's edges, and normals of its faces: both (N, K + 1, 3), not of unit length."""
    bottom, top = prisms[:, 0], prisms[:, 1]
    along = np.roll(bottom, -1, axis=1) - bottom
    up = (top - bottom)[:, :1]
    return np.concatenate([along, up], axis=1), np.concatenate([np.cross(along, up), up], axis=1)


def _widest(one: FloatArray, other: FloatArray, axes: FloatArray) -> FloatArray:
    """The widest gap along any of the axes (N, A, 3); an axis of length zero says nothing."""
    axes = geometry.unit(axes)
    origin = one[:, :1, :1].mean(axis=(1, 2), keepdims=True)
    a, b = (np.einsum("nai,nki->nak", axes, (p - origin).reshape(len(p), -1, 3)) for p in (one, other))
    gap = np.maximum(b.min(axis=2) - a.max(axis=2), a.min(axis=2) - b.max(axis=2))
    nothing = np.abs(axes).max(axis=2) == 0
    return np.asarray(np.where(nothing, -np.inf, gap).max(axis=1, initial=-np.inf))
