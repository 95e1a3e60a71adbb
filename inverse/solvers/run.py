"""One run of a solver: what it tells on the way, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from inverse._types import FloatArray
from inverse.nlp.point import Point


class Ending(StrEnum):
    """How a run ended, in IPOPT's words and one of ours; other solvers use the same."""

    SOLVED = "Solve_Succeeded"
    ACCEPTABLE = "Solved_To_Acceptable_Level"
    SETTLED = "Settled"  # an approach that came as near as it should
    FEASIBLE = "Feasible_Point_Found"
    GIVEN_UP = "User_Requested_Stop"  # who is told an iterate said stop
    LIMIT = "Maximum_Iterations_Exceeded"
    NO_STEP = "Search_Direction_Becomes_Too_Small"
    INFEASIBLE = "Infeasible_Problem_Detected"
    INVALID_NUMBER = "Invalid_Number_Detected"
    RESTORATION_FAILED = "Restoration_Failed"
    STEP_FAILED = "Error_In_Step_Computation"
    DIVERGING = "Diverging_Iterates"
    FEW_FREEDOMS = "Not_Enough_Degrees_Of_Freedom"
    OTHER = "Internal_Error"

    @classmethod
    def _missing_(cls, value: object) -> Ending:
        return cls.OTHER


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
class Run:
    """How a run ended. ``end`` is the last iterate; whether it is any good is not for the solver to say.

    Attributes:
        end: the last iterate with its multipliers.
        ending: the solver's own word, or that the iterates settled.
        iterations: number of iterations.
        seconds: wall time, building included when the solver is used for the first time.
        seconds_functions: part of it in the functions of the problem; linear algebra takes most of the rest.
        method: how, for the report.
    """

    end: Point
    ending: Ending
    iterations: int
    seconds: float
    seconds_functions: float
    method: str
