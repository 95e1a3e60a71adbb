"""Anchors of a specification as constraints: which vertices, where, and how many freedoms they take."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from inverse import constraints
from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.model import DesignModel
from inverse.nlp.term import Constraint
from inverse.origami.pattern import Pattern
from inverse.spec import Anchor, GridPattern, Loaded

END = 1e-6  # a vertex closer than this fraction of a segment to its end sits on the end


@dataclass(frozen=True, eq=False)
class PolylineAnchor:
    """Vertices that slide along a polyline, each for the time being on one of its segments.

    Attributes:
        name: unique name of the constraint.
        vertices: (N,) int.
        polyline: (n, 3) points; of a polygon the last is the first again.
        segments: (N,) int, segment that each vertex is held on.
    """

    name: str
    vertices: IntArray
    polyline: FloatArray
    segments: IntArray

    def constraint(self, model: DesignModel) -> Constraint:
        """The vertices held on their segments."""
        ends = self.polyline[self.segments], self.polyline[self.segments + 1]
        return constraints.on_segment(model, self.name, self.vertices, *ends)

    def moved_on(self, points: FloatArray) -> PolylineAnchor:
        """Vertices that ``points`` (V, 3) shows at an end of their segment go on to the next one."""
        a, b = self.polyline[self.segments], self.polyline[self.segments + 1]
        along = np.einsum("ij,ij->i", points[self.vertices] - a, b - a) / np.einsum("ij,ij->i", b - a, b - a)
        step = np.where(along > 1 - END, 1, np.where(along < END, -1, 0))
        segments, last = self.segments + step, len(self.polyline) - 2
        is_closed = (self.polyline[0] == self.polyline[-1]).all()
        segments = segments % (last + 1) if is_closed else np.clip(segments, 0, last)
        return PolylineAnchor(self.name, self.vertices, self.polyline, segments)


def build(loaded: Loaded, model: DesignModel, origin: FloatArray) -> tuple[list[Constraint], list[PolylineAnchor]]:
    """Anchors as constraints; those on polylines apart, since their vertices may change segments.

    Args:
        loaded: the specification.
        model: the model.
        origin: (3,) point of the specification's coordinates that the model's are relative to.

    Raises:
        InputError: an anchor names no boundary or no vertex, several vertices share a point, a vertex is held
            more than three times, or the anchors take more freedoms than the pattern has.
    """
    fixed, sliding = [], []
    demand = _Demand(loaded, model.pattern.degrees_of_freedom)
    for k, (anchor, vertices) in enumerate(held(loaded, model.pattern)):
        gone = vertices[~np.isin(vertices, model.kept_vertices)]
        if len(gone):
            raise loaded.source.error(
                _key(k), f"vertex {gone[0]} lies over a hole of the target, where the design is cut out",
                "Name other vertices.",
            )  # fmt: skip
        name = f"anchor_{k}"
        demand.add(k, anchor, vertices)
        if anchor.to.polyline is not None:
            sliding.append(_on_polyline(name, vertices, np.array(anchor.to.polyline) - origin, model))
        elif anchor.to.polygon is not None:
            corners = np.array([*anchor.to.polygon, anchor.to.polygon[0]]) - origin
            sliding.append(_on_polyline(name, vertices, corners, model))
        else:
            fixed.append(_fixed(name, vertices, anchor, model, origin))
    return fixed, sliding


def held(loaded: Loaded, pattern: Pattern) -> list[tuple[Anchor, IntArray]]:
    """Every anchor of a specification with the vertices (N,) that it holds."""
    asked = loaded.specification.constraints.anchors
    return [(anchor, _vertices(loaded, k, anchor, pattern)) for k, anchor in enumerate(asked)]


@dataclass
class _Demand:
    """What anchors ask for so far: points, equations of every vertex, and freedoms of the pattern."""

    loaded: Loaded
    freedoms: int
    held: dict[int, int] = field(default_factory=dict)
    taken: dict[tuple[float, ...], int] = field(default_factory=dict)
    total: int = 0

    def add(self, k: int, anchor: Anchor, vertices: IntArray) -> None:
        """Count anchor k in.

        Raises:
            InputError: vertices share a point, a vertex is held more than three times, or freedoms run out.
        """
        source, rows, point = self.loaded.source, _rows(anchor), anchor.to.point
        if point is not None and len(vertices) > 1:
            raise source.error(
                _key(k, "to"), f"{len(vertices)} vertices are anchored to one point, where they would coincide",
                "Anchor a single vertex to a point, or a side to a polyline.",
            )  # fmt: skip
        if point is not None and self.taken.setdefault(point, int(vertices[0])) != vertices[0]:
            raise source.error(
                _key(k, "to"), f"vertex {vertices[0]} is anchored to the point where vertex {self.taken[point]} is"
            )
        for vertex in vertices.tolist():
            self.held[vertex] = self.held.get(vertex, 0) + rows
            if self.held[vertex] > 3:
                raise source.error(
                    _key(k), f"vertex {vertex} is held by {self.held[vertex]} equations of this and earlier anchors, "
                    "but a vertex has 3 coordinates", "Leave the vertex out of one of the anchors.",
                )  # fmt: skip
        left = self.freedoms - self.total
        self.total += rows * len(vertices)
        if self.total > self.freedoms:
            raise source.error(
                _key(k),
                f"this anchor takes {rows * len(vertices)} freedoms, but of the pattern's {self.freedoms} only {left} "
                "are left",
                "Anchor fewer vertices, for example with `every: 2`.",
            )


def _key(k: int, *more: str) -> tuple[str | int, ...]:
    return ("constraints", "anchors", k, *more)


def _vertices(loaded: Loaded, k: int, anchor: Anchor, pattern: Pattern) -> IntArray:
    if anchor.vertices is not None:
        vertices = np.array(anchor.vertices, np.int64)
        if vertices.max() >= pattern.n_vertices:
            raise loaded.source.error(
                _key(k, "vertices"),
                f"vertex {vertices.max()} is not there: the pattern has vertices 0 to {pattern.n_vertices - 1}",
            )
        return vertices[:: anchor.every]
    sides = _sides(pattern)
    if isinstance(loaded.specification.pattern, GridPattern) and pattern.grid is None:
        raise loaded.source.error(
            _key(k, "side"), f"{anchor.side!r} names no side: the grid is trimmed to the target's outline",
            "Name the vertices, `vertices: [...]`, or write trim: none in the pattern.",
        )  # fmt: skip
    if anchor.side not in sides:
        what, own = {0: ("A grid", "u0, u1, v0 and v1")}.get(
            pattern.n_holes, ("A tube", "v0, v1 and ends, both of these")
        )
        raise loaded.source.error(
            _key(k, "side"), f"{anchor.side!r} names no boundary of this pattern",
            f"{what} has the sides {own}; any pattern takes `vertices: [...]` instead.",
        )  # fmt: skip
    return np.concatenate([line[:: anchor.every] for line in sides[anchor.side]])


def _sides(pattern: Pattern) -> dict[str, list[IntArray]]:
    """Vertices along the sides of a grid or the open ends of a tube, by the words of specifications."""
    if pattern.grid is None:
        return {}
    _, n = pattern.grid
    table = np.arange(pattern.n_vertices).reshape(-1, n + 1)  # a tube has no line m: it is line 0 again
    along_v = {"v0": [table[:, 0]], "v1": [table[:, -1]]}
    if pattern.n_holes == 1:
        return along_v | {"ends": along_v["v0"] + along_v["v1"]}
    return along_v | {"u0": [table[0]], "u1": [table[-1]]}


def _rows(anchor: Anchor) -> int:
    """Equations per vertex."""
    return 3 if anchor.to.point is not None else 1 if anchor.to.plane is not None else 2


def _fixed(name: str, vertices: IntArray, anchor: Anchor, model: DesignModel, origin: FloatArray) -> Constraint:
    to = anchor.to
    if to.point is not None:
        return constraints.on_point(model, name, vertices, np.array(to.point) - origin)
    if to.plane is not None:
        normal = np.array(to.plane.normal)
        point = np.array(to.plane.point) - origin
        return constraints.on_plane(model, name, vertices, point, normal / np.linalg.norm(normal))
    if to.circle is None:
        raise InputError("an anchor needs one of point, polyline, polygon, plane, circle")
    return constraints.on_circle(
        model, name, vertices, np.array(to.circle.center) - origin, np.array(to.circle.normal), to.circle.radius
    )


def _on_polyline(name: str, vertices: IntArray, polyline: FloatArray, model: DesignModel) -> PolylineAnchor:
    """Each vertex starts on the segment that is nearest to its place in the seed."""
    points = model.seed.vertices_coords[vertices]
    a, b = polyline[:-1], polyline[1:]
    along = np.einsum("nsk,sk->ns", points[:, None] - a, b - a) / np.einsum("sk,sk->s", b - a, b - a)
    feet = a + np.clip(along, 0, 1)[..., None] * (b - a)
    segments = np.argmin(np.linalg.norm(points[:, None] - feet, axis=2), axis=1)
    return PolylineAnchor(name, vertices, polyline, segments)
