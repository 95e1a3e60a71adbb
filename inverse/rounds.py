"""Rounds of a solver; between them closest points are refreshed, segments changed, crossing facets kept apart."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from inverse import constraints, geometry, nlopt_solver, objectives, verdict
from inverse.anchors import PolylineAnchor
from inverse.assembly import Problem
from inverse.attempt import GIVEN_UP, INVALID_NUMBER, Attempt, Progress
from inverse.control import Control
from inverse.crossing import crossing_facets
from inverse.formulate import Formulation
from inverse.ipopt import NEAR, Solver
from inverse.model import Constraint
from inverse.pattern import FloatArray, IntArray
from inverse.projection import polish
from inverse.relaxation import LightSolver, relaxed
from inverse.spec import Solver as SolverKeys
from inverse.strips import alike

MAX_ROUNDS = 40
SETTLED = 0.1  # rounds end when the gradient at the new closest points is this fraction of what is allowed
GAIN = 1e-2  # on a target with kinks they end when two rounds together lower the fit's rms by less than this
FAR = 1.0  # a run without bounds is given up when it leaves them by more than this
APPROACHING, STATIC, PIVOTED = "linearized constraints", "static pivots", "pivoting"  # methods, for the report
REDUCED = "SLSQP where all equations hold"
CLEARANCE = 0.05  # of facets that crossed, in mean edge lengths

Step = tuple[FloatArray, FloatArray]  # points of a design, and how far they are from where closest points were taken
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
        options: tolerance of the solver, iterations of each round.
        control: ends the rounds from outside.
        method: the solver, ipopt or nlopt.
        start: (n,) variables to start from instead of the seed, or None.
        multipliers: (R,) that belong to the start, where a solution is the start, or None.
        attempts: how each run of the solver ended, for the report.
        seconds_building: spent on the functions of problems.
    """

    formulation: Formulation
    options: SolverKeys
    control: Control
    method: str
    start: FloatArray | None = None
    multipliers: FloatArray | None = None
    attempts: list[dict[str, Any]] = field(default_factory=list)
    seconds_building: float = 0.0
    _round: int = 0
    _feasible: Iterate = (np.inf, np.inf, np.empty(0))
    _near: Iterate = (np.inf, np.inf, np.empty(0))

    def run(self) -> Solution:
        """Solve; where facets cross, keep them apart and solve again from the seed."""
        model = self.formulation.goal.model
        start = self.start
        apart = np.empty((0, 2), np.int64)
        while True:
            separation = constraints.separation(model, apart, CLEARANCE) if len(apart) else None
            solution = self._fitted(start, [separation] if separation else [])
            start = None
            more = np.unique(np.vstack([apart, self._crossing(solution.variables)]), axis=0)
            if self.control.stopped or self._round >= MAX_ROUNDS or len(more) == len(apart):
                return solution
            apart = more

    def unsolved(self) -> Solution:
        """The start as a solution that no solver has touched."""
        goal = self.formulation.goal
        x = goal.seed_variables if self.start is None else self.start
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
            self._feasible = (verdict.BOUND, value, goal.seed_variables)
        while True:
            seen.add(_segments(sliding))
            # The problem comes with closest points for the seed.
            parameters = problem.parameters(None if is_seed else objectives.refreshed(goal, aim))
            self._round += 1
            attempt = self._attempt(solver, problem, x, parameters, multipliers, is_seed=is_seed)
            is_seed = False
            x, multipliers = attempt.variables, attempt.multipliers
            if self.control.stopped:
                x = self._kept(problem, parameters)
            points = model.points(x)
            rms = float(np.sqrt(np.mean(verdict.fit_distances(goal, points) ** 2)))
            self.attempts[-1]["fit_rms"] = rms
            history.append((rms, Solution(x, multipliers, problem, parameters)))
            fresh = problem.parameters(objectives.refreshed(goal, points))
            onward = [anchor.moved_on(points) for anchor in sliding]
            if self._ends(attempt) or self._round >= MAX_ROUNDS or len(self._crossing(x)):
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

    def _attempt(
        self,
        solver: Solver | nlopt_solver.Solver,
        problem: Problem,
        x: FloatArray,
        parameters: FloatArray,
        multipliers: FloatArray | None,
        *,
        is_seed: bool,
    ) -> Attempt:
        """One round: come near, then fast steps; where they stall, exact ones from the point that they reached.

        From a good start bounds that are far from active are left out. What goes wrong without them, or leaves
        them, is done again with all.
        """
        left = self.options.max_iterations
        if isinstance(solver, nlopt_solver.Solver):
            return self._recorded(solver.run(x, parameters, multipliers, left), REDUCED, False)
        methods: tuple[str, ...] = (APPROACHING, STATIC) if multipliers is None else (STATIC,)
        if problem.has_passive_variables:
            # Static pivots come near there, but not to the end; linearized, packed states fly about.
            methods = (STATIC,) if multipliers is None else ()
        light = None if is_seed or not methods else self._light(problem, x, parameters)
        for method in methods:
            near = None
            for one in (light, solver) if light else (solver,):
                if method == APPROACHING:
                    attempt = one.approach(x, parameters, left, is_good=not is_seed)
                else:
                    attempt = one.run(x, parameters, multipliers, left, careful=False)
                self._recorded(attempt, method, one is light)
                left -= attempt.iterations
                if self._is_over(problem, attempt, parameters, left):
                    return attempt
                if attempt.status != GIVEN_UP and problem.violation(attempt.variables, parameters) <= NEAR:
                    near, x, multipliers = one, attempt.variables, attempt.multipliers
                    break
            if method == APPROACHING and near is not light:
                light = self._light(problem, x, parameters) if near else None
        attempt = solver.run(x, parameters, multipliers, left, careful=True)
        return self._recorded(attempt, PIVOTED, False)

    def _is_over(self, problem: Problem, attempt: Attempt, parameters: FloatArray, left: int) -> bool:
        solved = attempt.succeeded and problem.violation(attempt.variables, parameters) <= verdict.BOUND
        return solved or self._ends(attempt) or left <= 0

    def _ends(self, attempt: Attempt) -> bool:
        """Whether there is nothing more to do: stopped, or a term without a value, which no solver mends."""
        return self.control.stopped or attempt.status == INVALID_NUMBER

    def _light(self, problem: Problem, x: FloatArray, parameters: FloatArray) -> LightSolver | None:
        """A solver without the bounds that are far from active, if there are enough of them."""
        relaxation = relaxed(problem, x, parameters)
        if relaxation is None:
            return None

        model = self.formulation.goal.model

        def report(progress: Progress) -> bool:
            # Sector angles have no sign: without its bounds a facet may turn over and satisfy them again.
            if not geometry.are_convex(model.pattern, model.points(progress.variables)):
                return False
            whole = problem.violation(progress.variables, parameters)
            return self._report(replace(progress, violation=whole)) and whole <= FAR

        return LightSolver(relaxation, problem.n_rows, self._solver(relaxation.problem, report))

    def _recorded(self, attempt: Attempt, method: str, is_light: bool) -> Attempt:
        self.attempts.append(
            {
                "facets": self._facets,
                "round": self._round,
                "method": f"{self.method}, {method}" + (", without idle bounds" if is_light else ""),
                "ended": attempt.status,
                "iterations": attempt.iterations,
                "seconds": attempt.seconds,
                "seconds_functions": attempt.seconds_functions,
            }
        )
        return attempt

    def _kept(self, problem: Problem, parameters: FloatArray) -> FloatArray:
        """The best design so far: an iterate that a polish makes feasible, else the best that was so itself."""
        polished = polish(problem, self._near[2], parameters)
        goal = self.formulation.goal
        if goal.packed:
            polished = goal.start(goal.model.points(polished))  # boxes around the states that have moved
        return polished if problem.violation(polished, parameters) <= verdict.BOUND else self._feasible[2]

    @property
    def _facets(self) -> int:
        return len(self.formulation.goal.model.pattern.faces_vertices)

    def _crossing(self, x: FloatArray) -> IntArray:
        """Pairs of facets that cross, and those like them."""
        model = self.formulation.goal.model
        faces = model.pattern.faces_vertices
        return alike(model.pattern, crossing_facets(model.points(x), faces))

    def _problem(
        self, sliding: list[PolylineAnchor], extra: list[Constraint]
    ) -> tuple[Problem, Solver | nlopt_solver.Solver]:
        goal = self.formulation.goal
        terms = [*self.formulation.fixed, *(s.constraint(goal.model) for s in sliding), *extra]
        problem = Problem(goal.n_variables, self.formulation.objectives, terms)
        if self.method == "ipopt":
            return problem, self._solver(problem, self._report)
        _, gradient = problem.objective_and_gradient(goal.seed_variables, problem.parameters())
        steepness = float(np.abs(gradient).max())
        return problem, nlopt_solver.Solver(problem, self.options.tolerance, steepness, self._report)

    def _solver(self, problem: Problem, report: Callable[[Progress], bool]) -> Solver:
        began = time.perf_counter()
        problem.functions  # noqa: B018  built here, to be told apart from solving
        self.seconds_building += time.perf_counter() - began
        return Solver(problem, self.options.tolerance, self.formulation.goal.model.refinement, report)

    def _report(self, progress: Progress) -> bool:
        """Keep the best iterates; False stops the solver."""
        self._feasible = _better(self._feasible, progress, verdict.BOUND)
        self._near = _better(self._near, progress, NEAR)
        return self.control.tell(f"{self._facets} facets, round {self._round}", progress)


def _better(best: Iterate, progress: Progress, tolerated: float) -> Iterate:
    """The better of two iterates: violations below what is tolerated do not count, then the objective does."""
    rank = (max(progress.violation, tolerated), progress.objective)
    return (*rank, progress.variables) if rank < best[:2] else best


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
