"""The policy of solving: rounds of IPOPT, polish, and a verdict from our own unscaled residuals."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from inverse import fold_file, geometry, ipopt, objectives
from inverse.assembly import Problem
from inverse.certify import Certificate, check_frame
from inverse.fold_format import frame_of
from inverse.formulate import Formulation, formulate
from inverse.model import DesignModel
from inverse.pattern import Design, FloatArray
from inverse.refine import polish
from inverse.spec import Loaded

MAX_ROUNDS = 12
SETTLED = 0.1  # rounds go on until the gradient at the new closest points is this fraction of what is allowed

# Limits of our own verdict, all relative. Gradients: to the objective's gradient at the seed. Multiplier times
# slack: to the objective. Equations and bounds: to the mean edge length (lengths) or in radians (angles).
STATIONARITY = 1e-6
COMPLEMENTARITY = 1e-2
EQUATION = 1e-9
BOUND = 1e-7  # IPOPT relaxes bounds by 1e-8 to have an interior


@dataclass(frozen=True, eq=False)
class Result:
    """What a solve found, whether or not it is any good.

    Attributes:
        status: a sentence: how it ended and, unless certified and converged, what to do next.
        converged: stationary and feasible by our own test.
        certified: the independent certificate passes.
        interrupted: stopped by the user or the time limit; the design is the best so far.
        design: the design.
        seed: the placed seed.
        certificate: the independent certificate of the design.
        report: everything told in ``report.json``.
        formulation: target and terms, for pictures.
    """

    status: str
    converged: bool
    certified: bool
    interrupted: bool
    design: Design
    seed: Design
    certificate: Certificate
    report: dict[str, Any]
    formulation: Formulation


@dataclass
class _Run:
    """State shared by the rounds of one solve."""

    formulation: Formulation
    deadline: float
    watch: Callable[[str, ipopt.Progress], None]
    stop: threading.Event
    attempts: list[dict[str, Any]] = field(default_factory=list)
    best: tuple[float, float, FloatArray] = (np.inf, np.inf, np.empty(0))

    def report(self, progress: ipopt.Progress) -> bool:
        """Keep the best iterate; False stops IPOPT."""
        rank = (max(progress.violation, BOUND), progress.objective)
        if rank < self.best[:2]:
            self.best = (*rank, progress.variables)
        self.watch(f"round {len(self.attempts) + 1}", progress)
        return not self.stop.is_set() and time.monotonic() < self.deadline


def solve(loaded: Loaded, watch: Callable[[str, ipopt.Progress], None] | None = None) -> Result:
    """Design a mesh for a specification.

    Args:
        loaded: the specification, from :func:`inverse.load`.
        watch: told every iteration.

    Returns:
        The result; read ``certified`` and ``converged`` before using its design.

    Raises:
        InputError: the specification, or a file that it names, cannot be used.
    """
    began = time.perf_counter()
    formulation = formulate(loaded)
    formulated = time.perf_counter()
    options = loaded.specification.solver
    limit = options.time_limit_s
    run = _Run(
        formulation,
        time.monotonic() + limit if limit is not None else np.inf,
        watch or (lambda _phase, _progress: None),
        threading.Event(),
    )
    with _interruptible(run.stop):
        variables, multipliers, problem, parameters = _rounds(run, options.tolerance, options.max_iterations)
    solved = time.perf_counter()
    variables = polish(problem, variables, parameters)
    design = formulation.goal.model.design(variables)
    polished = time.perf_counter()
    certificate = check_frame(frame_of(fold_file.document(design)))
    seconds = {
        "formulate": formulated - began, "solve": solved - formulated,
        "polish": polished - solved, "certify": time.perf_counter() - polished,
    }  # fmt: skip

    verdict = _verdict(problem, variables, multipliers, parameters, formulation.goal.model)
    interrupted = run.stop.is_set() or time.monotonic() >= run.deadline
    converged = not verdict["failed"]
    report = {
        "converged": converged,
        "certified": certificate.certified,
        "fit": _fit(formulation, design),
        "coverage": _coverage(formulation, design),
        "objective": problem.objective_terms(variables, parameters),
        "verdict": verdict,
        "iterations": sum(a["iterations"] for a in run.attempts),
        "attempts": run.attempts,
        "seconds": seconds,
        "size": {
            "facets": len(design.pattern.faces_vertices), "variables": problem.n_variables,
            "rows": problem.n_rows, "degrees_of_freedom": design.pattern.degrees_of_freedom,
        },
    }  # fmt: skip
    status = _status(converged, certificate, interrupted, verdict, run.attempts)
    return Result(
        status, converged, certificate.certified, interrupted, design, formulation.goal.model.seed,
        certificate, report, formulation,
    )  # fmt: skip


def _rounds(run: _Run, tolerance: float, max_iterations: int) -> tuple[FloatArray, FloatArray, Problem, FloatArray]:
    """Solve; refresh closest points and polyline segments; solve again until the fit stops improving."""
    goal, model = run.formulation.goal, run.formulation.goal.model
    exact = goal.is_exact
    x = model.seed_points.ravel()
    sliding, seen = run.formulation.sliding, set()
    problem, solver, multipliers = None, None, None
    while True:
        if problem is None:
            anchored = [s.constraint(model) for s in sliding]
            problem = Problem(x.size, run.formulation.objectives, [*run.formulation.fixed, *anchored])
            solver = ipopt.Solver(problem, tolerance, max_iterations, run.report)
            seen.add(_segments(sliding))
        assert solver is not None
        parameters = problem.parameters(objectives.refreshed(goal, model.to_lengths(x.reshape(-1, 3))))
        attempt = solver.run(x, parameters, multipliers)
        points = model.to_lengths(attempt.variables.reshape(-1, 3))
        distances = goal.target.distances(objectives.mean_points(points, objectives.fit_vertices(model, goal.fit_points)))
        rms = float(np.sqrt(np.mean(distances**2)))
        run.attempts.append(
            {
                "method": "ipopt", "ended": attempt.status, "iterations": attempt.iterations,
                "seconds": attempt.seconds, "fit_rms": rms,
            }
        )  # fmt: skip
        stopped = run.stop.is_set() or time.monotonic() >= run.deadline
        x, multipliers = (run.best[2] if stopped else attempt.variables), attempt.multipliers
        if stopped or len(run.attempts) >= MAX_ROUNDS:
            break
        onward = [s.moved_on(points) for s in sliding]
        if _segments(onward) not in seen:
            sliding, problem, multipliers = onward, None, None
            continue
        # The verdict looks at the closest points of the design itself, not at those it was solved with.
        parameters = problem.parameters(objectives.refreshed(goal, points))
        if exact or _stationarity(problem, x, multipliers, parameters, model) < SETTLED * STATIONARITY:
            break
    parameters = problem.parameters(objectives.refreshed(goal, model.to_lengths(x.reshape(-1, 3))))
    return x, multipliers, problem, parameters


def _segments(sliding: list[Any]) -> tuple[bytes, ...]:
    return tuple(s.segments.tobytes() for s in sliding)


def _stationarity(
    problem: Problem, x: FloatArray, multipliers: FloatArray, parameters: FloatArray, model: DesignModel
) -> float:
    """Gradient of the Lagrangian, relative to the objective's gradient at the seed."""
    _, gradient = problem.objective_and_gradient(x, parameters)
    _, at_seed = problem.objective_and_gradient(model.seed_points.ravel(), problem.parameters())
    _, jacobian = problem.rows_and_jacobian(x, parameters)
    return float(np.abs(gradient + jacobian.T @ multipliers).max() / (np.abs(at_seed).max() or 1.0))


def _verdict(
    problem: Problem, x: FloatArray, multipliers: FloatArray, parameters: FloatArray, model: DesignModel
) -> dict[str, Any]:
    """Stationarity and feasibility by our own measure, and which of them fail."""
    value, _ = problem.objective_and_gradient(x, parameters)
    rows, _ = problem.rows_and_jacobian(x, parameters)
    stationarity = _stationarity(problem, x, multipliers, parameters, model)
    # A multiplier pushes inward from the bound that its sign belongs to; at a bound that is not there it is a
    # fault of its own size.
    slack = np.maximum(np.where(multipliers > 0, problem.upper - rows, rows - problem.lower), 0.0)
    gap = float(np.abs(multipliers) @ np.where(np.isfinite(slack), slack, 1.0))
    violations = problem.violations(x, parameters)
    equations = {c.name for c in problem.constraints if c.is_equation}
    failed = []
    if not stationarity <= STATIONARITY:
        failed.append(f"the design is not stationary: gradient {stationarity:.2g} of the seed's, {STATIONARITY:g} allowed")
    if not gap <= COMPLEMENTARITY * value + 1e-14:
        failed.append(f"bounds are not settled: multipliers times slacks {gap:.2g}, objective {value:.2g}")
    for name, (size, where) in violations.items():
        allowed = EQUATION if name in equations else BOUND
        if not size <= allowed:
            failed.append(f"constraint {name} is violated by {size:.2g} at {where}, {allowed:g} allowed")
    return {
        "stationarity": stationarity,
        "complementarity": gap,
        "violations": {name: {"value": size, "worst": where} for name, (size, where) in violations.items()},
        "failed": failed,
    }


def _fit(formulation: Formulation, design: Design) -> dict[str, Any]:
    goal = formulation.goal
    groups = objectives.fit_vertices(goal.model, goal.fit_points)

    def measure(points: FloatArray) -> tuple[float, float]:
        distances = goal.target.distances(objectives.mean_points(points, groups))
        return float(np.sqrt(np.mean(distances**2))), float(distances.max())

    rms, largest = measure(design.vertices_coords)
    start_rms, _ = measure(goal.model.seed.vertices_coords)
    size = geometry.diagonal(design.vertices_coords)
    return {
        "points": goal.fit_points, "rms": rms, "max": largest,
        "rms_relative": rms / size, "max_relative": largest / size, "start_rms": start_rms,
        "start_rms_relative": start_rms / geometry.diagonal(goal.model.seed.vertices_coords),
    }  # fmt: skip


def _coverage(formulation: Formulation, design: Design) -> float:
    """Fraction of the target's area within one (mean) facet diameter of the mesh."""
    from inverse.crossing import triangles_of
    from inverse.target.mesh import MeshTarget

    faces = design.pattern.faces_vertices
    points = design.vertices_coords
    diameters = [max(np.linalg.norm(points[a] - points[b]) for a in face for b in face) for face in faces]
    samples, areas = formulation.goal.target.samples()
    distances = MeshTarget(points, triangles_of(faces)[0]).distances(samples)
    return float(areas[distances <= np.mean(diameters)].sum() / areas.sum())


def _status(
    converged: bool, certificate: Certificate, interrupted: bool, verdict: dict[str, Any], attempts: list[dict[str, Any]]
) -> str:
    if converged and certificate.certified:
        return "certified and converged"
    failed = [check.sentence for check in certificate.checks.values() if not check.passed] + list(verdict["failed"])
    start = "interrupted, the best design so far was kept" if interrupted else f"IPOPT ended with {attempts[-1]['ended']}"
    advice = (
        "Let it run on, or raise solver.time_limit_s." if interrupted
        else "Loosen the bounds or anchors, turn the pattern (pattern.turn), or take more facets."
    )  # fmt: skip
    return f"{start}: {'; '.join(failed)}. {advice}"


@contextmanager
def _interruptible(stop: threading.Event) -> Iterator[None]:
    """Let Ctrl-C end the run at its next iteration instead of in the middle of one."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    previous = signal.signal(signal.SIGINT, lambda _signal, _frame: stop.set())
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous)
