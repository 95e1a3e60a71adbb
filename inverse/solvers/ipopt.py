"""One IPOPT run on an assembled problem."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import casadi
import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.nlp.layout import Layout
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.nlp.redundancy import redundant
from inverse.solvers.run import Ending, Progress, Run

# Measured on domes and vaults of 16 x 16 to 32 x 32 facets. METIS ordering and the adaptive barrier make most of
# the difference. The objective is scaled by us (SHARE), not by IPOPT.
OPTIONS: dict[str, Any] = {
    "print_level": 0,
    "sb": "yes",
    "linear_solver": "mumps",
    "mumps_pivot_order": 5,
    "mumps_permuting_scaling": 0,
    "mumps_scaling": 0,
    "perturb_always_cd": "yes",
    "jacobian_regularization_value": 1e-8,
    "mu_strategy": "adaptive",
    "nlp_scaling_method": "none",
}

# IPOPT minimizes this multiple of the mean square of distances in edges: gradients of the order of the constraints'.
OBJECTIVE_SCALE = 1000.0

# Static pivots make an iteration twice as fast at 32 x 32, since nothing is delayed and the factors stay sparse; the
# regularized constraint block keeps the matrix quasi-definite. Their steps are less exact, and some runs stall
# short of the tolerance: those go on with pivoting.
STATIC_PIVOTS: dict[str, Any] = {"mumps_pivtol": 0.0, "mumps_pivtolmax": 0.0}
STALL = 100  # iterations after which static pivots are given up

# Far from the solution the constraints' curvature makes the Hessian indefinite, IPOPT adds a multiple of the identity
# until it is not, and the steps become short. With the constraints taken as linear (the Gauss-Newton idea) the first
# steps are long; close to the solution they only go round it, and Newton's method takes over.
SETTLED = 0.1  # they end when one changes the objective by less than this fraction ...
APPROACH = 30  # ... or after so many
NEAR = 1e-2  # ... but not while a violation is larger than this; from there on iterates are worth going on from

# Where equations follow from others they are left out of Newton's method, which may then go along a branch where they
# do not hold. It begins nearer to the solution: of 15 tubes seven strayed with the values above, with these none.
SETTLED_CLOSE = 1e-3
APPROACH_CLOSE = 100

# From a coarser grid's design the first steps leave little to gain, and Newton's method would still be far from where
# the Lagrangian is convex: more of them are made, then some with a part of the constraints' curvature, each until the
# objective changes by less than these fractions, or so many.
SETTLED_SPREAD, APPROACH_SPREAD = 0.005, 20
PART, SETTLED_IN_PART, STEPS_IN_PART = 0.7, 0.002, 20

APPROACHING, STATIC, PIVOTED = "linearized constraints", "static pivots", "pivoting"  # methods, for the report
EASED = "part of the constraints' curvature"

NO_ROWS: IntArray = np.empty(0, np.int64)

PIVOTING: dict[str, Any] = {"mumps_pivtol": 1e-6, "mumps_pivtolmax": 0.1}

WARM_START: dict[str, Any] = {
    "warm_start_init_point": "yes",
    "warm_start_bound_push": 1e-9,
    "warm_start_slack_bound_push": 1e-9,
    "warm_start_bound_frac": 1e-9,
    "warm_start_slack_bound_frac": 1e-9,
    "warm_start_mult_bound_push": 1e-9,
    "mu_init": 1e-6,
}


class _Watch(casadi.Callback):
    """Copies every iterate, reports it, and stops the run on request."""

    def __init__(self, problem: Problem, n_parameters: int, report: Callable[[Progress], bool]) -> None:
        super().__init__()
        self._n, self._rows, self._n_parameters = problem.n_variables, problem.n_rows, n_parameters
        self._lower, self._upper = problem.lower, problem.upper
        self._report = report
        self.begin(0, 0.0)
        self.construct("watch", {})

    def begin(self, limit: int, settled: float) -> None:
        """Get ready for a run that ends after ``limit`` iterations, or when the objective changes by no more."""
        self._limit, self._settled = limit, settled
        self._last = np.nan  # objective of the iterate before
        self._count = 0
        self.ended: Ending | None = None
        self.error: BaseException | None = None

    def get_n_in(self) -> int:
        return int(casadi.nlpsol_n_out())

    def get_n_out(self) -> int:
        return 1

    def get_name_in(self, i: int) -> str:
        return str(casadi.nlpsol_out(i))

    def get_sparsity_in(self, i: int) -> casadi.Sparsity:
        sizes = {
            "f": 1,
            "x": self._n,
            "lam_x": self._n,
            "g": self._rows,
            "lam_g": self._rows,
            "lam_p": self._n_parameters,
        }
        return casadi.Sparsity.dense(sizes[casadi.nlpsol_out(i)], 1)

    def eval(self, arguments: Sequence[casadi.DM]) -> list[int]:
        values = {casadi.nlpsol_out(i): a for i, a in enumerate(arguments)}
        rows = np.asarray(values["g"]).ravel()
        violation = float(np.maximum(np.maximum(self._lower - rows, rows - self._upper), 0).max(initial=0.0))
        variables = np.array(values["x"]).ravel()
        progress = Progress(self._count, float(values["f"]), violation, variables)
        last, self._last = self._last, progress.objective
        self._count += 1
        try:
            if not self._report(progress):
                return [1]
        except BaseException as error:  # raised again by run(): CasADi would swallow it
            self.error = error
            return [1]
        if self._settled and violation <= NEAR and abs(progress.objective - last) <= self._settled * last:
            self.ended = Ending.SETTLED
        if progress.iteration >= self._limit:
            self.ended = Ending.LIMIT
        return [0 if self.ended is None else 1]


class Ipopt:
    """IPOPT on one problem; parameters change between runs without building anew.

    Args:
        problem: the problem.
        tolerance: of IPOPT.
        refinement: of the model, which the objective is scaled by.
        report: told every iterate; False stops the run.
    """

    def __init__(
        self, problem: Problem, tolerance: float, refinement: float, report: Callable[[Progress], bool]
    ) -> None:
        self._problem = problem
        self._solvers: dict[tuple[bool, bool], casadi.Function] = {}
        self._options: dict[str, Any] = OPTIONS | {
            "obj_scaling_factor": OBJECTIVE_SCALE * refinement**2,
            "tol": tolerance,
            "constr_viol_tol": tolerance,
            "compl_inf_tol": tolerance,
            "acceptable_iter": 0,
            "max_iter": np.iinfo(np.int32).max,  # the watch counts
        }
        if problem.has_passive_variables:
            # Where equations only carry one variable over to the next, regularized ones leave an error that adds up
            # along the chain: line searches then refuse the last steps.
            self._options["perturb_always_cd"] = "no"
        self._watch = _Watch(problem, problem.parameters().size, report)

    def _solver(self, warm: bool, careful: bool) -> casadi.Function:
        """The solver with the given options, built when first needed."""
        if (warm, careful) not in self._solvers:
            functions = self._problem.functions
            options: dict[str, Any] = {
                "print_time": False,
                "show_eval_warnings": False,  # a step to where a term has no value is made shorter, and that is all
                "calc_lam_p": False,
                "calc_lam_x": False,
                "iteration_callback": self._watch,
                "ipopt": self._options | (PIVOTING if careful else STATIC_PIVOTS) | (WARM_START if warm else {}),
                **{key: functions[key] for key in ("grad_f", "jac_g", "hess_lag")},
            }
            self._solvers[warm, careful] = casadi.nlpsol("design", "ipopt", functions["nlp"], options)
        return self._solvers[warm, careful]

    def approach(self, start: Point, limit: int, *, is_good: bool, is_spread: bool = False) -> Run:
        """Come near a solution with the constraints taken as linear in the Hessian.

        Args:
            start: where.
            limit: iterations.
            is_good: whether the start comes from a solution; it is not pushed off the bounds then.
            is_spread: whether that solution is a coarser grid's.

        Raises:
            BaseException: what the report function raised.
        """
        close = self._problem.has_redundant_equations
        near = (APPROACH_SPREAD, SETTLED_SPREAD) if is_spread else (APPROACH, SETTLED)
        steps, settled = (APPROACH_CLOSE, SETTLED_CLOSE) if close else near
        self._watch.begin(min(steps, limit), settled)
        linear = start.given(Layout.linearized(start.parameters))
        warm = linear.pushed(np.zeros(self._problem.n_rows) if is_good else None)
        return self._run(warm, start.parameters, NO_ROWS, APPROACHING, careful=False)

    def ease(self, start: Point, limit: int) -> Run:
        """Come nearer with a part of the constraints' curvature, with which the Lagrangian is convex sooner.

        Args:
            start: where an approach ended.
            limit: iterations.

        Raises:
            BaseException: what the report function raised.
        """
        self._watch.begin(min(STEPS_IN_PART, limit), SETTLED_IN_PART)
        eased = start.given(Layout.linearized(start.parameters, PART))
        return self._run(eased, start.parameters, redundant(start), EASED, careful=False)

    def run(self, start: Point, limit: int, *, careful: bool) -> Run:
        """Solve from a start, warm where it has multipliers; of equations that repeat each other only independent ones.

        Args:
            start: where.
            limit: iterations.
            careful: pivot for accuracy instead of speed; without, at most ``STALL`` iterations are made.

        Raises:
            BaseException: what the report function raised, KeyboardInterrupt included.
        """
        self._watch.begin(limit if careful else min(STALL, limit), 0.0)
        method = PIVOTED if careful else STATIC
        return self._run(start, start.parameters, redundant(start), method, careful=careful)

    def _run(self, start: Point, parameters: FloatArray, left_out: IntArray, method: str, *, careful: bool) -> Run:
        """Solve; the end is a point of the given parameters."""
        began = time.perf_counter()
        solver = self._solver(start.multipliers is not None, careful)
        lower, upper = self._problem.lower.copy(), self._problem.upper.copy()
        lower[left_out], upper[left_out] = -np.inf, np.inf
        out = solver(x0=start.variables, p=start.parameters, lbg=lower, ubg=upper, lam_g0=start.balance)
        if self._watch.error is not None:
            raise self._watch.error
        stats = solver.stats()
        end = Point(self._problem, np.array(out["x"]).ravel(), parameters, np.array(out["lam_g"]).ravel())
        return Run(
            end,
            self._watch.ended or Ending(stats["return_status"]),
            int(stats["iter_count"]),
            time.perf_counter() - began,
            sum(
                stats.get(f"t_wall_{name}", 0.0) for name in ("nlp_f", "nlp_g", "nlp_grad_f", "nlp_jac_g", "nlp_hess_l")
            ),
            method,
        )
