"""Places where anchors hold vertices, and where two of them meet."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from inverse._types import FloatArray
from inverse.origami.geometry import unit

PARALLEL = 1e-5  # sine of the angle between directions below which they count as one


@dataclass(frozen=True, eq=False)
class Spot:
    """One point.

    Attributes:
        at: (3,).
    """

    at: FloatArray
    rows = 3


@dataclass(frozen=True, eq=False)
class Straight:
    """An endless straight line.

    Attributes:
        point: (3,) of the line.
        direction: (3,) unit.
    """

    point: FloatArray
    direction: FloatArray
    rows = 2


@dataclass(frozen=True, eq=False)
class Path:
    """A polyline.

    Attributes:
        points: (n, 3); of a closed one the last is the first again.
    """

    points: FloatArray
    rows = 2

    @cached_property
    def pieces(self) -> tuple[Path, ...]:
        """Its segments."""
        return tuple(Path(np.stack(ends)) for ends in itertools.pairwise(self.points))

    def piece(self, near: FloatArray) -> Path:
        """The segment that is nearest to a point (3,)."""
        return min(self.pieces, key=lambda one: float(np.linalg.norm(foot(one, near) - near)))


@dataclass(frozen=True, eq=False)
class Ring:
    """A circle.

    Attributes:
        centre: (3,).
        normal: (3,) unit, of its plane.
        radius: its radius.
    """

    centre: FloatArray
    normal: FloatArray
    radius: float
    rows = 2


@dataclass(frozen=True, eq=False)
class Flat:
    """A plane.

    Attributes:
        point: (3,) of the plane.
        normal: (3,) unit.
    """

    point: FloatArray
    normal: FloatArray
    rows = 1

    def heights(self, points: FloatArray) -> FloatArray:
        """Distances (N,) of points (N, 3), positive on the side that the normal points to."""
        return np.asarray((points - self.point) @ self.normal)


Place = Spot | Straight | Path | Ring | Flat
_Piece = tuple[FloatArray, FloatArray, float, float]  # a point, a unit direction, and how far it goes either way


def foot(place: Place, point: FloatArray) -> FloatArray:
    """The point (3,) of a place that is nearest to a point (3,)."""
    if isinstance(place, Spot):
        return place.at
    if isinstance(place, Flat):
        return np.asarray(point - ((point - place.point) @ place.normal) * place.normal)
    if isinstance(place, Ring):
        flat = foot(Flat(place.centre, place.normal), point) - place.centre
        if np.linalg.norm(flat) < PARALLEL * place.radius:  # on the axis: any point of the circle
            flat = across(place.normal)[0]
        return np.asarray(place.centre + place.radius * unit(flat))
    feet = [_foot(piece, point) for piece in _pieces(place)]
    return min(feet, key=lambda one: float(np.linalg.norm(one - point)))


def across(direction: FloatArray) -> FloatArray:
    """Two unit vectors, (2, 3), across a unit vector (3,) and each other."""
    first = unit(np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))]))
    return np.stack([first, np.cross(direction, first)])


def lies_in(place: Place, plane: Flat, tolerance: float) -> bool:
    """Whether every point of a place is in a plane."""
    return bool(np.abs(_reach(place, plane)).max() <= tolerance)


def lies_on(place: Place, line: Path) -> bool:
    """Whether a place is a point of a segment (2, 3), or the same segment."""
    if isinstance(place, Spot):
        return bool(
            np.linalg.norm(foot(line, place.at) - place.at)
            <= PARALLEL * np.linalg.norm(line.points[1] - line.points[0])
        )
    return isinstance(place, Path) and _is_same(place, line)


def is_above(place: Place, plane: Flat, tolerance: float) -> bool:
    """Whether no point of a place is below a plane."""
    return bool(_reach(place, plane)[0] >= -tolerance)


def _reach(place: Place, plane: Flat) -> FloatArray:
    """The lowest and the highest distance, (2,), of a place's points from a plane."""
    if isinstance(place, Spot | Path):
        heights = plane.heights(np.atleast_2d(place.at if isinstance(place, Spot) else place.points))
        return np.array([heights.min(), heights.max()])
    if isinstance(place, Ring):
        height = float(plane.heights(place.centre[None])[0])
        half = place.radius * float(np.linalg.norm(np.cross(place.normal, plane.normal)))
        return np.array([height - half, height + half])
    slope = plane.normal @ place.direction if isinstance(place, Straight) else np.cross(plane.normal, place.normal)
    if np.linalg.norm(slope) > PARALLEL:
        return np.array([-np.inf, np.inf])
    return np.repeat(plane.heights(place.point[None]), 2)


def meet(a: Place, b: Place, near: FloatArray, tolerance: float) -> Place | None:
    """Where two places meet.

    Args:
        a: one.
        b: the other.
        near: (3,) where they meet more than once, what is nearest to this point is meant.
        tolerance: how far apart they may be and still meet.

    Returns:
        What they have in common there, or None if they do not meet.
    """
    order = [Spot, Straight, Path, Ring, Flat]
    if order.index(type(a)) > order.index(type(b)):
        a, b = b, a
    if isinstance(a, Spot):
        return a if np.linalg.norm(foot(b, a.at) - a.at) <= tolerance else None
    found: list[Place]
    if isinstance(a, Straight | Path):
        if isinstance(b, Path) and isinstance(a, Path) and _is_same(a, b):
            return a
        meeting = _with(b, tolerance)
        found = [common for piece in _pieces(a) for common in meeting(piece)]
    elif isinstance(a, Ring):
        found = _ring_meets_ring(a, b, tolerance) if isinstance(b, Ring) else _ring_meets_plane(a, _flat(b), tolerance)
    else:
        found = _planes_meet(a, _flat(b), tolerance)
    return min(found, key=lambda one: float(np.linalg.norm(foot(one, near) - near)), default=None)


def _flat(place: Place) -> Flat:
    assert isinstance(place, Flat)  # the last of the order
    return place


def _is_same(a: Path, b: Path) -> bool:
    return a.points.shape == b.points.shape and bool((a.points == b.points).all())


def _pieces(place: Straight | Path) -> list[_Piece]:
    if isinstance(place, Straight):
        return [(place.point, place.direction, -np.inf, np.inf)]
    steps = np.diff(place.points, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    return [(p, s / n, 0.0, float(n)) for p, s, n in zip(place.points[:-1], steps, lengths, strict=True)]


def _foot(piece: _Piece, point: FloatArray) -> FloatArray:
    start, direction, low, high = piece
    return np.asarray(start + np.clip((point - start) @ direction, low, high) * direction)


def _part(piece: _Piece, low: float, high: float) -> Place:
    """A part of a piece as a place."""
    start, direction = piece[:2]
    if np.isinf(low):
        return Straight(start, direction)
    return Path(np.stack([start + low * direction, start + high * direction]))


def _with(place: Place, tolerance: float) -> Callable[[_Piece], list[Place]]:
    """What a place has in common with straight pieces."""
    if isinstance(place, Flat):
        return lambda piece: _piece_meets_plane(piece, place, tolerance)
    if isinstance(place, Ring):
        return lambda piece: _piece_meets_ring(piece, place, tolerance)
    assert isinstance(place, Straight | Path)
    others = _pieces(place)
    return lambda piece: [common for other in others for common in _pieces_meet(piece, other, tolerance)]


def _piece_meets_plane(piece: _Piece, plane: Flat, tolerance: float) -> list[Place]:
    start, direction, low, high = piece
    slope, height = float(direction @ plane.normal), float((start - plane.point) @ plane.normal)
    if lies_in(_part(piece, low, high), plane, tolerance):
        return [_part(piece, low, high)]
    if abs(slope) <= PARALLEL:
        return []
    t = float(np.clip(-height / slope, low, high))
    return [Spot(start + t * direction)] if abs(height + t * slope) <= tolerance else []


def _piece_meets_ring(piece: _Piece, ring: Ring, tolerance: float) -> list[Place]:
    plane = Flat(ring.centre, ring.normal)
    crossing = _piece_meets_plane(piece, plane, tolerance)
    if not crossing or isinstance(crossing[0], Spot):
        spots = crossing
    else:
        beside = Flat(piece[0], unit(np.cross(piece[1], ring.normal)))
        spots = _ring_meets_plane(ring, beside, tolerance)
    return [spot for spot in spots if isinstance(spot, Spot) and _is_on(spot, ring, piece, tolerance)]


def _is_on(spot: Spot, ring: Ring, piece: _Piece, tolerance: float) -> bool:
    feet = foot(ring, spot.at), _foot(piece, spot.at)
    return all(np.linalg.norm(one - spot.at) <= tolerance for one in feet)


def _pieces_meet(a: _Piece, b: _Piece, tolerance: float) -> list[Place]:
    (p, d, low, high), (q, e, low_b, high_b) = a, b
    cosine, offset = float(d @ e), q - p
    sine = float(np.linalg.norm(np.cross(d, e)))
    if sine > PARALLEL:
        t = float(np.clip((offset @ d - cosine * (offset @ e)) / sine**2, low, high))
    else:  # side by side: over which part of the first the second lies
        ends = sorted(float(offset @ d + cosine * s) for s in (low_b, high_b))
        first, last = max(low, ends[0]), min(high, ends[1])
        if np.linalg.norm(offset - (offset @ d) * d) > tolerance:
            return []
        if last - first > tolerance:
            return [_part(a, first, last)]
        t = float(np.clip(ends[0] if ends[0] > low else ends[1], low, high))
    # The nearest point of the other piece may lie at its end, and what is nearest to that elsewhere on this one.
    other = _foot(b, p + t * d)
    mine = _foot(a, other)
    return [Spot(mine)] if np.linalg.norm(_foot(b, mine) - mine) <= tolerance else []


def _ring_meets_plane(ring: Ring, plane: Flat, tolerance: float) -> list[Place]:
    if lies_in(ring, plane, tolerance):
        return [ring]
    first, second = across(ring.normal)
    height = float(plane.heights(ring.centre[None])[0])
    tilt = ring.radius * np.array([first @ plane.normal, second @ plane.normal])
    size = float(np.linalg.norm(tilt))
    if abs(height) > size + tolerance or size <= PARALLEL * ring.radius:
        return []
    middle, half = np.arctan2(tilt[1], tilt[0]), np.arccos(np.clip(-height / size, -1.0, 1.0))
    angles = [middle + half, middle - half]
    return [Spot(ring.centre + ring.radius * (np.cos(t) * first + np.sin(t) * second)) for t in angles]


def _ring_meets_ring(a: Ring, b: Ring, tolerance: float) -> list[Place]:
    offset = b.centre - a.centre
    distance = float(np.linalg.norm(offset))
    if lies_in(a, Flat(b.centre, b.normal), tolerance):
        if distance <= tolerance:
            return [a] if abs(a.radius - b.radius) <= tolerance else []
        along = (distance**2 + a.radius**2 - b.radius**2) / (2 * distance)
        plane = Flat(a.centre + along * offset / distance, offset / distance)
    else:
        plane = Flat(b.centre, b.normal)
    spots = _ring_meets_plane(a, plane, tolerance)
    return [s for s in spots if isinstance(s, Spot) and np.linalg.norm(foot(b, s.at) - s.at) <= tolerance]


def _planes_meet(a: Flat, b: Flat, tolerance: float) -> list[Place]:
    direction = np.cross(a.normal, b.normal)
    size = float(np.linalg.norm(direction))
    if size <= PARALLEL:
        return [a] if abs(b.heights(a.point[None])[0]) <= tolerance else []
    middle = (a.point + b.point) / 2  # a point of the line near to where the planes were given
    heights = [*a.heights(middle[None]), *b.heights(middle[None]), 0.0]
    step = np.linalg.solve(np.stack([a.normal, b.normal, direction / size]), heights)
    return [Straight(middle - step, direction / size)]
