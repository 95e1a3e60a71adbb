"""The best of what a solve has come to so far, for whoever ends it early."""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace

import numpy as np

from inverse._types import FloatArray
from inverse.crossing import crossing_facets
from inverse.nlp.point import Point
from inverse.origami import geometry
from inverse.policy import verdict
from inverse.solvers.ipopt import NEAR
from inverse.solvers.projection import Projection, polish
from inverse.solvers.run import Progress
from inverse.terms.goal import Goal

# Of the iterates that violate no constraint by more than a level, the one with the lowest objective is remembered.
# Newton's method brings most of them within the constraints, of the last ones still many.
LEVELS = (verdict.BOUND, 1e-4, NEAR, 3e-2, 0.3, 1.0)
GAIN = 0.8  # of the objective: an iterate is worth the work if it promises less than this of what there is already
SECONDS = 5.0  # after which nothing further is tried
FIRST, SHORTEST = 0.5, 1 / 32  # steps of the way to an iterate, as shares of what is left of it
ARRIVED = 1e-2  # of the way

SEED = "the placed seed"
START = "the design that was started from"
COARSE = "the design of the coarser grid"


@dataclass(frozen=True, eq=False)
class Iterate:
    """A design on the way.

    Attributes:
        objective: weighted objective.
        violation: largest violation of a constraint row.
        variables: (n,).
        name: what it is, for messages.
    """

    objective: float
    violation: float
    variables: FloatArray
    name: str


@dataclass(frozen=True, eq=False)
class Kept:
    """What is kept of a solve that was ended early.

    Attributes:
        point: the design, with the problem and parameters that the verdict is to use.
        words: where it comes from, a sentence without full stop.
    """

    point: Point
    words: str


@dataclass(eq=False)
class BestSoFar:
    """The best iterates, and what can be made of them.

    Attributes:
        goal: what is fitted.
    """

    goal: Goal
    _levels: list[Iterate | None] = field(default_factory=lambda: [None] * len(LEVELS))
    _nearest: Iterate | None = None  # the least violated
    _beginning: Iterate | None = None  # the seed, or the start

    def begin(self, variables: FloatArray, objective: float, violation: float, name: str) -> None:
        """Take a design as the best so far; who stops early gets nothing worse."""
        iterate = Iterate(objective, violation, variables, name)
        if self._beginning is None:
            self._beginning = iterate
        self._tell(iterate)

    def tell(self, progress: Progress) -> None:
        """Remember an iterate if it is the best of its kind."""
        name = f"iteration {progress.iteration} of its run"
        self._tell(Iterate(progress.objective, progress.violation, progress.variables, name))

    @property
    def feasible(self) -> FloatArray | None:
        """The best iterate (n,) that met all constraints, or else the one that came nearest; None before the first."""
        found = self._levels[0] or self._beginning or self._nearest
        return None if found is None else found.variables

    def kept(self, point: Point) -> Kept:
        """The best design within the constraints that can be had at once.

        Args:
            point: with the problem, and the parameters that the verdict is to use.
        """
        end = time.monotonic() + SECONDS
        best = self._within(point, end)
        if best is not None:
            return best
        beginning = self._beginning or self._nearest
        if beginning is None:
            return Kept(point, "it is as it was, for there was no iteration yet")
        # A seed that does not hold its anchors yet: what it holds is to hold at least.
        problem, free = point.problem, point.moved(beginning.variables).excess > verdict.BOUND
        lower, upper = np.where(free, -np.inf, problem.lower), np.where(free, np.inf, problem.upper)
        found = self._within(replace(point, problem=problem.bounded(lower, upper), multipliers=None), end)
        if found is None:
            return Kept(point.moved(beginning.variables), _still(beginning))
        more = "" if found.words == _still(beginning) else ", but for those that the seed does not meet"
        return Kept(point.moved(found.point.variables), found.words + more)

    def _within(self, point: Point, end: float) -> Kept | None:
        """The best design within the constraints of a point's problem, found before a time, or None."""
        best: Kept | None = None
        promising: list[Iterate] = []
        for iterate in self._iterates:
            if best is not None and iterate.objective > GAIN * best.point.objective:
                continue
            if best is not None and time.monotonic() > end:
                break
            found = self._brought_within(point.moved(iterate.variables), iterate)
            if found is None:
                promising.append(iterate)
            elif best is None or found.point.objective < best.point.objective:
                best = found
        for iterate in promising:
            if best is not None and iterate.objective <= GAIN * best.point.objective and time.monotonic() < end:
                best = self._towards(best, iterate, end)
        return best

    def _brought_within(self, point: Point, iterate: Iterate) -> Kept | None:
        """An iterate moved within all constraints by Newton's method, if that leaves a mesh that is one."""
        is_within = point.violation <= verdict.BOUND
        moved = polish(point)
        if not is_within and moved.violation > verdict.BOUND:  # bounds, or too far to ignore them
            moved = Projection().moved(point, np.zeros_like(point.variables)) or moved
        moved = self._packed(moved)
        if not moved.violation <= verdict.BOUND or not self._is_mesh(moved):
            return None
        if iterate.name in (SEED, START):
            return Kept(moved, _still(iterate))
        if is_within:
            return Kept(moved, f"it is {iterate.name}, which met all constraints")
        far = self._distance(moved, point)
        return Kept(moved, f"it is {iterate.name}, moved by up to {far} by equation (9) to meet all constraints")

    def _towards(self, begun: Kept, iterate: Iterate, end: float) -> Kept:
        """As far as equation (9) leads from a design towards an iterate that itself cannot be brought within."""
        projection, at, step = Projection(), begun.point, FIRST
        way = float(np.linalg.norm(iterate.variables - at.variables))
        while step >= SHORTEST and time.monotonic() < end:
            left = iterate.variables - at.variables
            if np.linalg.norm(left) <= ARRIVED * way:
                break
            further = projection.moved(at, step * left)
            if further is None or not further.objective < at.objective:
                step /= 2
            else:
                at, step = further, min(2 * step, 1.0)
        at = self._packed(at)
        if at.objective >= begun.point.objective or not at.violation <= verdict.BOUND or not self._is_mesh(at):
            return begun
        far = self._distance(at, at.moved(iterate.variables))
        return Kept(at, f"it is on the way to {iterate.name}, as far as equation (9) led: up to {far} from it")

    def _is_mesh(self, point: Point) -> bool:
        """Whether no facet is turned over, and none cross."""
        model = self.goal.model
        points, pattern = model.points(point.variables), model.pattern
        return geometry.are_convex(pattern, points) and not len(crossing_facets(points, pattern.faces_vertices))

    def _distance(self, point: Point, other: Point) -> str:
        """How far vertices are apart at most, with the unit."""
        model = self.goal.model
        far = np.linalg.norm(model.points(point.variables) - model.points(other.variables), axis=1).max()
        return f"{far:.2g}" if model.seed.unit == "unit" else f"{far:.2g} {model.seed.unit}"

    @property
    def _iterates(self) -> list[Iterate]:
        """The best of each level, each once, the least violated first."""
        found: list[Iterate] = []
        for iterate in (self._beginning, *self._levels):
            if iterate is not None and all(iterate is not one for one in found):
                found.append(iterate)
        return found

    def _packed(self, point: Point) -> Point:
        """The same with boxes around the states that have moved."""
        goal = self.goal
        return point.moved(goal.start(goal.model.points(point.variables))) if goal.packed else point

    def _tell(self, iterate: Iterate) -> None:
        nearest = self._nearest
        if nearest is None or (iterate.violation, iterate.objective) < (nearest.violation, nearest.objective):
            self._nearest = iterate
        for k, level in enumerate(LEVELS):
            best = self._levels[k]
            if iterate.violation <= level and (best is None or iterate.objective < best.objective):
                self._levels[k] = iterate


def _still(beginning: Iterate) -> str:
    return f"it is still {beginning.name}, for no iteration had come to one that is better"
