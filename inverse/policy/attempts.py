"""What was tried, for the report: every run of a solver and how it ended."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from inverse.solvers.run import Run


@dataclass(frozen=True)
class Attempt:
    """One thing that was tried.

    Attributes:
        step: of the policy.
        method: how.
        ended: the solver's word for how it ended, see :class:`inverse.solvers.run.Ending`, or a sentence.
        iterations: number of iterations.
        facets: of the grid that was solved; None where no solver ran, as all that follows.
        round: number of the round within the step.
        seconds: wall time.
        seconds_functions: part of it in the functions of the problem.
        fit_rms: fit at the end of a round, in length units.
        outcome: at the end of a step, what still fails.
        traceback: where it raised what no step should.
    """

    step: str
    method: str
    ended: str
    iterations: int = 0
    facets: int | None = None
    round: int | None = None
    seconds: float | None = None
    seconds_functions: float | None = None
    fit_rms: float | None = None
    outcome: str | None = None
    traceback: tuple[str, ...] | None = None

    def document(self) -> dict[str, Any]:
        """As in ``report.json``."""
        return {key: value for key, value in asdict(self).items() if value is not None}


def attempt_of(run: Run, step: str, solver: str, facets: int, number: int) -> Attempt:
    """A run as it is told.

    Args:
        run: the run.
        step: of the policy.
        solver: its name.
        facets: of the grid that was solved.
        number: of the round.
    """
    method = f"{solver}, {run.method}"
    return Attempt(step, method, run.ending, run.iterations, facets, number, run.seconds, run.seconds_functions)
