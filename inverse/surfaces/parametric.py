"""Smooth targets over a rectangle of two parameters: heights, and vaults between two curves."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, lru_cache
from typing import Literal

import casadi
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.surfaces.base import ClosestPoints, Frame, Target
from inverse.surfaces.expression import parse
from inverse.surfaces.mesh import MeshTarget
from inverse.surfaces.polygon import checked, divided, filled

SAMPLES = 96  # per direction: starts of the closest-point search, pictures, areas
ACROSS = 64  # triangles across the longer side of a polygon
FLAT = 1e-9  # of the squared slope: least curvature of the squared distance that steps are scaled by
SETTLED_STEP, SHORT_STEP = 1e-15, 1e-8  # parts of the rectangle's side: last steps, for feet and for distances
SETTLED = 1e-6  # a foot is where its point is seen straight above, to this angle in radians
GAIN = 1e-9  # of the squared distance: by which another foot is to be nearer
Profile = Literal["arc", "parabola", "catenary"]


class ParametricTarget(Target):
    """A surface S(a, b) over a rectangle.

    Args:
        surface: CasADi function of the parameters (2,) that returns a point (3,).
        box: ((a0, a1), (b0, b1)).
    """

    _told_from = np.zeros(2)  # what messages add to parameters

    def __init__(self, surface: casadi.Function, box: Sequence[Sequence[float]] | FloatArray) -> None:
        self.low, self.high = (np.array([side[k] for side in box], np.float64) for k in (0, 1))
        q, p = casadi.SX.sym("q", 2), casadi.SX.sym("p", 3)
        s = surface(q)
        half_square = casadi.sumsqr(s - p) / 2
        hessian, gradient = casadi.hessian(half_square, q)
        self._point = casadi.Function("point", [q], [s])
        self._slopes = casadi.Function("slopes", [q], [casadi.densify(casadi.jacobian(s, q))])
        self._model = casadi.Function("model", [q, p], [half_square, casadi.densify(gradient), casadi.densify(hessian)])

    def point(self, parameters: FloatArray) -> FloatArray:
        """Points (N, 3) of the surface at parameters (N, 2)."""
        return np.asarray(self._point(parameters.T)).T

    @cached_property
    def _samples(self) -> tuple[FloatArray, FloatArray]:
        sides = [np.linspace(lo, hi, SAMPLES + 1) for lo, hi in zip(self.low, self.high, strict=True)]
        parameters = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 2)
        points = self.point(parameters)
        if not np.isfinite(points).all():
            bad = parameters[~np.isfinite(points).all(axis=1)][0]
            bad = bad + self._told_from
            raise InputError(
                f"the target has no value at ({bad[0]:.10g}, {bad[1]:.10g})",
                hint="Choose a smaller domain, or an expression that is defined all over it.",
            )
        return parameters, points

    def closest(self, points: FloatArray) -> ClosestPoints:
        """See :meth:`Target.closest`: the nearest sample, then Newton steps kept inside the rectangle.

        Where these come to no foot, as they may where the surface has no slope, from the closest point of the
        triangles.
        """
        q = self._nearest(points, SETTLED_STEP)
        return ClosestPoints(self.point(q), self._weights(q))

    def distances(self, points: FloatArray) -> FloatArray:
        """See :meth:`Target.distances`: near a foot they change by the square of what it is off."""
        return np.asarray(np.linalg.norm(points - self.point(self._nearest(points, SHORT_STEP)), axis=1))

    def _nearest(self, points: FloatArray, least: float) -> FloatArray:
        """Parameters (N, 2) of closest points, found by steps down to a least one."""
        parameters, _ = self._samples
        q, value, is_foot = self._descended(parameters[self._tree.query(points)[1]], points, least)
        lost = np.flatnonzero(~is_foot)
        if len(lost):
            again, lower, _ = self._descended(self._on_triangles(points[lost]), points[lost], least)
            better = lower < (1 - GAIN) * value[lost]
            q[lost[better]] = again[better]
        return q

    def _descended(
        self, q: FloatArray, points: FloatArray, least: float
    ) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
        """Newton steps from parameters (N, 2), each lowering the distance from its point (N, 3).

        They end when none is longer than a least one, as a part of the rectangle's side.

        Returns:
            Parameters (N, 2), half the squared distances (N,) and whether (N,) they are stationary.
        """
        value, gradient, hessian = self._evaluate(q, points)
        # Without a slope there is no step: such a start stays where it is.
        is_smooth = _are_finite(gradient, hessian)
        gradient = np.where(is_smooth[:, None], gradient, 0.0)
        hessian = np.where(is_smooth[:, None, None], hessian, np.eye(2))
        damping = np.full(len(q), 1e-12)
        for _ in range(60):
            at_low, at_high = q <= self.low, q >= self.high
            held = (at_low & (gradient > 0)) | (at_high & (gradient < 0))
            free_gradient = np.where(held, 0.0, gradient)
            # Seen from a centre of curvature the squared distance is flat: it has no size of its own there.
            size = np.maximum(np.abs(hessian[:, [0, 1], [0, 1]]).max(axis=1), FLAT * self._steepness**2)
            matrix = np.where(held[:, :, None] | held[:, None, :], 0.0, hessian)
            # Shifted until positive definite: away from the surface the squared distance is not convex.
            lowest = np.linalg.eigvalsh(matrix)[:, 0]
            shift = np.maximum(damping * size, 1e-3 * size - lowest) * (lowest < 1e-3 * size) + damping * size
            matrix = matrix + (shift[:, None] * np.ones(2))[:, :, None] * np.eye(2)
            matrix = matrix + np.where(held, size[:, None], 0.0)[:, :, None] * np.eye(2)
            step = -np.linalg.solve(matrix, free_gradient[..., None])[..., 0]
            trial = np.clip(q + step, self.low, self.high)
            new_value, new_gradient, new_hessian = self._evaluate(trial, points)
            better = (new_value <= value) & _are_finite(new_gradient, new_hessian)
            moved = np.abs(trial - q).max(initial=0.0)
            damping = np.where(better, np.maximum(damping / 10, 1e-12), np.maximum(damping * 100, 1e-6))
            q = np.where(better[:, None], trial, q)
            value = np.where(better, new_value, value)
            gradient = np.where(better[:, None], new_gradient, gradient)
            hessian = np.where(better[:, None, None], new_hessian, hessian)
            if moved <= least * np.abs(self.high - self.low).max():
                break
        held = ((q <= self.low) & (gradient > 0)) | ((q >= self.high) & (gradient < 0))
        left = np.abs(np.where(held, 0.0, gradient)).max(axis=1)
        # The sine of the angle at which the point is seen off the normal, or a distance that is rounding.
        is_foot = is_smooth & (left <= SETTLED * self._steepness * np.maximum(np.sqrt(2 * value), SETTLED * self._size))
        return q, value, is_foot

    def _on_triangles(self, points: FloatArray) -> FloatArray:
        """Parameters (N, 2) of the places on the triangles that are closest to points (N, 3)."""
        parameters, _ = self._samples
        vertices, triangles = self.triangles()
        _, facet, feet = self.nearest.find(points)
        corners = triangles[facet]
        first = vertices[corners[:, 0]]
        sides = vertices[corners[:, 1:]] - first[:, None]
        # By the pseudo-inverse, since where the surface comes to a point triangles have no area.
        shares = np.einsum("nk,nkj->nj", feet - first, np.linalg.pinv(sides))
        own = parameters[corners]
        q = own[:, 0] + np.einsum("nj,njk->nk", shares, own[:, 1:] - own[:, :1])
        return np.asarray(np.clip(q, self.low, self.high))

    @cached_property
    def _tree(self) -> cKDTree:  # of the samples
        return cKDTree(self._samples[1])

    @cached_property
    def _size(self) -> float:
        """Diagonal of the box around the surface."""
        return float(np.linalg.norm(np.ptp(self._samples[1], axis=0)))

    @property
    def _steepness(self) -> float:
        """Length on the surface per change of a parameter, in the mean."""
        return self._size / float(np.linalg.norm(self.high - self.low))

    def _evaluate(self, q: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        value, gradient, hessian = (np.asarray(k) for k in self._model(q.T, points.T))
        return value.ravel(), gradient.T, hessian.T.reshape(-1, 2, 2)

    def _weights(self, q: FloatArray) -> FloatArray:
        slopes = np.asarray(self._slopes(q.T)).T.reshape(-1, 2, 3)
        on_border = (q <= self.low) | (q >= self.high)
        with np.errstate(invalid="ignore", divide="ignore"):
            normal = np.cross(slopes[:, 0], slopes[:, 1])
            normal /= np.linalg.norm(normal, axis=1, keepdims=True)
            # On a border of constant a the tangent along it is the slope in b, and the other way round.
            along = np.where(on_border[:, :1], slopes[:, 1], slopes[:, 0])
            along /= np.linalg.norm(along, axis=1, keepdims=True)
            inside = normal[:, :, None] * normal[:, None, :]
            border = np.eye(3) - along[:, :, None] * along[:, None, :]
        count = on_border.sum(axis=1)[:, None, None]
        weights = np.where(count == 0, inside, np.where(count == 1, border, np.eye(3)))
        # Without a slope there is no tangent plane: the distance from the foot itself.
        return np.where(np.isfinite(weights).all(axis=(1, 2), keepdims=True), weights, np.eye(3))

    def triangles(self) -> tuple[FloatArray, IntArray]:
        """See :meth:`Target.triangles`: two triangles per sample cell."""
        return self._samples[1], _cells()


class HeightTarget(ParametricTarget):
    """z = h(x, y) over a rectangle of the plan.

    Args:
        expression: height, see :func:`inverse.surfaces.expression.parse`.
        domain: ((x0, x1), (y0, y1)).
        origin: (3,) point of the expression's coordinates that the surface's are relative to.
    """

    def __init__(
        self, expression: str, domain: Sequence[Sequence[float]], origin: Sequence[float] | FloatArray = (0.0, 0.0, 0.0)
    ) -> None:
        self.expression, self.domain, self.origin = expression, domain, origin
        x0, y0, z0 = (float(k) for k in origin)
        self._told_from = np.array([x0, y0])
        x, y, q = casadi.SX.sym("x"), casadi.SX.sym("y"), casadi.SX.sym("q", 2)
        self.height = casadi.Function("height", [x, y], [parse(expression)(x + x0, y + y0) - z0])
        surface = casadi.Function("surface", [q], [casadi.vertcat(q, self.height(q[0], q[1]))])
        super().__init__(surface, np.array(domain, np.float64) - self._told_from[:, None])

    @cached_property
    def frame(self) -> Frame:
        """The domain, at the mean height."""
        middle = (self.low + self.high) / 2
        points, areas = self.samples()
        height = float(points[:, 2] @ areas / areas.sum())
        size = self.high - self.low
        return Frame(np.r_[middle, height], np.eye(3), (float(size[0]), float(size[1])))

    def flattened(self, share: float) -> HeightTarget:
        """See :meth:`Target.flattened`; a height stays a height."""
        level = float(self.frame.origin[2]) + float(self.origin[2])
        lowered = f"({level!r}) + {share!r}*(({self.expression}) - ({level!r}))"
        return HeightTarget(lowered, self.domain, self.origin)

    def over_plan(self, points: FloatArray) -> FloatArray:
        """See :meth:`Target.over_plan`; of the surface itself."""
        return self.point(np.clip(points[:, :2], self.low, self.high))

    def residual(self, point: casadi.SX) -> casadi.SX:
        """Height difference along the normal, and how far the point lies outside the domain.

        Outside, the height goes on linearly from the border: finite wherever an iterate may stray, although
        the expression itself may have no value there.
        """
        plan = point[:2]
        inside = casadi.fmin(casadi.fmax(plan, self.low), self.high)
        xy = casadi.SX.sym("xy", 2)
        height = self.height(xy[0], xy[1])
        slope = casadi.Function("slope", [xy], [height, casadi.gradient(height, xy)])
        level, steepness = slope(inside)
        outside = plan - inside
        drop = point[2] - level - casadi.dot(steepness, outside)
        return casadi.vertcat(drop / casadi.sqrt(1 + casadi.sumsqr(steepness)), outside)


def height_over(expression: str, polygon: FloatArray, origin: FloatArray) -> MeshTarget:
    """z = h(x, y) over a polygon, as triangles.

    Args:
        expression: height, see :func:`inverse.surfaces.expression.parse`.
        polygon: (n, 2) corners, the first not repeated.
        origin: (3,) point of the expression's coordinates that the surface's are relative to.

    Raises:
        InputError: the polygon crosses itself, or the height has no value somewhere in it.
    """
    outline = checked(polygon, "the domain")
    spacing = float(np.ptp(outline, axis=0).max()) / ACROSS
    rim = divided(outline, spacing)
    inside, triangles = filled(rim, spacing)
    plan = np.concatenate([rim, inside])
    x, y = casadi.SX.sym("x"), casadi.SX.sym("y")
    heights = np.asarray(casadi.Function("height", [x, y], [parse(expression)(x, y)])(*plan.T[:, None])).ravel()
    if not np.isfinite(heights).all():
        bad = plan[np.argmin(np.isfinite(heights))]
        raise InputError(
            f"the target has no value at ({bad[0]:.10g}, {bad[1]:.10g})",
            hint="Choose a smaller domain, or an expression that is defined all over it.",
        )
    return MeshTarget(np.column_stack([plan, heights]) - origin, triangles)


class BetweenTarget(ParametricTarget):
    """A vault between two curves: S(s, w) = (1 - w) A(s) + w B(s) + rise profile(w) upward.

    Args:
        curves: two polylines (n, 3), run through in the same direction; s is the fraction of their lengths.
        rise: height of the crown over the chord.
        profile: ``arc`` of a circle, ``parabola`` or ``catenary`` of the mean span.
    """

    def __init__(self, curves: Sequence[FloatArray], rise: float, profile: Profile = "arc") -> None:
        first, second = (np.asarray(c, np.float64) for c in curves)
        self._ends = np.stack([first[[0, -1]], second[[0, -1]]])
        a, b = (_length_fraction(c) for c in (first, second))
        if (first[-1] - first[0]) @ (second[-1] - second[0]) <= 0:
            raise InputError(
                "the two curves run in opposite directions, so that the vault between them is twisted",
                hint="Give the points of one curve in the opposite order.",
            )
        span = float(np.mean([np.linalg.norm(second[k] - first[k]) for k in (0, -1)]))
        if span <= 0 or not rise > 0:
            raise InputError(f"the rise is {rise:g} over a span of {span:g}: both must be positive")
        if profile == "arc" and rise > span / 2:
            raise InputError(f"the rise is {rise:g}: an arc over a span of {span:g} rises at most half of it")
        q = casadi.SX.sym("q", 2)
        low = casadi.vertcat(*[casadi.pw_lin(q[0], a, first[:, k]) for k in range(3)])
        high = casadi.vertcat(*[casadi.pw_lin(q[0], b, second[:, k]) for k in range(3)])
        w, height = _profile(q[1], rise, span, profile)
        lift = casadi.vertcat(0, 0, rise * height)
        # The two parameters run across and along, so that u crosses the span.
        surface = casadi.Function("surface", [q], [(1 - w) * low + w * high + lift])
        swapped = casadi.Function("surface", [q], [surface(casadi.vertcat(q[1], q[0]))])
        super().__init__(swapped, ((0.0, 1.0), (0.0, 1.0)))

    @cached_property
    def frame(self) -> Frame:
        """x across the span, y along the curves, z up."""
        (a0, a1), (b0, b1) = self._ends
        along = (a1 - a0) / np.linalg.norm(a1 - a0) + (b1 - b0) / np.linalg.norm(b1 - b0)
        across = (b0 + b1 - a0 - a1) / 2
        z = np.cross(across, along)
        if z[2] < 0:
            along, z = -along, -z
        z /= np.linalg.norm(z)
        x = across - (across @ z) * z
        span = float(np.linalg.norm(x))
        x = x / span
        y = np.cross(z, x)
        length = float(np.mean([abs((a1 - a0) @ y), abs((b1 - b0) @ y)]))
        points, areas = self.samples()
        return Frame(points.T @ areas / areas.sum(), np.stack([x, y, z]), (span, length))


@lru_cache(maxsize=1)
def _cells() -> IntArray:
    """Triangles (T, 3) of the samples, the same for all surfaces."""
    n = SAMPLES + 1
    first = (np.arange(SAMPLES)[:, None] * n + np.arange(SAMPLES)).ravel()
    cells = np.stack([first, first + n, first + n + 1, first, first + n + 1, first + 1], axis=1).reshape(-1, 3)
    cells.setflags(write=False)
    return cells


def _are_finite(gradient: FloatArray, hessian: FloatArray) -> NDArray[np.bool_]:
    """Which of N evaluations, (N, 2) and (N, 2, 2), have slopes."""
    return np.asarray(np.isfinite(gradient).all(axis=1) & np.isfinite(hessian).all(axis=(1, 2)))


def _length_fraction(polyline: FloatArray) -> FloatArray:
    lengths = np.linalg.norm(np.diff(polyline, axis=0), axis=1)
    if len(polyline) < 2 or (lengths <= 0).any():
        raise InputError("a polyline needs two or more points, all different from their neighbours")
    return np.asarray(np.r_[0.0, np.cumsum(lengths)] / lengths.sum())


def _profile(v: casadi.SX, rise: float, span: float, profile: Profile) -> tuple[casadi.SX, casadi.SX]:
    """Place across the span, 0 to 1, and height over the chord relative to the rise, of a parameter v in 0 to 1."""
    from scipy.optimize import brentq

    across, half = 2 * v - 1, span / 2
    if profile == "parabola":
        return v, casadi.SX(1 - across**2)
    if profile == "arc":
        # By angle, so that a half circle, upright at its feet, is as smooth as any.
        radius = (half**2 + rise**2) / (2 * rise)
        angle = float(np.arcsin(min(half / radius, 1.0)))
        height = (radius * casadi.cos(angle * across) - (radius - rise)) / rise
        return casadi.SX((1 + casadi.sin(angle * across) / np.sin(angle)) / 2), casadi.SX(height)
    # An inverted catenary of that rise: (half / k) (cosh k - 1) = rise.
    k = float(brentq(lambda k: half / k * (np.cosh(k) - 1) - rise, 1e-9, 50.0))
    return v, casadi.SX((np.cosh(k) - casadi.cosh(k * across)) / (np.cosh(k) - 1))
