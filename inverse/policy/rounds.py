"""Rounds of a solver; between them closest points are refreshed, segments changed, crossing facets kept apart."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.crossing import crossing_facets
from inverse.formulation.anchors import PolylineAnchor
from inverse.formulation.formulate import Formulation
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.nlp.term import Constraint
from inverse.origami import folding, geometry
from inverse.policy import verdict
from inverse.policy.attempts import Attempt, attempt_of
from inverse.policy.best import COARSE, SEED, START
from inverse.policy.control import Control
from inverse.policy.following import Following
from inverse.policy.runs import Runs
from inverse.policy.strips import alike
from inverse.solvers.ipopt import Ipopt
from inverse.solvers.newton import METHOD
from inverse.solvers.projection import brought_near
from inverse.solvers.run import Ending, Run
from inverse.solvers.slsqp import Slsqp
from inverse.spec import SolverKeys
from inverse.terms import separation
from inverse.terms.goal import Goal

MAX_ROUNDS = 40
SETTLED = 0.1  # rounds end when the gradient at the new closest points is this fraction of what is allowed
SPACING = np.pi / 64  # of the states of the motion that are looked at, like the certificate's


@dataclass
class Rounds:
    """The rounds of one solve.

    Attributes:
        formulation: what is solved.
        options: tolerance of the solver, iterations of each round.
        control: ends the rounds from outside.
        method: the solver, ipopt or nlopt.
        start: (n,) variables to start from instead of the seed, or None.
        multipliers: (R,) that belong to the start, where a solution is the start, or None.
        step: of the policy, for the report.
        start_name: what the start is, for messages.
        attempts: what was tried so far.
        kept: where the design comes from that is kept of rounds which were ended early, a sentence; else None.
        is_exact: whether they ended with Newton's method, which leaves nothing to polish.
        apart: pairs of facets that are kept apart, by the states in which they crossed.
        segments: (N,) int for every sliding anchor, where its vertices are on its polyline; none before they are known.
    """

    formulation: Formulation
    options: SolverKeys
    control: Control
    method: str
    start: FloatArray | None = None
    multipliers: FloatArray | None = None
    step: str = "start"
    start_name: str = START
    attempts: list[Attempt] = field(default_factory=list)
    kept: str | None = None
    is_exact: bool = False
    apart: dict[float, set[tuple[int, int]]] = field(default_factory=dict)
    segments: tuple[IntArray, ...] = ()

    @cached_property
    def runs(self) -> Runs:
        """The runs of the solver."""
        from_solution = self.multipliers is not None
        return Runs(self.formulation.goal, self.options, self.control, self.method, from_solution=from_solution)

    def run(self) -> Point:
        """Solve; where facets cross, keep them apart and solve again from the seed.

        Returns:
            Where the rounds ended, with the last problem and the parameters that the verdict is to use.
        """
        model = self.formulation.goal.model
        start = self.start
        while True:
            extra: list[Constraint] = []
            for t, pairs in self.apart.items():
                if t == np.pi / 2:
                    one = separation.in_design(model, np.array(sorted(pairs)))
                    extra += [] if one is None else [one]
                else:
                    extra += separation.in_state(model, np.array(sorted(pairs)), t)
            point = self._fitted(start, extra)
            start = None
            crossing = self._crossing(point.variables)
            more = {t: pairs | self.apart.get(t, set()) for t, pairs in crossing.items()}
            if self.control.stopped or self.runs.round >= MAX_ROUNDS or {**self.apart, **more} == self.apart:
                return point
            self.apart |= more

    def unsolved(self) -> Point:
        """The start as a point that no solver has touched."""
        return self._untouched(self.formulation.goal.seed_variables if self.start is None else self.start)

    def abandoned(self) -> Point:
        """The best iterate as a point, where the rounds broke off in the middle; the start if there is none."""
        best = self.runs.best.feasible
        return self.unsolved() if best is None else self._untouched(best)

    def _untouched(self, x: FloatArray) -> Point:
        goal = self.formulation.goal
        problem, _ = self._problem(self.formulation.sliding, [])
        return _refreshed(goal, Point(problem, x, problem.parameters()), goal.model.points(x))

    def _fitted(self, start: FloatArray | None, extra: list[Constraint]) -> Point:
        """Rounds from a start, or the seed, until the closest points and the segments of polylines have settled."""
        goal = self.formulation.goal
        sliding, seen = self._sliding(), set()
        problem, solver = self._problem(sliding, extra)
        at = self._beginning(problem, start)
        if not _has_values(at):
            return at
        if self.control.stopped:  # before there was anything to do
            self.attempts.append(Attempt(self.step, self.method, Ending.GIVEN_UP))
            return self._best(at)
        is_spread = start is not None and self.start_name == COARSE
        is_seed, following = start is None, Following(goal, goal.model.points(at.variables))
        while True:
            seen.add(_segments(sliding))
            self.segments = tuple(anchor.segments for anchor in sliding)
            # The problem comes with closest points for the seed.
            at = at if is_seed else _refreshed(goal, at, following.aim)
            run, rms = self._one_round(solver, at, is_seed=is_seed, is_spread=is_spread)
            is_seed, is_spread, at = False, False, run.end
            points = goal.model.points(at.variables)
            if rms is not None:
                following.seen(at, rms)
            fresh = _refreshed(goal, at, points)
            onward = [anchor.moved_on(points) for anchor in sliding]
            if (
                self.runs.ends(run)
                or self.runs.round >= MAX_ROUNDS
                or len(crossing_facets(points, goal.model.pattern.faces_vertices))
            ):
                return fresh
            if _segments(onward) not in seen:
                sliding, following = onward, Following(goal, points)
                problem, solver = self._problem(sliding, extra)
                at = Point(problem, at.variables, problem.parameters())
            elif goal.fitting.is_exact or verdict.stationarity(fresh, goal) < SETTLED * verdict.STATIONARITY:
                return fresh
            elif following.is_to_and_fro:
                return following.best
            else:
                following.go_on(points)

    def _sliding(self) -> list[PolylineAnchor]:
        """The anchors on polylines with their vertices on the segments that are known, else on the seed's."""
        anchors = self.formulation.sliding
        if [len(anchor.segments) for anchor in anchors] != [len(segments) for segments in self.segments]:
            return anchors
        known = zip(anchors, self.segments, strict=True)
        return [replace(anchor, segments=np.minimum(own, len(anchor.polyline) - 2)) for anchor, own in known]

    def _beginning(self, problem: Problem, start: FloatArray | None) -> Point:
        """Where the rounds begin; who stops early gets the better of a start and the seed."""
        seed = Point(problem, self.formulation.goal.seed_variables, problem.parameters())
        best = self.runs.best
        if start is None:
            if _has_values(seed):
                best.begin(seed.variables, seed.objective, seed.violation, SEED)
            return seed
        multipliers = self.multipliers
        if multipliers is not None and multipliers.size != problem.n_rows:
            multipliers = None  # of a task with other constraints
        at = seed.moved(start).pushed(multipliers)
        if self.start_name == COARSE:
            at = self._near(at)
        if _has_values(at):
            best.begin(seed.variables, seed.objective, seed.violation, SEED)
            best.begin(at.variables, at.objective, at.violation, self.start_name)
        return at

    def _near(self, spread: Point) -> Point:
        """A coarser grid's design moved to where the equations nearly hold, if its facets stay what they are."""
        near, model = brought_near(spread), self.formulation.goal.model
        return near if geometry.are_convex(model.pattern, model.points(near.variables)) else spread

    def _one_round(
        self, solver: Ipopt | Slsqp, at: Point, *, is_seed: bool, is_spread: bool
    ) -> tuple[Run, float | None]:
        """The last run of a round, and the fit it came to on a target with kinks; all runs are told."""
        self.runs.round += 1
        self.runs.may_contradict = all(len(anchor.polyline) == 2 for anchor in self.formulation.sliding)
        runs = self.runs.one_round(solver, at, is_seed=is_seed, is_spread=is_spread)
        self.is_exact = runs[-1].method == METHOD and runs[-1].ending is Ending.SOLVED
        facets = len(self.formulation.goal.model.pattern.faces_vertices)
        told = [attempt_of(run, self.step, self.method, facets, self.runs.round) for run in runs]
        end = self._best(runs[-1].end) if self.control.stopped else runs[-1].end
        rms = self._rms(end)
        self.attempts += [*told[:-1], replace(told[-1], fit_rms=rms)]
        return replace(runs[-1], end=end), rms

    def _rms(self, point: Point) -> float | None:
        """The fit, in length units, where it tells whether rounds lead on: on a target with kinks; else None."""
        goal = self.formulation.goal
        if not goal.target.has_kinks:
            return None
        return float(np.sqrt(np.mean(goal.fitting.distances(goal.model.points(point.variables)) ** 2)))

    def _best(self, point: Point) -> Point:
        """The best design so far, for rounds that are ended early."""
        kept = self.runs.best.kept(point)
        self.kept = kept.words
        return kept.point

    def _crossing(self, x: FloatArray) -> dict[float, set[tuple[int, int]]]:
        """Pairs of facets that cross in the design state, and those like them; then those in demanded states.

        Of the states those matter where something crosses first, and the last demanded ones.
        """
        model = self.formulation.goal.model
        faces, points = model.pattern.faces_vertices, model.points(x)
        pairs = alike(model.pattern, crossing_facets(points, faces))
        if len(pairs) or self.formulation.free_range is None:
            return {np.pi / 2: set(map(tuple, pairs.tolist()))} if len(pairs) else {}
        found: dict[float, set[tuple[int, int]]] = {}
        for end in self.formulation.free_range:
            count = int(np.ceil(abs(end - np.pi / 2) / SPACING))
            states = np.pi / 2 + np.arange(1, count + 1) / count * (end - np.pi / 2)
            crossed = [
                (t, set(map(tuple, pairs.tolist())))
                for t, points in zip(states.tolist(), folding.fold(model.whole(x), states).vertices_coords, strict=True)
                if len(pairs := crossing_facets(points, faces))
            ]
            found |= dict(crossed[:1] + crossed[-1:])
        return found

    def _problem(self, sliding: list[PolylineAnchor], extra: list[Constraint]) -> tuple[Problem, Ipopt | Slsqp]:
        goal = self.formulation.goal
        terms = [*self.formulation.fixed, *(s.constraint(goal.model) for s in sliding), *extra]
        problem = Problem(goal.n_variables, self.formulation.objectives, terms)
        return problem, self.runs.solver(problem)


def _refreshed(goal: Goal, point: Point, points: FloatArray) -> Point:
    """A point with the target's closest points to vertices (V, 3)."""
    if goal.fitting.is_exact:
        return point
    return point.given(point.problem.parameters(goal.fitting.refreshed(points)))


def _has_values(start: Point) -> bool:
    """Whether a start can be solved from; near a solution, where it has multipliers, derivatives have values too."""
    if start.multipliers is not None and np.isfinite([start.objective, start.violation]).all():
        return True
    return start.not_a_number is None


def _segments(sliding: list[PolylineAnchor]) -> tuple[bytes, ...]:
    return tuple(anchor.segments.tobytes() for anchor in sliding)
