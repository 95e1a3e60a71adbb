"""Where anchored vertices may be, as sets of points: how far two are apart, and what of one half-spaces leave."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inverse._types import FloatArray
from inverse.origami import geometry
from inverse.spec import PlaceKeys

PAIRS = 1_000_000  # of segments, whose distances are found one by one; of more the boxes around them are compared
WIDE = 1e6  # coordinates in mean edges beyond which nothing is looked for


@dataclass(frozen=True, eq=False)
class HalfSpaces:
    """Points x with normals @ x >= offsets.

    Attributes:
        normals: (H, 3) unit vectors.
        offsets: (H,).
    """

    normals: FloatArray
    offsets: FloatArray

    def only(self, k: int) -> HalfSpaces:
        """The one half-space k."""
        return HalfSpaces(self.normals[[k]], self.offsets[[k]])

    def missing(self, equation: tuple[FloatArray, float] | None = None) -> tuple[float, FloatArray]:
        """How far a point is outside at least.

        Args:
            equation: normal (3,) and offset of a plane that the point lies on, if it does.

        Returns:
            The least distance, 0 where a point is inside all, and the weights (H,) of those that contradict each other.
        """
        from scipy.optimize import linprog

        if not len(self.offsets):
            return 0.0, np.empty(0)
        upper = -np.column_stack([self.normals, np.ones(len(self.offsets))])
        plane = {} if equation is None else {"A_eq": np.append(equation[0], 0.0)[None], "b_eq": [equation[1]]}
        found = linprog(
            [0.0, 0.0, 0.0, 1.0],
            upper,
            -self.offsets,
            bounds=[(-WIDE, WIDE)] * 3 + [(0, None)],
            method="highs",
            **plane,
        )
        if found.status != 0:
            return 0.0, np.zeros(len(self.offsets))  # no proof
        return float(found.fun), -np.asarray(found.ineqlin.marginals)


@dataclass(frozen=True, eq=False)
class Segments:
    """Points on segments.

    Attributes:
        starts: (N, 3).
        ends: (N, 3), the same where it is a single point.
    """

    starts: FloatArray
    ends: FloatArray

    def missing(self, spaces: HalfSpaces) -> float:
        """How far its points are outside of some half-space at least; a lower bound, and exact for one half-space."""
        a, b = (points @ spaces.normals.T - spaces.offsets for points in (self.starts, self.ends))
        outside = np.maximum(-np.maximum(a, b), 0.0).max(axis=1, initial=0.0)  # per segment, of the worst half-space
        with np.errstate(divide="ignore", invalid="ignore"):
            cut = a / (a - b)
        low = np.where((a < 0) & (b > 0), cut, 0.0).max(axis=1, initial=0.0)
        high = np.where((a > 0) & (b < 0), cut, 1.0).min(axis=1, initial=1.0)
        # The parts inside of different half-spaces do not meet: at their nearest ends one is missed by this.
        lengths = np.linalg.norm(self.ends - self.starts, axis=1)
        slopes = np.abs(b - a) / np.maximum(lengths, np.finfo(float).tiny)[:, None]
        gap = (
            np.maximum(low - high, 0.0)
            * lengths
            / 2
            * np.min(np.where(slopes > 0, slopes, np.inf), axis=1, initial=1.0)
        )
        return float(np.maximum(outside, gap).min())


@dataclass(frozen=True, eq=False)
class Flat:
    """Points on a plane.

    Attributes:
        normal: (3,) unit vector.
        offset: of the plane.
    """

    normal: FloatArray
    offset: float

    def missing(self, spaces: HalfSpaces) -> float:
        """How far its points are outside of some half-space at least."""
        return spaces.missing((self.normal, self.offset))[0]


@dataclass(frozen=True, eq=False)
class Ring:
    """Points on a circle.

    Attributes:
        centre: (3,).
        normal: (3,) unit vector.
        radius: of the circle.
    """

    centre: FloatArray
    normal: FloatArray
    radius: float

    def missing(self, spaces: HalfSpaces) -> float:
        """How far its points are outside of some half-space at least; of each by itself."""
        return float(np.maximum(spaces.offsets - self.along(spaces.normals)[1], 0.0).max(initial=0.0))

    def along(self, normals: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Least and largest component along unit vectors (N, 3)."""
        middle = normals @ self.centre
        reach = self.radius * np.sqrt(np.maximum(1 - (normals @ self.normal) ** 2, 0.0))
        return middle - reach, middle + reach


Place = Segments | Flat | Ring


def place_of(keys: PlaceKeys, scaled: FloatArray, origin: FloatArray) -> Place:
    """An anchor's place, its points moved by minus an origin (3,) and divided by a scale (1,)."""

    def points(given: object) -> FloatArray:
        return np.asarray((np.array(given, np.float64) - origin) / scaled)

    def unit(given: object) -> FloatArray:
        vector = np.array(given, np.float64)
        return np.asarray(vector / np.linalg.norm(vector))

    if keys.plane is not None:
        normal = unit(keys.plane.normal)
        return Flat(normal, float(normal @ points(keys.plane.point)))
    if keys.circle is not None:
        return Ring(points(keys.circle.center), unit(keys.circle.normal), float(keys.circle.radius / scaled[0]))
    line = points([keys.point] if keys.point is not None else keys.polyline or keys.polygon)
    if keys.polygon is not None:
        line = np.concatenate([line, line[:1]])
    return Segments(line[:-1], line[1:]) if len(line) > 1 else Segments(line, line)


def least_distance(a: Place, b: Place) -> float:
    """A lower bound of the distance between points of two places."""
    if isinstance(a, Flat):
        return _from_plane(a, b)
    if isinstance(b, Flat):
        return _from_plane(b, a)
    if isinstance(a, Ring) or isinstance(b, Ring):
        (p, reach_p), (q, reach_q) = (_without_ring(one) for one in (a, b))
        return max(_between(p, q) - reach_p - reach_q, 0.0)
    return _between(a, b)


def largest_distance(a: Place, b: Place) -> float:
    """An upper bound of the distance between points of two places."""
    if isinstance(a, Flat) or isinstance(b, Flat):
        return np.inf
    (p, reach_p), (q, reach_q) = (_without_ring(one) for one in (a, b))
    corners = [np.concatenate([one.starts, one.ends]) for one in (p, q)]
    if len(corners[0]) * len(corners[1]) > PAIRS:
        return geometry.diagonal(np.concatenate(corners)) + reach_p + reach_q
    far = np.linalg.norm(corners[0][:, None] - corners[1], axis=2).max()
    return float(far) + reach_p + reach_q


def _without_ring(place: Place) -> tuple[Segments, float]:
    """A place as segments, and how far its points are from these at most."""
    if isinstance(place, Ring):
        return Segments(place.centre[None], place.centre[None]), place.radius
    assert isinstance(place, Segments)
    return place, 0.0


def _from_plane(plane: Flat, other: Place) -> float:
    if isinstance(other, Flat):
        cosine = float(plane.normal @ other.normal)
        if abs(cosine) < 1 - 1e-12:
            return 0.0
        return float(abs(other.offset - np.sign(cosine) * plane.offset))
    if isinstance(other, Ring):
        low, high = (float(one[0]) - plane.offset for one in other.along(plane.normal[None]))
    else:
        heights = np.concatenate([other.starts, other.ends]) @ plane.normal - plane.offset
        low, high = float(heights.min()), float(heights.max())
    return max(low, -high, 0.0)


def _between(a: Segments, b: Segments) -> float:
    """Distance between two sets of segments, or a lower bound of it."""
    if len(a.starts) * len(b.starts) > PAIRS:
        boxes = [(np.minimum(s.starts, s.ends).min(axis=0), np.maximum(s.starts, s.ends).max(axis=0)) for s in (a, b)]
        apart = np.maximum(np.maximum(boxes[1][0] - boxes[0][1], boxes[0][0] - boxes[1][1]), 0.0)
        return float(np.linalg.norm(apart))
    u, v = (a.ends - a.starts)[:, None], (b.ends - b.starts)[None]
    w = a.starts[:, None] - b.starts[None]
    uu, vv, uv, uw, vw = (np.sum(p * q, axis=-1) for p, q in ((u, u), (v, v), (u, v), (u, w), (v, w)))
    tiny = np.finfo(float).tiny
    determinant = uu * vv - uv**2

    def distance(s: FloatArray, t: FloatArray) -> FloatArray:
        return np.asarray(np.linalg.norm(w + s[..., None] * u - t[..., None] * v, axis=-1))

    def other(of_s: FloatArray) -> FloatArray:
        return np.asarray(np.clip((vw + of_s * uv) / np.maximum(vv, tiny), 0, 1))

    def own(of_t: FloatArray) -> FloatArray:
        return np.asarray(np.clip((of_t * uv - uw) / np.maximum(uu, tiny), 0, 1))

    zero, one = np.zeros_like(uv), np.ones_like(uv)
    inside = np.clip((uv * vw - vv * uw) / np.where(determinant > 1e-12 * uu * vv, determinant, np.inf), 0, 1)
    found = [distance(s, other(s)) for s in (zero, one, inside)] + [distance(own(t), t) for t in (zero, one)]
    return float(np.min(found))
