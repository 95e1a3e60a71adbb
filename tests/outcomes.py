"""Outcomes of steps and policies without anything behind them, for tests of what follows from which."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np

from inverse.policy.attempts import Attempt
from inverse.policy.control import Control
from inverse.policy.outcome import Outcome
from inverse.policy.steps import Policy
from inverse.policy.verdict import Judgement
from inverse.solvers.run import Ending


def outcome(
    *, certified: bool = True, failed: tuple[str, ...] = (), violation: float = 0.0, objective: float = 1.0, n: int = 3
) -> Outcome:
    """What a step comes to."""
    point: Any = SimpleNamespace(violation=violation, objective=objective, variables=np.arange(float(n)))
    check = SimpleNamespace(passed=certified, sentence="closure FAILED")
    certificate: Any = SimpleNamespace(certified=certified, checks={"closure": check})
    design: Any = None
    return Outcome(point, design, certificate, Judgement(0.0, 0.0, {}, failed), ())


SOLVED, STALLED = outcome(), outcome(failed=("it is not stationary",))


def policy(method: str = "ipopt") -> Policy:
    solver = SimpleNamespace(method=method)
    loaded: Any = SimpleNamespace(specification=SimpleNamespace(solver=solver, constraints=None))
    goal = SimpleNamespace(model=SimpleNamespace(seed=None), start=lambda points: points)
    formulation: Any = SimpleNamespace(given=SimpleNamespace(design=None), goal=goal)
    return Policy(loaded, formulation, Control(math.inf))


def attempts(*ended: Ending) -> list[Attempt]:
    """Steps that ended so, each after a run that ended otherwise."""
    found = []
    for end in ended:
        first = Ending.LIMIT if end is Ending.INFEASIBLE else Ending.INFEASIBLE
        found += [Attempt("s", "m", first), Attempt("s", "m", end, outcome="fails")]
    return found
