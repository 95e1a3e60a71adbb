"""Runs that are watched, stopped, or have next to nothing to do."""

from __future__ import annotations

import math
import signal
import threading
import time
from typing import Any

import numpy as np
import pytest
from designs import assert_close
from test_solve import assert_good, dome, task

import inverse
from inverse import objectives
from inverse.attempt import Progress


class Told:
    """Remembers what a watch is told."""

    def __init__(self) -> None:
        self.phases: list[str] = []
        self.progress: list[Progress] = []

    def __call__(self, phase: str, progress: Progress) -> None:
        self.phases.append(phase)
        self.progress.append(progress)


def test_every_iteration_is_told() -> None:
    told = Told()
    result = inverse.solve(task(), told)
    assert set(told.phases) == {f"{result.report['size']['facets']} facets, round 1"}
    runs = [range(attempt["iterations"] + 1) for attempt in result.report["attempts"]]
    assert [p.iteration for p in told.progress] == [k for run in runs for k in run]
    first, last = told.progress[0], told.progress[-1]
    assert_close(first.variables, result.formulation.goal.model.seed_points.ravel(), 0)
    assert last.objective < 1e-3 * first.objective
    assert last.violation < 1e-8
    assert last.objective == pytest.approx(sum(result.report["objective"].values()), rel=1e-3)
    # Copies, not windows on a buffer that changes.
    assert np.abs(told.progress[3].variables - last.variables).max() > 1e-6


@pytest.mark.parametrize("error", [RuntimeError("the watch broke"), KeyboardInterrupt(), SystemExit(3)])
def test_what_a_watch_raises_comes_out(error: BaseException) -> None:
    def watch(_: str, progress: Progress) -> None:
        if progress.iteration == 3:
            raise error

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(type(error)) as caught:
        inverse.solve(task(), watch)
    assert caught.value is error
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.parametrize("at", [0, 4, 12])
def test_ctrl_c_keeps_the_best_design(at: int) -> None:
    told = Told()

    def watch(phase: str, progress: Progress) -> None:
        told(phase, progress)
        if len(told.progress) == at + 1:
            signal.raise_signal(signal.SIGINT)

    before = signal.getsignal(signal.SIGINT)
    result = inverse.solve(task(), watch)
    assert signal.getsignal(signal.SIGINT) is before
    assert result.interrupted
    assert not result.converged
    assert result.status.startswith("interrupted, the best design so far was kept: ")
    assert len(told.progress) == at + 1
    assert result.certified
    fit = result.report["fit"]
    assert fit["rms"] <= fit["start_rms"] * (1 + 1e-9 if at == 0 else 0.1)  # after 4 iterations a hundredth is left


def test_time_limit() -> None:
    began = time.monotonic()
    result = inverse.solve(task(solver={"time_limit_s": 0.5}), lambda *_: time.sleep(0.1))
    assert time.monotonic() - began < 3
    assert result.interrupted
    assert 1 <= result.report["iterations"] < 8
    assert result.certified
    assert result.status.endswith("Let it run on, or raise solver.time_limit_s.")


@pytest.mark.parametrize("limit", [1e-9, 1e-3])
def test_no_time_at_all(limit: float) -> None:
    result = inverse.solve(task(solver={"time_limit_s": limit}))
    assert result.interrupted
    assert_close(result.design.vertices_coords, result.seed.vertices_coords, 1e-9)


def test_iterations_run_out() -> None:
    result = inverse.solve(task(solver={"max_iterations": 5}))
    assert not result.interrupted
    assert not result.converged
    assert result.status.startswith("the solver ended with Maximum_Iterations_Exceeded: ")
    assert result.report["iterations"] == 5


def test_in_another_thread() -> None:
    """Signals belong to the main thread; elsewhere a solve leaves them alone."""
    found: list[Any] = []
    thread = threading.Thread(target=lambda: found.append(inverse.solve(task())))
    thread.start()
    thread.join(60)
    assert found[0].design.vertices_coords.tobytes() == dome().design.vertices_coords.tobytes()


# ---- objectives


@pytest.mark.parametrize("weight", [3.0, 0.1])
def test_a_common_factor_of_all_weights_changes_nothing(weight: float) -> None:
    weights = {name: weight * term.default_weight for name, term in objectives.OBJECTIVES.items()}
    result = inverse.solve(task(objectives=weights))
    assert_good(result)
    values = [sum(r.report["objective"].values()) for r in (result, dome())]
    assert values[0] / weight == pytest.approx(values[1], rel=1e-4)
    assert_close(result.design.vertices_coords, dome().design.vertices_coords, 1e-2)  # the optimum is flat


def test_more_fairness_is_fairer() -> None:
    fair = inverse.solve(task(objectives={"fairness": 1e-2}))
    assert fair.converged
    per_weight = [r.report["objective"]["fairness"] / w for r, w in ((fair, 1e-2), (dome(), 1e-5))]
    assert per_weight[0] < 0.9 * per_weight[1]
    assert fair.report["fit"]["rms"] > dome().report["fit"]["rms"]


def test_an_objective_of_ones_own() -> None:
    """Vertices 0 and 48 a given distance apart, in metres."""
    inverse.register_objective(
        "reach", lambda points: (points[0, :] - points[48, :]) @ (points[0, :] - points[48, :]).T - 1.6**2
    )
    try:
        result = inverse.solve(task(objectives={"reach": 10}))
        plain = inverse.solve(task())
    finally:
        del objectives.OBJECTIVES["reach"]
    assert result.converged
    reached, before = (math.dist(*r.design.vertices_coords[[0, 48]]) for r in (result, plain))
    assert abs(before - 1.6) > 0.05
    assert reached == pytest.approx(1.6, abs=0.01)
    assert_close(plain.design.vertices_coords, dome().design.vertices_coords, 0)  # weight 0: not there


# ---- the smallest tasks


@pytest.mark.parametrize("size", [[2, 2], [2, 3], [3, 3]])
def test_a_sheet_that_fits_exactly_has_converged(size: list[int]) -> None:
    result = inverse.solve(task(pattern={"size": size}))
    assert result.report["fit"]["rms_relative"] < 1e-4
    assert result.status == "certified and converged"


def test_without_objectives_the_seed_is_a_solution() -> None:
    result = inverse.solve(task(objectives=dict.fromkeys(objectives.OBJECTIVES, 0)))
    assert result.status == "certified and converged"


def test_one_facet() -> None:
    result = inverse.solve(task(pattern={"size": [1, 1]}))
    assert result.report["size"]["facets"] == 1


@pytest.mark.parametrize("size", [[1, 4], [4, 1]])
def test_one_strip_moves_in_more_than_one_way(size: list[int]) -> None:
    result = inverse.solve(task(pattern={"size": size}))
    assert not result.certified
    assert "3 independent motions" in result.status
