"""Solving a specification: from what it says to a result that says what happened."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from inverse._types import FloatArray
from inverse.certify import Certificate, check_frame
from inverse.errors import InputError
from inverse.files import fold_file
from inverse.files.fold_format import frame_of
from inverse.formulation.formulate import Formulation, formulate, moved_back
from inverse.nlp.redundancy import dependence
from inverse.origami.pattern import Design
from inverse.policy import measures, statuses
from inverse.policy.control import Control, Watch
from inverse.policy.steps import SHORTEST_SHARE, Outcome, Policy, reasons
from inverse.solvers.run import Ending
from inverse.spec import Loaded
from inverse.terms.goal import Goal


@dataclass(frozen=True, eq=False)
class Result:
    """What a solve found, whether or not it is any good.

    Attributes:
        ending: a word of :data:`inverse.policy.statuses.ENDINGS`: ``solved``, or why not.
        status: the same as a sentence: how it ended and, unless certified and converged, what to do next.
        converged: stationary and feasible by our own test.
        certified: the independent certificate passes.
        interrupted: stopped by the user, the time limit or a broken watch; the design is the best so far.
        design: the design.
        seed: the placed seed.
        multipliers: (R,) of all constraint rows, which make the result a start for a task like it.
        certificate: the independent certificate of the design.
        report: everything told in ``report.json``.
        formulation: target and terms, for pictures.
    """

    ending: str
    status: str
    converged: bool
    certified: bool
    interrupted: bool
    design: Design
    seed: Design
    multipliers: FloatArray
    certificate: Certificate
    report: dict[str, Any]
    formulation: Formulation


class SolveError(RuntimeError):
    """A solve that was to raise where its design is not both certified and converged.

    Args:
        result: what it found nevertheless; its status says how it ended and what to do next.
    """

    def __init__(self, result: Result) -> None:
        self.result = result
        super().__init__(result.status)


def solve(loaded: Loaded, watch: Watch | None = None, start: Result | None = None, *, throw: bool = False) -> Result:
    """Design a mesh for a specification.

    Args:
        loaded: the specification, from :func:`inverse.load`.
        watch: told every iteration.
        start: the result of a task like this one, such as the same with its target moved a little, to go on from
            instead of the seed.
        throw: raise where the design is not both certified and converged.

    Returns:
        The result; without ``throw``, read ``certified`` and ``converged`` before using its design.

    Raises:
        InputError: the specification, or a file that it names, cannot be used; the start has another pattern.
        SolveError: with ``throw``, for every ending but ``solved``; it carries the result.
        KeyboardInterrupt: at Ctrl-C or SIGTERM before there is a design to keep, and at a second one at any time.
    """
    began = time.perf_counter()
    limit = loaded.specification.solver.time_limit_s
    control = Control(np.inf if limit is None else time.monotonic() + limit, watch)
    with control.interruptible():
        formulation = formulate(loaded)
        measures.own(formulation.goal.model.seed)  # what is wrong with them is told before solving
        control.check()
        policy = Policy(loaded, formulation, control)
        formulated = time.perf_counter()
        if start is None:
            outcome = policy.run(None, None)
        else:
            outcome = policy.run(_variables(start, formulation.goal), start.multipliers)
        report, was_certified = _report(policy, outcome), outcome.certificate.certified
        if formulation.goal.origin.any():
            outcome = _moved_back(outcome, formulation.goal.origin)
            formulation = moved_back(loaded, formulation)
        ending, details = _ending(policy, outcome)
        if ending == "not_certified" and was_certified:
            far = float(np.abs(outcome.design.vertices_coords).max())
            ending, details = "too_far", [f"numbers of {far:.3g} are {np.spacing(far):.1g} apart", *details]
        report |= {"ending": ending, "certified": outcome.certificate.certified}
        failures: list[str] = []
        report["measures"] = {name: _finite(value) for name, value in measures.own(outcome.design, failures).items()}
        report["failed_measures"] = failures
        report["seconds"] = {"formulate": formulated - began} | policy.seconds
    result = Result(
        ending, statuses.sentence(ending, details), outcome.converged, outcome.certificate.certified,
        control.stopped and not outcome.is_solved,
        outcome.design, formulation.goal.model.seed, outcome.point.balance, outcome.certificate, report,
        formulation,
    )  # fmt: skip
    if throw and ending != statuses.SOLVED:
        raise SolveError(result) from policy.error or control.failure
    return result


def _moved_back(outcome: Outcome, origin: FloatArray) -> Outcome:
    """An outcome in the coordinates of the specification, certified there: what was solved was near to an origin."""
    design = outcome.design.moved_to(outcome.design.vertices_coords + origin)
    certificate = check_frame(frame_of(fold_file.document(design)))
    return replace(outcome, design=design, certificate=certificate)


def _variables(start: Result, goal: Goal) -> FloatArray:
    """Variables of an earlier result, carried along with the seed where the target has moved."""
    model = goal.model
    if start.design.pattern.faces_vertices != model.pattern.faces_vertices:
        raise InputError(
            f"the start has another pattern: {len(start.design.pattern.faces_vertices)} facets, "
            f"the specification {len(model.pattern.faces_vertices)}",
            hint="Start from a result of the same pattern, or without one.",
        )
    moved = start.design.vertices_coords - start.seed.vertices_coords
    return goal.start(model.seed.vertices_coords + moved)


def _ending(policy: Policy, outcome: Outcome) -> tuple[str, list[str]]:
    """The word for how a solve ended, and what was measured."""
    control, details = policy.control, reasons(outcome)
    if outcome.is_solved:
        return statuses.SOLVED, details
    if policy.not_a_number is not None:
        name, element = policy.not_a_number
        return "not_a_number", [f"{name} at {element}"]
    if policy.failure is not None:
        return "failed", details
    if control.failure is not None:
        return "watch_failed", [f"{type(control.failure).__name__}: {control.failure}", *details]
    if control.stop.is_set():
        return "interrupted", details
    if control.timed_out:
        return "time_limit", details
    if policy.reached is not None and policy.reached < 1 and not outcome.converged:
        came = f"came to {policy.reached:.3g}" if policy.reached > 0 else f"did not even come to {SHORTEST_SHARE:.3g}"
        details = [*details, f"a path from the seed {came} of the target's height"]
    if not outcome.is_feasible:
        return "infeasible", details
    if outcome.converged:
        return "not_certified", details
    # The last run of each step counts: fast steps end at a limit of their own before exact ones follow.
    ran_out = any(a.ended == Ending.LIMIT for a in policy.attempts if a.outcome is not None)
    return "iteration_limit" if ran_out else "stalled", details


def _report(policy: Policy, outcome: Outcome) -> dict[str, Any]:
    goal, design, point = policy.formulation.goal, outcome.design, outcome.point
    problem = point.problem
    judgement = outcome.judgement.document()
    report = {
        "converged": outcome.converged,
        "certified": outcome.certificate.certified,
        "fit": measures.fit(goal, design).document(),
        "coverage": measures.coverage(goal, design),
        "footprint": measures.footprint(goal, point.variables),
        "objective": point.objective_terms,
        "verdict": judgement | {"failed": list(outcome.failed)},
        "iterations": sum(attempt.iterations for attempt in policy.attempts),
        "attempts": [attempt.document() for attempt in policy.attempts],
        "reached": policy.reached,
        "equations": dependence(point) if problem.has_redundant_equations else None,
        "size": {
            "facets": len(design.pattern.faces_vertices),
            "variables": problem.n_variables,
            "rows": problem.n_rows,
            "degrees_of_freedom": design.pattern.degrees_of_freedom,
        },
    }
    return {name: _finite(value) for name, value in report.items()}


def _finite(value: Any) -> Any:
    """The same with None for what is not a finite number, as terms without a value are: JSON has no word for it."""
    if isinstance(value, dict):
        return {key: _finite(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_finite(one) for one in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value
