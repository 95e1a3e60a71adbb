"""Centre lines and the tubes around them, against closed forms and brute force."""

from __future__ import annotations

import numpy as np
import pytest
from designs import assert_close, rotation
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar

from inverse.errors import InputError
from inverse.surfaces.axis import Axis, arc
from inverse.surfaces.tube import TubeTarget

RNG = np.random.default_rng(5)
TURN = rotation(3)
QUARTER = arc([0, 0, 0], [1 - np.sqrt(0.5), 0, np.sqrt(0.5)], [1, 0, 1])
KNOTS = np.array([[0.0, 0, 0], [1, 2, 0.5], [3, 2, 1], [4, 0, 3]])
AXES = {
    "line": Axis([[1, 0, 0], [1, 3, 4]], smooth=False),
    "polyline": Axis([[0, 0, 0], [0, 0, 2], [1, 0, 3], [1, 2, 3]], smooth=False),
    "spline": Axis(KNOTS, smooth=True),
    "arc": QUARTER,
}
PROFILE = np.array([[0.0, 1.0], [0.3, 0.9], [1.0, 0.4]])


def test_an_arc_is_a_circle_through_its_points() -> None:
    t = np.linspace(0, 1, 41)
    angle = np.pi / 2 * t
    assert_close(QUARTER.at(t), np.c_[1 - np.cos(angle), 0 * t, np.sin(angle)], 1e-8)
    assert_close(QUARTER.tangents(t), np.c_[np.sin(angle), 0 * t, np.cos(angle)], 1e-6)
    assert pytest.approx(np.pi / 2, rel=1e-7) == QUARTER.length


def test_an_arc_goes_the_way_that_its_middle_point_says() -> None:
    """Three quarters of a circle, not the quarter between the same ends."""
    far = arc([1, 0, 0], [-np.sqrt(0.5), 0, -np.sqrt(0.5)], [0, 0, 1])
    assert far.length == pytest.approx(1.5 * np.pi, rel=1e-6)
    assert_close(far.at(np.array([0.5])), [[-np.sqrt(0.5), 0, -np.sqrt(0.5)]], 1e-7)


@pytest.mark.parametrize("name", AXES)
def test_fractions_are_of_the_length(name: str) -> None:
    axis = AXES[name]
    points = axis.at(np.linspace(0, 1, 20001))
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert length.sum() == pytest.approx(axis.length, rel=1e-4)  # corners are cut
    assert length[:10000].sum() == pytest.approx(axis.length / 2, rel=1e-4)


def test_a_spline_meets_its_points_and_goes_on_as_the_cubic_between_them() -> None:
    axis = AXES["spline"]
    chords = np.r_[0, np.linalg.norm(np.diff(KNOTS, axis=0), axis=1).cumsum()]
    cubic = CubicSpline(chords, KNOTS)(np.linspace(0, chords[-1], 50))
    t = axis.closest(cubic)
    assert_close(axis.at(t), cubic, 1e-6)
    assert_close(axis.at(np.array([0.0, 1.0])), KNOTS[[0, -1]], 1e-12)


@pytest.mark.parametrize("name", AXES)
def test_the_closest_fraction_is_the_closest(name: str) -> None:
    axis = AXES[name]
    points = axis.at(RNG.uniform(0.05, 0.95, 25)) + 0.2 * RNG.standard_normal((25, 3))
    t = axis.closest(points)
    dense = np.linspace(-0.3, 1.3, 3201)
    for point, own in zip(points, t, strict=True):

        def gap(s: float, point: np.ndarray = point) -> float:
            return float(np.linalg.norm(axis.at(np.array([s]))[0] - point))

        start = dense[np.argmin(np.linalg.norm(axis.at(dense) - point, axis=1))]
        best = minimize_scalar(gap, bounds=(start - 1e-3, start + 1e-3), method="bounded", options={"xatol": 1e-12})
        assert gap(own) <= best.fun + 1e-12


def test_beyond_its_ends_an_axis_is_straight() -> None:
    t = np.array([-0.2, 1.5])
    assert_close(QUARTER.at(t), [[0, 0, -0.1 * np.pi], [1 + np.pi / 4, 0, 1]], 1e-6)
    assert_close(QUARTER.closest(np.add(QUARTER.at(t), [0.0, 0.3, 0.0])), t, 1e-9)


@pytest.mark.parametrize("name", AXES)
def test_a_straightened_axis_keeps_its_length(name: str) -> None:
    axis = AXES[name]
    for share in (0.0, 0.4, 1.0):
        assert axis.straightened(share).length == pytest.approx(axis.length, rel=1e-5)
    chord = axis.points[-1] - axis.points[0]
    straight = axis.straightened(0.0).tangents(np.linspace(0, 1, 9))
    assert_close(straight, np.tile(chord / np.linalg.norm(chord), (9, 1)), 1e-9)
    assert_close(axis.straightened(0.0).at(np.array([0.5])), [axis.points[0] + chord / 2], 1e-9)
    t = np.linspace(0, 1, 30)
    assert_close(axis.straightened(1.0).at(t), axis.at(t), 1e-5 * axis.length)


# ---- tubes


def test_distances_from_a_cone() -> None:
    """Radius falls linearly: the distance in the meridian plane is that from a straight line, or from its ends."""
    axis = np.array([[0.0, 0, 0], [0, 0, 4]])
    cone = TubeTarget(Axis(axis @ TURN + 7.0, smooth=False), np.array([[0, 2.0], [1, 1.0]]))
    rho, z, angle = RNG.uniform(0.3, 4, 60), RNG.uniform(-1.5, 5.5, 60), RNG.uniform(0, 7, 60)
    points = np.c_[rho * np.cos(angle), rho * np.sin(angle), z] @ TURN + 7.0
    along = np.array([-1.0, 4.0])
    share = np.clip(((rho - 2) * along[0] + z * along[1]) / 17, 0, 1)
    expected = np.hypot(rho - (2 - share), z - 4 * share)
    assert_close(cone.distances(points), expected, 1e-7)
    closest = cone.closest(points)
    moved = np.einsum("nij,nj->ni", closest.weights, points - closest.feet)
    assert_close(np.linalg.norm(moved, axis=1), expected, 1e-5)


def test_distances_from_a_torus() -> None:
    torus = TubeTarget(QUARTER, 0.3)
    t = RNG.uniform(0.1, 0.9, 40)
    outward = np.cross(QUARTER.tangents(t), RNG.standard_normal((40, 3)))
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    beside = RNG.uniform(0.05, 0.8, 40)
    assert_close(torus.distances(QUARTER.at(t) + beside[:, None] * outward), np.abs(beside - 0.3), 1e-7)


def test_a_point_of_the_axis_is_as_far_as_the_radius() -> None:
    tube = TubeTarget(AXES["line"], 0.5)
    assert_close(tube.distances(AXES["line"].at(np.array([0.5]))), [0.5], 1e-9)


def test_a_profile_meets_its_pairs_and_does_not_overshoot() -> None:
    tube = TubeTarget(AXES["spline"], PROFILE)
    assert_close(tube.radii(PROFILE[:, 0]), PROFILE[:, 1], 1e-12)
    radii = tube.radii(np.linspace(-0.5, 1.5, 400))
    assert (np.diff(radii) <= 0).all()
    assert_close(radii[[0, -1]], [1.0, 0.4], 1e-12)


def test_slopes_are_those_of_the_profile() -> None:
    tube = TubeTarget(AXES["arc"], PROFILE)
    t = np.array([-0.1, 0.1, 0.5, 0.8, 1.2])
    h = 1e-6
    at = tube.stations(tube.axis.at(t))
    expected = (tube.radii(t + h) - tube.radii(t - h)) / (2 * h * tube.axis.length)
    assert_close(at.fractions, t, 1e-9)
    assert_close(at.slopes, expected, 1e-6)
    assert_close(at.radii, tube.radii(t), 1e-9)


@pytest.mark.parametrize("name", AXES)
def test_triangles_lie_on_the_tube_and_close(name: str) -> None:
    tube = TubeTarget(AXES[name], 0.2)
    points, triangles = tube.triangles()
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, count = np.unique(edges, axis=0, return_counts=True)
    assert (count == 1).sum() == 2 * 64  # the two open ends
    assert (count <= 2).all()
    if AXES[name].smooth:
        assert tube.distances(points).max() < 1e-6
        area = 2 * np.pi * 0.2 * AXES[name].length  # Pappus
        assert tube.samples()[1].sum() == pytest.approx(area, rel=4e-3)


def test_flattened_tubes() -> None:
    tube = TubeTarget(QUARTER, PROFILE)
    flat = tube.flattened(0.0)
    assert_close(flat.radii(np.linspace(0, 1, 9)), np.full(9, tube.mean_radius), 1e-12)
    half = tube.flattened(0.5)
    assert_close(half.radii(PROFILE[:, 0]), (PROFILE[:, 1] + tube.mean_radius) / 2, 1e-12)
    assert half.axis.length == pytest.approx(QUARTER.length, rel=1e-5)


def test_the_frame_lies_in_the_plane_of_a_bend() -> None:
    frame = TubeTarget(QUARTER, 0.3).frame
    assert_close(frame.axes[0], np.array([1, 0, 1]) / np.sqrt(2), 1e-9)
    assert_close(frame.axes[1], np.array([-1, 0, 1]) / np.sqrt(2), 1e-6)
    assert_close(frame.origin, [0.5, 0, 0.5], 1e-9)
    assert frame.extent == pytest.approx((np.pi / 2, 0.6), rel=1e-6)


def test_refusals() -> None:
    with pytest.raises(InputError, match="ends where it begins"):
        Axis([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0]], smooth=True)
    with pytest.raises(InputError, match="lie on a line"):
        arc([0, 0, 0], [1, 1, 1], [2, 2, 2])
    with pytest.raises(InputError, match="all different from their neighbours"):
        Axis([[0, 0, 0], [0, 0, 0]], smooth=False)
    with pytest.raises(InputError, match="not positive"):
        TubeTarget(QUARTER, -1.0)
    with pytest.raises(InputError, match="increasing fractions"):
        TubeTarget(QUARTER, np.array([[0.5, 1.0], [0.5, 2.0]]))
