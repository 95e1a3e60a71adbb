"""Round tubes around a centre line: what the rings of a tube of facets are fitted to."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.surfaces.axis import Axis
from inverse.surfaces.base import ClosestPoints, Frame, Target

AROUND, ALONG = 64, 128  # facets of the surface in pictures
SEARCHED = 192  # places along the axis where the search for the closest point begins


@dataclass(frozen=True, eq=False)
class Stations:
    """Places on the axis and what the target asks for there.

    Attributes:
        fractions: (N,) of the axis' length; beyond its ends below 0 and above 1.
        points: (N, 3).
        tangents: (N, 3) unit vectors.
        radii: (N,).
        slopes: (N,) change of the radius per length along the axis.
    """

    fractions: FloatArray
    points: FloatArray
    tangents: FloatArray
    radii: FloatArray
    slopes: FloatArray


class TubeTarget(Target):
    """All points at a distance from a centre line that is given along it.

    Args:
        axis: the centre line.
        radius: one number, or pairs [fraction of the length, radius], joined by a smooth curve that overshoots nowhere
            (PCHIP); constant before the first and after the last.

    Raises:
        InputError: fractions that do not increase, or a radius that is not positive.
    """

    def __init__(self, axis: Axis, radius: float | FloatArray) -> None:
        from scipy.interpolate import PchipInterpolator

        self.axis = axis
        profile = np.array([[0.0, radius], [1.0, radius]]) if np.ndim(radius) == 0 else np.asarray(radius, np.float64)
        if len(profile) < 2 or not (np.diff(profile[:, 0]) > 0).all():
            raise InputError("a profile needs two or more pairs [fraction, radius] with increasing fractions")
        if not (profile[:, 1] > 0).all():
            raise InputError(f"the radius {profile[:, 1].min():g} of the profile is not positive")
        self._profile = profile
        self._radius = PchipInterpolator(profile[:, 0], profile[:, 1])
        self._slope = self._radius.derivative()

    @property
    def has_kinks(self) -> bool:  # type: ignore[override]
        """Whether the axis has corners."""
        return not self.axis.smooth

    def radii(self, fractions: FloatArray) -> FloatArray:
        """Radii (N,) at fractions (N,) of the axis' length."""
        return np.asarray(self._radius(np.clip(fractions, *self._profile[[0, -1], 0])))

    @property
    def mean_radius(self) -> float:
        """Mean over the length."""
        return float(self.radii((np.arange(ALONG) + 0.5) / ALONG).mean())

    def stations(self, points: FloatArray) -> Stations:
        """The places of the axis nearest to points (N, 3)."""
        t = self.axis.closest(points)
        low, high = self._profile[[0, -1], 0]
        slopes = np.where((t > low) & (t < high), self._slope(np.clip(t, low, high)), 0.0) / self.axis.length
        return Stations(t, self.axis.at(t), self.axis.tangents(t), self.radii(t), slopes)

    def closest(self, points: FloatArray) -> ClosestPoints:
        """See :meth:`Target.closest`: of the closest points of all circles around the axis the nearest one."""

        def gap(t: FloatArray) -> FloatArray:
            return np.asarray(np.linalg.norm(points - self._on_circle(points, t), axis=1))

        starts = np.linspace(0, 1, SEARCHED + 1)
        near = np.argmin(self._gaps(points, starts), axis=0)
        low, high = starts[np.maximum(near - 1, 0)], starts[np.minimum(near + 1, SEARCHED)]
        golden = (np.sqrt(5) - 1) / 2
        for _ in range(40):
            a, b = high - golden * (high - low), low + golden * (high - low)
            left = gap(a) < gap(b)
            low, high = np.where(left, low, a), np.where(left, b, high)
        t = (low + high) / 2
        ends = np.where(t < 0.5, 0.0, 1.0)
        t = np.where(gap(ends) <= gap(t), ends, t)
        feet = self._on_circle(points, t)
        around = np.cross(self.axis.tangents(t), feet - self.axis.at(t))
        around /= np.linalg.norm(around, axis=1, keepdims=True)
        low, high = np.maximum(t - 1e-6, 0), np.minimum(t + 1e-6, 1)
        normal = np.cross(around, self._on_circle(points, high) - self._on_circle(points, low))
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        border = np.eye(3) - around[:, :, None] * around[:, None, :]
        on_border = ((t <= 0) | (t >= 1))[:, None, None]
        return ClosestPoints(feet, np.where(on_border, border, normal[:, :, None] * normal[:, None, :]))

    def _gaps(self, points: FloatArray, t: FloatArray) -> FloatArray:
        """Distances (T, N) of points (N, 3) from the circles around the axis at fractions (T,)."""
        offset = points - self.axis.at(t)[:, None]
        along = np.einsum("tnk,tk->tn", offset, self.axis.tangents(t))
        beside = np.sqrt(np.maximum(np.einsum("tnk,tnk->tn", offset, offset) - along**2, 0.0))
        return np.asarray(np.hypot(along, beside - self.radii(t)[:, None]))

    def _on_circle(self, points: FloatArray, t: FloatArray) -> FloatArray:
        """Nearest places (N, 3) to points (N, 3) on the circles around the axis at fractions (N,)."""
        centre, tangent = self.axis.at(t), self.axis.tangents(t)
        offset = points - centre
        outward = offset - np.einsum("ij,ij->i", offset, tangent)[:, None] * tangent
        size = np.linalg.norm(outward, axis=1, keepdims=True)
        helper = np.cross(tangent, np.eye(3)[np.argmin(np.abs(tangent), axis=1)])  # from the axis itself, anywhere
        helper /= np.linalg.norm(helper, axis=1, keepdims=True)
        outward = np.where(size > 1e-12 * self.axis.length, outward / np.maximum(size, 1e-300), helper)
        return np.asarray(centre + self.radii(t)[:, None] * outward)

    @cached_property
    def _mesh(self) -> tuple[FloatArray, IntArray]:
        t = np.linspace(0, 1, ALONG + 1)
        centres, tangents = self.axis.at(t), self.axis.tangents(t)
        across = [np.cross(tangents[0], np.eye(3)[np.argmin(np.abs(tangents[0]))])]
        for a, b in pairwise(tangents):  # carried along without a twist
            across.append(across[-1] - (across[-1] @ b) / (1 + a @ b) * (a + b))
        first = np.array(across)
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        second = np.cross(tangents, first)
        angle = np.linspace(0, 2 * np.pi, AROUND, endpoint=False)
        outward = first[:, None] * np.cos(angle)[:, None] + second[:, None] * np.sin(angle)[:, None]
        points = centres[:, None] + self.radii(t)[:, None, None] * outward
        i, j = (k.ravel() for k in np.meshgrid(np.arange(ALONG), np.arange(AROUND), indexing="ij"))
        here, beside = i * AROUND + j, i * AROUND + (j + 1) % AROUND
        cells = np.stack([here, beside, beside + AROUND, here, beside + AROUND, here + AROUND], axis=1)
        return points.reshape(-1, 3), cells.reshape(-1, 3).astype(np.int64)

    def triangles(self) -> tuple[FloatArray, IntArray]:
        """See :meth:`Target.triangles`."""
        return self._mesh

    @property
    def frame(self) -> Frame:
        """x along the chord of the axis, y towards its bulge; the length of the axis and the mean width."""
        points = self.axis.points
        chord = points[-1] - points[0]
        x = chord / np.linalg.norm(chord)
        middle = points[0] + chord / 2
        bulge = self.axis.at(np.linspace(0, 1, 65)).mean(axis=0) - middle
        y = bulge - (bulge @ x) * x
        if np.linalg.norm(y) < 1e-9 * self.axis.length:
            y = np.cross(np.eye(3)[2] if abs(x[2]) < 0.9 else np.eye(3)[0], x)
        y /= np.linalg.norm(y)
        return Frame(middle, np.stack([x, y, np.cross(x, y)]), (self.axis.length, 2 * self.mean_radius))

    def flattened(self, share: float) -> TubeTarget:
        """See :meth:`Target.flattened`: at share 0 straight along the chord, with the mean radius all along."""
        profile = self._profile.copy()
        profile[:, 1] = (1 - share) * self.mean_radius + share * profile[:, 1]
        return TubeTarget(self.axis.straightened(share), profile)
