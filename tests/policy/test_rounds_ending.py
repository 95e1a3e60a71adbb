"""When rounds end and what follows a round, with the rounds themselves replaced: no solver runs here."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from inverse.policy import rounds as module
from inverse.policy import verdict
from inverse.policy.best import Kept
from inverse.policy.control import Control
from inverse.policy.following import Following, _ahead
from inverse.policy.rounds import MAX_ROUNDS, SETTLED, SPACING, Rounds
from inverse.solvers.run import Ending, Run

QUARTER = np.pi / 2
SEED, START = np.zeros(3), np.ones(3)


@dataclass(frozen=True)
class At:
    """Where a round begins or ends."""

    variables: Any = field(default_factory=lambda: SEED, compare=False)
    problem: Any = field(default_factory=lambda: SimpleNamespace(n_rows=4, parameters=lambda: None), compare=False)
    not_a_number: Any = None
    multipliers: Any = None
    objective: float = 2.0
    violation: float = 0.0
    said: str = ""

    def moved(self, variables: Any) -> At:
        return replace(self, variables=variables)

    def pushed(self, multipliers: Any) -> At:
        return replace(self, multipliers=multipliers)


def made(start: Any = None, *, exact: bool = False, kinks: bool = False, free_range: Any = None) -> Rounds:
    model = SimpleNamespace(
        pattern=SimpleNamespace(faces_vertices=[[0, 1, 2]]), points=lambda x: x, whole=lambda x: ("design", x)
    )
    fitting = SimpleNamespace(is_exact=exact, distances=lambda points: np.array([3.0, 4.0]) * (1 + points[0]))
    goal = SimpleNamespace(model=model, fitting=fitting, target=SimpleNamespace(has_kinks=kinks), seed_variables=SEED)
    formulation: Any = SimpleNamespace(goal=goal, sliding=[], free_range=free_range)
    options: Any = SimpleNamespace(max_iterations=10, tolerance=1e-8)
    return Rounds(formulation, options, Control(math.inf), "ipopt", start)


# ---- facets kept apart


class Apart:
    """Rounds of which each ends with the next of some crossings; remembers what was kept apart."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *crossings: dict[float, set[tuple[int, int]]]) -> None:
        self.rounds, self.asked = made(START), []
        self.starts: list[Any] = []
        left = iter(crossings)

        def fitted(start: Any, extra: list[Any]) -> At:
            self.starts.append(start)
            self.asked.append(extra)
            return At(said=f"point {len(self.asked)}")

        def in_state(_: Any, pairs: Any, t: float) -> list[Any]:
            return [(t, *pair) for pair in pairs.tolist()]

        monkeypatch.setattr(self.rounds, "_fitted", fitted)
        monkeypatch.setattr(self.rounds, "_crossing", lambda _: next(left))
        monkeypatch.setattr(module.separation, "in_state", in_state)
        monkeypatch.setattr(module.separation, "in_design", lambda _, pairs: pairs.tolist())

    def run(self) -> str:
        found: Any = self.rounds.run()
        return str(found.said)


def test_what_crossed_is_kept_apart_from_then_on_and_the_seed_is_the_start(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = Apart(monkeypatch, {QUARTER: {(2, 3)}}, {QUARTER: {(0, 1)}}, {2.0: {(4, 5)}, 2.5: {(6, 7)}}, {})
    assert tried.run() == "point 4"
    both = [[0, 1], [2, 3]]
    assert tried.asked == [[], [[[2, 3]]], [both], [both, (2.0, 4, 5), (2.5, 6, 7)]]
    assert tried.starts[0] is START
    assert tried.starts[1:] == [None] * 3


def test_what_crosses_though_kept_apart_ends_the_rounds(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = Apart(monkeypatch, {QUARTER: {(0, 1), (2, 3)}}, {QUARTER: {(2, 3)}})
    assert tried.run() == "point 2"


def test_facets_that_no_plane_separates_are_not_kept_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = Apart(monkeypatch, {QUARTER: {(0, 1)}}, {})
    monkeypatch.setattr(module.separation, "in_design", lambda *_: None)
    tried.run()
    assert tried.asked == [[], []]


@pytest.mark.parametrize(("number", "rounds"), [(MAX_ROUNDS, 1), (MAX_ROUNDS - 1, 2)])
def test_after_the_last_round_nothing_is_solved_again(
    number: int, rounds: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried = Apart(monkeypatch, {QUARTER: {(0, 1)}}, {})
    tried.rounds.runs.round = number
    assert tried.run() == f"point {rounds}"


def test_a_stop_ends_the_rounds(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = Apart(monkeypatch, {QUARTER: {(0, 1)}}, {})
    tried.rounds.control.stop.set()
    assert tried.run() == "point 1"


# ---- which facets cross


def crossing(monkeypatch: pytest.MonkeyPatch, crosses: Any, free_range: Any) -> tuple[Any, list[Any]]:
    """What is found where facets cross in the states t that ``crosses`` says; and the states that were looked at."""
    looked: list[Any] = []

    def fold(design: Any, states: Any) -> Any:
        assert design == ("design", QUARTER)
        looked.append(states)
        return SimpleNamespace(vertices_coords=states)

    monkeypatch.setattr(module.folding, "fold", fold)
    monkeypatch.setattr(
        module, "crossing_facets", lambda t, _: np.array([[0, round(100 * t)]] if crosses(t) else np.empty((0, 2)), int)
    )
    monkeypatch.setattr(module, "alike", lambda _, pairs: np.concatenate([pairs, pairs + 1]))
    one: Any = made(free_range=free_range)
    return one._crossing(QUARTER), looked


RANGE = (0.5, 2.6)


def test_what_crosses_in_the_design_state_comes_first(monkeypatch: pytest.MonkeyPatch) -> None:
    for free_range in (RANGE, None):
        found, looked = crossing(monkeypatch, lambda _: True, free_range)
        assert found == {QUARTER: {(0, 157), (1, 158)}}
        assert not looked


def test_without_an_asked_range_no_other_state_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    assert crossing(monkeypatch, lambda t: t != QUARTER, None) == ({}, [])


def test_an_asked_range_is_looked_at_to_both_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    found, looked = crossing(monkeypatch, lambda _: False, RANGE)
    assert found == {}
    for states, end in zip(looked, RANGE, strict=True):
        assert states[-1] == pytest.approx(end, abs=1e-15)
        steps = np.abs(np.diff([QUARTER, *states]))
        assert steps.max() <= SPACING
        assert steps.min() > 0.9 * SPACING


def test_of_states_that_cross_the_first_and_the_last_are_kept_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    found, (down, up) = crossing(monkeypatch, lambda t: t > 2.0 or t < 1.0, RANGE)
    states = [down[down < 1.0][0], down[-1], up[up > 2.0][0], up[-1]]
    assert found == {t: {(0, round(100 * t))} for t in states}


def test_one_state_that_crosses_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    found, _ = crossing(monkeypatch, lambda t: t > 2.59, RANGE)
    assert list(found) == [pytest.approx(2.6)]


# ---- when rounds have settled


@dataclass(frozen=True)
class Anchor:
    """A sliding anchor on a segment; it moves on along a list of them."""

    segment: int
    onward: tuple[int, ...] = ()

    @property
    def segments(self) -> Any:
        return np.array([self.segment])

    def moved_on(self, _: Any) -> Anchor:
        return Anchor(self.onward[0], self.onward[1:]) if self.onward else self


class Fitted:
    """Rounds that end in points of given stationarities and fits."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, gradients: list[float], **given: Any) -> None:
        self.rounds, self.seeds = made(given.pop("start", None), **given), []
        self.problems: list[list[int]] = []
        self.crosses, self.fits = False, [1.0 / (k + 1) for k in range(MAX_ROUNDS)]
        self.ending = Ending.SOLVED

        def problem(sliding: list[Anchor], extra: list[Any]) -> tuple[Any, Any]:
            assert extra == ["extra"]
            self.problems.append([anchor.segment for anchor in sliding])
            return At().problem, "a solver"

        def one_round(_: Any, at: At, *, is_seed: bool, is_spread: bool) -> tuple[Run, float]:
            self.seeds.append(is_seed)
            self.rounds.runs.round += 1
            k = len(self.seeds)
            end: Any = replace(at, variables=np.full(3, float(k)), said=f"round {k}")
            return Run(end, self.ending, 1, 0.0, 0.0, ""), self.fits[k - 1]

        def stationarity(at: At, _: Any) -> float:
            return gradients[int(at.said.split()[1]) - 1]

        monkeypatch.setattr(self.rounds, "_problem", problem)
        monkeypatch.setattr(self.rounds, "_one_round", one_round)
        monkeypatch.setattr(module, "_refreshed", lambda _, at, points: at)
        monkeypatch.setattr(module, "Point", lambda _, variables, __: At(variables))
        monkeypatch.setattr(verdict, "stationarity", stationarity)
        monkeypatch.setattr(module, "crossing_facets", lambda *_: [(0, 1)] if self.crosses else [])

    def run(self) -> str:
        extra: Any = ["extra"]
        found: Any = self.rounds._fitted(self.rounds.start, extra)
        return str(found.said)


ENOUGH, MORE = 0.99 * SETTLED * verdict.STATIONARITY, 1.01 * SETTLED * verdict.STATIONARITY


def test_rounds_end_when_closest_points_have_settled(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = Fitted(monkeypatch, [1.0, MORE, ENOUGH, 0.0])
    assert tried.run() == "round 3"
    assert tried.seeds == [True, False, False]
    tried = Fitted(monkeypatch, [ENOUGH], start=START)
    assert tried.run() == "round 1"
    assert tried.seeds == [False]


def test_closest_points_follow_the_rounds(monkeypatch: pytest.MonkeyPatch) -> None:
    """Taken at the end of each round, to see whether they have settled, and where they are aimed at before the next."""
    for start, taken in ((None, [1, 1, 2, 2, 3]), (START, [1, 1, 1, 2, 1.5, 3])):
        tried = Fitted(monkeypatch, [1.0, 1.0, 0.0], start=start)
        points: list[float] = []

        def refreshed(_: Any, at: At, at_points: Any, points: list[float] = points) -> At:
            points.append(at_points[0])
            return at

        monkeypatch.setattr(module, "_refreshed", refreshed)
        tried.run()
        assert points == taken


def test_without_closest_points_one_round_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    assert Fitted(monkeypatch, [1.0], exact=True).run() == "round 1"


def test_rounds_end_where_facets_cross(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = Fitted(monkeypatch, [1.0, 1.0])
    tried.crosses = True
    assert tried.run() == "round 1"


def test_rounds_end_where_a_term_has_no_number_or_on_a_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = Fitted(monkeypatch, [1.0, 1.0])
    tried.ending = Ending.INVALID_NUMBER
    assert tried.run() == "round 1"
    tried = Fitted(monkeypatch, [1.0, 1.0])
    monkeypatch.setattr(tried.rounds.runs, "ends", lambda _: True)
    assert tried.run() == "round 1"


def test_after_a_stop_no_round_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = Fitted(monkeypatch, [1.0, 1.0])
    monkeypatch.setattr(tried.rounds.runs.best, "kept", lambda at: Kept(replace(at, said="kept"), "it is the seed"))
    tried.rounds.control.stop.set()
    assert tried.run() == "kept"
    assert tried.rounds.kept == "it is the seed"
    assert tried.seeds == []
    assert [attempt.ended for attempt in tried.rounds.attempts] == [Ending.GIVEN_UP]


def test_there_is_a_last_round(monkeypatch: pytest.MonkeyPatch) -> None:
    assert Fitted(monkeypatch, [1.0] * (MAX_ROUNDS + 1)).run() == f"round {MAX_ROUNDS}"


def test_segments_that_change_make_a_new_problem_until_they_come_again(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = Fitted(monkeypatch, [0.0] * 5)
    formulation: Any = tried.rounds.formulation
    formulation.sliding = [Anchor(0, (1, 0))]
    assert tried.run() == "round 2"
    assert tried.problems == [[0], [1]]


@pytest.mark.parametrize(
    ("fits", "rounds", "best"),
    [
        # Rounds 4 and 5 together gain 2.5 %, rounds 5 and 6 0.6 %.
        ([4.0, 2.0, 1.0, 0.98, 0.975, 0.974], 6, 6),
        ([1.0, 0.9, 0.95, 1.2], 4, 2),
        # Four rounds are the least that are compared.
        ([1.0, 1.0, 1.0, 0.5, 0.5, 0.498], 6, 6),
        # The better of two counts, and the best of those before.
        ([1.0, 1.0, 0.5, 1.0, 0.7], 5, 3),
    ],
)
def test_rounds_to_and_fro_between_facets_of_a_target_end_with_the_best(
    fits: list[float], rounds: int, best: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried = Fitted(monkeypatch, [1.0] * 9, kinks=True)
    tried.fits = [*fits, 0.1, 0.01]
    assert tried.run() == f"round {best}"
    assert len(tried.seeds) == rounds


def test_on_a_smooth_target_rounds_are_never_to_and_fro(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = Fitted(monkeypatch, [1.0] * 8 + [0.0])
    tried.fits = [1.0] * 9
    assert tried.run() == "round 9"


def test_a_start_without_a_number_is_told_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    tried = Fitted(monkeypatch, [0.0])
    monkeypatch.setattr(tried.rounds, "_beginning", lambda *_: At(not_a_number=("fit", "vertex 3"), said="the start"))
    assert tried.run() == "the start"
    assert tried.seeds == []


# ---- where rounds begin and end


@pytest.mark.parametrize(("size", "kept"), [(4, True), (5, False), (None, False)])
def test_multipliers_of_other_constraints_are_forgotten(
    size: int | None, kept: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "Point", lambda problem, variables, _: At(variables, problem))
    one: Any = made(START)
    one.multipliers = None if size is None else np.zeros(size)
    at = one._beginning(At().problem, START)
    assert at.variables is START
    assert (at.multipliers is not None) is kept
    assert one.runs.best.feasible is SEED  # who stops early gets nothing worse
    assert one._beginning(At().problem, None).variables is SEED


def test_a_start_without_a_number_has_no_best(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "Point", lambda problem, variables, _: At(variables, problem, ("fit", "vertex 3")))
    one: Any = made(START)
    one._beginning(At().problem, START)
    assert one.runs.best.feasible is None


@pytest.mark.parametrize("stopped", [False, True])
def test_a_round_that_was_stopped_ends_at_the_best(stopped: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    one: Any = made()
    two = [Run(At(said=said), Ending.LIMIT, 3, 0.0, 0.0, "static pivots") for said in ("first", "last")]  # type: ignore[arg-type]
    monkeypatch.setattr(one.runs, "one_round", lambda *_, **__: two)
    kept = lambda end: Kept(replace(end, variables=START, said="kept"), "it is iteration 3")  # noqa: E731
    monkeypatch.setattr(one.runs.best, "kept", kept)
    if stopped:
        one.control.stop.set()
    run, rms = one._one_round("a solver", At(), is_seed=True, is_spread=False)
    assert run.end.said == ("kept" if stopped else "last")
    assert one.kept == ("it is iteration 3" if stopped else None)
    assert rms is None  # it is asked for on targets with kinks only
    assert {attempt.round for attempt in one.attempts} == {one.runs.round} == {1}
    one.formulation.goal.target.has_kinks = True
    _, rms = one._one_round("a solver", At(), is_seed=True, is_spread=False)
    assert rms == pytest.approx(np.sqrt(12.5) * (2 if stopped else 1))
    assert one.attempts[-1].fit_rms == rms


def test_where_rounds_broke_off_the_best_iterate_is_kept_else_the_start(monkeypatch: pytest.MonkeyPatch) -> None:
    for start, expected in ((None, SEED), (START, START)):
        one: Any = made(start)
        monkeypatch.setattr(one, "_untouched", lambda x: x)
        assert one.abandoned() is expected
        best = np.full(3, 5.0)
        one.runs.best.begin(best, 0.0, 0.0, "a start")
        assert one.abandoned() is best
        assert one.unsolved() is expected


# ---- where closest points are taken


def test_the_line_through_two_rounds_leads_on() -> None:
    """Changes that halve from round to round go as far again; one that turns is cut; none leaps."""
    here, change = np.full(3, 6.0), np.full(3, 1.0)
    before = np.full(3, 4.0), np.full(3, 2.0)
    assert _ahead((here, change), None) is here
    np.testing.assert_allclose(_ahead((here, change), before), 8.0)  # share -1
    np.testing.assert_allclose(_ahead((here, -change), before), 6 - 2 / 3)  # share 1/3
    np.testing.assert_allclose(_ahead((here, 1.9 * change), before), 10.0)  # share -19, at most -2
    np.testing.assert_allclose(_ahead((here, -9 * change), before), 5.0)  # share 9/11, at most 1/2
    np.testing.assert_allclose(_ahead((here, before[1]), before), 6.0)  # no turn: no line


def test_on_a_target_with_kinks_closest_points_are_those_of_the_last_round() -> None:
    for kinks, expected in ((True, 6.0), (False, 8.0)):
        following = Following(made(kinks=kinks).formulation.goal, np.full(3, 2.0))
        following.go_on(np.full(3, 4.0))  # 2 on from where it aimed
        np.testing.assert_array_equal(following.aim, 4.0)
        following.aim = np.full(3, 5.0)
        following.go_on(np.full(3, 6.0))  # 1 on
        np.testing.assert_allclose(following.aim, expected)
