"""Walls: planes of anchors that the whole design stays within."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from inverse import constraints
from inverse._types import FloatArray, IntArray
from inverse.formulation.places import Flat, Path, Place, Spot, foot, is_above, lies_in
from inverse.model import DesignModel
from inverse.nlp.term import Constraint
from inverse.origami import geometry
from inverse.spec import Anchor, Loaded

UPRIGHT = np.cos(np.radians(45))  # upwards part of the normals of planes that are rather floors than walls
MOST = 0.75  # share of the seed's vertices on one side of a wall, so that the design is there
FOUR = {"u0", "u1", "v0", "v1"}


@dataclass(frozen=True, eq=False)
class Wall:
    """A plane that some vertices stay on one side of.

    Attributes:
        name: unique name of the constraint.
        plane: its normal points to where the design is.
        vertices: (N,) int, those that stay there; the others are held where they are.
    """

    name: str
    plane: Flat
    vertices: IntArray

    def constraint(self, model: DesignModel, at: Mapping[int, Place], tolerance: float) -> Constraint | None:
        """The vertices kept on their side; those that are held there by their anchors need no more.

        Args:
            model: the model.
            at: places of the vertices that are held.
            tolerance: how far behind the wall these may be.

        Returns:
            The constraint, or None where no vertex is left.
        """
        free = [v for v in self.vertices.tolist() if not self._is_settled(at.get(v), tolerance)]
        if not free:
            return None
        return constraints.keep_out(model, self.name, self.plane.point, self.plane.normal, np.array(free))

    def _is_settled(self, place: Place | None, tolerance: float) -> bool:
        # A bound on a vertex that is held at a point is met or contradicts it, and is no independent row either way.
        return place is not None and (isinstance(place, Spot) or is_above(place, self.plane, tolerance))


def of_anchors(
    loaded: Loaded, model: DesignModel, places: Sequence[Place], sides: Sequence[IntArray], tolerance: float
) -> list[Wall]:
    """The walls of a task.

    A wall bounds the whole mesh. Only where a polyline turns into the design, as at the inner corner of an L, no
    plane does that: there a segment bounds the vertices of its own side of the mesh that are nearest to it.

    Args:
        loaded: the specification.
        model: the model.
        places: of every anchor.
        sides: (N,) int of every anchor, all vertices of the side that it names; none where it names vertices.
        tolerance: how far apart points may be and still count as one.

    Raises:
        InputError: the design is on both sides of what is said to be a wall.
    """
    anchors = loaded.specification.constraints.anchors
    is_court = {anchor.side for anchor in anchors} >= FOUR and model.pattern.n_holes == 0
    found: list[Wall] = []
    for k, (anchor, place) in enumerate(zip(anchors, places, strict=True)):
        if not (_is_wall(anchor, place, is_court) if anchor.within is None else anchor.within):
            continue
        walls = [_by_plane(place, model)] if isinstance(place, Flat) else _by_path(place, sides[k], model, tolerance)
        if None in walls and anchor.within:
            raise loaded.source.error(
                ("constraints", "anchors", k, "within"),
                "the seed lies on both sides of this anchor's place, so that nothing says which side is within",
                "Leave `within` out, or bound the design by a keep_out with a plane, whose normal says the side.",
            )
        for wall in walls:
            if wall is not None and not any(_is_same(wall, other, tolerance) for other in found):
                found.append(replace(wall, name=f"within_{k}" + (f"_{len(found)}" if len(walls) > 1 else "")))
    return found


def _is_wall(anchor: Anchor, place: Place, is_court: bool) -> bool:
    """Whether an anchor that does not say so is a wall."""
    if anchor.side is None:
        return False
    if isinstance(place, Flat):
        return bool(abs(place.normal[2]) <= UPRIGHT)
    return isinstance(place, Path) and is_court


def _is_same(wall: Wall, other: Wall, tolerance: float) -> bool:
    """Whether another wall bounds these vertices already, as where all sides name one polygon."""
    return (
        bool(wall.plane.normal @ other.plane.normal > 1 - 1e-9)
        and lies_in(Spot(wall.plane.point), other.plane, tolerance)
        and bool(np.isin(wall.vertices, other.vertices).all())
    )


def _by_plane(plane: Flat, model: DesignModel) -> Wall | None:
    """The wall that a plane is, with its normal to where the seed is; None where that is on both sides."""
    heights = plane.heights(model.seed.vertices_coords)
    above = float((heights > 0).mean())
    if max(above, 1 - above) < MOST:
        return None
    return Wall("", Flat(plane.point, plane.normal if above >= MOST else -plane.normal), _all(model))


def _by_path(place: Place, side: IntArray, model: DesignModel, tolerance: float) -> list[Wall | None]:
    """The walls that stand on the segments of a polyline; none on upright segments."""
    if not isinstance(place, Path):
        return []
    line, points = place.points, model.seed.vertices_coords
    left = _left(line, geometry.facet_centroids(model.pattern, points)) if (line[0] == line[-1]).all() else None
    nearest = [int(np.argmin([np.linalg.norm(foot(one, p) - p) for one in place.pieces])) for p in points[side]]
    found: list[Wall | None] = []
    for s, (start, end) in enumerate(itertools.pairwise(line)):
        along = end - start
        if np.hypot(along[0], along[1]) <= tolerance:
            continue
        normal = geometry.unit(np.array([-along[1], along[0], 0.0]))
        whole = _by_plane(Flat(start, normal), model) if left is None else None
        if left is not None:
            whole = Wall("", Flat(start, normal if left else -normal), _all(model))
        if whole is not None and not is_above(place, whole.plane, tolerance):  # the line turns into the design
            whole = Wall("", whole.plane, side[np.array(nearest, np.int64) == s])
        if whole is None or len(whole.vertices):
            found.append(whole)
    return found


def _all(model: DesignModel) -> IntArray:
    return np.arange(model.pattern.n_vertices)


def _left(polygon: FloatArray, points: FloatArray) -> bool:
    """Whether most points (N, 3) lie, in plan, on the left of a closed polyline (n, 3): within, if it turns left."""
    x, y = polygon[:, :2].T
    turns_left = float(x[:-1] @ y[1:] - x[1:] @ y[:-1]) > 0
    seen = polygon[None, :, :2] - points[:, None, :2]
    steps = np.diff(np.unwrap(np.arctan2(seen[..., 1], seen[..., 0]), axis=1)[:, [0, -1]], axis=1)
    is_within = float((np.abs(steps) > np.pi).mean()) > 0.5
    return turns_left == is_within
