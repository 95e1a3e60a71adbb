"""Runs of a solver within one round: which methods, in which order, and what each of them did."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from inverse._types import FloatArray
from inverse.nlp.problem import Problem
from inverse.objectives import Goal
from inverse.origami import geometry
from inverse.policy import verdict
from inverse.policy.control import Control
from inverse.solvers import slsqp
from inverse.solvers.ipopt import NEAR, Solver
from inverse.solvers.projection import polish
from inverse.solvers.relaxation import LightSolver, relaxed
from inverse.solvers.run import GIVEN_UP, INVALID_NUMBER, Attempt, Progress
from inverse.spec import Solver as SolverKeys

FAR = 1.0  # a run without bounds is given up when it leaves them by more than this
APPROACHING, STATIC, PIVOTED = "linearized constraints", "static pivots", "pivoting"  # methods, for the report
REDUCED = "SLSQP where all equations hold"

Iterate = tuple[float, float, FloatArray]  # violation, objective, variables


@dataclass
class Runs:
    """All runs of one solve.

    Attributes:
        goal: what is fitted.
        options: tolerance of the solver, iterations of each round.
        control: ends the runs from outside.
        method: the solver, ipopt or nlopt.
        attempts: how each run of the solver ended, for the report.
        seconds_building: spent on the functions of problems.
        round: number of the round, for the report.
    """

    goal: Goal
    options: SolverKeys
    control: Control
    method: str
    attempts: list[dict[str, Any]] = field(default_factory=list)
    seconds_building: float = 0.0
    round: int = 0
    _feasible: Iterate = (np.inf, np.inf, np.empty(0))
    _near: Iterate = (np.inf, np.inf, np.empty(0))

    def solver(self, problem: Problem) -> Solver | slsqp.Solver:
        """The solver of a problem."""
        if self.method == "ipopt":
            return self._ipopt(problem, self._report)
        steepness = verdict.gradient_scale(problem, self.goal)
        return slsqp.Solver(problem, self.options.tolerance, steepness, self._report)

    def attempt(
        self,
        solver: Solver | slsqp.Solver,
        problem: Problem,
        x: FloatArray,
        parameters: FloatArray,
        multipliers: FloatArray | None,
        *,
        is_seed: bool,
    ) -> Attempt:
        """One round: come near, then fast steps; where they stall, exact ones from the point that they reached.

        A start that is the answer already stays as it is: solvers would leave it to come back. From a good start bounds
        that are far from active are left out. What goes wrong without them, or leaves them, is done again with all.

        Args:
            solver: of the problem.
            problem: what is solved.
            x: (n,) where to start.
            parameters: of the problem.
            multipliers: (R,) of the round before, or None.
            is_seed: whether the start is the seed.

        Returns:
            The last run.
        """
        settled = self._settled(problem, x, parameters)
        if settled is not None:
            return settled
        left = self.options.max_iterations
        if isinstance(solver, slsqp.Solver):
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
                    if method == APPROACHING and problem.has_redundant_equations:
                        # Which equations follow from others shows where all of them hold.
                        x, multipliers = polish(problem, x, parameters), None
                    break
            if method == APPROACHING and near is not light:
                light = self._light(problem, x, parameters) if near else None
        attempt = solver.run(x, parameters, multipliers, left, careful=True)
        return self._recorded(attempt, PIVOTED, False)

    def ends(self, attempt: Attempt) -> bool:
        """Whether there is nothing more to do: stopped, or a term without a value, which no solver mends."""
        return self.control.stopped or attempt.status == INVALID_NUMBER

    def begin(self, x: FloatArray, objective: float) -> None:
        """Take a design as the best so far; who stops early gets nothing worse."""
        self._feasible = (verdict.BOUND, objective, x)

    def kept(self, problem: Problem, parameters: FloatArray) -> FloatArray:
        """The best design so far: an iterate that a polish makes feasible, else the best that was so itself."""
        polished = polish(problem, self._near[2], parameters)
        goal = self.goal
        if goal.packed:
            polished = goal.start(goal.model.points(polished))  # boxes around the states that have moved
        return polished if problem.violation(polished, parameters) <= verdict.BOUND else self._feasible[2]

    @property
    def best(self) -> FloatArray | None:
        """The best iterate that was told, (n,), or None before the first one."""
        return self._feasible[2] if self._feasible[2].size else None

    def _settled(self, problem: Problem, x: FloatArray, parameters: FloatArray) -> Attempt | None:
        """A run that ends where it starts, if nothing pulls the start anywhere and all constraints hold."""
        idle, violation = np.zeros(problem.n_rows), problem.violation(x, parameters)
        pull = verdict.stationarity(problem, x, idle, parameters, self.goal)
        if not (violation <= verdict.EQUATION and pull <= self.options.tolerance):
            return None
        self._report(Progress(0, problem.objective_and_gradient(x, parameters)[0], violation, x))
        return self._recorded(Attempt(x, idle, "Solve_Succeeded", 0, 0.0, 0.0), "the start is stationary", False)

    def _is_over(self, problem: Problem, attempt: Attempt, parameters: FloatArray, left: int) -> bool:
        solved = attempt.succeeded and problem.violation(attempt.variables, parameters) <= verdict.BOUND
        return solved or self.ends(attempt) or left <= 0

    def _light(self, problem: Problem, x: FloatArray, parameters: FloatArray) -> LightSolver | None:
        """A solver without the bounds that are far from active, if there are enough of them."""
        relaxation = relaxed(problem, x, parameters)
        if relaxation is None:
            return None

        model = self.goal.model

        def report(progress: Progress) -> bool:
            # Sector angles have no sign: without its bounds a facet may turn over and satisfy them again.
            if not geometry.are_convex(model.pattern, model.points(progress.variables)):
                return False
            whole = problem.violation(progress.variables, parameters)
            return self._report(replace(progress, violation=whole)) and whole <= FAR

        return LightSolver(relaxation, problem.n_rows, self._ipopt(relaxation.problem, report))

    def _ipopt(self, problem: Problem, report: Callable[[Progress], bool]) -> Solver:
        began = time.perf_counter()
        problem.functions  # noqa: B018  built here, to be told apart from solving
        self.seconds_building += time.perf_counter() - began
        return Solver(problem, self.options.tolerance, self.goal.model.refinement, report)

    def _recorded(self, attempt: Attempt, method: str, is_light: bool) -> Attempt:
        self.attempts.append(
            {
                "facets": self._facets,
                "round": self.round,
                "method": f"{self.method}, {method}" + (", without idle bounds" if is_light else ""),
                "ended": attempt.status,
                "iterations": attempt.iterations,
                "seconds": attempt.seconds,
                "seconds_functions": attempt.seconds_functions,
            }
        )
        return attempt

    @property
    def _facets(self) -> int:
        return len(self.goal.model.pattern.faces_vertices)

    def _report(self, progress: Progress) -> bool:
        """Keep the best iterates; False stops the solver."""
        self._feasible = _better(self._feasible, progress, verdict.BOUND)
        self._near = _better(self._near, progress, NEAR)
        return self.control.tell(f"{self._facets} facets, round {self.round}", progress)


def _better(best: Iterate, progress: Progress, tolerated: float) -> Iterate:
    """The better of two iterates: violations below what is tolerated do not count, then the objective does."""
    rank = (max(progress.violation, tolerated), progress.objective)
    return (*rank, progress.variables) if rank < best[:2] else best
