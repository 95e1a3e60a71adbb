"""One run of a solver: what it tells on the way, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass

from inverse._types import FloatArray

# IPOPT's words for runs that did not end at a solution; other solvers use the same.
GIVEN_UP = "User_Requested_Stop"  # who is told an iterate says stop
LIMIT = "Maximum_Iterations_Exceeded"
INFEASIBLE = "Infeasible_Problem_Detected"
INVALID_NUMBER = "Invalid_Number_Detected"


@dataclass(frozen=True)
class Progress:
    """One iteration, as told to whoever watches.

    Attributes:
        iteration: number of the iteration.
        objective: weighted objective, dimensionless.
        violation: largest violation of a constraint row, dimensionless.
        variables: (n,) the iterate.
    """

    iteration: int
    objective: float
    violation: float
    variables: FloatArray


@dataclass(frozen=True, eq=False)
class Attempt:
    """How a run ended. ``variables`` is the last iterate; whether it is any good is not for the solver to say.

    Attributes:
        variables: (n,) last iterate.
        multipliers: (R,) of the constraint rows; positive pushes down from an upper bound.
        status: the solver's own word, or that the iterates settled.
        iterations: number of iterations.
        seconds: wall time, building included when the solver is used for the first time.
        seconds_functions: part of it in the functions of the problem; linear algebra takes most of the rest.
    """

    variables: FloatArray
    multipliers: FloatArray
    status: str
    iterations: int
    seconds: float
    seconds_functions: float

    @property
    def succeeded(self) -> bool:
        """Whether the solver reached its tolerances, not merely its acceptable ones."""
        return self.status == "Solve_Succeeded"
