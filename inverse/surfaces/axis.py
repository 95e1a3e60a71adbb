"""Centre lines of tubes: polylines, splines and arcs by the fraction of their lengths."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from inverse._types import FloatArray
from inverse.errors import InputError

SAMPLES = 512  # pieces that a smooth centre line is cut into where it is measured and searched
SHORTEST_CHORD = 1e-3  # of the length: a centre line whose ends are nearer to each other leads nowhere


class Axis:
    """A curve c(t) over the fraction t of its length, straight beyond its ends.

    Args:
        points: (n, 3) points in order; what lies between two of them is straight, or for a smooth curve part of a
            cubic spline through all of them.
        smooth: whether the curve is smooth at its points.

    Attributes:
        length: of the curve.
        smooth: whether it has no corners.
        fractions: (m,) of points that stand for the curve, 0 to 1.
        points: (m, 3) these points.

    Raises:
        InputError: the points lead nowhere.
    """

    def __init__(self, points: Sequence[Sequence[float]] | FloatArray, *, smooth: bool) -> None:
        from scipy.interpolate import CubicSpline, PPoly

        given = np.array(points, np.float64)
        self.fractions, self.length = _fractions(given)
        self.points: FloatArray = given
        if smooth and len(given) > 2:
            # By the lengths of chords first, then by the length of the curve that results.
            fine = CubicSpline(self.fractions, given)(np.linspace(0, 1, 8 * SAMPLES + 1))
            t, self.length = _fractions(fine)
            self.fractions = np.linspace(0, 1, SAMPLES + 1)
            self.points = CubicSpline(t, fine)(self.fractions)
        self.smooth = smooth or len(given) == 2
        if np.linalg.norm(self.points[-1] - self.points[0]) < SHORTEST_CHORD * self.length:
            raise InputError(
                "the axis ends where it begins", hint="A tube has two open ends: let the axis end somewhere else."
            )
        pieces = np.diff(self.points, axis=0) / np.diff(self.fractions)[:, None]
        straight = PPoly(np.stack([pieces, self.points[:-1]]), self.fractions)
        self._curve: PPoly = CubicSpline(self.fractions, self.points) if self.smooth else straight
        self._slope, self._bend = (self._curve.derivative(k) for k in (1, 2))

    def at(self, t: FloatArray) -> FloatArray:
        """Points (N, 3) at fractions (N,)."""
        inside = np.clip(t, 0.0, 1.0)
        return np.asarray(self._curve(inside) + (t - inside)[:, None] * self._slope(inside))

    def tangents(self, t: FloatArray) -> FloatArray:
        """Unit tangents (N, 3) at fractions (N,)."""
        slope = self._slope(np.clip(t, 0.0, 1.0))
        return np.asarray(slope / np.linalg.norm(slope, axis=1, keepdims=True))

    def closest(self, points: FloatArray) -> FloatArray:
        """Fractions (N,) of the places nearest to points (N, 3); beyond the ends below 0 and above 1."""
        a, steps = self.points[:-1], np.diff(self.points, axis=0)
        along = np.einsum("nsk,sk->ns", points[:, None] - a, steps) / np.einsum("sk,sk->s", steps, steps)
        low, high = np.zeros(len(a)), np.ones(len(a))
        low[0], high[-1] = -np.inf, np.inf
        along = np.clip(along, low, high)
        beside = np.linalg.norm(points[:, None] - a - along[..., None] * steps, axis=2)
        piece = np.argmin(beside, axis=1)
        widths = np.diff(self.fractions)
        t = self.fractions[piece] + along[np.arange(len(points)), piece] * widths[piece]
        for _ in range(4 if self.smooth else 0):  # Newton from that near: the pieces were straight
            inside = np.clip(t, 0.0, 1.0)
            slope, offset = self._slope(inside), self.at(t) - points
            bend = np.where((t > 0) & (t < 1), np.einsum("ij,ij->i", offset, self._bend(inside)), 0.0)
            squared = np.einsum("ij,ij->i", slope, slope)
            t = t - np.einsum("ij,ij->i", offset, slope) / np.maximum(squared + bend, 0.1 * squared)
        return np.asarray(t)

    def straightened(self, share: float) -> Axis:
        """The same length with every direction turned towards the chord, which is all that is left at share 0."""
        chord = self.points[-1] - self.points[0]
        straight = chord / np.linalg.norm(chord)
        middles = (self.fractions[1:] + self.fractions[:-1]) / 2
        directions = (1 - share) * straight + share * self.tangents(middles)
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        steps = self.length * np.diff(self.fractions)[:, None] * directions
        start = self.points[0] + (1 - share) * (chord - self.length * straight) / 2
        return Axis(np.vstack([start, start + np.cumsum(steps, axis=0)]), smooth=self.smooth)


def arc(start: Sequence[float], through: Sequence[float], end: Sequence[float]) -> Axis:
    """The circular arc from a start through a point on the way to an end.

    Raises:
        InputError: the three points lie on a line.
    """
    a, b, c = (np.asarray(p, np.float64) for p in (start, through, end))
    u, v = b - a, c - a
    normal = np.cross(u, v)
    if np.linalg.norm(normal) < 1e-9 * np.linalg.norm(u) * np.linalg.norm(v):
        raise InputError(
            "the three points of the arc lie on a line", hint="Write a straight axis as a polyline of two points."
        )
    # The centre is as far from all three.
    centre = a + np.cross(normal, u * (v @ v) - v * (u @ u)) / (2 * normal @ normal)
    x = a - centre
    y = np.cross(normal / np.linalg.norm(normal), x)
    angle = float(np.arctan2((c - centre) @ y, (c - centre) @ x)) % (2 * np.pi)
    t = np.linspace(0, angle, SAMPLES + 1)[:, None]
    return Axis(centre + np.cos(t) * x + np.sin(t) * y, smooth=True)


def _fractions(points: FloatArray) -> tuple[FloatArray, float]:
    """Fractions (n,) of the length of a polyline, and that length."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if len(points) < 2 or not (steps > 0).all():
        raise InputError("an axis needs two or more points, all different from their neighbours")
    return np.r_[0.0, np.cumsum(steps)] / steps.sum(), float(steps.sum())
