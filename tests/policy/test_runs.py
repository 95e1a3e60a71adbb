"""The runs of one round with solvers that end as told: which method follows which, from where, and what is kept."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from inverse.policy import runs as module
from inverse.policy import verdict
from inverse.policy.control import Control
from inverse.policy.runs import TOO_FAR, Runs
from inverse.solvers.feasibility import Least
from inverse.solvers.ipopt import APPROACHING, EASED, NEAR, STATIC
from inverse.solvers.run import Ending, Progress, Run
from inverse.solvers.slsqp import Slsqp

PIVOTED = "pivoting"


PLAIN = SimpleNamespace(has_passive_variables=False, has_redundant_equations=False)


@dataclass(frozen=True)
class At:
    """A point by its name: the run that came there."""

    name: str = "the start"
    violation: float = 1.0
    multipliers: Any = None
    problem: Any = field(default_factory=lambda: PLAIN)
    objective: float = 4.0
    variables: Any = field(default_factory=lambda: np.zeros(2), compare=False)

    def pushed(self, multipliers: Any) -> At:
        return replace(self, multipliers=multipliers)

    def moved(self, variables: Any) -> At:
        return replace(self, variables=variables)


@dataclass
class Told:
    """A solver whose runs end as told, by method: (ending, violation, iterations); else they find a solution."""

    name: str
    calls: list[str]
    ends: dict[str, tuple[Ending, float, int]] = field(default_factory=dict)
    limits: list[int] = field(default_factory=list)

    def approach(self, at: At, limit: int, *, is_good: bool, is_spread: bool = False) -> Any:
        self.limits.append(limit)
        start = " of a spread start" if is_spread else " of a good start" if is_good else ""
        return self._ended(APPROACHING + start, APPROACHING, at)

    def ease(self, at: At, limit: int) -> Any:
        self.limits.append(limit)
        return self._ended(EASED, EASED, at)

    def run(self, at: At, limit: int, *, careful: bool) -> Any:
        self.limits.append(limit)
        return self._ended(PIVOTED if careful else STATIC, PIVOTED if careful else STATIC, at)

    def _ended(self, said: str, method: str, at: At) -> Any:
        self.calls.append(f"{self.name}: {said} from {at.name}")
        usual = Ending.SETTLED if method in (APPROACHING, EASED) else Ending.SOLVED
        ending, violation, iterations = self.ends.get(method, (usual, 0.0, 1))
        end: Any = At(f"{method} {self.name}", violation, "its multipliers")
        return Run(end, ending, iterations, 0.0, 0.0, method)


def made(limit: int = 100, watch: Any = None) -> Runs:
    model = SimpleNamespace(pattern=SimpleNamespace(faces_vertices=[[0, 1, 2]]), points=lambda x: x)
    goal: Any = SimpleNamespace(model=model, packed=())
    options: Any = SimpleNamespace(max_iterations=limit, tolerance=1e-7)
    return Runs(goal, options, Control(math.inf, watch), "ipopt")


class Round:
    """One round of a solver and one without idle bounds."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, limit: int = 100) -> None:
        self.calls: list[str] = []
        self.whole, self.light = Told("whole", self.calls), Told("light", self.calls)
        self.relaxed_at: list[str] = []
        self.runs = made(limit)

        def relaxed(at: At) -> Told:
            self.relaxed_at.append(at.name)
            return self.light

        monkeypatch.setattr(self.runs, "_is_settled", lambda _: False)
        monkeypatch.setattr(self.runs, "_light", relaxed)

    def go(self, start: Any = None, *, is_seed: bool = False, is_spread: bool = False) -> list[Run]:
        solver: Any = self.whole
        return self.runs.one_round(solver, At() if start is None else start, is_seed=is_seed, is_spread=is_spread)


@pytest.fixture
def one(monkeypatch: pytest.MonkeyPatch) -> Round:
    return Round(monkeypatch)


def test_a_coarser_grids_design_is_come_near_to_in_two_ways(one: Round) -> None:
    one.go(is_spread=True)
    assert one.calls == [
        f"light: {APPROACHING} of a spread start from the start",
        f"light: {EASED} from {APPROACHING} light",
        f"light: {STATIC} from {EASED} light",
    ]


def test_what_fails_with_a_part_of_the_curvature_is_left_out(one: Round) -> None:
    one.whole.ends = one.light.ends = {EASED: (Ending.GIVEN_UP, 1.0, 3)}
    one.go(is_spread=True)
    assert one.calls[-1] == f"light: {STATIC} from {APPROACHING} light"


def test_a_good_start_needs_no_idle_bounds(one: Round) -> None:
    found = one.go()
    assert one.calls == [
        f"light: {APPROACHING} of a good start from the start",
        f"light: {STATIC} from {APPROACHING} light",
    ]
    assert [run.method for run in found] == [APPROACHING, STATIC]
    assert one.relaxed_at == ["the start"]


def test_from_the_seed_idle_bounds_are_left_out_when_it_came_near(one: Round) -> None:
    one.go(is_seed=True)
    assert one.calls == [f"whole: {APPROACHING} from the start", f"light: {STATIC} from {APPROACHING} whole"]
    assert one.relaxed_at == [f"{APPROACHING} whole"]


@pytest.mark.parametrize("end", [(Ending.GIVEN_UP, 0.0, 1), (Ending.LIMIT, 1.01 * NEAR, 1)])
def test_what_goes_wrong_without_idle_bounds_is_done_again_with_them(end: Any, one: Round) -> None:
    one.light.ends[APPROACHING] = end
    one.go()
    assert one.calls == [
        f"light: {APPROACHING} of a good start from the start",
        f"whole: {APPROACHING} of a good start from the start",
        f"light: {STATIC} from {APPROACHING} whole",
    ]
    assert one.relaxed_at == ["the start", f"{APPROACHING} whole"]


def test_static_pivots_too_are_done_again_with_idle_bounds(one: Round) -> None:
    """After them there is no use for a solver without."""
    one.light.ends[STATIC] = (Ending.GIVEN_UP, 0.0, 1)
    one.whole.ends[STATIC] = (Ending.NO_STEP, 0.0, 1)
    one.go()
    assert one.calls[1:] == [
        f"light: {STATIC} from {APPROACHING} light",
        f"whole: {STATIC} from {APPROACHING} light",
        f"whole: {PIVOTED} from {STATIC} whole",
    ]
    assert one.relaxed_at == ["the start"]


def test_what_came_near_is_gone_on_from(one: Round) -> None:
    """A limit that was reached within what is called near; then static pivots that stall go on with pivoting."""
    one.light.ends = {APPROACHING: (Ending.LIMIT, NEAR, 1), STATIC: (Ending.NO_STEP, NEAR, 1)}
    one.go()
    assert one.calls[1:] == [
        f"light: {STATIC} from {APPROACHING} light",
        f"whole: {PIVOTED} from {STATIC} light",
    ]


def test_where_nothing_came_near_exact_steps_begin_at_the_start(one: Round) -> None:
    far = (Ending.LIMIT, 1.01 * NEAR, 1)
    one.whole.ends = one.light.ends = {APPROACHING: far, STATIC: far}
    one.go()
    assert one.calls[2:] == [f"whole: {STATIC} from the start", f"whole: {PIVOTED} from the start"]


def test_a_solution_ends_a_round_if_it_holds_its_bounds(one: Round) -> None:
    one.light.ends[STATIC] = (Ending.SOLVED, verdict.BOUND, 1)
    assert len(one.go()) == 2
    one.light.ends[STATIC] = (Ending.SOLVED, 1.01 * verdict.BOUND, 1)
    assert [run.method for run in one.go()] == [APPROACHING, STATIC, PIVOTED]


def test_a_round_ends_with_its_iterations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten in all: four to come near, then six, of which the last run takes all or leaves one."""
    for taken, count in ((6, 2), (5, 3)):
        one = Round(monkeypatch, limit=10)
        one.light.ends = {APPROACHING: (Ending.SETTLED, 0.0, 4), STATIC: (Ending.NO_STEP, 0.0, taken)}
        assert len(one.go()) == count
        assert one.light.limits == [10, 6]
        assert one.whole.limits == [1] * (count - 2)


def test_a_round_ends_when_stopped_or_without_a_number(one: Round) -> None:
    one.light.ends[APPROACHING] = (Ending.INVALID_NUMBER, 0.0, 1)
    assert len(one.go()) == 1
    one.light.ends = {}
    one.runs.control.stop.set()
    assert len(one.go()) == 1


def test_equations_that_hold_show_which_are_redundant(one: Round, monkeypatch: pytest.MonkeyPatch) -> None:
    problem = SimpleNamespace(has_passive_variables=False, has_redundant_equations=True)
    monkeypatch.setattr(module, "polish", lambda at: replace(at, name=f"polished {at.name}"))
    one.light.ends[STATIC] = (Ending.NO_STEP, 0.0, 1)
    one.go(At(problem=problem))
    assert one.calls[1:] == [
        f"light: {STATIC} from polished {APPROACHING} light",
        f"whole: {PIVOTED} from {STATIC} light",
    ]


@pytest.mark.parametrize(
    ("passive", "multipliers", "methods"),
    [
        (False, None, (APPROACHING, STATIC)),
        (False, "some", (STATIC,)),
        (True, None, (STATIC,)),
        (True, "some", ()),
    ],
)
def test_methods_by_what_the_start_brings(passive: bool, multipliers: Any, methods: Any, one: Round) -> None:
    problem = SimpleNamespace(has_passive_variables=passive, has_redundant_equations=False)
    one.light.ends[STATIC] = (Ending.NO_STEP, 0.0, 1)
    found = one.go(At(problem=problem, multipliers=multipliers))
    assert tuple(run.method for run in found) == (*methods, PIVOTED)
    assert one.relaxed_at == (["the start"] if methods else [])


def test_the_other_solver_takes_all_iterations_at_once(one: Round) -> None:
    solver: Any = object.__new__(Slsqp)
    solver.run = lambda at, limit: (at.name, limit)
    given: Any = At()
    assert one.runs.one_round(solver, given, is_seed=True) == [("the start", 100)]


# ---- constraints that contradict each other


def contradictory(
    one: Round, monkeypatch: pytest.MonkeyPatch, *ends: tuple[float, bool], violation: float = 1.0
) -> Any:
    """A round that does not come near, where the least violation is found in ``ends``: squared, and settled."""
    one.whole.ends = one.light.ends = {APPROACHING: (Ending.LIMIT, 1.01 * NEAR, 30)}
    left, starts = iter(ends), []

    def least(at: At, _: Any) -> Least:
        squared, settled = next(left)
        starts.append(float(at.variables[0]))
        point: Any = At(f"least of {squared}")
        return Least(point, squared, settled)

    monkeypatch.setattr(module, "least_violation", least)
    goal: Any = one.runs.goal
    goal.seed_variables = np.ones(2)
    one.runs.may_contradict = True
    return one.go(At(violation=violation)), starts


def test_what_is_clearly_violated_wherever_it_is_looked_for_ends_the_round(
    one: Round, monkeypatch: pytest.MonkeyPatch
) -> None:
    found, starts = contradictory(one, monkeypatch, (0.9, True), (0.5, True), (0.7, True))
    assert found[-1].ending is Ending.INFEASIBLE
    assert found[-1].end.name == "the start"
    assert len(one.calls) == 2  # neither of them came near
    assert starts == [1.0, 0.7, 1.2]
    least: Any = one.runs.least
    assert least.name == "least of 0.5"
    assert one.runs.ends(found[-1])


@pytest.mark.parametrize("end", [(0.99 * module.CLEAR, True), (1.0, False)])
def test_what_may_be_met_is_tried_on(end: tuple[float, bool], one: Round, monkeypatch: pytest.MonkeyPatch) -> None:
    found, starts = contradictory(one, monkeypatch, (0.9, True), end)
    assert starts == [1.0, 0.7]
    assert found[-1].ending is Ending.SOLVED
    assert one.runs.least is None


def test_a_start_that_meets_all_constraints_shows_that_it_can_be_done(
    one: Round, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, starts = contradictory(one, monkeypatch, violation=verdict.BOUND)
    assert starts == []


# ---- starts that are the answer


@pytest.mark.parametrize(
    ("violation", "gradient", "settled"),
    [(verdict.EQUATION, 1e-7, True), (1.01 * verdict.EQUATION, 0.0, False), (0.0, 1.01e-7, False)],
)
def test_a_start_that_is_the_answer_stays(
    violation: float, gradient: float, settled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without its multipliers: nothing is to pull at it."""

    def stationarity(point: Any, _: Any) -> float:
        return 1.0 if point.multipliers is not None else gradient

    told: list[Progress] = []
    runs = made(watch=lambda _, progress: told.append(progress))
    monkeypatch.setattr(verdict, "stationarity", stationarity)
    solver: Any = Told("whole", [])
    monkeypatch.setattr(runs, "_light", lambda _: None)
    start: Any = At(violation=violation, multipliers="some")
    found = runs.one_round(solver, start, is_seed=False)
    assert (not solver.calls) == settled
    assert [progress.iteration for progress in told] == [0] * settled
    if settled:
        assert found[0].ending is Ending.SOLVED
        assert found[0].end.multipliers is None
        assert runs.best.feasible is start.variables


def iterate(violation: float, objective: float, k: float) -> Progress:
    return Progress(0, objective, violation, np.full(2, k))


# ---- runs without idle bounds


def reporter(monkeypatch: pytest.MonkeyPatch, violation: float, *, convex: bool) -> tuple[Callable[..., bool], Runs]:
    """What such a run tells its iterates to, where the whole problem has a given violation."""
    runs = made()
    monkeypatch.setattr(module, "relaxed", lambda _: SimpleNamespace(problem=None))
    monkeypatch.setattr(module.geometry, "are_convex", lambda *_: convex)
    monkeypatch.setattr(runs, "_ipopt", lambda _, report: report)
    monkeypatch.setattr(At, "moved", lambda at, _: replace(at, violation=violation))
    start: Any = At()
    light: Any = runs._light(start)
    return light.solver, runs


@pytest.mark.parametrize(
    ("violation", "convex", "goes_on"),
    [(TOO_FAR, True, True), (1.01 * TOO_FAR, True, False), (0.0, False, False), (0.0, True, True)],
)
def test_a_run_without_idle_bounds_is_given_up_where_it_leaves_them(
    violation: float, convex: bool, goes_on: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    report, runs = reporter(monkeypatch, violation, convex=convex)
    assert report(iterate(0.0, 1.0, 1)) is goes_on
    told = runs.best._nearest
    assert (None if told is None else told.violation) == (violation if convex else None)  # of all bounds


def test_a_stop_ends_a_run_without_idle_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    report, runs = reporter(monkeypatch, 0.0, convex=True)
    runs.control.stop.set()
    assert not report(iterate(0.0, 1.0, 1))


def test_where_few_bounds_are_idle_all_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "relaxed", lambda _: None)
    start: Any = At()
    assert made()._light(start) is None
