"""What is tried when the straight way fails, with failures injected; how every ending is told."""

from __future__ import annotations

import json
import re
import time
from dataclasses import replace
from typing import Any

import casadi
import numpy as np
import pytest
from designs import assert_close
from domes import assert_good, dome, task

import inverse
from inverse import objectives
from inverse.certify import check_frame
from inverse.constraints import edge_length
from inverse.dragging import LIMITS
from inverse.files import fold_file
from inverse.files.fold_format import frame_of
from inverse.formulation.formulate import formulate
from inverse.model import DesignModel
from inverse.nlp.kernels import Elements, Kernel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.nlp.term import Objective
from inverse.origami.pattern import FloatArray
from inverse.policy import endings, verdict
from inverse.policy.rounds import Rounds
from inverse.solvers.ipopt import Ipopt
from inverse.solvers.run import Ending, Run
from inverse.surfaces.parametric import BetweenTarget, HeightTarget


def steps(result: inverse.Result) -> list[str]:
    """The steps of the policy in their order."""
    return list(dict.fromkeys(attempt["step"] for attempt in result.report["attempts"]))


class Failing:
    """IPOPT whose first runs do nothing, and say that they stopped short."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, runs: int, ending: Ending = Ending.RESTORATION_FAILED) -> None:
        self.left, self.ending = runs, ending
        for name in ("approach", "run"):
            monkeypatch.setattr(Ipopt, name, self.instead_of(getattr(Ipopt, name)))

    def instead_of(self, method: Any) -> Any:
        def run(solver: Ipopt, start: Point, *arguments: Any, **options: Any) -> Run:
            if self.left <= 0:
                return method(solver, start, *arguments, **options)
            self.left -= 1
            return Run(start.pushed(np.zeros(solver._problem.n_rows)), self.ending, 0, 0.0, 0.0, "nothing")

        return run


# ---- the table


def test_every_ending_says_what_happened_and_what_to_do() -> None:
    assert endings.sentence(endings.SOLVED, []) == "certified, converged and as asked"
    for word, ending in endings.ENDINGS.items():
        if word == "not_as_asked":  # what to do stands in every request's own sentence
            assert endings.sentence(word, ["one thing. Do this", "another"]).endswith(": one thing. Do this; another")
        elif word != endings.SOLVED:
            text = endings.sentence(word, ["one thing", "another"])
            assert "one thing; another. " in text
            assert text.endswith(".")
            assert "{" not in text
            assert len(ending.advice) > 20


def test_every_ending_can_be_reached() -> None:
    """Each word of the table stands in a test of this folder that reaches it."""
    from pathlib import Path

    text = "".join(path.read_text() for path in Path(__file__).parents[1].rglob("test_*.py"))
    lacking = [word for word in endings.ENDINGS if not re.search(rf'ending.* == \(?"{word}"', text)]
    assert not lacking


def test_a_solved_task() -> None:
    result = inverse.solve(task(), throw=True)
    assert result.ending == "solved"
    assert steps(result) == ["start"]
    assert result.report["attempts"][-1]["outcome"] == "certified and converged"
    assert result.report["reached"] is None


def test_throwing_or_returning() -> None:
    loaded = task(solver={"time_limit_s": 1e-9})
    result = inverse.solve(loaded)
    assert result.ending == "time_limit"
    with pytest.raises(inverse.SolveError) as caught:
        inverse.solve(loaded, throw=True)
    assert str(caught.value) == result.status
    assert caught.value.result.ending == "time_limit"


# ---- fallbacks


def test_a_first_run_that_fails_is_made_up_for(monkeypatch: pytest.MonkeyPatch) -> None:
    Failing(monkeypatch, 3)
    result = inverse.solve(task())
    assert_good(result)
    assert steps(result) == ["start", "again from the best"]
    ended = [attempt["ended"] for attempt in result.report["attempts"]]
    assert ended[:3] == ["Restoration_Failed"] * 3
    assert_close(result.design.vertices_coords, dome().design.vertices_coords, 1e-5)


def test_a_path_of_flatter_targets_comes_to_the_same_design(monkeypatch: pytest.MonkeyPatch) -> None:
    Failing(monkeypatch, 6)
    result = inverse.solve(task())
    assert_good(result)
    assert steps(result)[2:] == ["path, 0.25 of the target", "path, 0.75 of the target", "path, 1 of the target"]
    assert result.report["reached"] == 1.0
    assert_close(result.design.vertices_coords, dome().design.vertices_coords, 1e-5)


def test_a_path_that_ends_early_says_how_far_it_came(monkeypatch: pytest.MonkeyPatch) -> None:
    failing = Failing(monkeypatch, 6)
    monkeypatch.setattr("inverse.policy.steps.NLOPT_LARGEST", 0)
    made = []
    run = Ipopt.run

    def counted(solver: Ipopt, *arguments: Any, **options: Any) -> Run:
        made.append(solver)
        if len(made) > 6:
            failing.left = 10**6  # after the first task on the path nothing works any more
        return run(solver, *arguments, **options)

    monkeypatch.setattr(Ipopt, "run", counted)
    result = inverse.solve(task(solver={"max_iterations": 30}))
    assert not result.converged
    assert result.certified
    assert 0 < result.report["reached"] < 1
    assert f"a path from the seed came to {result.report['reached']:.3g} of the target's height" in result.status


def test_without_ipopt_nlopt_finds_the_same_design(monkeypatch: pytest.MonkeyPatch) -> None:
    Failing(monkeypatch, 10**6)
    result = inverse.solve(task())
    assert_good(result)
    assert steps(result)[-1] == "nlopt"
    assert result.report["attempts"][-1]["method"].startswith("nlopt, ")
    assert result.report["reached"] == 0
    assert_close(result.design.vertices_coords, dome().design.vertices_coords, 1e-5)


def test_where_nothing_works_the_seed_is_returned_and_not_called_converged(monkeypatch: pytest.MonkeyPatch) -> None:
    Failing(monkeypatch, 10**6)
    monkeypatch.setattr("inverse.policy.steps.NLOPT_LARGEST", 0)
    result = inverse.solve(task())
    assert result.ending == "stalled"
    assert result.certified
    assert not result.converged
    assert result.report["reached"] == 0
    assert "not stationary" in result.status
    assert "a path from the seed did not even come to 0.125 of the target's height" in result.status
    assert_close(result.design.vertices_coords, result.seed.vertices_coords, 1e-9)


def test_a_limit_within_a_step_is_not_the_end_of_the_iterations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only static pivots run out of iterations, as they may; what ends the step is a failure of pivoting."""
    Failing(monkeypatch, 10**6)
    monkeypatch.setattr("inverse.policy.steps.NLOPT_LARGEST", 0)
    run = Ipopt.run

    def ended(solver: Ipopt, *arguments: Any, careful: bool, **options: Any) -> Run:
        attempt = run(solver, *arguments, careful=careful, **options)
        return attempt if careful else replace(attempt, ending=Ending.LIMIT)

    monkeypatch.setattr(Ipopt, "run", ended)
    assert inverse.solve(task()).ending == "stalled"


def test_the_limits_of_a_drag_are_those_that_a_specification_has_by_default() -> None:
    limits = task().specification.constraints
    assert limits.edge_length == LIMITS["edge_length"]
    assert np.radians(limits.sector_angle) == pytest.approx(LIMITS["sector_angle"], rel=1e-15)
    assert np.radians(limits.fold_angle) == pytest.approx(LIMITS["fold_angle"], rel=1e-15)


def test_a_design_outside_its_bounds_is_brought_within_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where no solver does anything, equation (9) at least meets the constraints."""
    Failing(monkeypatch, 10**6)
    monkeypatch.setattr("inverse.policy.steps.NLOPT_LARGEST", 0)
    low = float(dome().seed.vertices_coords[:, 2].min())
    keep_out = [{"below": low + 0.01}]
    result = inverse.solve(task(constraints={"keep_out": keep_out}))
    assert result.report["attempts"][-1] == {
        "step": "equation (9)", "method": "equation (9)", "ended": "within the constraints", "iterations": 0
    }  # fmt: skip
    assert result.certified
    assert not result.converged
    assert result.design.vertices_coords[:, 2].min() > low + 0.01 - 1e-9


def test_what_the_certificate_refuses_is_not_solved(monkeypatch: pytest.MonkeyPatch) -> None:
    document = fold_file.document(dome().design)
    document["vertices_coords"][24][2] += 0.01
    refused = check_frame(frame_of(document))
    assert not refused.certified
    monkeypatch.setattr("inverse.policy.steps.check_frame", lambda _: refused)
    result = inverse.solve(task(solver={"time_limit_s": 60}))
    assert result.ending == "not_certified"
    assert result.converged
    assert not result.certified
    assert "FAILED" in result.status
    assert result.report["reached"] == 0
    assert "path" not in result.status  # how far one came is no cause of this


# ---- steps that raise


def test_what_a_step_raises_loses_no_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """The search for crossing facets breaks after the first round: its best iterate is kept, and the cause is told."""
    crossing, called = Rounds._crossing, []

    def broken(rounds: Rounds, x: FloatArray) -> Any:
        called.append(x)
        if len(called) == 1:
            raise np.linalg.LinAlgError("Singular matrix")
        return crossing(rounds, x)

    monkeypatch.setattr(Rounds, "_crossing", broken)
    result = inverse.solve(task())
    assert result.ending == "failed"
    assert "the step start raised LinAlgError: Singular matrix" in result.status
    assert result.certified
    assert not result.converged
    assert not result.interrupted
    assert steps(result) == ["start"]
    last = result.report["attempts"][-1]
    assert last["ended"] == "LinAlgError: Singular matrix"
    assert "in broken" in "".join(last["traceback"])
    assert_close(result.design.vertices_coords, dome().design.vertices_coords, 1e-5)


def test_what_a_later_step_raises_keeps_the_earlier_best(monkeypatch: pytest.MonkeyPatch) -> None:
    Failing(monkeypatch, 6)

    def broken(*_: Any) -> None:
        raise ZeroDivisionError("by zero")

    monkeypatch.setattr("inverse.policy.steps.formulate", broken)
    result = inverse.solve(task())
    assert result.ending == "failed"
    assert "the step along a path raised ZeroDivisionError: by zero" in result.status
    assert result.certified
    monkeypatch.setattr("inverse.policy.rounds.Rounds.run", broken)
    with pytest.raises(inverse.SolveError) as caught:
        inverse.solve(task(), throw=True)
    assert isinstance(caught.value.__cause__, ZeroDivisionError)


# ---- seeds that are the answer, or nearly


def straight_tube(radius: Any) -> dict[str, Any]:
    return {
        "pattern": {"kind": "tube", "size": [6, 6]},
        "target": {"axis": {"polyline": [[0, 0, 0], [0, 0, 6]]}, "radius": radius},
    }


NEAR_AT_HAND: dict[str, tuple[dict[str, Any], int]] = {
    "a straight tube": (straight_tube(1), 0),
    "a straight tube by nlopt": (straight_tube(1) | {"solver": {"method": "nlopt"}}, 0),
    "a tube that hardly tapers": (straight_tube([[0, 1], [1, 1 + 1e-6]]), 50),
    "nothing to fit": ({"objectives": {"fit": 0, "coverage": 0}}, 0),
    "a plane": ({"target": {"height": "0", "domain": [[-1, 1], [-1, 1]]}}, 20),
}


@pytest.mark.parametrize("name", NEAR_AT_HAND)
def test_a_seed_that_is_the_answer_is_found_at_once(name: str) -> None:
    """Its gradient is rounding, which is no measure of others."""
    keys, most = NEAR_AT_HAND[name]
    result = inverse.solve(task(**keys))
    assert result.certified
    assert result.converged
    assert steps(result) == ["start"]
    assert result.report["iterations"] <= most
    if most == 0:
        assert_close(result.design.vertices_coords, result.seed.vertices_coords, 1e-9)


def test_gradients_are_measured_by_the_seeds_where_it_is_far_from_its_target() -> None:
    formulation = formulate(task())
    goal = formulation.goal
    problem = Problem(goal.n_variables, formulation.objectives, formulation.fixed)
    at_seed = np.abs(Point(problem, goal.seed_variables, problem.parameters()).gradient).max()
    assert verdict.gradient_scale(problem, goal) == at_seed


def test_a_start_that_is_the_answer_may_be_stopped() -> None:
    result = inverse.solve(task(**straight_tube(1), solver={"time_limit_s": 1e-9}))
    assert result.ending == "solved"


# ---- targets on the way


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_flattened_targets(share: float) -> None:
    height = HeightTarget("0.3 + x*y - 0.2*x^2", [[-1, 1], [-0.5, 0.5]])
    arc = BetweenTarget([np.array([[0.0, 0, 0], [0, 2, 0]]), np.array([[1.0, 0, 0], [1, 2, 0]])], 0.5)
    for target in (height, arc):
        flat, frame = target.flattened(share), target.frame
        points = target.samples()[0]
        heights = (points - frame.origin) @ frame.axes[2]
        lowered = points - (1 - share) * heights[:, None] * frame.axes[2]
        assert flat.distances(lowered).max() < 2e-4
        assert_close(np.sort(flat.frame.extent), np.sort(frame.extent), 1e-2 if share < 1 else 1e-9)
    assert isinstance(height.flattened(share), HeightTarget)
    assert height.flattened(0.0).triangles()[0][:, 2] == pytest.approx(height.frame.origin[2], abs=1e-12)


# ---- terms that are not numbers


@pytest.mark.usefixtures("registered")
@pytest.mark.parametrize(
    "function",
    [
        lambda points: casadi.sqrt(points[:, 2] - 100),  # no value
        lambda points: casadi.sqrt(casadi.fmax(0, points[:, 2] - 100)),  # no derivative
    ],
)
def test_a_term_that_is_not_a_number_is_named_at_once(function: Any) -> None:
    objectives.objective("mine", per="mesh")(lambda points, _: function(points))
    result = inverse.solve(task(objectives={"mine": 1.0}))
    assert result.ending == "not_a_number"
    assert "mine at vertices 0, 1, 2, 3" in result.status
    assert result.report["iterations"] == 0
    assert not result.converged
    assert_close(result.design.vertices_coords, result.seed.vertices_coords, 1e-9)


def test_a_target_without_a_slope_is_told_in_numbers_or_not_at_all() -> None:
    """A hemisphere and the plane around it: the root has no slope there, and JSON no word for what follows."""
    flat = {"height": "sqrt(max(0, 1 - x^2 - y^2))", "domain": [[-1, 1], [-1, 1]]}
    result = inverse.solve(task(target=flat))
    assert result.ending == "not_a_number"
    assert "fit at vertices" in result.status
    assert json.dumps(result.report, allow_nan=False)
    assert result.report["verdict"]["stationarity"] is None


@pytest.mark.usefixtures("registered")
def test_no_number_beyond_a_wall_is_a_wall() -> None:
    """A term may lack a value where no design needs to go: the solver steps back from there."""
    highest = float(dome().design.vertices_coords[:, 2].max())
    wall = objectives.objective("wall", per="mesh")
    wall(lambda points, _: 1e-3 * casadi.log(highest + 0.005 - points[:, 2]))
    result = inverse.solve(task(objectives={"wall": 1e-6}))
    assert_good(result)


def test_the_element_that_is_not_a_number_is_named() -> None:
    model = DesignModel(inverse.seeds.grid((3, 4)))
    kernel = Kernel("root", lambda q, p: casadi.sqrt(q[0] - p), 3, 1)
    places = model.variables_of(np.arange(20)[:, None])
    x = model.seed_points.ravel()
    floor = np.full((20, 1), -100.0)
    problem = Problem(60, [Objective(Elements("root", kernel, places, floor), 1.0)], [edge_length(model, (0.5, 2))])
    assert Point(problem, x, problem.parameters()).not_a_number is None
    floor[7] = 100.0
    assert Point(problem, x, problem.parameters()).not_a_number == ("root", "vertex 7")
    x[3 * 11] = np.nan
    assert Point(problem, x, problem.parameters()).not_a_number == ("root", "vertex 7")
    floor[7] = -100.0
    assert Point(problem, x, problem.parameters()).not_a_number == ("root", "vertex 11")
    bounds = Problem(60, [], [edge_length(model, (0.5, 2))])
    name, element = Point(bounds, x, bounds.parameters()).not_a_number or ("", "")
    assert name == "edge_length"
    assert re.fullmatch(r"edge (\d+-11|11-\d+)", element)


def test_a_weight_that_leaves_no_number_is_named() -> None:
    """Specifications admit no such weight, scripts that make terms of their own may."""
    model = DesignModel(inverse.seeds.grid((3, 4)))
    elements = Elements("pull", Kernel("pull", lambda q, _: 1e3 * q, 3), model.variables_of(np.arange(20)[:, None]),
                        np.empty((20, 0)))  # fmt: skip
    for weight, found in ((1e280, None), (1e304, ("pull", "all elements, for its weight is too large"))):
        problem = Problem(60, [Objective(elements, weight)], [edge_length(model, (0.5, 2))])
        assert Point(problem, model.seed_points.ravel(), problem.parameters()).not_a_number == found


# ---- units


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e3, 0.3048])
def test_the_unit_does_not_matter(factor: float) -> None:
    one, other = (inverse.solve(task(target=dome_of_radius(radius))) for radius in (1.0, factor))
    assert_good(other)
    assert_close(other.design.vertices_coords / factor, one.design.vertices_coords, 1e-6)


def dome_of_radius(radius: float) -> dict[str, Any]:
    half = 0.6 * radius
    return {"height": f"sqrt({radius * radius!r} - x^2 - y^2)", "domain": [[-half, half], [-half, half]]}


# ---- constraints that contradict each other


CAP = {"height": "sqrt(100 - x^2 - y^2)", "domain": [[-6, 6], [-6, 6]]}
WALLS = [{"plane": {"point": [x, 0, 0], "normal": [-x, 0, 0]}} for x in (-0.25, 0.25)]
RAILS = [
    {"side": side, "every": 2, "to": {"polyline": [[x, -6, 8], [x, 6, 8]]}} for side, x in (("u0", -9.5), ("u1", 9.5))
]
CONTRADICTORY = {
    "rails farther apart than folds allow": (
        {"edge_length": [0.9, 1.1], "fold_angle": [80, 150], "anchors": RAILS},
        "m from its polyline (constraints.anchors.0)",
    ),
    "walls that a sheet cannot be folded into": (
        {"edge_length": [0.8, 1.2], "keep_out": WALLS},
        "m on the wrong side of its plane (constraints.keep_out.",
    ),
    "a gap lower than folds allow": (
        {"edge_length": [0.8, 1.2], "fold_angle": [40, 140], "keep_out": [{"below": 7.99}, {"above": 8.03}]},
        "m too low (constraints.keep_out.0: below 7.99 m)",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CONTRADICTORY)
def test_what_no_design_can_meet_ends_soon_and_says_where(name: str) -> None:
    """No lengths of paths and no intervals prove these; from three starts nothing comes near."""
    constraints, said = CONTRADICTORY[name]
    began = time.process_time()
    result = inverse.solve(task(pattern={"size": [16, 16], "u_lines": "CFL"}, target=CAP, constraints=constraints))
    assert time.process_time() - began < 10  # some 5 s
    assert result.ending == "contradictory"
    assert result.iterations <= 30
    assert result.certified
    assert not result.converged
    assert result.status.startswith("the constraints contradict each other near every start that was tried")
    assert said in result.status
