"""Runs that are watched, stopped, or have next to nothing to do."""

from __future__ import annotations

import importlib
import math
import random
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import casadi
import numpy as np
import pytest
from designs import assert_close
from domes import assert_good, dome, task

import inverse
from inverse import interrupts, objectives
from inverse.cli import commands
from inverse.formulation.formulate import formulate
from inverse.policy.best import BestSoFar
from inverse.policy.control import Watch
from inverse.solvers.run import Progress


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
    result = inverse.solve(task(), watch=told)
    assert set(told.phases) == {f"{result.report['size']['facets']} facets, round 1"}
    runs = [range(attempt["iterations"] + 1) for attempt in result.report["attempts"]]
    assert [p.iteration for p in told.progress] == [k for run in runs for k in run]
    first, last = told.progress[0], told.progress[-1]
    assert_close(first.variables, formulate(task()).goal.model.seed_points.ravel(), 0)
    assert last.objective < 1e-3 * first.objective
    assert last.violation < 1e-8
    assert last.objective == pytest.approx(sum(result.report["objective"].values()), rel=1e-3)
    # Copies, not windows on a buffer that changes.
    assert np.abs(told.progress[3].variables - last.variables).max() > 1e-6


def breaking(error: BaseException, at: int = 3) -> Watch:
    def watch(_: str, progress: Progress) -> None:
        if progress.iteration == at:
            raise error

    return watch


def test_a_watch_that_fails_ends_the_solve_with_the_best_design() -> None:
    error = RuntimeError("the watch broke")
    result = inverse.solve(task(), watch=breaking(error))
    assert (result.ending, result.interrupted, result.converged) == ("watch_failed", True, False)
    assert result.certified
    assert "RuntimeError: the watch broke" in result.status
    with pytest.raises(inverse.SolveError, match="the watch broke") as caught:
        inverse.solve(task(), watch=breaking(error), throw=True)
    assert caught.value.__cause__ is error
    assert caught.value.result.ending == "watch_failed"


def test_an_interrupt_raised_in_the_watch_is_an_interrupt() -> None:
    result = inverse.solve(task(), watch=breaking(KeyboardInterrupt()))
    assert (result.ending, result.certified) == ("interrupted", True)


def test_who_wants_to_exit_exits() -> None:
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(SystemExit):
        inverse.solve(task(), watch=breaking(SystemExit(3)))
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.parametrize(
    ("at", "number"), [(0, signal.SIGINT), (4, signal.SIGINT), (8, signal.SIGINT), (4, signal.SIGTERM)]
)
def test_ctrl_c_keeps_the_best_design(at: int, number: signal.Signals) -> None:
    told = Told()

    def watch(phase: str, progress: Progress) -> None:
        told(phase, progress)
        if len(told.progress) == at + 1:
            signal.raise_signal(number)

    before = signal.getsignal(number)
    result = inverse.solve(task(), watch=watch)
    assert signal.getsignal(number) is before
    assert result.interrupted
    assert not result.converged
    assert result.status.startswith("interrupted, the best design so far was kept: ")
    assert len(told.progress) == at + 1
    assert result.certified
    fit = result.report["fit"]
    assert fit["rms"] <= fit["start_rms"] * (1 + 1e-9 if at == 0 else 0.1)  # after 4 iterations a hundredth is left


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_before_there_is_a_design(
    number: signal.Signals, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """As CasADi does it: what a handler raises comes out as something else."""
    module = importlib.import_module("inverse.results.making")
    formulate = module.formulate

    def in_casadi(*given: Any, **more: Any) -> Any:
        try:
            signal.raise_signal(number)
        except KeyboardInterrupt:
            raise SystemError("returned a result with an exception set") from None
        return formulate(*given, **more)

    monkeypatch.setattr(module, "formulate", in_casadi)
    before = signal.getsignal(number)
    with pytest.raises(KeyboardInterrupt):
        inverse.solve(task())
    assert signal.getsignal(number) is before
    (tmp_path / "dome.yaml").write_text(TASK)
    assert commands.run(["solve", str(tmp_path / "dome.yaml"), "-o", str(tmp_path / "out")]) == 3
    assert capsys.readouterr().err == "interrupted; no file was left half-written\n"
    assert not (tmp_path / "out").exists()


def test_the_second_signal_ends_at_once() -> None:
    stop = threading.Event()

    def work() -> None:
        with interrupts.held(stop):
            signal.raise_signal(signal.SIGTERM)
            assert stop.is_set()
            try:
                signal.raise_signal(signal.SIGINT)
            except KeyboardInterrupt:
                raise NotImplementedError("Wrong number or type of arguments") from None

    with pytest.raises(KeyboardInterrupt):
        work()


TASK = """\
name: dome
pattern: {size: [4, 4]}
target: {height: "0.45 - 0.3*(x^2 + y^2)", domain: [[-1, 1], [-1, 1]]}
require: {coverage: 0, beyond: 1}
"""
PROGRAM = """\
import sys
from inverse.__main__ import main
sys.modules["pyvista"] = None  # no pictures
print("begun", flush=True)
main()
"""


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signals_at_any_moment(number: signal.Signals, tmp_path: Path) -> None:
    (tmp_path / "dome.yaml").write_text(TASK)
    arguments = ["solve", str(tmp_path / "dome.yaml"), "-o", str(tmp_path / "out")]
    moments = random.Random(number)
    longest = 1.0
    codes = []
    for _ in range(20):
        with subprocess.Popen(
            [sys.executable, "-c", PROGRAM, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as process:
            assert process.stdout is not None
            process.stdout.readline()
            began = time.monotonic()
            time.sleep(moments.uniform(0, longest))
            process.send_signal(number)
            _, said = process.communicate(timeout=60)
        codes.append(process.returncode)
        assert process.returncode in (0, 3), said
        assert "Traceback" not in said
        assert "Exception ignored" not in said
        if process.returncode == 0:  # over before the signal came
            longest = min(longest, time.monotonic() - began)
        elif process.returncode == 3:
            assert "interrupted" in said.lower()
    assert codes.count(3) >= 10


SIGNALLED = """\
import os, signal, sys
from inverse.cli import solve
from inverse.policy import best
def told(self, phase, progress):
    if progress.iteration == 6:
        os.kill(os.getpid(), signal.{name})
solve._Watch.__call__ = told
within = best.BestSoFar._brought_within
def twice(self, *given):
    if {twice}:
        os.kill(os.getpid(), signal.{name})
    return within(self, *given)
best.BestSoFar._brought_within = twice
from inverse.__main__ import main
main()
"""


def signalled(name: str, folder: Path, *, twice: bool) -> subprocess.CompletedProcess[str]:
    """A process that gets a signal at its sixth iteration, and another one while it finishes."""
    (folder / "dome.yaml").write_text(TASK)
    program = SIGNALLED.format(name=name, twice=twice)
    command = [sys.executable, "-c", program, "solve", str(folder / "dome.yaml"), "-o", str(folder / "out")]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_process_that_is_ended_leaves_a_whole_folder_and_says_so_at_once(name: str, tmp_path: Path) -> None:
    done = signalled(name, tmp_path, twice=False)
    assert done.returncode == 3, done.stderr
    first, second, third = done.stderr.splitlines()
    assert first.startswith("interrupted: the best design so far is brought within the constraints and written")
    assert second == "Interrupted: the results have no 3D pictures."
    assert third.startswith("NOT DONE: interrupted, the best design so far was kept: it is ")
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"design.fold", "certificate.json", "report.json", "crease_pattern.svg"}
    assert inverse.check(tmp_path / "out" / "design.fold").certified


def test_the_second_signal_ends_a_process_without_its_design(tmp_path: Path) -> None:
    done = signalled("SIGINT", tmp_path, twice=True)
    assert done.returncode == 3, done.stderr
    assert done.stderr.splitlines()[1:] == ["interrupted; no file was left half-written"]
    assert not (tmp_path / "out").exists()


def test_what_casadi_makes_of_a_second_signal_is_no_fault_of_a_step(monkeypatch: pytest.MonkeyPatch) -> None:
    def amid_casadi(*_: Any) -> None:
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            raise AttributeError("'NoneType' object has no attribute 'tocsr'") from None

    def watch(_: str, progress: Progress) -> None:
        if progress.iteration == 3:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(BestSoFar, "_brought_within", amid_casadi)
    with pytest.raises(KeyboardInterrupt):
        inverse.solve(task(), watch=watch)


def test_an_interrupted_result_has_no_3d_pictures_that_would_take_long(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def drawn(_: object) -> None:
        raise AssertionError("it was not to be drawn")

    result = inverse.solve(task(), watch=breaking(KeyboardInterrupt()))
    monkeypatch.setattr("inverse.results.saving.Renderer.__enter__", drawn)
    assert result.save(tmp_path) == ["Interrupted: the results have no 3D pictures."]
    assert (tmp_path / "crease_pattern.svg").exists()


def test_time_limit() -> None:
    began = time.monotonic()
    result = inverse.solve(task(solver={"time_limit_s": 1.0}), watch=lambda *_: time.sleep(0.1))
    assert time.monotonic() - began < 5
    assert result.interrupted
    assert 1 <= result.report["iterations"] < 11
    assert result.certified
    assert result.ending == "time_limit"
    assert "Raise solver.time_limit_s" in result.status


@pytest.mark.parametrize("limit", [1e-9, 1e-3])
def test_no_time_at_all(limit: float) -> None:
    result = inverse.solve(task(solver={"time_limit_s": limit}))
    assert result.interrupted
    assert_close(result.design.vertices_coords, result.seed.vertices_coords, 1e-9)


def test_iterations_run_out() -> None:
    result = inverse.solve(task(solver={"max_iterations": 1}))
    assert not result.interrupted
    assert not result.converged
    assert result.ending == "iteration_limit"
    assert result.status.startswith("the iterations ran out, the best design was kept: ")
    assert all(attempt["iterations"] <= 1 for attempt in result.report["attempts"])


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
    weights = {name: weight * term.weight for name, term in objectives.OBJECTIVES.items()}
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


@pytest.mark.usefixtures("registered")
def test_an_objective_of_ones_own() -> None:
    """Vertices 0 and 48 a given distance apart, in metres."""

    @inverse.objective("reach", per="mesh")
    def reach(points: casadi.SX, _: casadi.SX) -> casadi.SX:
        return casadi.sumsqr(points[0, :] - points[48, :]) - 1.6**2

    result = inverse.solve(task(objectives={"reach": 10}))
    plain = inverse.solve(task())
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
    assert result.certified
    assert result.converged


def test_without_objectives_the_seed_is_a_solution() -> None:
    result = inverse.solve(task(objectives=dict.fromkeys(objectives.OBJECTIVES, 0)))
    assert result.certified
    assert result.converged


@pytest.mark.parametrize("size", [[1, 2], [2, 1]])
def test_a_single_fold(size: list[int]) -> None:
    result = inverse.solve(task(pattern={"size": size}))
    assert result.certified
    assert result.converged
