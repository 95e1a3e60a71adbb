"""Unit dual quaternions as arrays of shape (8, ...): w, x, y, z of the real part, then of the dual part."""

from __future__ import annotations

import numpy as np

from inverse._types import FloatArray


def multiply(a: FloatArray, b: FloatArray) -> FloatArray:
    """The motion ``b`` followed by ``a``, both (8, ...)."""
    real = _hamilton(a[:4], b[:4])
    return np.concatenate([real, _hamilton(a[:4], b[4:]) + _hamilton(a[4:], b[:4])])


def move(a: FloatArray, points: FloatArray) -> FloatArray:
    """Points (3, ...) moved by ``a`` (8, ...): p x p* + 2 d p* for the real part p and the dual part d."""
    w, u = a[0], a[1:4]
    twice = 2 * _cross(u, points)
    shift = 2 * (w * a[5:8] - a[4] * u - _cross(a[5:8], u))
    return np.asarray(points + w * twice + _cross(u, twice) + shift)


def screw_axes(points: FloatArray, directions: FloatArray) -> FloatArray:
    """Plücker coordinates, (6, N), of lines through ``points`` (N, 3) along unit ``directions`` (N, 3)."""
    return np.concatenate([directions.T, np.cross(points, directions).T])


def rotations(scalar: FloatArray, vector: FloatArray, axes: FloatArray) -> FloatArray:
    """The rotations ``scalar + vector * axis`` about lines: (..., N) twice and (6, N) give (8, ..., N)."""
    zero = np.zeros_like(scalar)
    h = [vector * component for component in axes]
    return np.stack([scalar, h[0], h[1], h[2], zero, h[3], h[4], h[5]])


def _hamilton(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.stack(
        [
            a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
            a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
            a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
        ]
    )


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
