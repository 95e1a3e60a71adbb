"""Tubes of a given section around a centre line: a door stays a door."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import pairwise

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.surfaces.axis import Axis
from inverse.surfaces.base import ClosestPoints, Frame
from inverse.surfaces.polygon import checked
from inverse.surfaces.tube import TubeTarget

ALONG = 128  # pieces that directions across the axis are carried along in, and facets of the surface in pictures
VERTICAL = np.cos(np.radians(10.0))  # an axis that begins so near to the vertical has the world's y as its up
ON_OUTLINE = 128  # places on an outline that its mean radius is taken over

Sections = Sequence[tuple[float, FloatArray]]


class SectionTarget(TubeTarget):
    """A closed polygon swept along a centre line.

    Across the axis y is up (the world's y where the axis begins vertically) and x is to the right, seen from the end of
    the axis towards its beginning; along a bent axis both are carried without a twist.

    Args:
        axis: the line on which the origin of the sections lies.
        sections: pairs of a fraction of the axis' length and the polygon (n, 2) there, its first corner not repeated,
            joined by straight lines; constant before the first and after the last.

    Raises:
        InputError: fractions that do not increase, different numbers of corners, a polygon that crosses itself or has
            no area.
    """

    def __init__(self, axis: Axis, sections: Sections) -> None:
        fractions, polygons = check_sections(sections)
        self._given, self._sections = axis, sections
        self._fractions = fractions
        corners = np.array(polygons)
        middles = np.array([_on_outline(polygon).mean(axis=0) for polygon in polygons])
        self._corners = corners - middles[:, None]
        radii = [np.sqrt(np.mean(np.sum(_on_outline(polygon) ** 2, axis=1))) for polygon in self._corners]
        profile = np.column_stack([fractions, radii])
        if len(profile) == 1:
            profile = np.array([[0.0, radii[0]], [1.0, radii[0]]])
        x, y = _carried(axis, axis.fractions)
        offset = np.stack([np.interp(axis.fractions, fractions, middles[:, k]) for k in (0, 1)], axis=1)
        points = axis.points + offset[:, :1] * x + offset[:, 1:] * y
        super().__init__(Axis(points, smooth=axis.smooth) if offset.any() else axis, profile)

    @property
    def has_kinks(self) -> bool:  # type: ignore[override]
        """See :attr:`Target.has_kinks`: sections have corners."""
        return True

    def outlines(self, t: FloatArray) -> FloatArray:
        """Corners (N, n, 2) of the sections at fractions (N,) of the length, from their middles on the axis."""
        where = np.interp(np.clip(t, 0, 1), self._fractions, np.arange(len(self._fractions)))
        low = np.floor(where).astype(int)
        high = np.minimum(low + 1, len(self._fractions) - 1)
        share = (where - low)[:, None, None]
        return np.asarray((1 - share) * self._corners[low] + share * self._corners[high])

    def across(self, t: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Unit vectors (N, 3) of x and y of the sections at fractions (N,)."""
        return _carried(self.axis, np.clip(t, 0, 1))

    def closest(self, points: FloatArray) -> ClosestPoints:
        """See :meth:`Target.closest`: on the outline of the section beside which a point lies."""
        t = self.axis.closest(points)
        inside = np.clip(t, 0.0, 1.0)
        centre, (x, y) = self.axis.at(inside), self.across(inside)
        offset = points - centre
        own = np.stack([np.einsum("ij,ij->i", offset, k) for k in (x, y)], axis=1)
        foot, direction = on_polygons(own, self.outlines(inside))
        along = direction[:, :1] * x + direction[:, 1:] * y
        normal = direction[:, 1:] * x - direction[:, :1] * y
        border = np.eye(3) - along[:, :, None] * along[:, None, :]
        is_inside = ((t > 0) & (t < 1))[:, None, None]
        weights = np.where(is_inside, normal[:, :, None] * normal[:, None, :], border)
        return ClosestPoints(centre + foot[:, :1] * x + foot[:, 1:] * y, weights)

    @cached_property
    def _mesh(self) -> tuple[FloatArray, IntArray]:
        t = np.linspace(0, 1, ALONG + 1)
        x, y = self.across(t)
        corners = self.outlines(t)
        n = corners.shape[1]
        points = self.axis.at(t)[:, None] + corners[..., :1] * x[:, None] + corners[..., 1:] * y[:, None]
        i, j = (k.ravel() for k in np.meshgrid(np.arange(ALONG), np.arange(n), indexing="ij"))
        here, beside = i * n + j, i * n + (j + 1) % n
        cells = np.stack([here, beside, beside + n, here, beside + n, here + n], axis=1)
        return points.reshape(-1, 3), cells.reshape(-1, 3).astype(np.int64)

    @property
    def frame(self) -> Frame:
        """x along the chord of the axis, y up in the section half-way; the length of the axis and the mean width."""
        chord = self.axis.points[-1] - self.axis.points[0]
        x = chord / np.linalg.norm(chord)
        up = self.across(np.array([0.5]))[1][0]
        y = up - (up @ x) * x
        y /= np.linalg.norm(y)
        middle = self.axis.points[0] + chord / 2
        return Frame(middle, np.stack([x, y, np.cross(x, y)]), (self.axis.length, 2 * self.mean_radius))

    def flattened(self, share: float) -> SectionTarget:
        """See :meth:`Target.flattened`: at share 0 straight along the chord."""
        return SectionTarget(self._given.straightened(share), self._sections)


def check_sections(sections: Sections) -> tuple[FloatArray, list[FloatArray]]:
    """Sections as arrays: fractions (S,), and S polygons (n, 2) counter-clockwise.

    Raises:
        InputError: as of :class:`SectionTarget`.
    """
    fractions = np.array([t for t, _ in sections], np.float64)
    polygons = [checked(np.asarray(polygon, np.float64), "the section") for _, polygon in sections]
    counts = sorted({len(polygon) for polygon in polygons})
    if len(counts) > 1:
        raise InputError(
            f"the sections have {counts[0]} and {counts[-1]} corners",
            hint="Give all of them the same number of corners; a corner may lie on a straight side.",
        )
    if not (np.diff(fractions) > 0).all():
        raise InputError("the fractions of the sections must increase")
    return fractions, polygons


def _on_outline(polygon: FloatArray) -> FloatArray:
    """Places (ON_OUTLINE, 2) at equal distances along a closed polygon."""
    closed = np.vstack([polygon, polygon[:1]])
    length = np.r_[0.0, np.linalg.norm(np.diff(closed, axis=0), axis=1).cumsum()]
    at = (np.arange(ON_OUTLINE) + 0.5) / ON_OUTLINE * length[-1]
    return np.stack([np.interp(at, length, closed[:, k]) for k in (0, 1)], axis=1)


def on_polygons(points: FloatArray, polygons: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Closest points (N, 2) to points (N, 2) on a polygon each (N, n, 2), and unit directions (N, 2) of their sides."""
    steps = np.roll(polygons, -1, axis=1) - polygons
    offset = points[:, None] - polygons
    share = np.einsum("nsk,nsk->ns", offset, steps) / np.maximum(np.einsum("nsk,nsk->ns", steps, steps), 1e-300)
    feet = polygons + np.clip(share, 0, 1)[..., None] * steps
    side = np.argmin(np.linalg.norm(points[:, None] - feet, axis=2), axis=1)
    each = np.arange(len(points))
    direction = steps[each, side]
    return feet[each, side], direction / np.linalg.norm(direction, axis=1, keepdims=True)


def _carried(axis: Axis, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit vectors (N, 3) to the right and up across an axis at fractions (N,), carried along without a twist."""
    places = np.linspace(0, 1, ALONG + 1)
    tangents = axis.tangents(places)
    first = tangents[0]
    up = np.array([0.0, 1.0, 0.0]) if abs(first[2]) > VERTICAL else np.array([0.0, 0.0, 1.0])
    ups = [up - (up @ first) * first]
    for a, b in pairwise(tangents):
        ups.append(ups[-1] - (ups[-1] @ b) / (1 + a @ b) * (a + b))
    table, own = np.array(ups), axis.tangents(t)
    y = np.stack([np.interp(t, places, table[:, k]) for k in range(3)], axis=1)
    y -= np.einsum("ij,ij->i", y, own)[:, None] * own
    y /= np.linalg.norm(y, axis=1, keepdims=True)
    return np.cross(y, own), y
