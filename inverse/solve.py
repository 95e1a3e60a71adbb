"""The policy of solving: rounds of IPOPT, polish, and a verdict from our own unscaled residuals."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from inverse import coarse, fold_file, verdict
from inverse.attempt import Progress
from inverse.certify import Certificate, check_frame
from inverse.errors import InputError
from inverse.fold_format import frame_of
from inverse.formulate import Formulation, formulate
from inverse.ipopt import NEAR
from inverse.objectives import Goal
from inverse.pattern import Design, FloatArray
from inverse.refine import polish
from inverse.rounds import Control, Rounds
from inverse.spec import Loaded


@dataclass(frozen=True, eq=False)
class Result:
    """What a solve found, whether or not it is any good.

    Attributes:
        status: a sentence: how it ended and, unless certified and converged, what to do next.
        converged: stationary and feasible by our own test.
        certified: the independent certificate passes.
        interrupted: stopped by the user or the time limit; the design is the best so far.
        design: the design.
        seed: the placed seed.
        multipliers: (R,) of all constraint rows, which make the result a start for a task like it.
        certificate: the independent certificate of the design.
        report: everything told in ``report.json``.
        formulation: target and terms, for pictures.
    """

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


def solve(loaded: Loaded, watch: Callable[[str, Progress], None] | None = None, start: Result | None = None) -> Result:
    """Design a mesh for a specification.

    Args:
        loaded: the specification, from :func:`inverse.load`.
        watch: told every iteration.
        start: the result of a task like this one, such as the same with its target moved a little, to go on from
            instead of the seed.

    Returns:
        The result; read ``certified`` and ``converged`` before using its design.

    Raises:
        InputError: the specification, or a file that it names, cannot be used; the start has another pattern.
    """
    began = time.perf_counter()
    limit = loaded.specification.solver.time_limit_s
    control = Control(np.inf if limit is None else time.monotonic() + limit, watch or (lambda _phase, _progress: None))
    formulation = formulate(loaded)
    formulated = time.perf_counter()
    with _interruptible(control.stop):
        attempts: list[dict[str, Any]] = []
        if start is None:
            variables, multipliers = _from_coarse(loaded, formulation.goal, control, attempts), None
        else:
            variables, multipliers = _from_result(start, formulation.goal), start.multipliers
        started = time.perf_counter()
        rounds = Rounds(formulation, loaded.specification.solver, control, variables, multipliers)
        solution = rounds.run()
    attempts += rounds.attempts
    solved = time.perf_counter()
    problem, parameters = solution.problem, solution.parameters
    variables = polish(problem, solution.variables, parameters)
    goal = formulation.goal
    design = goal.model.design(variables)
    polished = time.perf_counter()
    certificate = check_frame(frame_of(fold_file.document(design)))
    seconds = {
        "formulate": formulated - began,
        "start": started - formulated,
        "build": rounds.seconds_building,
        "solve": solved - started - rounds.seconds_building,
        "polish": polished - solved,
        "certify": time.perf_counter() - polished,
    }

    judgement = verdict.judge(problem, variables, solution.multipliers, parameters, goal)
    converged = not judgement["failed"]
    report = {
        "converged": converged,
        "certified": certificate.certified,
        "fit": verdict.fit(goal, design),
        "coverage": verdict.coverage(goal, design),
        "footprint": verdict.footprint(goal, variables),
        "objective": problem.objective_terms(variables, parameters),
        "verdict": judgement,
        "iterations": sum(attempt["iterations"] for attempt in attempts),
        "attempts": attempts,
        "seconds": seconds,
        "size": {
            "facets": len(design.pattern.faces_vertices),
            "variables": problem.n_variables,
            "rows": problem.n_rows,
            "degrees_of_freedom": design.pattern.degrees_of_freedom,
        },
    }
    status = _status(converged, certificate, control.stopped, judgement["failed"], rounds.attempts[-1]["ended"])
    return Result(
        status, converged, certificate.certified, control.stopped, design, goal.model.seed, solution.multipliers,
        certificate, report, formulation,
    )  # fmt: skip


def _from_result(start: Result, goal: Goal) -> FloatArray:
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


def _from_coarse(loaded: Loaded, goal: Goal, control: Control, attempts: list[dict[str, Any]]) -> FloatArray | None:
    """Variables to start a fine grid from, taken from a coarser one; what is attempted there is added."""
    task = coarse.coarsened(loaded)
    if task is None:
        return None
    formulation = formulate(task)
    own = formulation.goal.model
    start = _from_coarse(task, formulation.goal, control, attempts)
    rounds = Rounds(formulation, task.specification.solver, control, start)
    solution = rounds.run()
    attempts += rounds.attempts
    if control.stopped or solution.problem.violation(solution.variables, solution.parameters) > NEAR:
        return None  # the seed is better than what failed already
    points = own.points(solution.variables)
    return goal.start(coarse.spread(own.seed, points, goal.model.seed))


def _status(converged: bool, certificate: Certificate, interrupted: bool, failed: list[str], ended: str) -> str:
    if converged and certificate.certified:
        return "certified and converged"
    reasons = [*(check.sentence for check in certificate.checks.values() if not check.passed), *failed]
    start = "interrupted, the best design so far was kept" if interrupted else f"IPOPT ended with {ended}"
    advice = (
        "Let it run on, or raise solver.time_limit_s." if interrupted
        else "Loosen the bounds or anchors, turn the pattern (pattern.turn), or take more facets."
    )  # fmt: skip
    return f"{start}: {'; '.join(reasons)}. {advice}"


@contextmanager
def _interruptible(stop: threading.Event) -> Iterator[None]:
    """Let Ctrl-C end the run at its next iteration instead of in the middle of one."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    previous = signal.signal(signal.SIGINT, lambda _signal, _frame: stop.set())
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous)
