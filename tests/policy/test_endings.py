"""How every ending is told, and what ends a solve from outside: without any solver."""

from __future__ import annotations

import math
import threading
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from outcomes import SOLVED, STALLED, attempts, outcome, policy

from inverse.policy import endings
from inverse.policy.control import Control
from inverse.policy.steps import Policy
from inverse.solvers.run import Ending, Progress

POINT: Any = "the least violation"
PROGRESS = Progress(0, 1.0, 0.0, np.zeros(1))


# ---- how it ended


def stopped_by_clock(one: Policy) -> None:
    one.control.deadline = -math.inf


def stopped_by_user(one: Policy) -> None:
    stopped_by_clock(one)  # the user's word is told though time is up as well
    one.control.stop.set()


def stopped_by_watch(one: Policy) -> None:
    stopped_by_user(one)
    one.control.failure = ValueError("broken")


def failed(one: Policy) -> None:
    stopped_by_watch(one)
    one.failure = ("start", "ValueError: broken")


def not_a_number(one: Policy) -> None:
    failed(one)
    one.not_a_number = ("fit", "vertex 3")


CAUSES = {
    "not_a_number": not_a_number,
    "failed": failed,
    "watch_failed": stopped_by_watch,
    "interrupted": stopped_by_user,
    "time_limit": stopped_by_clock,
}


@pytest.mark.parametrize("word", CAUSES)
def test_the_first_cause_is_told_whatever_followed_from_it(word: str) -> None:
    one = policy()
    CAUSES[word](one)
    ending, details = endings.ending_of(one, STALLED)
    assert ending == word
    first = {
        "not_a_number": "fit at vertex 3",
        "watch_failed": "ValueError: broken",
        "failed": "it is not stationary",
    }
    assert details[0] == first.get(word, "it is the best of the steps that had ended")
    assert details[-1] == ("fit at vertex 3" if word == "not_a_number" else "it is not stationary")
    if word in ("interrupted", "time_limit"):
        assert endings.ending_of(one, replace(STALLED, kept="it is the seed"))[1][0] == "it is the seed"
    assert endings.ending_of(one, SOLVED) == ("solved", [])


def test_without_a_cause_from_outside_it_is_the_design_that_tells() -> None:
    one = policy()
    assert endings.ending_of(one, outcome(failed=("no",), violation=1e-3)) == ("infeasible", ["no"])
    assert endings.ending_of(one, outcome(certified=False)) == ("not_certified", ["closure FAILED"])
    assert endings.ending_of(one, outcome(certified=False, failed=("no",))) == ("stalled", ["closure FAILED", "no"])
    one.attempts = attempts(Ending.INFEASIBLE, Ending.LIMIT, Ending.NO_STEP)
    assert endings.ending_of(one, STALLED)[0] == "iteration_limit"
    one.attempts = attempts(Ending.INFEASIBLE)  # after a run within the step that came to its limit
    assert endings.ending_of(one, STALLED)[0] == "stalled"


def test_constraints_that_contradict_each_other_are_told_from_the_least_violation(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What can be loosened first, and no more than a few."""
    said = [f"edge {k} is too long (constraints.edge_length)" for k in range(4)]
    said += ["vertex 1 is too low (constraints.keep_out.0)", "vertex 2 is off (constraints.anchors.1)"]
    monkeypatch.setattr(endings, "violated", lambda *_: list(said))
    one = policy()
    one.least = POINT
    found = endings.ending_of(one, outcome(failed=("no",), violation=1e-3))
    assert found == ("contradictory", [said[5], said[4], said[0], said[1]])
    assert endings.ending_of(one, outcome(failed=("no",)))[0] == "stalled"  # something met them after all


@pytest.mark.parametrize(
    ("reached", "told"),
    [(None, ""), (1.0, ""), (0.75, "came to 0.75 of"), (0.0, "did not even come to 0.125 of")],
)
def test_how_far_a_path_came_is_told_where_it_matters(reached: float | None, told: str) -> None:
    one = policy()
    one.reached = reached
    ending, details = endings.ending_of(one, STALLED)
    assert ending == "stalled"
    assert details == ["it is not stationary"] + [f"a path from the seed {told} the target's height"] * bool(told)
    assert endings.ending_of(one, outcome(certified=False)) == ("not_certified", ["closure FAILED"])


# ---- what ends a solve from outside


def test_what_stops_a_solve(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("inverse.policy.control.time.monotonic", lambda: 5.0)
    assert not Control(5.5).stopped
    assert Control(5.0).timed_out
    assert Control(5.0).stopped
    asked, broken = Control(5.5), Control(5.5, failure=ValueError())
    asked.stop.set()
    assert asked.stopped
    assert broken.stopped
    assert not asked.timed_out
    assert not broken.timed_out


def test_the_watch_is_told_until_the_solve_is_stopped() -> None:
    told: list[str] = []
    control = Control(math.inf, lambda phase, _: told.append(phase))
    assert control.tell("first", PROGRESS)
    control.stop.set()
    assert not control.tell("second", PROGRESS)
    assert told == ["first"]
    assert Control(math.inf).tell("nobody watches", PROGRESS)
    assert not Control(-math.inf).tell("nobody watches", PROGRESS)


def test_a_watch_that_stops_the_solve_ends_it_at_once() -> None:
    stop = threading.Event()
    assert not Control(math.inf, lambda *_: stop.set(), stop).tell("", PROGRESS)


def test_where_nothing_was_found_yet_an_interrupt_is_one() -> None:
    control = Control(math.inf)
    control.check()
    control.stop.set()
    with pytest.raises(KeyboardInterrupt):
        control.check()
