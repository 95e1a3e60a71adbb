"""Which step follows which outcome, and which outcome is kept: without any solver."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from outcomes import SOLVED, STALLED, attempts, outcome, policy

from inverse.errors import InputError
from inverse.policy import steps, verdict
from inverse.policy.attempts import Attempt
from inverse.policy.outcome import Outcome
from inverse.policy.steps import Policy
from inverse.solvers.ipopt import NEAR
from inverse.solvers.run import Ending

# ---- the better of two outcomes


BETTER = {
    "solved, though farther off": (outcome(objective=9.0), replace(STALLED, point=outcome(objective=1.0).point)),
    "certified, though violated": (
        outcome(failed=("no",), violation=1e-3),
        outcome(certified=False, objective=0.1),
    ),
    "less violated, though farther off": (
        outcome(failed=("no",), violation=1e-3, objective=9.0),
        outcome(failed=("no",), violation=2e-3, objective=0.1),
    ),
    "nearer, where both hold": (
        outcome(violation=0.9e-7, objective=0.9),
        outcome(violation=0.0, objective=1.0),
    ),
}


@pytest.mark.parametrize("name", BETTER)
def test_the_better_outcome(name: str) -> None:
    good, bad = BETTER[name]
    assert good.better(bad) is good
    assert bad.better(good) is good


def test_of_equal_outcomes_the_one_before_is_kept() -> None:
    first, second = outcome(), outcome()
    assert second.better(first) is first
    assert first.better(None) is first


def test_constraints_hold_up_to_the_tolerance_of_bounds() -> None:
    assert outcome(violation=verdict.BOUND).is_feasible
    assert not outcome(violation=1.01 * verdict.BOUND).is_feasible


def test_solved_is_converged_and_certified() -> None:
    assert SOLVED.is_solved
    assert not outcome(certified=False).is_solved
    assert not STALLED.is_solved
    for fault in ({"raised": ("a step raised",)}, {"range_faults": ("the motion is not free",)}):
        assert not replace(SOLVED, **fault).converged


# ---- which steps follow


class Steps:
    """A policy whose steps end as told; remembers which were taken, and from what."""

    NAMES = ("again", "along_a_path", "by_nlopt", "restored")

    def __init__(self, monkeypatch: pytest.MonkeyPatch, **ends: Outcome | None) -> None:
        self.policy, self.taken = policy(), []
        self.seen: list[Outcome] = []
        monkeypatch.setattr(self.policy, "_solved", lambda step, *_, **__: self.end(step, ends["start"]))
        for name in self.NAMES:

            def step(best: Outcome, name: str = name) -> Outcome | None:
                self.seen.append(best)
                return self.end(name, ends.get(name))

            monkeypatch.setattr(self.policy, f"_{name}", step)

    def end(self, name: str, found: Outcome | None) -> Outcome | None:
        self.taken.append(name)
        return found

    def run(self) -> Outcome:
        return self.policy.run(np.zeros(3), None)


@pytest.mark.parametrize("solved", range(5))
def test_steps_are_taken_until_one_solves(solved: int, monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("start", *Steps.NAMES)
    tried = Steps(monkeypatch, **{name: SOLVED if k >= solved else STALLED for k, name in enumerate(names)})
    assert tried.run() is SOLVED
    assert tried.taken == list(names[: solved + 1])


def test_the_best_of_all_steps_is_kept_and_handed_on(monkeypatch: pytest.MonkeyPatch) -> None:
    near, far = (outcome(failed=("no",), objective=objective) for objective in (1.0, 2.0))
    tried = Steps(monkeypatch, start=far, again=near, by_nlopt=far)
    assert tried.run() is near
    assert tried.seen == [far, near, near, near]


@pytest.mark.parametrize("end", ["stop", "not_a_number", "failure", "least"])
def test_no_step_follows_where_none_can_help(end: str, monkeypatch: pytest.MonkeyPatch) -> None:
    tried = Steps(monkeypatch, start=STALLED)
    if end == "stop":
        tried.policy.control.stop.set()
    else:
        setattr(tried.policy, end, ("fit", "vertex 3"))
    tried.run()
    assert tried.taken == ["start"]


# ---- one solve


class Solved:
    """Rounds that end in a point with given attempts, or raise."""

    attempts: tuple[Attempt, ...] = ()
    raised: Exception | None = None
    kept: str | None = None
    is_exact = False
    step = "a step"
    runs = SimpleNamespace(seconds_building=0.0, least=None)

    def __init__(self, *given: Any) -> None:
        pass

    def run(self) -> Any:
        if self.raised is not None:
            raise self.raised
        return SimpleNamespace(name="the end", not_a_number=("fit", "vertex 3"))

    def abandoned(self) -> Any:
        return SimpleNamespace(name="the best iterate")


def solved(monkeypatch: pytest.MonkeyPatch, found: Outcome, **of: Any) -> tuple[Policy, list[str]]:
    """The policy after one solve that comes to ``found``; and what was judged."""
    one, judged = policy(), []

    def polished(point: Any, *, is_polished: bool = False) -> Any:
        assert is_polished == (Solved.kept is not None)
        return point

    def judgement_of(point: Any, _: Any) -> Outcome:
        judged.append(point.name)
        return found

    for name, value in of.items():
        monkeypatch.setattr(Solved, name, value)
    monkeypatch.setattr(steps, "Rounds", Solved)
    monkeypatch.setattr(one, "_polished", polished)
    monkeypatch.setattr(one, "_judged", judgement_of)
    outcome = one._solved("a step", one.formulation, None)
    assert (outcome.point, outcome.judgement) == (found.point, found.judgement)
    assert outcome.kept == (None if Solved.raised else Solved.kept)
    return one, judged


def test_what_was_kept_of_a_step_that_was_ended_early_is_not_polished_again(monkeypatch: pytest.MonkeyPatch) -> None:
    solved(monkeypatch, STALLED, attempts=(Attempt("a step", "m", Ending.GIVEN_UP),), kept="it is the seed")


def test_the_last_run_of_a_step_tells_what_it_came_to(monkeypatch: pytest.MonkeyPatch) -> None:
    runs = (Attempt("a step", "m", Ending.INVALID_NUMBER), Attempt("a step", "m", Ending.LIMIT))
    for found, said in ((SOLVED, "certified and converged"), (STALLED, "it is not stationary")):
        one, judged = solved(monkeypatch, found, attempts=runs)
        assert [(attempt.ended, attempt.outcome) for attempt in one.attempts] == [
            (Ending.INVALID_NUMBER, None),
            (Ending.LIMIT, said),
        ]
        assert one.not_a_number is None
        assert judged == ["the end"]


@pytest.mark.parametrize("runs", [(), (Attempt("a step", "m", Ending.LIMIT), Attempt("", "", Ending.INVALID_NUMBER))])
def test_a_solve_that_met_no_number_says_where(runs: tuple[Attempt, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    one, _ = solved(monkeypatch, STALLED, attempts=runs)
    assert one.not_a_number == ("fit", "vertex 3")
    assert one.attempts[-1].ended == Ending.INVALID_NUMBER
    assert one.attempts[-1].outcome == "it is not stationary"


def test_a_solve_that_raises_comes_to_its_best_iterate(monkeypatch: pytest.MonkeyPatch) -> None:
    runs = (Attempt("a step", "m", Ending.LIMIT),)
    one, judged = solved(monkeypatch, STALLED, attempts=runs, raised=ZeroDivisionError("by zero"))
    assert judged == ["the best iterate"]
    assert one.failure == ("a step", "ZeroDivisionError: by zero")
    assert [attempt.ended for attempt in one.attempts] == [Ending.LIMIT, "ZeroDivisionError: by zero"]


@pytest.mark.parametrize("not_a_number", [None, ("fit", "vertex 3")])
def test_what_has_a_number_is_polished_before_it_is_judged(not_a_number: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    one = policy()
    one.not_a_number = not_a_number
    model: Any = one.formulation.goal.model
    model.design = lambda variables: f"design of {variables}"
    formulation: Any = one.formulation
    formulation.free_range = None
    for name in ("polish", "balanced"):
        monkeypatch.setattr(steps, name, lambda at, name=name: SimpleNamespace(variables=f"{at.variables}, {name}"))
    monkeypatch.setattr(steps.fold_file, "frame", lambda design: design)
    monkeypatch.setattr(steps, "check_frame", lambda frame: f"certificate of {frame}")
    monkeypatch.setattr(verdict, "range_faults", lambda *_: ())
    monkeypatch.setattr(verdict, "judge", lambda at, *_: f"judgement on {at.variables}")
    point: Any = SimpleNamespace(variables="x")
    found = one._outcome(point)
    expected = "x, polish, balanced" if not_a_number is None else "x"
    assert found.design == f"design of {expected}"
    assert found.certificate == f"certificate of design of {expected}"
    assert found.judgement == f"judgement on {expected}"
    kept = one._polished(point, is_polished=True)
    assert kept.variables == ("x, balanced" if not_a_number is None else "x")


# ---- a path of flatter targets


def path(monkeypatch: pytest.MonkeyPatch, reachable: float, stop: bool = False) -> tuple[list[float], Policy, Any]:
    """The shares that were tried where steps of at most ``reachable`` succeed, and what came of it."""
    tried: list[float] = []
    at, one = [0.0], policy()

    def solved(name: str, on_the_way: Any, _: Any) -> Outcome:
        share = 1.0 if on_the_way is one.formulation else on_the_way
        assert name == f"path, {share:.3g} of the target"
        tried.append(share)
        if stop:
            one.control.stop.set()
        if share - at[0] > reachable:
            return STALLED
        at[0] = share
        return SOLVED

    def flatter(_: Any, share: float, __: Any) -> float:
        assert share < 1  # the whole target is what the solve is about
        return share

    monkeypatch.setattr(one, "_solved", solved)
    monkeypatch.setattr(one, "_outcome", lambda point: ("the last design", point))
    monkeypatch.setattr(steps, "formulate", flatter)
    monkeypatch.setattr(steps, "Rounds", lambda *given: SimpleNamespace(unsolved=lambda: given[-1]))
    return tried, one, one._along_a_path(STALLED)


def test_steps_of_the_path_double_while_they_succeed_and_halve_where_they_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    tried, one, found = path(monkeypatch, 1.0)
    assert (tried, one.reached, found) == ([0.25, 0.75, 1.0], 1.0, SOLVED)
    tried, one, found = path(monkeypatch, 0.3)
    assert (tried, one.reached, found) == ([0.25, 0.75, 0.5, 1.0, 0.75, 1.0], 1.0, SOLVED)


def test_the_path_ends_where_an_eighth_is_too_far(monkeypatch: pytest.MonkeyPatch) -> None:
    tried, one, found = path(monkeypatch, 0.1)
    assert (tried, one.reached, found) == ([0.25, 0.125], 0.0, None)


def test_the_last_design_of_a_path_is_one_for_the_whole_target(monkeypatch: pytest.MonkeyPatch) -> None:
    tried, one, found = path(monkeypatch, 1.0, stop=True)  # after the first step
    assert (tried, one.reached) == ([0.25], 0.25)
    assert found[0] == "the last design"
    assert found[1] is SOLVED.point.variables


# ---- the other solver


def by_nlopt(monkeypatch: pytest.MonkeyPatch, one: Policy, best: Outcome) -> Any:
    monkeypatch.setattr(one, "_solved", lambda *given, **named: (given, named))
    return one._by_nlopt(best)


def test_nlopt_starts_from_the_best_where_that_is_feasible_else_from_the_seed(monkeypatch: pytest.MonkeyPatch) -> None:
    one = policy()
    one.attempts = attempts(Ending.INFEASIBLE, Ending.LIMIT)
    (step, _, start), named = by_nlopt(monkeypatch, one, STALLED)
    assert (step, named) == ("nlopt", {"method": "nlopt"})
    assert start is STALLED.point.variables
    (_, _, start), _ = by_nlopt(monkeypatch, one, outcome(failed=("no",), violation=1e-3))
    assert start is None


def test_nlopt_is_not_tried_where_it_has_no_chance(monkeypatch: pytest.MonkeyPatch) -> None:
    assert by_nlopt(monkeypatch, policy("nlopt"), STALLED) is None
    contradictory = policy()
    contradictory.attempts = attempts(Ending.INFEASIBLE, Ending.INFEASIBLE)
    assert by_nlopt(monkeypatch, contradictory, STALLED) is None
    one = policy()
    one.attempts = attempts(Ending.LIMIT)
    largest = steps.NLOPT_LARGEST
    assert by_nlopt(monkeypatch, one, outcome(failed=("no",), n=largest)) is not None
    assert by_nlopt(monkeypatch, one, outcome(failed=("no",), n=largest + 1)) is None


# ---- at last at least the constraints


@pytest.mark.parametrize(("certified", "violation"), [(False, 0.0), (True, 1e-3), (True, 0.0)])
@pytest.mark.parametrize("found", ["a design", None])
def test_what_is_not_within_its_constraints_is_brought_there(
    certified: bool, violation: float, found: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    wishes = []

    def moved(point: Any, wish: Any) -> str | None:
        wishes.append(wish)
        return found

    one = policy()
    monkeypatch.setattr(steps, "Projection", lambda: SimpleNamespace(moved=moved))
    monkeypatch.setattr(one, "_outcome", lambda point: f"{point}, judged")
    restored: Any = one._restored(outcome(certified=certified, violation=violation, failed=("no",)))
    ended = [attempt.ended for attempt in one.attempts]
    if certified and violation == 0:
        assert (restored, ended, wishes) == (None, [], [])
        return
    assert not np.any(wishes)
    if found is None:
        assert (restored, ended) == (None, ["no design found near by"])
    else:
        assert (restored, ended) == ("a design, judged", ["within the constraints"])


# ---- a coarser grid


class Coarser:
    """Rounds on a coarser grid that end in a point of a given violation."""

    violation = 0.0

    def __init__(self, *_: Any, **__: Any) -> None:
        self.attempts = [Attempt("coarser grid", "m", "ended")]

    def run(self) -> Any:
        return SimpleNamespace(violation=self.violation, variables=None)


def from_coarse(monkeypatch: pytest.MonkeyPatch, one: Policy, violation: float = 0.0) -> Any:
    grid = SimpleNamespace(grid=(2, 2))
    coarser = SimpleNamespace(
        goal=SimpleNamespace(model=SimpleNamespace(seed=None, pattern=grid, points=lambda _: None))
    )
    tasks = iter(["coarse", None])
    monkeypatch.setattr(steps.coarse, "coarsened", lambda _: next(tasks))
    monkeypatch.setattr(steps.coarse, "spread", lambda *_: "spread")
    monkeypatch.setattr(steps, "formulate", lambda *_, **__: coarser)
    monkeypatch.setattr(steps, "Rounds", Coarser)
    monkeypatch.setattr(Coarser, "violation", violation)
    return one._from_coarse(one.loaded, one.formulation.goal)


def test_a_coarser_grid_gives_the_start_where_it_came_near(monkeypatch: pytest.MonkeyPatch) -> None:
    one = policy()
    assert from_coarse(monkeypatch, one, NEAR) == "spread"
    assert [attempt.step for attempt in one.attempts] == ["coarser grid"]
    assert from_coarse(monkeypatch, policy(), 1.01 * NEAR) is None


def test_a_coarser_grid_is_not_begun_after_a_stop_or_for_a_given_design(monkeypatch: pytest.MonkeyPatch) -> None:
    stopped, given = policy(), policy()
    stopped.control.stop.set()
    assert from_coarse(monkeypatch, stopped) is None
    seed: Any = "a design"
    given.formulation.given.design = seed
    assert from_coarse(monkeypatch, given) is None
    assert given.attempts == []


def test_terms_that_know_only_the_fine_grid_start_from_the_seed(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: Any, **__: Any) -> None:
        raise InputError("48 vertices are wanted")

    monkeypatch.setattr(steps.coarse, "coarsened", lambda _: "coarse")
    monkeypatch.setattr(steps, "formulate", refused)
    one = policy()
    assert one._from_coarse(one.loaded, one.formulation.goal) is None
