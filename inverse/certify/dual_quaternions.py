"""Unit dual quaternions as arrays of shape (8, ...): w, x, y, z of the real part, then of the dual part."""

from __future__ import annotations

import numpy as np

from inverse._types import FloatArray

# Of products with w, x, y and z on the left: which of the right factor's components each of theirs is, and its sign.
ROWS = (
    ((0, 1, 2, 3), (1, 1, 1, 1)),
    ((1, 0, 3, 2), (-1, 1, -1, 1)),
    ((2, 3, 0, 1), (-1, 1, 1, -1)),
    ((3, 2, 1, 0), (-1, -1, 1, 1)),
)


def multiply(a: FloatArray, b: FloatArray) -> FloatArray:
    """The motion ``b`` followed by ``a``, both (8, ...)."""
    return times(a, factors(b))


def factors(b: FloatArray) -> FloatArray:
    """What w, x, y and z of a real part are multiplied with on the left of ``b`` (8, ...): (4, 8, ...)."""
    found = np.empty((4, *b.shape))
    for part in (0, 4):
        for k, (rows, signs) in enumerate(ROWS):
            for row, (own, sign) in enumerate(zip(rows, signs, strict=True)):
                np.multiply(b[part + own], sign, out=found[k, part + row])
    return found


def times(a: FloatArray, b: FloatArray) -> FloatArray:
    """The motion with the factors ``b`` (4, 8, ...) followed by ``a`` (8, ...)."""
    product = a[0] * b[0]
    dual = a[4] * b[0, :4]
    for k in (1, 2, 3):
        product += a[k] * b[k]
        dual += a[4 + k] * b[k, :4]
    product[4:] += dual
    return np.asarray(product)


def matrices(a: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The same motions (8, ...) as rotations (3, 3, ...) and shifts (3, ...): R p + s for p x p* + 2 d p*."""
    w, x, y, z = a[:4]
    xx, yy, zz, xy, yz, zx = x * x, y * y, z * z, x * y, y * z, z * x
    wx, wy, wz = w * x, w * y, w * z
    rotation = 2 * np.array(
        [[-(yy + zz), xy - wz, zx + wy], [xy + wz, -(xx + zz), yz - wx], [zx - wy, yz + wx, -(xx + yy)]]
    )
    for k in range(3):
        rotation[k, k] += 1
    return rotation, np.asarray(2 * (w * a[5:8] - a[4] * a[1:4] - _cross(a[5:8], a[1:4])))


def move(a: FloatArray, points: FloatArray) -> FloatArray:
    """Points (3, ...) moved by ``a`` (8, ...)."""
    return placed(*matrices(a), points)


def placed(rotation: FloatArray, shift: FloatArray, points: FloatArray) -> FloatArray:
    """Points (3, ...) turned by (3, 3, ...) and shifted by (3, ...)."""
    return np.asarray(rotation[:, 0] * points[0] + rotation[:, 1] * points[1] + rotation[:, 2] * points[2] + shift)


def screw_axes(points: FloatArray, directions: FloatArray) -> FloatArray:
    """Plücker coordinates, (6, N), of lines through ``points`` (N, 3) along unit ``directions`` (N, 3)."""
    return np.concatenate([directions.T, np.cross(points, directions).T])


def rotations(scalar: FloatArray, vector: FloatArray, axes: FloatArray) -> FloatArray:
    """The rotations ``scalar + vector * axis`` about lines: (..., N) twice and (6, N) give (8, ..., N)."""
    zero = np.zeros_like(scalar)
    h = [vector * component for component in axes]
    return np.stack([scalar, h[0], h[1], h[2], zero, h[3], h[4], h[5]])


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
