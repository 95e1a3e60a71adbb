"""Where two places meet: found for every pair of kinds, whatever their order, and checked by distances."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from designs import assert_close, rotation

from inverse.formulation.places import Flat, Path, Place, Ring, Spot, Straight, foot, is_above, lies_in, meet

ORIGIN, NEAR, TINY = np.zeros(3), np.array([1.1, 0.1, 0.2]), 1e-6
X, Y, Z = np.eye(3)
AT = np.array([1.0, 0.0, 0.0])  # all of these pass through this point, and nothing else near it is common to two
THROUGH: dict[str, Place] = {
    "spot": Spot(AT),
    "straight": Straight(AT - 3 * Y, Y),
    "path": Path(np.array([[1.0, 0, -2], [1, 0, 2], [5, 5, 5]])),
    "ring": Ring(ORIGIN, np.array([0.0, 0.6, -0.8]), 1.0),
    "other ring": Ring(np.array([2.0, 0, 0]), np.array([0.0, 0.8, 0.6]), 1.0),
    "flat": Flat(np.array([1.0, 4, 4]), X),
    "other flat": Flat(AT, np.array([0.6, 0.48, 0.64])),
}


def moved(place: Place, turn: np.ndarray, shift: np.ndarray) -> Place:
    if isinstance(place, Spot):
        return Spot(place.at @ turn + shift)
    if isinstance(place, Path):
        return Path(place.points @ turn + shift)
    if isinstance(place, Straight):
        return Straight(place.point @ turn + shift, place.direction @ turn)
    if isinstance(place, Ring):
        return Ring(place.centre @ turn + shift, place.normal @ turn, place.radius)
    return Flat(place.point @ turn + shift, place.normal @ turn)


PLANES = {"flat", "other flat"}


@pytest.mark.parametrize(("a", "b"), list(itertools.permutations(THROUGH, 2)))
def test_places_through_a_point_meet_there(a: str, b: str) -> None:
    turn, shift = rotation(3), np.array([4.0, -2.0, 7.0])
    one, other = moved(THROUGH[a], turn, shift), moved(THROUGH[b], turn, shift)
    near, at = NEAR @ turn + shift, AT @ turn + shift
    common = meet(one, other, near, TINY)
    assert common is not None
    assert_close(foot(one, foot(common, at)), foot(common, at), 1e-9)
    assert_close(foot(common, at), at, 1e-6)
    kept = {"straight", "flat"} == {a, b} or {"path", "flat"} == {a, b}  # these lie in the plane
    assert isinstance(common, Straight | Path if kept or {a, b} == PLANES else Spot)


@pytest.mark.parametrize(
    ("a", "b"),
    [
        (Flat(ORIGIN, Z), Flat(Z, -Z)),
        (Straight(ORIGIN, X), Straight(Z, X)),
        (Straight(ORIGIN, X), Straight(Z, Y)),
        (Straight(ORIGIN, X), Flat(Z, Z)),
        (Path(np.array([ORIGIN, X])), Flat(2 * X, X)),
        (Path(np.array([ORIGIN, X])), Path(np.array([2 * X, 3 * X]))),
        (Path(np.array([ORIGIN, X])), Path(np.array([2 * X, 2 * X + Y]))),
        (Ring(ORIGIN, Z, 1.0), Path(np.array([0.2 * X, 0.9 * X]))),
        (Ring(ORIGIN, Z, 1.0), Ring(ORIGIN, Z, 2.0)),
        (Ring(ORIGIN, Z, 1.0), Ring(5 * X, Y, 2.0)),
        (Ring(ORIGIN, Z, 1.0), Flat(2 * X, X)),
        (Spot(ORIGIN), Ring(ORIGIN, Z, 1.0)),
    ],
)
def test_places_that_do_not_meet(a: Place, b: Place) -> None:
    assert meet(a, b, NEAR, TINY) is None
    assert meet(b, a, NEAR, TINY) is None


def test_what_several_places_have_in_common() -> None:
    wall = Path(np.array([[0.0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0], [0, 0, 0]]))
    assert meet(wall, Path(wall.points.copy()), NEAR, TINY) is wall
    side = meet(wall, Flat(ORIGIN, Y), NEAR, TINY)  # all of one segment, and nearer than the points of others
    assert isinstance(side, Path)
    assert_close(side.points, [[0, 0, 0], [4, 0, 0]], 1e-12)
    part = meet(wall, Path(np.array([[3.0, 0, 0], [9, 0, 0]])), NEAR, TINY)
    assert isinstance(part, Path)
    assert_close(part.points, [[3, 0, 0], [4, 0, 0]], 1e-12)
    edge = meet(Flat(X, X), Flat(Y, Y), 5 * Z, TINY)
    assert isinstance(edge, Straight)
    assert_close(np.abs(edge.direction), Z, 1e-12)
    assert_close(edge.point[:2], [1, 1], 1e-12)
    ring = Ring(ORIGIN, Z, 2.0)
    assert meet(ring, Flat(ORIGIN, -Z), NEAR, TINY) is ring
    assert meet(ring, Ring(ORIGIN, -Z, 2.0), NEAR, TINY) is ring


def test_of_several_points_the_nearest_is_taken() -> None:
    ring, plane = Ring(ORIGIN, Z, 2.0), Flat(ORIGIN, Y)
    for near in (X, -X):
        common = meet(ring, plane, near, TINY)
        assert isinstance(common, Spot)
        assert_close(common.at, 2 * near, 1e-12)


def test_places_that_nearly_meet() -> None:
    a, b = Path(np.array([ORIGIN, X])), Path(np.array([X + 0.01 * Z, X + Y]))
    assert meet(a, b, NEAR, 0.005) is None
    common = meet(a, b, NEAR, 0.02)
    assert isinstance(common, Spot)
    assert_close(common.at, X, 1e-12)


def test_planes_and_what_lies_in_or_above_them() -> None:
    floor = Flat(ORIGIN, Z)
    assert lies_in(Ring(ORIGIN, Z, 3.0), floor, TINY)
    assert not lies_in(Ring(ORIGIN, X, 3.0), floor, TINY)
    assert lies_in(Straight(X, Y), floor, TINY)
    assert is_above(Ring(3 * Z, X, 3.0), floor, TINY)
    assert not is_above(Ring(3 * Z, X, 3.1), floor, TINY)
    assert not is_above(Straight(Z, np.array([0.0, 0.6, 0.8])), floor, TINY)
    assert is_above(Flat(2 * Z, Z), floor, TINY)
    assert not is_above(Flat(2 * Z, X), floor, TINY)
