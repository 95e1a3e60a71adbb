"""How a solve can end: one table, each entry a sentence with the cause and one with the next step."""

from __future__ import annotations

from dataclasses import dataclass

SOLVED = "solved"


@dataclass(frozen=True)
class Ending:
    """One way to end.

    Attributes:
        cause: what happened; ``{details}`` is replaced by what was measured.
        advice: what to do next.
    """

    cause: str
    advice: str


ENDINGS: dict[str, Ending] = {
    SOLVED: Ending("certified and converged", ""),
    "interrupted": Ending(
        "interrupted, the best design so far was kept: {details}",
        "Let it run on, or start again from this result.",
    ),
    "time_limit": Ending(
        "the time limit was reached, the best design so far was kept: {details}",
        "Raise solver.time_limit_s, or start again from this result.",
    ),
    "watch_failed": Ending(
        "the function that watches the iterations failed, the best design so far was kept: {details}",
        "Mend that function; what it raised is the cause of the error that throw=True raises.",
    ),
    "failed": Ending(
        "a step of the solve failed, the best design so far was kept: {details}",
        "This is a fault of the program or of a term of your own, not of the task: report it with report.json, which "
        "has the traceback.",
    ),
    "not_a_number": Ending(
        "a term of the model is not a number: {details}",
        "This is a fault of the term, not of the solver: mend the objective or the target named here.",
    ),
    "infeasible": Ending(
        "no attempt met all constraints: {details}",
        "Loosen the anchors, keep-outs or bounds that are named, or anchor fewer vertices.",
    ),
    "not_certified": Ending(
        "the solver converged, but the independent certificate refuses the design: {details}",
        "Turn the pattern (pattern.turn), take more facets, or narrow constraints.fold_angle.",
    ),
    "too_far": Ending(
        "the design is certified near the origin, but not where it stands, too far for numbers in a file: {details}",
        "Subtract a point near by from all coordinates of the task.",
    ),
    "iteration_limit": Ending(
        "the iterations ran out, the best design was kept: {details}",
        "Raise solver.max_iterations, or start again from this result.",
    ),
    "stalled": Ending(
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
    if word == SOLVED:
        return ending.cause
    return f"{ending.cause.format(details='; '.join(details))}. {ending.advice}"
