"""Dragging vertices of a design by equation (9): every step the nearest move that keeps it rigid-foldable."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from inverse import constraints, cylinder_loop
from inverse._types import FloatArray, IntArray
from inverse.constraints import Range
from inverse.errors import InputError
from inverse.model import DesignModel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import geometry
from inverse.origami.pattern import Design, Pattern
from inverse.solvers.projection import Projection, polish

LIMITS: dict[str, Range] = {
    "edge_length": (0.3, 3.0),
    "sector_angle": (float(np.radians(14)), float(np.radians(166))),
    "fold_angle": (float(np.radians(20)), float(np.radians(160))),
}
GAIN = 0.02  # steps at the end of the way go on while each brings the vertices nearer by this fraction
SHORTEST = 1 / 64  # of a step: a drag that gets no further by this much has come to its end


@dataclass(frozen=True, eq=False)
class Refined:
    """Where a drag ended.

    Attributes:
        design: the design, which satisfies all equations.
        remaining: (V,) distance of every vertex from where it was wished, in the design's unit; 0 where there was
            no wish of its own.
        residual: largest violation of an equation or a bound, dimensionless.
        steps: Euler steps made.
    """

    design: Design
    remaining: FloatArray
    residual: float
    steps: int


class Drag:
    """A design that is dragged move by move, as by a pointer: what moves have in common is made once.

    Limits are those of :func:`refine`, of the design that it begins with.

    Args:
        design: to begin with; small errors of its own are removed.
        pins: vertices that stay where they are.
        bars: pairs of vertices that keep their distance.

    Raises:
        InputError: a pin or a bar of a vertex that is not there; a strip around a hole that opens already.
    """

    def __init__(self, design: Design, *, pins: Sequence[int] = (), bars: Sequence[tuple[int, int]] = ()) -> None:
        n_vertices = design.pattern.n_vertices
        self._pinned = _vertices(list(pins), "a pin", n_vertices)
        ends = _vertices([v for bar in bars for v in bar], "a bar", n_vertices).reshape(-1, 2)
        for a, b in ends.tolist():
            if a == b:
                raise InputError(f"a bar joins vertex {a} with itself")
        self._model = model = DesignModel(design)
        terms = [*constraints.hard_constraints(model, _limits(design)), *cylinder_loop.around_holes(model)]
        if len(self._pinned):
            terms.append(constraints.on_point(model, "pins", self._pinned, design.vertices_coords[self._pinned]))
        if len(ends):
            terms.append(constraints.bars(model, "bars", ends))
        problem = Problem(model.n_variables, [], terms)
        self._projection = Projection()
        self._point = polish(Point(problem, model.seed_points.ravel(), problem.parameters()))

    @property
    def design(self) -> Design:
        """The design as it is now; it satisfies all equations."""
        return self._model.design(self._point.variables)

    def move(
        self,
        move: Mapping[int, Sequence[float] | FloatArray] | FloatArray | None,
        *,
        reach: float | None = None,
        steps: int = 1,
    ) -> Refined:
        """Move vertices from where they are now, as far as the constraints admit.

        Args:
            move: wished displacements, as of :func:`refine`.
            reach: how far others follow, as of :func:`refine`.
            steps: Euler steps that the way is cut into; one is enough for what a pointer moves at a time.

        Returns:
            The design that was reached, from where the next move goes on.

        Raises:
            InputError: a vertex that is not there, a displacement that is not finite or of another shape, no steps.
        """
        design = self.design
        n_vertices = design.pattern.n_vertices
        named, wished = _wished(move, n_vertices)
        if steps < 1:
            raise InputError(f"{steps} steps were given: at least 1 is needed")
        goal = self._model.to_dimensionless(design.vertices_coords + wished)
        done = 0
        if len(named) and not np.isin(named, self._pinned).all():
            follow = _followers(design, named, reach)
            self._point, done = _dragged(design.pattern, self._projection, self._point, goal, named, follow, steps)
        left = np.zeros(n_vertices)
        reached = self._point.variables.reshape(-1, 3)
        left[named] = np.linalg.norm(reached - goal, axis=1)[named] * self._model.scale
        return Refined(self.design, left, self._point.violation, done)


def refine(
    design: Design,
    move: Mapping[int, Sequence[float] | FloatArray] | FloatArray | None = None,
    *,
    pins: Sequence[int] = (),
    bars: Sequence[tuple[int, int]] = (),
    reach: float | None = None,
    steps: int = 20,
) -> Refined:
    """Move vertices as far as the constraints admit, and to the nearest admissible place otherwise.

    Edges keep within 0.3 to 3 of their lengths, sector angles within 14 to 166 degrees, folds their signs and 20 to
    160 degrees (or what the given design has beyond these). Around every hole a strip stays closed through the whole
    motion.

    Args:
        design: the design to start from; small errors of its own are removed.
        move: wished displacements, in the design's unit: of some vertices by their numbers, each (3,), or of all,
            (V, 3). None only removes the residual.
        pins: vertices that stay where they are.
        bars: pairs of vertices that keep their distance.
        reach: how far, in the design's unit, others are wished to follow vertices that are moved by number; a
            quarter of the diagonal if None, 0 to leave them to the projection alone.
        steps: Euler steps that the way is cut into; they are halved where one is too long.

    Returns:
        The design that was reached; see ``remaining`` for what is left of the way.

    Raises:
        InputError: a vertex that is not there, a displacement that is not finite or of another shape, no steps; a
            strip around a hole that opens already.
    """
    return Drag(design, pins=pins, bars=bars).move(move, reach=reach, steps=steps)


def _dragged(
    pattern: Pattern,
    projection: Projection,
    at: Point,
    goal: FloatArray,
    named: IntArray,
    follow: FloatArray,
    steps: int,
) -> tuple[Point, int]:
    """The point after the whole way, cut into steps, and the number of steps made."""

    def left(point: Point) -> FloatArray:
        return np.asarray((goal - point.variables.reshape(-1, 3))[named])

    def step(share: float) -> Point | None:
        moved = projection.moved(at, (share * (follow @ left(at))).ravel())
        # Sector angles have no sign: in a leap a facet may turn over and satisfy them again.
        return moved if moved and geometry.are_convex(pattern, moved.variables.reshape(-1, 3)) else None

    way, length, done = 0.0, 1.0 / steps, 0
    while way < 1 and length >= SHORTEST / steps:
        share = min(length / (1 - way), 1.0)  # of what is left, so that later steps make up for earlier ones
        moved = step(share)
        if moved is None:
            length /= 2
        else:
            at, way, done = moved, 1.0 if share == 1.0 else way + length, done + 1
    # The wish was taken to the end, its projection perhaps not.
    for _ in range(steps):
        rest = np.linalg.norm(left(at))
        moved = step(1.0) if rest > 0 else None
        if moved is None or np.linalg.norm(left(moved)) > (1 - GAIN) * rest:
            break
        at, done = moved, done + 1
    return at, done


def _followers(design: Design, named: IntArray, reach: float | None) -> FloatArray:
    """Weights (V, K) of the K moved vertices' wishes in the wish of every vertex."""
    points = design.vertices_coords
    own = np.zeros((len(points), len(named)))
    own[named, np.arange(len(named))] = 1.0
    width = geometry.diagonal(points) / 4 if reach is None else reach
    if width <= 0 or len(named) == len(points):
        return own
    distances = np.linalg.norm(points[:, None] - points[named], axis=2)
    weights = np.exp(-((distances / width) ** 2))
    weights /= np.maximum(weights.sum(axis=1, keepdims=True), 1.0)  # between several they share
    weights[named] = own[named]
    return np.asarray(weights)


def _wished(
    move: Mapping[int, Sequence[float] | FloatArray] | FloatArray | None, n: int
) -> tuple[IntArray, FloatArray]:
    """Numbers (K,) of the vertices that are moved, and displacements (V, 3) of all."""
    if move is None:
        return np.empty(0, np.int64), np.zeros((n, 3))
    if isinstance(move, Mapping):
        named = _vertices(list(move), "a move", n)
        rows = [np.asarray(one, np.float64) for one in move.values()]
        displaced = np.zeros((n, 3))
        for vertex, row in zip(named.tolist(), rows, strict=True):
            if row.shape != (3,):
                raise InputError(f"the move of vertex {vertex} has shape {row.shape}: a displacement has 3 components")
            displaced[vertex] = row
    else:
        named, displaced = np.arange(n), np.asarray(move, np.float64)
        if displaced.shape != (n, 3):
            raise InputError(f"the moves have shape {displaced.shape}: for all {n} vertices ({n}, 3) is needed")
    if not np.isfinite(displaced).all():
        vertex = int(np.argmax(~np.isfinite(displaced).all(axis=1)))
        raise InputError(f"the move of vertex {vertex} is {displaced[vertex].tolist()}: finite numbers are needed")
    return named, displaced


def _vertices(numbers: list[int], what: str, n: int) -> IntArray:
    for vertex in numbers:
        if not 0 <= vertex < n:
            raise InputError(f"{what} names vertex {vertex}, which is not there: the design has vertices 0 to {n - 1}")
    return np.array(numbers, np.int64)


def _limits(design: Design) -> dict[str, Range]:
    """The limits of angles, widened to what the design itself has."""
    pattern, points = design.pattern, design.vertices_coords
    folds = np.abs(geometry.fold_angles(pattern, points))[pattern.interior_edges]
    own = {"sector_angle": geometry.sector_angles(pattern, points), "fold_angle": folds}
    limits = dict(LIMITS)
    for name, angles in own.items():
        if len(angles):
            low, high = limits[name]
            limits[name] = (min(low, float(angles.min())), max(high, float(angles.max())))
    return limits
