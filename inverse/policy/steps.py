"""What is tried, and in which order, until a design is certified and converged."""

from __future__ import annotations

import time
import traceback
from dataclasses import dataclass, field, replace

import numpy as np

from inverse._types import FloatArray
from inverse.certify import check_frame
from inverse.errors import InputError
from inverse.files import fold_file
from inverse.formulation.formulate import Formulation, formulate
from inverse.nlp.point import Point
from inverse.policy import coarse, verdict
from inverse.policy.attempts import Attempt
from inverse.policy.best import COARSE, START
from inverse.policy.control import Control
from inverse.policy.outcome import Outcome, reasons
from inverse.policy.rounds import Rounds
from inverse.solvers.ipopt import NEAR
from inverse.solvers.projection import Projection, balanced, polish
from inverse.solvers.run import Ending
from inverse.spec import Loaded, SolverKeys
from inverse.terms.goal import Goal

FIRST_SHARE = 0.25  # of the target's heights: where a path from the seed to the target begins
SHORTEST_SHARE = 1 / 8  # steps of the path that fail are halved down to this
NLOPT_LARGEST = 1500  # variables up to which the fallback has a chance to end within a minute


@dataclass(eq=False)
class Policy:
    """The steps of one solve.

    Attributes:
        loaded: the specification.
        formulation: what it means.
        control: ends the steps from outside.
        attempts: every run of a solver and how it ended, for the report.
        seconds: spent on parts of the work.
        not_a_number: name and element of a term that has no value, where that ended the solve.
        reached: share of the target's heights that a path from the seed reached, where one was needed.
        least: the design with the least violation of all constraints, where these contradict each other.
        failure: name of the step that raised what no step should, and what that was, where it ended the solve.
        error: the same as an exception.
        rounds: the latest.
    """

    loaded: Loaded
    formulation: Formulation
    control: Control
    attempts: list[Attempt] = field(default_factory=list)
    seconds: dict[str, float] = field(
        default_factory=lambda: dict.fromkeys(("formulate", "start", "build", "solve", "polish", "certify"), 0.0)
    )
    not_a_number: tuple[str, str] | None = None
    reached: float | None = None
    least: Point | None = None
    failure: tuple[str, str] | None = None
    error: Exception | None = None
    rounds: Rounds | None = None

    def run(self, variables: FloatArray | None, multipliers: FloatArray | None) -> Outcome:
        """Try one step after the other until one succeeds.

        The first goes the straight way from the start. Those after it are for what that one could not do: leave a
        place where a solver stalled, come to the target on a path of easier ones, or with another method; at last at
        least the constraints are met.

        Args:
            variables: (n,) where to start, or None for the seed, or a coarser grid where the grid is fine.
            multipliers: (R,) that belong to them, or None.

        Returns:
            The best outcome of all steps.
        """
        start_name = START
        if variables is None:
            began = time.perf_counter()
            variables, start_name = self._from_coarse(self.loaded, self.formulation.goal), COARSE
            self.seconds["start"] += time.perf_counter() - began
        best = self._solved("start", self.formulation, variables, multipliers, start_name=start_name)
        for step in (self._again, self._along_a_path, self._by_nlopt, self._restored):
            if best.is_solved or self._is_over:
                break
            try:
                outcome = step(best)
            except Exception as error:  # the best design is not to be lost with it
                self._fail(step.__name__.strip("_").replace("_", " "), error)
            else:
                best = outcome.better(best) if outcome is not None else best
        if self.failure is not None:  # told whatever the design is worth
            best = replace(best, raised=("the step {} raised {}".format(*self.failure),))
        return best

    @property
    def _is_over(self) -> bool:
        """Whether no further step can help."""
        faults = (self.not_a_number, self.failure, self.least)
        return self.control.stopped or any(fault is not None for fault in faults)

    @property
    def _options(self) -> SolverKeys:
        """How it is to be solved."""
        return self.loaded.specification.solver

    @property
    def _method(self) -> str:
        """The solver that was asked for."""
        return self._options.method

    def _again(self, best: Outcome) -> Outcome:
        """From the best design, with all that was learnt about multipliers forgotten."""
        return self._solved("again from the best", self.formulation, best.point.variables)

    def _along_a_path(self, _: Outcome) -> Outcome | None:
        """From the seed by way of targets that are flatter, in steps as long as they succeed."""
        share, step, variables, outcome = 0.0, FIRST_SHARE, None, None
        while share < 1 and step >= SHORTEST_SHARE and not self._is_over:
            ahead = min(share + step, 1.0)
            on_the_way = formulate(self.loaded, ahead, self.formulation.given) if ahead < 1 else self.formulation
            found = self._solved(f"path, {ahead:.3g} of the target", on_the_way, variables)
            if found.is_solved:
                share, step, variables, outcome = ahead, 2 * step, found.point.variables, found
            else:
                step /= 2
        self.reached = share
        if outcome is None or share == 1:
            return outcome
        # The last design on the path, seen as one for the whole target.
        rounds = Rounds(self.formulation, self._options, self.control, self._method, outcome.point.variables)
        return self._outcome(rounds.unsolved())

    def _by_nlopt(self, best: Outcome) -> Outcome | None:
        """With the other solver; not where IPOPT found each time that the constraints contradict each other."""
        contradictory = all(a.ended == Ending.INFEASIBLE for a in self.attempts if a.outcome is not None)
        if self._method == "nlopt" or contradictory or best.point.variables.size > NLOPT_LARGEST:
            return None
        start = best.point.variables if best.is_feasible else None
        return self._solved("nlopt", self.formulation, start, method="nlopt")

    def _restored(self, best: Outcome) -> Outcome | None:
        """Bring the best design within its constraints by equation (9), if it is not."""
        if best.certificate.certified and best.is_feasible:
            return None
        moved = Projection().moved(best.point, 0 * best.point.variables)
        self._record("equation (9)", "within the constraints" if moved is not None else "no design found near by")
        return None if moved is None else self._outcome(moved)

    def follow(self, variables: FloatArray, multipliers: FloatArray, before: Rounds) -> Point:
        """Only the straight way from the solution of a task like this one, not yet certified.

        Args:
            variables: (n,) where to start.
            multipliers: (R,) that belong to them.
            before: the rounds that found that solution.
        """
        return self._run(
            Rounds(
                self.formulation, self._options, self.control, self._method, variables, multipliers, "update",
                apart=dict(before.apart), segments=before.segments,
            )
        )  # fmt: skip

    def outcome(self, point: Point) -> Outcome:
        """Certify and judge the point that :meth:`follow` came to, and tell of it as of an attempt."""
        outcome = self._judged(point, self.formulation)
        self._conclude(outcome)
        return outcome

    def _solved(
        self,
        step: str,
        formulation: Formulation,
        variables: FloatArray | None,
        multipliers: FloatArray | None = None,
        method: str | None = None,
        start_name: str = START,
    ) -> Outcome:
        """One solve from a start, or the seed."""
        rounds = Rounds(
            formulation, self._options, self.control, method or self._method, variables, multipliers, step, start_name
        )
        try:
            point = self._run(rounds)
        except Exception as error:  # the best iterate is not to be lost with it
            self.attempts += rounds.attempts
            self._fail(step, error)
            return self._outcome(rounds.abandoned(), formulation)
        outcome = replace(self._judged(point, formulation), kept=rounds.kept)
        self._conclude(outcome)
        return outcome

    def _run(self, rounds: Rounds) -> Point:
        """Where rounds end, polished."""
        self.rounds, began = rounds, time.perf_counter()
        point = rounds.run()
        self.seconds["build"] += rounds.runs.seconds_building
        self.seconds["solve"] += time.perf_counter() - began - rounds.runs.seconds_building
        self.least = rounds.runs.least
        self.attempts += rounds.attempts or [Attempt(rounds.step, rounds.step, Ending.INVALID_NUMBER)]
        if self.attempts[-1].ended == Ending.INVALID_NUMBER:
            self.not_a_number = point.not_a_number
        return point if rounds.is_exact else self._polished(point, is_polished=rounds.kept is not None)

    def _conclude(self, outcome: Outcome) -> None:
        """Tell with the last attempt what it came to."""
        said = "; ".join(reasons(outcome)) or "certified and converged"
        self.attempts[-1] = replace(self.attempts[-1], outcome=said)

    def _outcome(self, point: Point, formulation: Formulation | None = None) -> Outcome:
        """Polish, certify and judge."""
        return self._judged(self._polished(point), formulation or self.formulation)

    def _polished(self, point: Point, *, is_polished: bool = False) -> Point:
        """A point where all equations hold to rounding, if they can, with multipliers that fit it."""
        if self.not_a_number is not None:
            return point
        began = time.perf_counter()
        point = balanced(point if is_polished else polish(point))
        self.seconds["polish"] += time.perf_counter() - began
        return point

    def _judged(self, point: Point, asked: Formulation) -> Outcome:
        """Certify and judge."""
        design = asked.goal.model.design(point.variables)
        began = time.perf_counter()
        self.control.phase("certifying")
        certificate = check_frame(fold_file.frame(design))
        self.seconds["certify"] += time.perf_counter() - began
        with np.errstate(over="ignore", invalid="ignore"):  # figures that are no numbers are told as such
            judgement = verdict.judge(point, asked.goal, self.loaded.specification.constraints)
        return Outcome(point, design, certificate, judgement, verdict.range_faults(asked.free_range, certificate))

    def _from_coarse(self, loaded: Loaded, goal: Goal) -> FloatArray | None:
        """Variables to start a fine grid from, taken from a coarser one."""
        task = coarse.coarsened(loaded)
        if task is None or self.formulation.given.design is not None:
            return None
        try:
            formulation = formulate(task, given=self.formulation.given)
        except InputError:
            return None  # terms of one's own, or a pattern family, that know only the fine grid
        if self.control.stopped:
            return None  # there is nothing better than the seed yet
        own = formulation.goal.model
        if own.pattern.grid is None:
            return None  # trimmed to an outline, each in its own way
        start = self._from_coarse(task, formulation.goal)
        rounds = Rounds(
            formulation, self._options, self.control, self._method, start, step="coarser grid", start_name=COARSE
        )
        point = rounds.run()
        self.attempts += rounds.attempts
        if point.violation > NEAR:
            return None  # the seed is better than what failed already
        points = own.points(point.variables)
        return goal.start(coarse.spread(own.seed, points, goal.model.seed))

    def _fail(self, step: str, error: Exception) -> None:
        """End the solve with what a step raised.

        Raises:
            KeyboardInterrupt: that is what it was before it met CasADi.
        """
        if self.control.ended.is_set():
            raise KeyboardInterrupt from error
        self.failure, self.error = (step, f"{type(error).__name__}: {error}"), error
        told = tuple(traceback.format_exception(error))
        self.attempts.append(Attempt(step, step, self.failure[1], traceback=told))

    def _record(self, step: str, ended: str) -> None:
        self.attempts.append(Attempt(step, step, ended))
