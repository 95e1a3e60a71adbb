"""Anchors of a specification: which vertices, where, and the constraints that hold them there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from inverse import constraints
from inverse._types import FloatArray, IntArray
from inverse.formulation import sharing, walls
from inverse.formulation.places import Flat, Path, Place, Ring, Spot, Straight, lies_on
from inverse.formulation.walls import Wall
from inverse.model import DesignModel
from inverse.nlp.term import Constraint
from inverse.origami.holes import boundary_loops
from inverse.origami.pattern import Pattern
from inverse.spec import Anchor, GridPattern, Loaded

END = 1e-6  # a vertex closer than this fraction of a segment to its end sits on the end
MEET = 0.01  # mean edges: places so near to each other meet


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


@dataclass(frozen=True, eq=False)
class Anchored:
    """The anchors of a task.

    Attributes:
        fixed: constraints that stay as they are: anchors, and walls that the design stays within.
        sliding: anchors on polylines, whose vertices may change segments.
        places: of every anchor, in the order of the specification.
        held: for every anchor the vertices that it holds, (N,) int; some together with others.
        at: where each vertex that is held is held.
        walls: what the design stays within.
        notes: sentences about vertices that several anchors name.
    """

    fixed: list[Constraint]
    sliding: list[PolylineAnchor]
    places: list[Place]
    held: list[IntArray]
    at: Mapping[int, Place]
    walls: list[Wall]
    notes: tuple[str, ...]


def build(loaded: Loaded, model: DesignModel, origin: FloatArray) -> Anchored:
    """The anchors of a specification as constraints.

    A vertex that several anchors name, as a corner of two sides, is held where their places meet.

    Args:
        loaded: the specification.
        model: the model.
        origin: (3,) point of the specification's coordinates that the model's are relative to.

    Raises:
        InputError: an anchor names no boundary or no vertex, several vertices share a point, a vertex is named by
            two anchors whose places do not meet, the anchors take more freedoms than the pattern has, or the design
            is on no side of a wall.
    """
    asked = loaded.specification.constraints.anchors
    places = [place_of(anchor, origin) for anchor in asked]
    lines = [_lines(loaded, k, anchor, model.pattern) for k, anchor in enumerate(asked)]
    for k, some in enumerate(lines):
        gone = np.setdiff1d(np.concatenate(some), model.kept_vertices)
        if len(gone):
            raise loaded.source.error(
                ("constraints", "anchors", k),
                f"vertex {gone[0]} lies over a hole of the target, where the design is cut out",
                "Name other vertices.",
            )
    tolerance = MEET * model.scale
    shared = sharing.shared(loaded, model, places, lines, tolerance)
    at, by = shared.at, shared.by
    _check_folds(loaded, model.pattern, at, by)
    groups: dict[tuple[int, ...], list[int]] = {}
    for vertex, owners in by.items():
        groups.setdefault(owners, []).append(vertex)
    fixed: list[Constraint] = []
    sliding: list[PolylineAnchor] = []
    for owners in sorted(groups):
        name, vertices = "anchor_" + "+".join(map(str, owners)), np.array(groups[owners], np.int64)
        if len(owners) == 1:
            _hold(name, vertices, places[owners[0]], model, fixed, sliding)
        else:  # each where the places of its anchors meet
            for vertex in groups[owners]:
                _hold(f"{name} at {vertex}", np.array([vertex]), at[vertex], model, fixed, sliding)
    sides = sides_of(model.pattern)
    whole = [np.concatenate([np.empty(0, np.int64), *sides.get(one.side or "", [])]) for one in asked]
    found = walls.of_anchors(loaded, model, places, whole, tolerance)
    fixed += [constraint for wall in found if (constraint := wall.constraint(model, at, tolerance)) is not None]
    held = [np.array(sorted(v for v, owners in by.items() if k in owners), np.int64) for k in range(len(asked))]
    return Anchored(fixed, sliding, places, held, at, found, shared.notes)


def place_of(anchor: Anchor, origin: FloatArray) -> Place:
    """Where an anchor holds its vertices, relative to a point (3,) of the specification's coordinates."""
    to = anchor.to
    if to.point is not None:
        return Spot(np.array(to.point) - origin)
    if to.polyline is not None:
        return Path(np.array(to.polyline) - origin)
    if to.polygon is not None:
        return Path(np.array([*to.polygon, to.polygon[0]]) - origin)
    if to.plane is not None:
        normal = np.array(to.plane.normal)
        return Flat(np.array(to.plane.point) - origin, normal / np.linalg.norm(normal))
    assert to.circle is not None  # exactly one is given
    normal = np.array(to.circle.normal)
    return Ring(np.array(to.circle.center) - origin, normal / np.linalg.norm(normal), to.circle.radius)


def _lines(loaded: Loaded, k: int, anchor: Anchor, pattern: Pattern) -> list[IntArray]:
    """The vertices that an anchor names, line by line."""
    key = ("constraints", "anchors", k)
    if anchor.vertices is not None:
        vertices = np.array(anchor.vertices, np.int64)
        if vertices.max() >= pattern.n_vertices:
            raise loaded.source.error(
                (*key, "vertices"),
                f"vertex {vertices.max()} is not there: the pattern has vertices 0 to {pattern.n_vertices - 1}",
            )
        return [vertices[:: anchor.every]]
    sides = sides_of(pattern)
    if isinstance(loaded.specification.pattern, GridPattern) and pattern.grid is None:
        raise loaded.source.error(
            (*key, "side"), f"{anchor.side!r} names no side: the grid is trimmed to the target's outline",
            "Name the vertices, `vertices: [...]`, or write trim: none in the pattern.",
        )  # fmt: skip
    if anchor.side not in sides:
        what, own = {0: ("A grid", "u0, u1, v0 and v1")}.get(
            pattern.n_holes, ("A tube", "v0, v1 and ends, both of these")
        )
        raise loaded.source.error(
            (*key, "side"), f"{anchor.side!r} names no boundary of this pattern",
            f"{what} has the sides {own}; any pattern takes `vertices: [...]` instead.",
        )  # fmt: skip
    return [line[:: anchor.every] for line in sides[anchor.side]]


def _check_folds(loaded: Loaded, pattern: Pattern, at: Mapping[int, Place], by: Mapping[int, tuple[int, ...]]) -> None:
    """Refuse three neighbours on the rim that one straight line holds: no fold can start between them."""
    degree = np.bincount(pattern.edges_vertices.ravel(), minlength=pattern.n_vertices)
    for loop in boundary_loops(pattern):
        for three in zip(loop, np.roll(loop, -1).tolist(), np.roll(loop, -2).tolist(), strict=True):
            place = at.get(three[1])
            if degree[three[1]] > 2 and isinstance(place, Path) and len(place.points) == 2:
                on_it = [v in at and (at[v] is place or lies_on(at[v], place)) for v in three]
                if all(on_it):
                    raise loaded.source.error(
                        ("constraints", "anchors", by[three[1]][0]),
                        "vertices {}, {} and {} are held on one straight line: the facets between them would lie in "
                        "one plane, without a fold".format(*sorted(three)),
                        "Hold every second vertex with `every: 2`, or all of them on a plane.",
                    )


def sides_of(pattern: Pattern) -> dict[str, list[IntArray]]:
    """Vertices along the sides of a grid or the open ends of a tube, by the words of specifications."""
    if pattern.grid is None:
        return {}
    _, n = pattern.grid
    table = np.arange(pattern.n_vertices).reshape(-1, n + 1)  # a tube has no line m: it is line 0 again
    along_v = {"v0": [table[:, 0]], "v1": [table[:, -1]]}
    if pattern.n_holes == 1:
        return along_v | {"ends": along_v["v0"] + along_v["v1"]}
    return along_v | {"u0": [table[0]], "u1": [table[-1]]}


def _hold(
    name: str,
    vertices: IntArray,
    place: Place,
    model: DesignModel,
    fixed: list[Constraint],
    sliding: list[PolylineAnchor],
) -> None:
    """Add what holds vertices (N,) in a place."""
    if isinstance(place, Spot):
        fixed.append(constraints.on_point(model, name, vertices, place.at))
    elif isinstance(place, Straight):
        fixed.append(constraints.on_line(model, name, vertices, place.point, place.direction))
    elif isinstance(place, Flat):
        fixed.append(constraints.on_plane(model, name, vertices, place.point, place.normal))
    elif isinstance(place, Ring):
        fixed.append(constraints.on_circle(model, name, vertices, place.centre, place.normal, place.radius))
    else:
        sliding.append(_on_polyline(name, vertices, place.points, model))


def _on_polyline(name: str, vertices: IntArray, polyline: FloatArray, model: DesignModel) -> PolylineAnchor:
    """Each vertex starts on the segment that is nearest to its place in the seed."""
    points = model.seed.vertices_coords[vertices]
    a, b = polyline[:-1], polyline[1:]
    along = np.einsum("nsk,sk->ns", points[:, None] - a, b - a) / np.einsum("sk,sk->s", b - a, b - a)
    feet = a + np.clip(along, 0, 1)[..., None] * (b - a)
    segments = np.argmin(np.linalg.norm(points[:, None] - feet, axis=2), axis=1)
    return PolylineAnchor(name, vertices, polyline, segments)
