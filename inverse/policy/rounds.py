"""Rounds of a solver; between them closest points are refreshed, segments changed, crossing facets kept apart."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from inverse import objectives
from inverse._types import FloatArray
from inverse.crossing import crossing_facets
from inverse.formulation.anchors import PolylineAnchor
from inverse.formulation.formulate import Formulation
from inverse.nlp.problem import Problem
from inverse.nlp.term import Constraint
from inverse.origami import folding
from inverse.policy import verdict
from inverse.policy.control import Control
from inverse.policy.runs import Runs
from inverse.policy.strips import alike
from inverse.solvers import slsqp
from inverse.solvers.ipopt import Solver
from inverse.spec import Solver as SolverKeys
from inverse.terms import separation

MAX_ROUNDS = 40
SETTLED = 0.1  # rounds end when the gradient at the new closest points is this fraction of what is allowed
GAIN = 1e-2  # on a target with kinks they end when two rounds together lower the fit's rms by less than this
SPACING = np.pi / 64  # of the states of the motion that are looked at, like the certificate's

Step = tuple[FloatArray, FloatArray]  # points of a design, and how far they are from where closest points were taken


@dataclass(frozen=True, eq=False)
class Solution:
    """Where the rounds ended.

    Attributes:
        variables: (n,) the design.
        multipliers: (R,) of the problem's rows.
        problem: the last problem.
        parameters: the parameters that the verdict is to use.
    """

    variables: FloatArray
    multipliers: FloatArray
    problem: Problem
    parameters: FloatArray


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
    """

    formulation: Formulation
    options: SolverKeys
    control: Control
    method: str
    start: FloatArray | None = None
    multipliers: FloatArray | None = None

    @cached_property
    def runs(self) -> Runs:
        """The runs of the solver, and what they did."""
        return Runs(self.formulation.goal, self.options, self.control, self.method)

    def run(self) -> Solution:
        """Solve; where facets cross, keep them apart and solve again from the seed."""
        model = self.formulation.goal.model
        start = self.start
        apart: dict[float, set[tuple[int, int]]] = {}  # by states
        while True:
            extra: list[Constraint] = []
            for t, pairs in apart.items():
                if t == np.pi / 2:
                    one = separation.in_design(model, np.array(sorted(pairs)))
                    extra += [] if one is None else [one]
                else:
                    extra += separation.in_state(model, np.array(sorted(pairs)), t)
            solution = self._fitted(start, extra)
            start = None
            crossing = self._crossing(solution.variables)
            more = {t: pairs | apart.get(t, set()) for t, pairs in crossing.items()}
            if self.control.stopped or self.runs.round >= MAX_ROUNDS or {**apart, **more} == apart:
                return solution
            apart |= more

    def unsolved(self) -> Solution:
        """The start as a solution that no solver has touched."""
        return self._untouched(self.formulation.goal.seed_variables if self.start is None else self.start)

    def abandoned(self) -> Solution:
        """The best iterate as a solution, where the rounds broke off in the middle; the start if there is none."""
        best = self.runs.best
        return self.unsolved() if best is None else self._untouched(best)

    def _untouched(self, x: FloatArray) -> Solution:
        goal = self.formulation.goal
        problem, _ = self._problem(self.formulation.sliding, [])
        parameters = problem.parameters(objectives.refreshed(goal, goal.model.points(x)))
        return Solution(x, np.zeros(problem.n_rows), problem, parameters)

    def _fitted(self, start: FloatArray | None, extra: list[Constraint]) -> Solution:
        """Rounds from a start, or the seed, until the closest points and the segments of polylines have settled."""
        goal, model = self.formulation.goal, self.formulation.goal.model
        x = goal.seed_variables if start is None else start
        sliding, seen = self.formulation.sliding, set()
        history: list[tuple[float, Solution]] = []
        multipliers, is_seed = None if start is None else self.multipliers, start is None
        aim, before = model.points(x), None
        problem, solver = self._problem(sliding, extra)
        if multipliers is not None and multipliers.size != problem.n_rows:
            multipliers = None  # of a task with other constraints
        if problem.not_a_number(x, problem.parameters()) is not None:
            return Solution(x, np.zeros(problem.n_rows), problem, problem.parameters())
        if start is not None:
            # A start may be less feasible than the seed; who stops early gets the better of both.
            value, _ = problem.objective_and_gradient(goal.seed_variables, problem.parameters())
            self.runs.begin(goal.seed_variables, value)
        while True:
            seen.add(_segments(sliding))
            # The problem comes with closest points for the seed.
            parameters = problem.parameters(None if is_seed else objectives.refreshed(goal, aim))
            self.runs.round += 1
            attempt = self.runs.attempt(solver, problem, x, parameters, multipliers, is_seed=is_seed)
            is_seed = False
            x, multipliers = attempt.variables, attempt.multipliers
            if self.control.stopped:
                x = self.runs.kept(problem, parameters)
            points = model.points(x)
            rms = float(np.sqrt(np.mean(verdict.fit_distances(goal, points) ** 2)))
            self.runs.attempts[-1]["fit_rms"] = rms
            history.append((rms, Solution(x, multipliers, problem, parameters)))
            fresh = problem.parameters(objectives.refreshed(goal, points))
            onward = [anchor.moved_on(points) for anchor in sliding]
            if (
                self.runs.ends(attempt)
                or self.runs.round >= MAX_ROUNDS
                or len(crossing_facets(points, model.pattern.faces_vertices))
            ):
                return Solution(x, multipliers, problem, fresh)
            if _segments(onward) not in seen:
                sliding, multipliers, history, aim, before = onward, None, [], points, None
                problem, solver = self._problem(sliding, extra)
                continue
            steepness = verdict.stationarity(problem, x, multipliers, fresh, goal)
            if goal.is_exact or steepness < SETTLED * verdict.STATIONARITY:
                return Solution(x, multipliers, problem, fresh)
            if goal.target.has_kinks and len(history) > 3 and _no_gain([rms for rms, _ in history]):
                # Between the facets of a target mesh the closest points jump to and fro for ever. The best round
                # is the answer, stationary for the tangent planes that it was solved with.
                return min(history, key=lambda entry: entry[0])[1]
            step = points, points - aim
            aim = points if goal.target.has_kinks else _ahead(step, before)
            before = step

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
                for t, points in zip(
                    states.tolist(), folding.fold(model.design(x), states).vertices_coords, strict=True
                )
                if len(pairs := crossing_facets(points, faces))
            ]
            found |= dict(crossed[:1] + crossed[-1:])
        return found

    def _problem(self, sliding: list[PolylineAnchor], extra: list[Constraint]) -> tuple[Problem, Solver | slsqp.Solver]:
        goal = self.formulation.goal
        terms = [*self.formulation.fixed, *(s.constraint(goal.model) for s in sliding), *extra]
        problem = Problem(goal.n_variables, self.formulation.objectives, terms)
        return problem, self.runs.solver(problem)


def _ahead(step: Step, before: Step | None) -> FloatArray:
    """Where closest points are taken next, from the designs of two rounds and how far each went from its aim.

    Tangent planes know nothing of the target's curvature, so that rounds go past the solution and back again, or
    come nearer slowly. The line through two rounds shows where they lead (Anderson's method of depth one).
    """
    points, change = step
    if before is None:
        return points
    earlier, change_before = before
    turn = change - change_before
    share = float(np.sum(change * turn) / max(np.sum(turn * turn), np.finfo(float).tiny))
    share = min(max(share, -2.0), 0.5)  # no leaps while rounds still differ much
    return np.asarray((1 - share) * points + share * earlier)


def _no_gain(rms: list[float]) -> bool:
    return min(rms[-2:]) > (1 - GAIN) * min(rms[:-2])


def _segments(sliding: list[PolylineAnchor]) -> tuple[bytes, ...]:
    return tuple(anchor.segments.tobytes() for anchor in sliding)
