"""How a solve can end: one table, each entry a sentence with the cause and one with the next step."""

from __future__ import annotations

from dataclasses import dataclass

from inverse.policy.outcome import Outcome, reasons
from inverse.policy.steps import SHORTEST_SHARE, Policy
from inverse.policy.verdict import violated
from inverse.solvers.run import Ending

SOLVED = "solved"
MENTIONED = 4  # of the constraints that contradict each other; all others follow from the compromise


@dataclass(frozen=True)
class Words:
    """What is said of one way to end.

    Attributes:
        cause: what happened; ``{details}`` is replaced by what was measured.
        advice: what to do next.
    """

    cause: str
    advice: str


ENDINGS: dict[str, Words] = {
    SOLVED: Words("certified, converged and as asked", ""),
    "not_as_asked": Words("certified and converged, but not as asked: {details}", ""),
    "interrupted": Words(
        "interrupted, the best design so far was kept: {details}",
        "Let it run on, or start again from this result.",
    ),
    "time_limit": Words(
        "the time limit was reached, the best design so far was kept: {details}",
        "Raise solver.time_limit_s, or start again from this result.",
    ),
    "watch_failed": Words(
        "the function that watches the iterations failed, the best design so far was kept: {details}",
        "Mend that function; what it raised is the cause of the error that throw=True raises.",
    ),
    "failed": Words(
        "a step of the solve failed, the best design so far was kept: {details}",
        "This is a fault of the program or of a term of your own, not of the task: report it with report.json, which "
        "has the traceback.",
    ),
    "not_a_number": Words(
        "a term of the model is not a number: {details}",
        "This is a fault of the term, not of the solver: mend the objective or the target named here.",
    ),
    "infeasible": Words(
        "no attempt met all constraints: {details}",
        "Loosen the anchors, keep-outs or bounds that are named, or anchor fewer vertices.",
    ),
    "contradictory": Words(
        "the constraints contradict each other near every start that was tried, whatever the target; at best {details}",
        "Loosen the anchors, keep-outs or bounds that are named, or anchor fewer vertices.",
    ),
    "not_certified": Words(
        "the solver converged, but the independent certificate refuses the design: {details}",
        "Turn the pattern (pattern.turn), take more facets, or narrow constraints.fold_angle.",
    ),
    "too_far": Words(
        "the design is certified near the origin, but not where it stands, too far for numbers in a file: {details}",
        "Subtract a point near by from all coordinates of the task.",
    ),
    "iteration_limit": Words(
        "the iterations ran out, the best design was kept: {details}",
        "Raise solver.max_iterations, or start again from this result.",
    ),
    "stalled": Words(
        "every solver stopped short of the optimum, the best design was kept: {details}",
        "Loosen the bounds or anchors, turn the pattern (pattern.turn), or take more facets.",
    ),
}


def sentence(word: str, details: list[str]) -> str:
    """The status for an ending of the table.

    Args:
        word: key of ``ENDINGS``.
        details: what was measured, as sentences without full stops.
    """
    ending = ENDINGS[word]
    cause = ending.cause.format(details="; ".join(details))
    return f"{cause}. {ending.advice}" if ending.advice else cause


def ending_of(policy: Policy, outcome: Outcome) -> tuple[str, list[str]]:
    """The word for how a solve ended, and what was measured.

    Args:
        policy: what was tried.
        outcome: the best of it.

    Returns:
        A key of ``ENDINGS``, and sentences without full stops.
    """
    control, details = policy.control, reasons(outcome)
    if outcome.is_solved:
        return SOLVED, details
    if policy.not_a_number is not None:
        name, element = policy.not_a_number
        return "not_a_number", [f"{name} at {element}"]
    if policy.failure is not None:
        return "failed", details
    if control.stopped:
        details = [outcome.kept or "it is the best of the steps that had ended", *details]
    if control.failure is not None:
        return "watch_failed", [f"{type(control.failure).__name__}: {control.failure}", *details]
    if control.stop.is_set():
        return "interrupted", details
    if control.timed_out:
        return "time_limit", details
    if policy.least is not None and not outcome.is_feasible:
        found = violated(policy.least, policy.formulation.goal, policy.loaded.specification.constraints)
        found.sort(key=lambda one: ("constraints.anchors" not in one, "constraints.keep_out" not in one))
        return "contradictory", found[:MENTIONED]
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
