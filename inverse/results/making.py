"""From a task to its result: where it starts, what is tried, and what is told of the best outcome."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from inverse._types import FloatArray
from inverse.brief.brief import Brief
from inverse.certify import check_frame
from inverse.context import triangulated
from inverse.errors import InputError
from inverse.files import fold_file
from inverse.formulation.context import read_context
from inverse.formulation.formulate import Formulation, formulate, moved_back
from inverse.formulation.given import Given
from inverse.nlp.redundancy import dependence
from inverse.origami.pattern import Design
from inverse.pictures.design_state import Surface
from inverse.policy import endings, measures
from inverse.policy.control import Control, Watch
from inverse.policy.outcome import Outcome
from inverse.policy.steps import Policy
from inverse.results.result import Result, Size, SolveError
from inverse.spec import Loaded
from inverse.terms.goal import Goal

Start = Result | Design | Path | str


def made(loaded: Loaded, given: Given, start: Start | None, watch: Watch | None, *, throw: bool) -> Result:
    """Solve a task; see :func:`inverse.solve`."""
    control = controlled(loaded, watch)
    with control.interruptible():
        context = surroundings(loaded)
        policy, outcome = solved(loaded, given, start, control)
        result = told(policy, outcome, context)
    if throw and result.ending != endings.SOLVED:
        raise SolveError(result) from policy.error or control.failure
    return result


def controlled(loaded: Loaded, watch: Watch | None) -> Control:
    """What ends the steps of a task from outside; its clock runs from now on."""
    limit = loaded.specification.solver.time_limit_s
    return Control(np.inf if limit is None else time.monotonic() + limit, watch)


def surroundings(loaded: Loaded) -> Surface | None:
    """Vertices (V, 3) and triangles (T, 3) of the buildings that a specification names, if any."""
    context = read_context(loaded)
    return None if context is None else triangulated(context)[:2]


def solved(loaded: Loaded, given: Given, start: Start | None, control: Control) -> tuple[Policy, Outcome]:
    """Try all that the policy knows; its best outcome."""
    began = time.perf_counter()
    first = _read(start) if isinstance(start, Path | str) else start
    formulation = formulate(loaded, given=given)
    measures.own(formulation.goal.model.seed)  # what is wrong with them is told before solving
    control.check()
    policy = Policy(loaded, formulation, control)
    policy.seconds["formulate"] = time.perf_counter() - began
    return policy, policy.run(*_beginning(first, formulation.goal))


def _read(path: Path | str) -> Design:
    """The design in an output folder, or in a file."""
    path = Path(path)
    return fold_file.read(path / "design.fold" if path.is_dir() else path)


def _beginning(start: Result | Design | None, goal: Goal) -> tuple[FloatArray | None, FloatArray | None]:
    """Variables and multipliers to start from; an earlier result is carried along where its target has moved."""
    if start is None:
        return None, None
    seed = goal.model.seed
    design = start.design if isinstance(start, Result) else start
    if design.pattern.faces_vertices != seed.pattern.faces_vertices:
        raise InputError(
            f"the start has another pattern: {len(design.pattern.faces_vertices)} facets, "
            f"the specification {len(seed.pattern.faces_vertices)}",
            hint="Start from a result of the same pattern, or without one.",
        )
    if isinstance(start, Result):
        moved = design.vertices_coords - start.seed.vertices_coords
        return goal.start(seed.vertices_coords + moved), start.multipliers
    return goal.start(design.vertices_coords - goal.origin), None


def told(policy: Policy, outcome: Outcome, context: Surface | None) -> Result:
    """What is told of an outcome, in the coordinates of the specification, with the buildings around it."""
    loaded, formulation, near = policy.loaded, policy.formulation, outcome
    goal, point = formulation.goal, outcome.point
    if goal.origin.any():
        outcome = _moved_back(outcome, goal.origin)
        formulation = moved_back(loaded, formulation)
    footprint = measures.footprint(goal, point.variables)
    began = time.perf_counter()
    brief = Brief(loaded, policy.formulation, near.design, outcome.certificate, footprint["limits"])
    ending, details = _ending(policy, near, outcome, brief)
    policy.seconds["brief"] = time.perf_counter() - began
    failed_measures: list[str] = []
    own = measures.own(outcome.design, failed_measures)
    return Result(
        ending=ending,
        status=endings.sentence(ending, details),
        converged=outcome.converged,
        certified=outcome.certificate.certified,
        interrupted=policy.control.stopped and not outcome.is_solved,
        design=outcome.design,
        seed=formulation.goal.model.seed,
        multipliers=point.balance,
        certificate=outcome.certificate,
        fit=measures.fit(goal, goal.model.whole(point.variables)),
        coverage=brief.coverage,
        asked=brief.asked,
        footprint=footprint,
        measures=own,
        failed_measures=tuple(failed_measures),
        notes=formulation.anchored.notes,
        objective=point.objective_terms,
        judgement=outcome.judgement,
        failed=outcome.failed,
        attempts=tuple(policy.attempts),
        reached=policy.reached,
        equations=dependence(point) if point.problem.has_redundant_equations else None,
        size=_size(formulation, outcome),
        seconds=dict(policy.seconds),
        specification=loaded.specification.model_dump(mode="json"),
        target=formulation.goal.target.triangles(),
        context=context,
    )


def _moved_back(outcome: Outcome, origin: FloatArray) -> Outcome:
    """An outcome in the coordinates of the specification, certified there: what was solved was near to an origin."""
    design = outcome.design.moved_to(outcome.design.vertices_coords + origin)
    certificate = check_frame(fold_file.frame(design))
    return replace(outcome, design=design, certificate=certificate)


def _ending(policy: Policy, near: Outcome, outcome: Outcome, brief: Brief) -> tuple[str, list[str]]:
    ending, details = endings.ending_of(policy, outcome)
    missed = [one.told for one in brief.asked if not one.met]
    if ending == endings.SOLVED and missed:
        return "not_as_asked", missed
    if ending == "not_certified" and near.certificate.certified:
        far = float(np.abs(outcome.design.vertices_coords).max())
        return "too_far", [f"numbers of {far:.3g} are {np.spacing(far):.1g} apart", *details]
    return ending, details


def _size(formulation: Formulation, outcome: Outcome) -> Size:
    pattern, problem = outcome.design.pattern, outcome.point.problem
    return Size(len(pattern.faces_vertices), problem.n_variables, problem.n_rows, pattern.degrees_of_freedom)
