"""What is kept of a solve that is ended early: on a small dome, whose iterates are known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from designs import assert_close
from domes import PATTERNS, task

import inverse
from inverse.certify import check_frame
from inverse.files import fold_file
from inverse.formulation.formulate import formulate
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.policy import best as module
from inverse.policy import verdict
from inverse.policy.best import GAIN, LEVELS, SEED, BestSoFar, Kept
from inverse.solvers.run import Progress


class Dome:
    """A dome's problem, its seed, and the iterates of a solve."""

    def __init__(self, **keys: Any) -> None:
        loaded = task(**keys)
        self.told: list[Progress] = []
        self.result = inverse.solve(loaded, watch=lambda _, progress: self.told.append(progress))
        formulation = formulate(loaded)
        self.goal = formulation.goal
        terms = [*formulation.fixed, *(s.constraint(self.goal.model) for s in formulation.sliding)]
        problem = Problem(self.goal.n_variables, formulation.objectives, terms)
        self.seed = Point(problem, self.goal.seed_variables, problem.parameters())

    def begun(self) -> BestSoFar:
        """With the seed."""
        best = BestSoFar(self.goal)
        best.begin(self.seed.variables, self.seed.objective, self.seed.violation, SEED)
        return best

    def told_until(self, k: int) -> BestSoFar:
        """With the seed and the iterates up to one."""
        best = self.begun()
        for progress in self.told[: k + 1]:
            best.tell(progress)
        return best

    def is_certified(self, kept: Kept) -> bool:
        return check_frame(fold_file.frame(self.goal.model.design(kept.point.variables))).certified


@pytest.fixture(scope="module")
def dome() -> Dome:
    return Dome()


def test_whatever_the_iteration_a_certified_design_is_kept_that_is_better_than_the_seed(dome: Dome) -> None:
    rough = [k for k, progress in enumerate(dome.told) if progress.violation > 1e-3]
    assert len(rough) > 2  # most iterates are none that could be kept as they are
    for k in range(1, len(dome.told)):
        kept = dome.told_until(k).kept(dome.seed)
        assert kept.point.violation <= verdict.BOUND
        assert dome.is_certified(kept)
        lowest = min(progress.objective for progress in dome.told[1 : k + 1])
        assert kept.point.objective < max(0.5 * dome.seed.objective, 1.5 * lowest)
        assert kept.point.objective < 0.5 * dome.seed.objective


def test_without_an_iteration_it_is_still_the_seed_and_says_so(dome: Dome) -> None:
    kept = dome.begun().kept(dome.seed)
    assert_close(kept.point.variables, dome.seed.variables, 1e-9)
    assert kept.words == "it is still the placed seed, for no iteration had come to one that is better"
    assert BestSoFar(dome.goal).kept(dome.seed).words == "it is as it was, for there was no iteration yet"


def test_an_iterate_within_all_constraints_is_kept_as_it_is(dome: Dome) -> None:
    last = dome.told[-1]
    kept = dome.told_until(len(dome.told) - 1).kept(dome.seed)
    assert kept.words == f"it is iteration {last.iteration} of its run, which met all constraints"
    assert_close(kept.point.variables, last.variables, 1e-6)


def test_what_had_to_be_moved_is_told_with_how_far_in_the_files_unit(dome: Dome) -> None:
    k = next(k for k, progress in enumerate(dome.told) if progress.violation > 1e-3)
    kept = dome.told_until(k).kept(dome.seed)
    model = dome.goal.model
    far = np.linalg.norm(
        model.points(kept.point.variables) - model.points(dome.told[k].variables), axis=1
    ).max()  # fmt: skip
    said = f"it is iteration {dome.told[k].iteration} of its run, moved by up to {far:.2g} m by equation (9)"
    assert kept.words == f"{said} to meet all constraints"


def test_of_every_level_the_lowest_objective_is_remembered(dome: Dome) -> None:
    best = BestSoFar(dome.goal)
    x = dome.seed.variables
    for number, (violation, objective) in enumerate([(0.2, 1.0), (0.02, 2.0), (1e-3, 3.0), (0.0, 4.0), (0.1, 5.0)]):
        best.tell(Progress(number, objective, violation, x))
    assert [None if one is None else one.objective for one in best._levels] == [4.0, 4.0, 3.0, 2.0, 1.0, 1.0]
    assert list(LEVELS) == sorted(LEVELS)
    assert best.feasible is x


def test_what_promises_little_is_not_tried(dome: Dome, monkeypatch: pytest.MonkeyPatch) -> None:
    best = dome.begun()
    tried = []

    def brought(point: Point, iterate: Any) -> Kept | None:
        tried.append(iterate.violation)
        return Kept(point, "kept") if iterate.name == SEED else None

    monkeypatch.setattr(best, "_brought_within", brought)
    monkeypatch.setattr(best, "_towards", lambda found, *_: found)
    x = dome.seed.variables
    best.tell(Progress(1, 1.01 * GAIN * dome.seed.objective, 1e-3, x))
    best.tell(Progress(2, 0.99 * GAIN * dome.seed.objective, 1e-2, x))
    best.kept(dome.seed)
    assert tried == [dome.seed.violation, 1e-2]


def test_an_iterate_out_of_reach_is_gone_towards(dome: Dome, monkeypatch: pytest.MonkeyPatch) -> None:
    best = dome.begun()
    moved = module.Projection.moved

    def short(self: Any, point: Point, wish: Any) -> Point | None:
        """Steps of a quarter of the way at most, and none from a point off the constraints."""
        far = np.linalg.norm(wish) > 0.25 * np.linalg.norm(dome.told[-1].variables - dome.seed.variables)
        return None if far or point.violation > 1e-6 else moved(self, point, wish)

    monkeypatch.setattr(module.Projection, "moved", short)
    monkeypatch.setattr(module, "polish", lambda at: at)
    out_of_reach = dome.told[-1].variables + 1e-2 * np.random.default_rng(0).standard_normal(dome.seed.variables.size)
    best.tell(Progress(7, dome.told[-1].objective, 0.2, out_of_reach))
    kept = best.kept(dome.seed)
    assert kept.words.startswith("it is on the way to iteration 7 of its run, as far as equation (9) led: up to ")
    assert kept.point.objective < 1e-2 * dome.seed.objective
    assert kept.point.violation <= verdict.BOUND
    assert dome.is_certified(kept)


def test_facets_that_cross_are_not_kept(dome: Dome, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(BestSoFar, "_is_mesh", lambda self, point: bool(point.objective > 0.5 * dome.seed.objective))
    kept = dome.told_until(len(dome.told) - 1).kept(dome.seed)
    assert kept.words.startswith("it is still the placed seed")


def test_where_the_anchors_cannot_be_met_yet_the_mesh_is_one_nevertheless(monkeypatch: pytest.MonkeyPatch) -> None:
    rail = [[-0.6, -0.6, 0.6], [-0.6, 0.6, 0.6]]
    anchored = Dome(constraints={"anchors": [{"side": "u0", "every": 2, "to": {"polyline": rail}}]})
    assert anchored.seed.violation > 0.1
    best, whole = anchored.told_until(7), anchored.seed.problem
    within = best._within
    monkeypatch.setattr(best, "_within", lambda at, end: None if at.problem is whole else within(at, end))
    kept = best.kept(anchored.seed)
    assert kept.words.endswith("to meet all constraints, but for those that the seed does not meet")
    assert kept.point.problem is whole
    assert kept.point.violation > verdict.BOUND
    assert kept.point.objective < GAIN * anchored.seed.objective
    assert anchored.is_certified(kept)


def test_packed_states_follow(monkeypatch: pytest.MonkeyPatch) -> None:
    one = BestSoFar(formulate(task(pattern=PATTERNS["miura"], objectives={"footprint": 1e-3})).goal)
    assert one.goal.packed
    monkeypatch.setattr(type(one.goal), "start", lambda _, points: np.full(3, float(points.sum())))
    monkeypatch.setattr(type(one.goal.model), "points", lambda _, x: x)
    point: Any = Point(None, np.ones(4), np.empty(0))  # type: ignore[arg-type]
    assert one._packed(point).variables.tolist() == [4.0, 4.0, 4.0]
