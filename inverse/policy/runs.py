"""Runs of a solver within one round: which methods, in which order."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import geometry
from inverse.policy import verdict
from inverse.policy.best import BestSoFar
from inverse.policy.control import Control
from inverse.solvers.feasibility import least_violation
from inverse.solvers.ipopt import APPROACHING, EASED, NEAR, STATIC, Ipopt
from inverse.solvers.newton import METHOD, newton
from inverse.solvers.projection import polish
from inverse.solvers.relaxation import LightIpopt, relaxed
from inverse.solvers.run import Ending, Progress, Run
from inverse.solvers.slsqp import Slsqp
from inverse.spec import SolverKeys
from inverse.terms.goal import Goal

# Where a run does not even come near the constraints, the least violation of all of them is looked for, from the seed
# and from these multiples of it. Where all end at more than this sum of squares, the constraints contradict each other.
# Of 160 tasks with a solution, many of them tight, three ended so at 0.06 or less.
SIZES = (1.0, 0.7, 1.2)
CLEAR = 0.2

TOO_FAR = 1.0  # a run without bounds is given up when it leaves them by more than this


@dataclass
class Runs:
    """All runs of one solve.

    Attributes:
        goal: what is fitted.
        options: tolerance of the solver, iterations of each round.
        control: ends the runs from outside.
        method: the solver, ipopt or nlopt.
        seconds_building: spent on the functions of problems.
        round: number of the round, for whoever watches.
        best: the best iterates so far.
        may_contradict: whether all that is asked stands in the problem; not where vertices may go on to other segments.
        least: the design with the least violation of all constraints, where these contradict each other.
        from_solution: whether it all began at the solution of a task like this one.
    """

    goal: Goal
    options: SolverKeys
    control: Control
    method: str
    seconds_building: float = 0.0
    round: int = 0
    best: BestSoFar = field(init=False)
    may_contradict: bool = False
    least: Point | None = None
    from_solution: bool = False

    def __post_init__(self) -> None:
        self.best = BestSoFar(self.goal)

    def solver(self, problem: Problem) -> Ipopt | Slsqp:
        """The solver of a problem."""
        if self.method == "ipopt":
            return self._ipopt(problem, self._report)
        steepness = verdict.gradient_scale(problem, self.goal)
        return Slsqp(problem, self.options.tolerance, steepness, self._report)

    def one_round(self, solver: Ipopt | Slsqp, start: Point, *, is_seed: bool, is_spread: bool = False) -> list[Run]:
        """One round: come near, then fast steps; where they stall, exact ones from the point that they reached.

        A start that is the answer already stays as it is: solvers would leave it to come back. From a good start bounds
        that are far from active are left out. What goes wrong without them, or leaves them, is done again with all.

        Args:
            solver: of the start's problem.
            start: where, with the multipliers of the round before, if any.
            is_seed: whether the start is the seed.
            is_spread: whether it is a coarser grid's design.

        Returns:
            All runs; where the last one ended the round ends.
        """
        if self._is_settled(start):
            return [Run(start.pushed(None), Ending.SOLVED, 0, 0.0, 0.0, "the start is stationary")]
        limit = self.options.max_iterations
        if isinstance(solver, Slsqp):
            return [solver.run(start, limit)]
        if self.from_solution and start.multipliers is not None:
            found = newton(start, self.goal.model.refinement, self.options.tolerance, limit, self._report_convex)
            if found is not None or self.control.stopped:
                return [found or Run(start, Ending.GIVEN_UP, 0, 0.0, 0.0, METHOD)]
        runs: list[Run] = []
        at, methods = start, _methods(start, is_spread)
        light = None if is_seed or not methods else self._light(start)
        for method in methods:
            near = None
            for one in (light, solver) if light else (solver,):
                left = limit - sum(run.iterations for run in runs)
                if method == APPROACHING:
                    run = one.approach(at, left, is_good=not is_seed, is_spread=is_spread)
                elif method == EASED:
                    run = one.ease(at, left)
                else:
                    run = one.run(at, left, careful=False)
                runs.append(run)
                if self._is_over(run) or left <= run.iterations:
                    return runs
                if run.ending is not Ending.GIVEN_UP and run.end.violation <= NEAR:
                    near, at = one, run.end
                    if method == APPROACHING and start.problem.has_redundant_equations:
                        # Which equations follow from others shows where all of them hold.
                        at = polish(at).pushed(None)
                    break
            if method == APPROACHING and near is None and self._contradicts(start):
                return [*runs, Run(start, Ending.INFEASIBLE, 0, 0.0, 0.0, "least violation")]
            if method == APPROACHING and near is not light:
                light = self._light(at) if near else None
        left = limit - sum(run.iterations for run in runs)
        return [*runs, solver.run(at, left, careful=True)]

    def ends(self, run: Run) -> bool:
        """Whether there is nothing more to do: stopped, or a fault of the task, which no solver mends."""
        return self.control.stopped or run.ending is Ending.INVALID_NUMBER or self.least is not None

    def _contradicts(self, start: Point) -> bool:
        """Whether the least violation of all constraints is clearly more than none, wherever it is looked for."""
        if not self.may_contradict or start.problem.has_passive_variables or start.violation <= verdict.BOUND:
            return False
        seed, found = start.moved(self.goal.seed_variables), []
        for size in SIZES:
            found.append(least_violation(seed.moved(size * seed.variables), lambda: not self.control.stopped))
            if not found[-1].settled or found[-1].squared < CLEAR:
                return False
        self.least = min(found, key=lambda one: one.squared).point
        return True

    def _is_settled(self, start: Point) -> bool:
        """Whether nothing pulls a start anywhere and all constraints hold; then it is told as an iterate."""
        idle = start.pushed(None)
        if not (idle.violation <= verdict.EQUATION and verdict.stationarity(idle, self.goal) <= self.options.tolerance):
            return False
        self._report(Progress(0, idle.objective, idle.violation, idle.variables))
        return True

    def _is_over(self, run: Run) -> bool:
        solved = run.ending is Ending.SOLVED and run.end.violation <= verdict.BOUND
        return solved or self.ends(run)

    def _light(self, at: Point) -> LightIpopt | None:
        """A solver without the bounds that are far from active, if there are enough of them."""
        relaxation = relaxed(at)
        if relaxation is None:
            return None

        def report(progress: Progress) -> bool:
            return self._report_convex(replace(progress, violation=at.moved(progress.variables).violation))

        return LightIpopt(relaxation, self._ipopt(relaxation.problem, report))

    def _report_convex(self, progress: Progress) -> bool:
        """The same for who keeps to some bounds only: stops where all of them are left, or a facet turns over.

        Sector angles have no sign: without its bounds a facet may turn over and satisfy them again.
        """
        model = self.goal.model
        if not geometry.are_convex(model.pattern, model.points(progress.variables)):
            return False
        return self._report(progress) and progress.violation <= TOO_FAR

    def _ipopt(self, problem: Problem, report: Callable[[Progress], bool]) -> Ipopt:
        began = time.perf_counter()
        problem.functions  # noqa: B018  built here, to be told apart from solving
        self.seconds_building += time.perf_counter() - began
        return Ipopt(problem, self.options.tolerance, self.goal.model.refinement, report)

    def _report(self, progress: Progress) -> bool:
        """Keep the best iterates; False stops the solver."""
        self.best.tell(progress)
        facets = len(self.goal.model.pattern.faces_vertices)
        return self.control.tell(f"{facets} facets, round {self.round}", progress)


def _methods(start: Point, is_spread: bool) -> tuple[str, ...]:
    """What is tried before exact steps."""
    if start.problem.has_passive_variables:
        # Static pivots come near there, but not to the end; linearized, packed states fly about.
        return (STATIC,) if start.multipliers is None else ()
    if start.multipliers is not None:
        return (STATIC,)
    return (APPROACHING, EASED, STATIC) if is_spread else (APPROACHING, STATIC)
