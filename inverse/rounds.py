"""Rounds of IPOPT; in between closest points are refreshed, polyline segments changed, crossing facets kept apart."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from inverse import constraints, objectives, verdict
from inverse.anchors import PolylineAnchor
from inverse.assembly import Problem
from inverse.crossing import crossing_facets
from inverse.formulate import Formulation
from inverse.ipopt import Attempt, Progress, Solver
from inverse.model import Constraint
from inverse.pattern import FloatArray, IntArray, Pattern
from inverse.refine import polish

MAX_ROUNDS = 40
SETTLED = 0.1  # rounds end when the gradient at the new closest points is this fraction of what is allowed
GAIN = 1e-2  # on a target with kinks they end when two rounds together lower the fit's rms by less than this
NEAR = 1e-2  # iterates with violations up to this are worth going on from, or keeping after a polish
CLEARANCE = 0.05  # of facets that crossed, in mean edge lengths

Iterate = tuple[float, float, FloatArray]  # violation, objective, variables


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
        tolerance: of IPOPT.
        max_iterations: of each round.
        deadline: on the monotonic clock, in seconds.
        watch: told every iteration.
        stop: set from outside to end at the next iteration.
        attempts: how each round ended, for the report.
    """

    formulation: Formulation
    tolerance: float
    max_iterations: int
    deadline: float
    watch: Callable[[str, Progress], None]
    stop: threading.Event = field(default_factory=threading.Event)
    attempts: list[dict[str, Any]] = field(default_factory=list)
    _feasible: Iterate = (np.inf, np.inf, np.empty(0))
    _near: Iterate = (np.inf, np.inf, np.empty(0))

    @property
    def stopped(self) -> bool:
        """Whether the user or the clock ended the rounds."""
        return self.stop.is_set() or time.monotonic() >= self.deadline

    def run(self) -> Solution:
        """Solve; where facets cross, keep them apart and solve again from the seed."""
        model = self.formulation.goal.model
        apart = np.empty((0, 2), np.int64)
        while True:
            separation = constraints.separation(model, apart, CLEARANCE) if len(apart) else None
            solution = self._fitted([separation] if separation else [])
            more = np.unique(np.vstack([apart, self._crossing(solution.variables)]), axis=0)
            if self.stopped or len(self.attempts) >= MAX_ROUNDS or len(more) == len(apart):
                return solution
            apart = more

    def _fitted(self, extra: list[Constraint]) -> Solution:
        """Rounds until the closest points and the segments of polylines have settled."""
        goal, model = self.formulation.goal, self.formulation.goal.model
        sliding, seen = self.formulation.sliding, set()
        x = model.seed_points.ravel()
        history: list[tuple[float, Solution]] = []
        multipliers, started = None, False
        problem, solver = self._problem(sliding, extra)
        while True:
            seen.add(_segments(sliding))
            points = model.to_lengths(x.reshape(-1, 3))
            # The problem comes with closest points for the seed.
            parameters = problem.parameters(objectives.refreshed(goal, points) if started else None)
            started = True
            attempt = self._attempt(solver, problem, x, parameters, multipliers)
            x, multipliers = attempt.variables, attempt.multipliers
            if self.stopped:
                x = self._kept(problem, parameters)
            points = model.to_lengths(x.reshape(-1, 3))
            rms = float(np.sqrt(np.mean(verdict.fit_distances(goal, points) ** 2)))
            self.attempts[-1]["fit_rms"] = rms
            history.append((rms, Solution(x, multipliers, problem, parameters)))
            fresh = problem.parameters(objectives.refreshed(goal, points))
            onward = [anchor.moved_on(points) for anchor in sliding]
            if self.stopped or len(self.attempts) >= MAX_ROUNDS or len(self._crossing(x)):
                return Solution(x, multipliers, problem, fresh)
            if _segments(onward) not in seen:
                sliding, multipliers, history = onward, None, []
                problem, solver = self._problem(sliding, extra)
                continue
            steepness = verdict.stationarity(problem, x, multipliers, fresh, model)
            if goal.is_exact or steepness < SETTLED * verdict.STATIONARITY:
                return Solution(x, multipliers, problem, fresh)
            if goal.target.has_kinks and len(history) > 3 and _no_gain([rms for rms, _ in history]):
                # Between the facets of a target mesh the closest points jump to and fro for ever. The best round
                # is the answer, stationary for the tangent planes that it was solved with.
                return min(history, key=lambda entry: entry[0])[1]

    def _attempt(
        self, solver: Solver, problem: Problem, x: FloatArray, parameters: FloatArray, multipliers: FloatArray | None
    ) -> Attempt:
        """One round: fast steps first; where they stall, exact ones from the point that they reached."""
        attempt = self._recorded(solver.run(x, parameters, multipliers, careful=False), "ipopt, static pivots")
        if attempt.succeeded or self.stopped or not solver.may_be_careful:
            return attempt
        worst = max(size for size, _ in problem.violations(attempt.variables, parameters).values())
        if worst <= NEAR:
            x, multipliers = attempt.variables, attempt.multipliers
        return self._recorded(solver.run(x, parameters, multipliers, careful=True), "ipopt")

    def _recorded(self, attempt: Attempt, method: str) -> Attempt:
        self.attempts.append(
            {
                "method": method,
                "ended": attempt.status,
                "iterations": attempt.iterations,
                "seconds": attempt.seconds,
            }
        )
        return attempt

    def _kept(self, problem: Problem, parameters: FloatArray) -> FloatArray:
        """The best design so far: an iterate that a polish makes feasible, else the best that was so itself."""
        polished = polish(problem, self._near[2], parameters)
        worst = max(size for size, _ in problem.violations(polished, parameters).values())
        return polished if worst <= verdict.BOUND else self._feasible[2]

    def _crossing(self, x: FloatArray) -> IntArray:
        """Pairs of facets that cross, and those like them."""
        pattern = self.formulation.goal.model.pattern
        return _alike(pattern, crossing_facets(x.reshape(-1, 3), pattern.faces_vertices))

    def _problem(self, sliding: list[PolylineAnchor], extra: list[Constraint]) -> tuple[Problem, Solver]:
        goal = self.formulation.goal
        terms = [*self.formulation.fixed, *(s.constraint(goal.model) for s in sliding), *extra]
        problem = Problem(goal.model.seed_points.size, self.formulation.objectives, terms)
        return problem, Solver(problem, self.tolerance, self.max_iterations, self._report)

    def _report(self, progress: Progress) -> bool:
        """Keep the best iterates; False stops IPOPT."""
        self._feasible = _better(self._feasible, progress, verdict.BOUND)
        self._near = _better(self._near, progress, NEAR)
        self.watch(f"round {len(self.attempts) + 1}", progress)
        return not self.stopped


def _better(best: Iterate, progress: Progress, tolerated: float) -> Iterate:
    """The better of two iterates: violations below what is tolerated do not count, then the objective does."""
    rank = (max(progress.violation, tolerated), progress.objective)
    return (*rank, progress.variables) if rank < best[:2] else best


def _no_gain(rms: list[float]) -> bool:
    return min(rms[-2:]) > (1 - GAIN) * min(rms[:-2])


def _segments(sliding: list[PolylineAnchor]) -> tuple[bytes, ...]:
    return tuple(anchor.segments.tobytes() for anchor in sliding)


def _alike(pattern: Pattern, pairs: IntArray) -> IntArray:
    """Pairs of facets and, on a grid, all pairs that lie alike along the strips that they belong to."""
    if pattern.grid is None or not len(pairs):
        return pairs
    m, n = pattern.grid
    (i0, j0), (i1, j1) = np.divmod(pairs[:, 0], n), np.divmod(pairs[:, 1], n)
    found = set()
    for a, b, c, d in np.stack([i0, j0, i1, j1], axis=1).tolist():
        if abs(c - a) <= abs(d - b):
            found |= {(i * n + b, (i + c - a) * n + d) for i in range(m) if 0 <= i + c - a < m}
        else:
            found |= {(a * n + j, c * n + j + d - b) for j in range(n) if 0 <= j + d - b < n}
    return np.array(sorted((min(p), max(p)) for p in found), np.int64)
