"""Closest points of smooth targets against closed forms, and the distances that are linear in small moves."""

from __future__ import annotations

import casadi
import numpy as np
import pytest
from designs import assert_close
from scipy.optimize import brentq

from inverse.errors import InputError
from inverse.surfaces import Target
from inverse.surfaces.parametric import BetweenTarget, HeightTarget

SIDE = 0.6
CAP = ("sqrt(1 - x^2 - y^2)", [[-SIDE, SIDE], [-SIDE, SIDE]])


def nearest(points: np.ndarray, candidates: list[np.ndarray]) -> np.ndarray:
    """For every point the nearest of its candidates, each (N, 3) with NaN where it is none."""
    table = np.array(candidates)
    distance = np.linalg.norm(table - points, axis=2)
    return table[np.nanargmin(distance, axis=0), np.arange(len(points))]


def on_cap(points: np.ndarray) -> np.ndarray:
    """Closest points of the unit sphere's part over a square: inside, on four arcs, at four corners."""
    inside = points / np.linalg.norm(points, axis=1, keepdims=True)
    outside = (np.abs(inside[:, :2]) > SIDE).any(axis=1) | (inside[:, 2] < 0)
    found = [np.where(outside[:, None], np.nan, inside)]
    radius, height = np.sqrt(1 - SIDE**2), np.sqrt(1 - 2 * SIDE**2)
    for sign in (-1, 1):
        for axis in (0, 1):
            other = 1 - axis
            arc = points.copy()
            arc[:, axis] = 0
            arc *= radius / np.linalg.norm(arc, axis=1, keepdims=True)
            arc[:, axis] = sign * SIDE
            found.append(np.where((np.abs(arc[:, other]) > SIDE)[:, None], np.nan, arc))
            corner = [sign * SIDE, (-sign if axis else sign) * SIDE, height]
            found.append(np.tile(corner, (len(points), 1)))
    return nearest(points, found)


def test_a_spherical_cap_with_its_border() -> None:
    rng = np.random.default_rng(0)
    near = rng.uniform([-1.5, -1.5, 0.3], [1.5, 1.5, 2.5], (600, 3))
    points = np.vstack([near, rng.uniform([-40, -40, 1], [40, 40, 80], (50, 3))])
    target = HeightTarget(*CAP)
    expected = on_cap(points)
    on_border = (np.abs(np.abs(expected[:, :2]) - SIDE) < 1e-9).sum(axis=1)
    assert [int((on_border == k).sum()) for k in range(3)] > [100, 100, 20]
    distances = target.distances(points)
    assert_close(distances, np.linalg.norm(points - expected, axis=1), 1e-12)
    assert_close(target.closest(points).feet, expected, 1e-7)


def test_a_cylinder_with_its_border() -> None:
    points = np.random.default_rng(1).uniform([-2, -2, 0.2], [2, 2, 2], (500, 3))
    target = HeightTarget("sqrt(1 - x^2)", [[-0.8, 0.8], [-1, 1]])
    limit = np.arcsin(0.8)
    angle = np.clip(np.arctan2(points[:, 0], points[:, 2]), -limit, limit)
    expected = np.c_[np.sin(angle), np.clip(points[:, 1], -1, 1), np.cos(angle)]
    assert_close(target.closest(points).feet, expected, 1e-7)
    assert_close(target.distances(points), np.linalg.norm(points - expected, axis=1), 1e-12)


def test_a_plane_and_its_corners() -> None:
    target = HeightTarget("2*x - y + 1", [[0, 2], [-1, 1]])
    normal = np.array([-2, 1, 1]) / np.sqrt(6)
    inside = np.array([[0.7, 0.2, 2.2], [1.5, -0.5, 4.5]])
    closest = target.closest(inside + 0.3 * normal)
    assert_close(closest.feet, inside, 1e-12)
    assert_close(closest.weights, np.broadcast_to(np.outer(normal, normal), (2, 3, 3)), 1e-12)
    corner = target.closest(np.array([[-1.0, 1.5, -3]]))
    assert_close(corner.feet, [[0, 1, 0]], 1e-12)
    assert_close(corner.weights[0], np.eye(3), 0)


# ---- weights: |W (p - foot)| is the distance to first order


def curves() -> list[np.ndarray]:
    return [np.array([[-1.0, -2, 0], [-1, 2, 0]]), np.array([[1.0, -2, 0], [1, 2, 0]])]


SMOOTH: dict[str, Target] = {
    "cap": HeightTarget(*CAP),
    "saddle": HeightTarget("x*y + 0.2*x^3", [[-1, 1], [-1, 1]]),
    "vault": BetweenTarget(curves(), 0.7),
}


@pytest.mark.parametrize("name", SMOOTH)
def test_weights_give_distances_of_first_order(name: str) -> None:
    """The error of the distance from refreshed weights falls by four when the move is halved."""
    rng, target = np.random.default_rng(3), SMOOTH[name]
    vertices, _ = target.triangles()
    points = vertices[rng.integers(len(vertices), size=300)] + 0.3 * rng.standard_normal((300, 3))
    closest = target.closest(points)
    assert len(np.unique(np.round(np.trace(closest.weights, axis1=1, axis2=2)))) == 3  # inside, border, corner
    step = rng.standard_normal((300, 3))
    errors = []
    for h in (1e-3, 5e-4, 2.5e-4):
        linear = np.linalg.norm(np.einsum("nij,nj->ni", closest.weights, points + h * step - closest.feet), axis=1)
        errors.append(np.abs(linear - target.distances(points + h * step)))
    # A few feet lie where border and inside meet, within the step: there the rate is lost.
    rate = np.array(errors[:-1]) / np.maximum(np.array(errors[1:]), 1e-300)
    regular = (np.abs(rate - 4) < 0.2).all(axis=0) | (errors[0] < 1e-12)
    assert regular.mean() > 0.95
    assert np.median(errors[0]) < 1e-5


@pytest.mark.parametrize("name", ["cap", "saddle"])
def test_residuals_of_heights_are_distances_of_first_order(name: str) -> None:
    target, q = SMOOTH[name], casadi.SX.sym("q", 3)
    residual = casadi.Function("residual", [q], [target.residual(q)])
    rng = np.random.default_rng(4)
    low, high = target.low, target.high
    errors = []
    feet = target.point(rng.uniform(0.9 * low, 0.9 * high, (50, 2)))
    normals = np.linalg.eigh(target.closest(feet).weights)[1][:, :, 2]
    for h in (1e-3, 5e-4, 2.5e-4):
        values = np.array([np.linalg.norm(np.asarray(residual(p))) for p in feet + h * normals])
        errors.append(np.abs(values - h))
    rate = np.array(errors[:-1]) / np.array(errors[1:])
    assert np.median(rate) == pytest.approx(4, abs=0.01)
    assert (np.abs(rate - 4) < 0.3).mean() > 0.95  # where the curvature along the drop does not vanish
    assert np.array(errors).max() < 1e-5
    # Beside the domain they are the distance in plan, and the height over the surface continued linearly.
    corner = target.point(np.array([high]))[0]
    assert_close(np.asarray(residual(corner)).ravel(), 0, 1e-12)
    beside = corner + np.array([0.2, 0, 0])
    assert_close(np.asarray(residual(beside)).ravel()[1:], [0.2, 0], 1e-12)
    assert np.isfinite(np.asarray(residual([9, -7, 3]))).all()


@pytest.mark.parametrize("name", SMOOTH)
def test_triangles_cover_the_surface(name: str) -> None:
    target = SMOOTH[name]
    vertices, triangles = target.triangles()
    assert_close(target.distances(vertices), 0, 1e-12)
    centroids, areas = target.samples()
    assert_close(centroids, vertices[triangles].mean(axis=1), 1e-14)
    assert (areas > 0).all()
    if name == "cap":
        assert areas.sum() == pytest.approx(spherical_area(), rel=1e-3)


def spherical_area() -> float:
    """Area of the unit sphere over the square, by integration of 1 / z."""
    x, weight = np.polynomial.legendre.leggauss(40)
    x, weight = SIDE * x, SIDE * weight
    return float(weight @ (1 / np.sqrt(1 - x[:, None] ** 2 - x[None] ** 2)) @ weight)


# ---- vaults between curves


def section(target: BetweenTarget, along: float, across: np.ndarray) -> np.ndarray:
    return target.point(np.c_[across, np.full(len(across), along)])


W = np.linspace(0, 1, 21)


@pytest.mark.parametrize("profile", ["arc", "parabola", "catenary"])
def test_sections_of_a_vault(profile: str) -> None:
    rise, half = 0.6, 1.0
    target = BetweenTarget(curves(), rise, profile)
    x, z = section(target, 0.3, W)[:, [0, 2]].T
    assert (np.diff(x) > 0).all()
    assert x[[0, 10, -1]] == pytest.approx([-1, 0, 1], abs=1e-14)
    if profile == "arc":
        radius = (half**2 + rise**2) / (2 * rise)
        assert_close(np.hypot(x, z - (rise - radius)), radius, 1e-14)
    elif profile == "parabola":
        assert_close(z, rise * (1 - x**2), 1e-14)
    else:
        a = brentq(lambda a: a * (np.cosh(half / a) - 1) - rise, 0.1, 100, xtol=1e-15)
        assert_close(z, rise - a * (np.cosh(x / a) - 1), 1e-12)
    assert z[[0, -1]] == pytest.approx(0, abs=1e-14)
    assert z[10] == pytest.approx(rise, abs=1e-14)


@pytest.mark.parametrize("profile", ["arc", "parabola", "catenary"])
def test_a_vault_hangs_on_its_curves(profile: str) -> None:
    """Polylines of unequal pieces and heights: points by the fraction of their lengths."""
    first = np.array([[0.0, 0, 1], [0, 3, 1], [0, 4, 1]])
    second = np.array([[3.0, 0, 0], [4, 0, 0], [4, 3, 2]])
    target = BetweenTarget([first, second], 0.8, profile)
    lengths = 1 + np.sqrt(13)
    for fraction in (0.0, 0.1, 0.75, 0.9, 1.0):
        low, high = section(target, fraction, np.array([0.0, 1.0]))
        assert_close(low, [0, 4 * fraction, 1], 1e-13)
        way = fraction * lengths
        on_second = [3 + way, 0, 0] if way <= 1 else second[1] + (way - 1) / np.sqrt(13) * (second[2] - second[1])
        assert_close(high, on_second, 1e-13)
        crown = section(target, fraction, np.array([0.5]))[0]
        assert_close(crown, (low + high) / 2 + [0, 0, 0.8], 1e-13)


def test_the_plan_of_a_vault() -> None:
    turn = np.array([[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]])
    first, second = (c @ turn.T + [5, 6, 7] for c in curves())
    frame = BetweenTarget([first, second], 0.5).frame
    assert_close(frame.axes @ frame.axes.T, np.eye(3), 1e-14)
    assert np.linalg.det(frame.axes) == pytest.approx(1, abs=1e-14)
    assert_close(frame.axes[0], turn @ [1, 0, 0], 1e-13)
    assert_close(frame.axes[2], [0, 0, 1], 1e-14)
    assert frame.extent == pytest.approx((2, 4), abs=1e-12)
    assert_close(frame.origin[:2], [5, 6], 1e-9)
    backward = BetweenTarget([first[::-1], second[::-1]], 0.5).frame
    assert_close(backward.axes, frame.axes, 1e-13)


def test_the_plan_of_a_height() -> None:
    frame = HeightTarget("3 + x", [[1, 5], [-2, 0]]).frame
    assert_close(frame.origin, [3, -1, 6], 1e-12)
    assert_close(frame.axes, np.eye(3), 0)
    assert frame.extent == (4, 2)


def test_half_a_circle_is_a_vault() -> None:
    target = BetweenTarget(curves(), 1.0, "arc")
    x, _, z = section(target, 0.5, W).T
    assert_close(np.hypot(x, z), 1, 1e-14)
    points = np.array([[0.9, 0.1, 1.5], [1.7, 0, 0.2], [-2.0, 0.3, -0.5]])
    closest = target.closest(points)
    assert np.isfinite(closest.weights).all()
    assert_close(target.distances(points), [np.hypot(0.9, 1.5) - 1, np.hypot(1.7, 0.2) - 1, np.hypot(1, 0.5)], 1e-6)


@pytest.mark.parametrize(
    ("rise", "profile", "match"),
    [
        (1.001, "arc", "rise is 1.001: an arc over a span of 2 rises at most half of it"),
        (0.0, "parabola", "rise is 0 over a span of 2: both must be positive"),
        (-1.0, "arc", "rise is -1 over a span of 2"),
    ],
)
def test_rises_that_are_refused(rise: float, profile: str, match: str) -> None:
    with pytest.raises(InputError, match=match):
        BetweenTarget(curves(), rise, profile)


def test_curves_that_are_refused() -> None:
    first, second = curves()
    with pytest.raises(InputError, match="over a span of 0"):
        BetweenTarget([first, first], 0.5, "parabola")
    with pytest.raises(InputError, match="a polyline needs two or more points, all different"):
        BetweenTarget([first, second[[0, 1, 1]]], 0.5)
    with pytest.raises(InputError, match="a polyline needs two or more points"):
        BetweenTarget([first, second[:1]], 0.5)


def test_a_height_without_a_value_is_refused() -> None:
    with pytest.raises(InputError, match=r"no value at \(-2, -2\)"):
        HeightTarget("sqrt(1 - x^2 - y^2)", [[-2, 2], [-2, 2]]).triangles()


# ---- where the squared distance has no curvature, or the surface no slope


def test_points_level_with_the_centre_of_a_sphere() -> None:
    """The squared distance is linear in the plan there: the corner that is farthest that way is nearest."""
    target = HeightTarget("sqrt(100 - x^2 - y^2)", [[-6, 6], [-6, 6]])
    points = np.array([[6.0, 6, 0], [-3, 2, 0], [0.5, -7, 0], [0, 0, 0], [0, 0, 3], [0, 0, 25]])
    corner = np.array([6, 6, np.sqrt(28)])
    signs = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1]])
    expected = [*np.linalg.norm(points[:3] - corner * signs, axis=1), 10, 7, 15]
    assert_close(target.distances(points), expected, 1e-12)
    assert np.isfinite(target.closest(points).weights).all()


def test_an_upright_border() -> None:
    """A half-cylinder has no slope where it ends."""
    target = HeightTarget("sqrt(1 - x^2)", [[-1, 1], [-1, 1]])
    x, y, z = points = np.random.default_rng(6).uniform(-2, 2, (3, 400))
    points = points.T
    above = z > 0
    # Inside the distance from the cylinder, below its edges that from the nearer one.
    to_arc = np.where(above, np.hypot(x, z) - 1, np.hypot(np.abs(x) - 1, z))
    expected = np.hypot(to_arc, np.maximum(np.abs(y) - 1, 0))
    closest = target.closest(points)
    assert_close(np.linalg.norm(points - closest.feet, axis=1), expected, 1e-3)
    steep = np.abs(closest.feet[:, 0]) > 0.95
    assert_close(np.linalg.norm(points - closest.feet, axis=1)[~steep], expected[~steep], 1e-10)
    assert np.isfinite(closest.weights).all()


def test_the_tip_of_a_cone() -> None:
    target = HeightTarget("sqrt(x^2 + y^2)", [[-1, 1], [-1, 1]])
    closest = target.closest(np.array([[0, 0, -1.0], [0.01, 0.02, -0.5]]))
    assert_close(closest.feet, 0, 1e-9)
    assert_close(closest.weights, np.tile(np.eye(3), (2, 1, 1)), 0)
