"""What the speed is compared with: IPOPT as it comes, the method of the paper, and the time of bare factorizations.

Each returns seconds for the task that the solver has; none is used outside the benchmark.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import casadi
import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

from inverse.formulation.formulate import Formulation
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import geometry
from inverse.solvers.ipopt import OBJECTIVE_SCALE
from inverse.terms.surface_fit import fit_vertices, mean_points

LIMIT = 900.0  # seconds, of IPOPT with its own options


def default_ipopt(formulation: Formulation) -> dict[str, float | int | str]:
    """The same program and derivatives with IPOPT's own options, from the seed."""
    model = formulation.goal.model
    began = time.perf_counter()
    problem = Problem(model.seed_points.size, formulation.objectives, formulation.fixed)
    functions = problem.functions
    options = {
        "print_time": False,
        "ipopt": {"print_level": 0, "sb": "yes", "max_wall_time": LIMIT},
        **{key: functions[key] for key in ("grad_f", "jac_g", "hess_lag")},
    }
    solver = casadi.nlpsol("reference", "ipopt", functions["nlp"], options)
    x = model.seed_points.ravel()
    solver(x0=x, p=problem.parameters(), lbg=problem.lower, ubg=problem.upper)
    stats = solver.stats()
    return {
        "seconds": time.perf_counter() - began,
        "iterations": int(stats["iter_count"]),
        "ended": str(stats["return_status"]),
    }


def paper(formulation: Formulation, rms: float, steps: int = 400) -> dict[str, float | int]:
    """Equation (9): Euler steps of the wished movement, projected with a dense pseudo-inverse, then Newton's steps.

    Every vertex wishes to move by the mean of what brings the centroids of its facets onto the target.

    Args:
        formulation: what is solved; its bounds and weights have no place in this method.
        rms: fit at which the reference may stop, relative to the diagonal.
        steps: at most so many.
    """
    goal = formulation.goal
    model, faces = goal.model, goal.model.pattern.faces_vertices
    equations = [c for c in formulation.fixed if c.is_equation]
    problem = Problem(model.seed_points.size, formulation.objectives, equations)
    p = problem.parameters()
    corners, facets = np.concatenate(faces), np.repeat(np.arange(len(faces)), [len(face) for face in faces])
    share = sparse.csr_matrix((np.ones(len(corners)), (corners, facets)), (model.pattern.n_vertices, len(faces)))
    share = sparse.diags(1 / np.asarray(share.sum(axis=1)).ravel()) @ share
    groups = fit_vertices(model, "facets")
    problem.functions  # noqa: B018  building is not part of the method
    began = time.perf_counter()
    x = model.seed_points.ravel()
    made, reached = 0, np.inf
    while made < steps:
        points = model.points(x)
        middles = mean_points(points, groups)
        reached = float(np.sqrt(np.mean(goal.fitting.distances(points) ** 2)) / geometry.diagonal(points))
        if reached <= rms:
            break
        wish = 0.5 * (share @ (goal.target.closest(middles).feet - middles)) / model.scale
        jacobian = Point(problem, x, p).jacobian
        inverse = np.linalg.pinv(jacobian.toarray())
        move = wish.ravel()
        x = x + move - inverse @ (jacobian @ move)
        for _ in range(3):
            x = x - inverse @ Point(problem, x, p).rows
        made += 1
    return {"seconds": time.perf_counter() - began, "steps": made, "rms": reached}


def floor(formulation: Formulation) -> dict[str, float | str]:
    """Seconds of the fastest factorization at hand of the matrix that a step needs, equations only."""
    model = formulation.goal.model
    problem = Problem(model.seed_points.size, formulation.objectives, [c for c in formulation.fixed if c.is_equation])
    p = problem.parameters()
    x = model.seed_points.ravel() + 1e-3 * np.random.default_rng(0).standard_normal(problem.n_variables)
    jacobian = Point(problem, x, p).jacobian
    scale = OBJECTIVE_SCALE * model.refinement**2
    upper = problem.functions["hess_lag"](x, problem.layout.linearized(p), scale, np.zeros(problem.n_rows)).sparse()
    hessian = upper + sparse.triu(upper, 1).T + 1e-4 * sparse.identity(problem.n_variables)
    corner = -1e-8 * sparse.identity(problem.n_rows)
    matrix = sparse.bmat([[hessian, jacobian.T], [jacobian, corner]], format="csc")
    found = {name: min(_seconds(make(matrix)) for _ in range(3)) for name, make in _libraries().items()}
    fastest = min(found, key=lambda name: found[name])
    return {"seconds": found[fastest], "library": fastest, **{f"seconds_{name}": s for name, s in found.items()}}


def _seconds(factorize: Callable[[], object]) -> float:
    began = time.perf_counter()
    factorize()
    return time.perf_counter() - began


def _libraries() -> dict[str, Callable[[sparse.csc_matrix], Callable[[], object]]]:
    """By name: what prepares a factorization, with its ordering where that can be reused, and returns it."""

    def superlu(matrix: sparse.csc_matrix) -> Callable[[], object]:
        return lambda: splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    found: dict[str, Callable[[sparse.csc_matrix], Callable[[], object]]] = {"superlu": superlu}
    try:
        import qdldl

        def with_qdldl(matrix: sparse.csc_matrix) -> Callable[[], object]:
            upper = sparse.triu(matrix, format="csc")
            solver = qdldl.Solver(upper, upper=True)
            return lambda: solver.update(upper, upper=True)

        found["qdldl"] = with_qdldl
    except ImportError:
        pass
    try:
        import pypardiso

        def pardiso(matrix: sparse.csc_matrix) -> Callable[[], object]:
            upper = sparse.triu(matrix, format="csr")
            solver = pypardiso.PyPardisoSolver(mtype=-2)
            right = np.ones(matrix.shape[0])
            solver.set_phase(11)
            solver._call_pardiso(upper, right)
            solver.set_phase(22)
            return lambda: solver._call_pardiso(upper, right)

        found["pardiso"] = pardiso
    except ImportError:
        pass
    return found
