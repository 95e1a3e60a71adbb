"""One nlopt run on an assembled problem: SLSQP in coordinates of the manifold where all equations hold.

nlopt's quasi-Newton methods know no sparsity and no second derivatives. Both are put into the coordinates: a chart
removes the equations and with them most variables, and its axes are scaled by the curvature of the Lagrangian, so that
the first step in each chart is Newton's. After a few evaluations a chart is left for one around the best point found.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable

import nlopt
import numpy as np
import scipy.sparse as sparse

from inverse._types import FloatArray, IntArray
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.solvers.chart import Chart, ChartPoint, Functions
from inverse.solvers.run import Ending, Progress, Run

EVALUATIONS = 10  # in one chart: taking the curvature anew costs little more than one
REDUCED = "SLSQP where all equations hold"  # method, for the report
REACH = 0.13  # first trust region: move along one axis of a chart, in mean edges times the root of the variables
NARROW = 1e-5  # ... and where it has become this small, nothing better is found
NOTHING = 1e-12  # of the objective: a gain that may be rounding
WATCHED = 2.0  # bounds are watched that a step of this many times Newton's length might reach
FLAT = 1e-4  # of the largest curvature: what is less counts as this
EQUATION, BOUND = 1e-9, 1e-8  # of a solution
FAIR = 1e-6  # gradient that counts as solved where rounding allows no less, see verdict.STATIONARITY
LITTLE = 1e-4  # a chart is left when nlopt gains less than this, relative to Newton's first step
SAME = 1e-6  # difference of rows that count as the same, relative to their slopes
OVERWEIGHT = 10.0  # of a residual that is left at the start of a chart, relative to what the objective gains by it


class Slsqp:
    """nlopt on one problem; parameters change between runs without building anew.

    Args:
        problem: the problem; at least one of its rows is an equation.
        tolerance: for the gradient of the Lagrangian.
        steepness: largest component of the gradient that gradients are measured by, such as the seed's.
        report: told every iterate; False stops the run.
    """

    def __init__(
        self, problem: Problem, tolerance: float, steepness: float, report: Callable[[Progress], bool]
    ) -> None:
        self._problem, self._tolerance, self._steepness, self._report = problem, tolerance, steepness, report

    def run(self, start: Point, limit: int) -> Run:
        """Solve from a start; its multipliers, where it has some, are for the first curvature.

        Args:
            start: where.
            limit: evaluations of the functions.

        Raises:
            BaseException: what the report function raised, KeyboardInterrupt included.
        """
        parameters, multipliers = start.parameters, start.multipliers
        began = time.perf_counter()
        functions = Functions(self._problem, parameters)
        chart = Chart(functions, start.variables)
        reach, count, stalled = REACH * np.sqrt(len(start.variables)), 0, False
        while True:
            found = _multipliers(self._problem, chart)
            status = self._status(chart.place, found, stalled, count >= limit, reach)
            if status is None:
                curving = found if multipliers is None else _completed(self._problem, chart, multipliers)
                multipliers = None
                search = _Search(self._problem, functions, chart, curving, reach, count, self._report)
                search.run(min(EVALUATIONS, limit - count))
                count, stalled = search.count, search.gain <= NOTHING * chart.place.objective
                # Where a chart ends before the trust region does, the region was too large.
                reach *= 0.25 if stalled else 0.5 if search.lost else 2.0
                if search.gain > 0.0:
                    chart = Chart(functions, search.best.variables)
                if not search.given_up:
                    continue
                status = Ending.GIVEN_UP
            end = Point(self._problem, chart.place.variables, parameters, found)
            return Run(end, status, count, time.perf_counter() - began, functions.seconds, REDUCED)

    def _status(
        self, place: ChartPoint, multipliers: FloatArray, stalled: bool, is_limit: bool, reach: float
    ) -> Ending | None:
        """How the run ends here, if it does."""
        lower, upper = self._problem.lower, self._problem.upper
        beyond = np.maximum(lower - place.rows, place.rows - upper)
        steep = np.abs(place.gradient + place.jacobian.T @ multipliers).max() / self._steepness
        feasible = bool((beyond <= np.where(lower == upper, EQUATION, BOUND)).all())
        if feasible and steep <= (max(FAIR, self._tolerance) if stalled else self._tolerance):
            return Ending.SOLVED
        if is_limit:
            return Ending.LIMIT
        return Ending.NO_STEP if reach < NARROW else None


class _Search:
    """What nlopt is given in one chart: functions of scaled coordinates y, the last the share of the residual."""

    def __init__(
        self,
        problem: Problem,
        functions: Functions,
        chart: Chart,
        multipliers: FloatArray,
        reach: float,
        count: int,
        report: Callable[[Progress], bool],
    ) -> None:
        self._problem, self._chart, self._report = problem, chart, report
        self.count = count
        self.best, self.gain = chart.place, 0.0
        self.lost = self.given_up = False
        self.error: BaseException | None = None
        place, tangents = chart.place, chart.tangents
        hessian = tangents.T @ (functions.hessian(place.variables, multipliers) @ tangents)
        curvature, axes = np.linalg.eigh((hessian + hessian.T) / 2)
        # Newton's step towards a saddle or a maximum becomes one away from it.
        curvature = np.maximum(np.abs(curvature), FLAT * np.abs(curvature).max())
        scale = 1 / np.sqrt(curvature)
        # In units of Newton's step, since nlopt's systems lose what is far below 1.
        length = float(np.linalg.norm(scale * (place.gradient @ tangents @ axes))) or 1.0
        self._unit = length**2  # of the objective
        self._directions = tangents @ axes * (length * scale)
        # Bounds cost nlopt time; those that no step will reach are left out.
        self._bounds = np.where(reach > WATCHED * length * scale, np.inf, reach / (length * scale))
        lower, upper = problem.lower, problem.upper
        inequalities = lower != upper
        # Exact penalties: of bounds, to compare points that violate them; of the residual, as nlopt minimizes it.
        self._penalty = max(2 * float(np.abs(multipliers[inequalities]).max(initial=0.0)), place.objective)
        gain = chart.slopes(place, sparse.csr_matrix(place.gradient), self._directions)[0, -1]
        self._weight = OVERWEIGHT * (abs(float(gain)) + place.objective or 1.0) if chart.residual.any() else 0.0
        self._share = length / np.sqrt(self._weight) if self._weight else 1.0
        step = float(np.linalg.norm(chart.correction))
        self._least = 1.0 - min(1.0, reach / step) if step > 0.0 else 1.0
        self._low, self._high = self._watched()
        self._merit = self._value(place, 1.0)
        self._last: tuple[bytes, ChartPoint | None] = (b"", None)

    def run(self, limit: int) -> None:
        """Let nlopt minimize, and keep the best point.

        Raises:
            BaseException: what the report function raised.
        """
        n, m = self._directions.shape[1], len(self._low) + len(self._high)
        self._optimizer = nlopt.opt(nlopt.LD_SLSQP, n + 1)
        self._optimizer.set_min_objective(self._objective)
        if m:
            self._optimizer.add_inequality_mconstraint(self._beyond, np.full(m, BOUND))
        self._optimizer.set_lower_bounds(np.append(-self._bounds, self._least / self._share))
        self._optimizer.set_upper_bounds(np.append(self._bounds, 1 / self._share))
        self._optimizer.set_maxeval(limit)
        self._optimizer.set_ftol_abs(LITTLE)
        # However it ends: the best point is known, and what it is worth is judged elsewhere.
        with contextlib.suppress(nlopt.ForcedStop, nlopt.RoundoffLimited, nlopt.runtime_error, RuntimeError):
            self._optimizer.optimize(np.append(np.zeros(n), 1 / self._share))
        if self.error is not None:
            raise self.error

    def _watched(self) -> tuple[IntArray, IntArray]:
        """Rows whose lower, and whose upper bounds a step of a few times Newton's length might reach.

        Of rows that are one function on the manifold, as the folds along a line are, one is enough; with all of them
        the systems that nlopt solves would be singular to rounding.
        """
        problem, place = self._problem, self._chart.place
        inequalities = np.flatnonzero(problem.lower != problem.upper)
        slopes = place.jacobian[inequalities] @ self._directions
        steepness = np.linalg.norm(slopes, axis=1)
        reachable = WATCHED * (steepness + np.abs(place.jacobian @ self._chart.correction)[inequalities])
        found = []
        for sign, slack in ((-1, place.rows - problem.lower), (1, problem.upper - place.rows)):
            near = np.flatnonzero(slack[inequalities] <= reachable)
            table = np.column_stack([sign * slopes, slack[inequalities]])[near] / steepness[near, None]
            # Rows that are the same come to stand side by side.
            order = np.argsort(table @ np.random.default_rng(0).standard_normal(table.shape[1]), kind="stable")
            differs = np.linalg.norm(np.diff(table[order], axis=0), axis=1) > SAME
            found.append(inequalities[near[np.sort(order[np.append(True, differs)[: len(order)]])]])
        return found[0], found[1]

    def _objective(self, y: FloatArray, gradient: FloatArray) -> float:
        place = self._place(y)
        if place is None:
            gradient[:] = 0.0
            return np.inf
        if gradient.size:
            gradient[:] = self._slopes(place, sparse.csr_matrix(place.gradient))[0]
            gradient[-1] += self._weight * self._share
            gradient /= self._unit
        change = place.objective - self._chart.place.objective
        return (change + self._weight * (self._share * float(y[-1]) - 1)) / self._unit

    def _beyond(self, result: FloatArray, y: FloatArray, gradient: FloatArray) -> None:
        """By how much the watched rows are beyond their bounds; negative within."""
        place = self._place(y)
        if place is None:
            result[:], gradient[:] = np.inf, 0.0
            return
        low, high = self._low, self._high
        result[: len(low)] = self._problem.lower[low] - place.rows[low]
        result[len(low) :] = place.rows[high] - self._problem.upper[high]
        if gradient.size:
            gradient[:] = self._slopes(place, sparse.vstack([-place.jacobian[low], place.jacobian[high]]).tocsr())

    def _slopes(self, place: ChartPoint, vectors: sparse.csr_matrix) -> FloatArray:
        slopes = self._chart.slopes(place, vectors, self._directions)
        slopes[:, -1] *= self._share
        return slopes

    def _place(self, y: FloatArray) -> ChartPoint | None:
        """The point at y; None where there is none, and when the run is over."""
        if self.error is not None or self.given_up:
            return None
        if y.tobytes() == self._last[0]:
            return self._last[1]
        share = float(y[-1]) * self._share
        try:
            place = self._chart.at(self._directions @ y[:-1], share)
            self._last = y.tobytes(), place
            if place is None:
                self.lost = True
            else:
                gain = self._merit - self._value(place, share)
                if gain > self.gain:
                    self.best, self.gain = place, gain
                excess = np.maximum(self._problem.lower - place.rows, place.rows - self._problem.upper)
                progress = Progress(self.count, place.objective, max(float(excess.max()), 0.0), place.variables)
                self.given_up = not self._report(progress)
            self.count += 1
        except BaseException as error:  # raised again by run(): nlopt would swallow it
            self.error = error
        if self.error is not None or self.given_up:
            self._optimizer.force_stop()
            return None
        return place

    def _value(self, place: ChartPoint, share: float) -> float:
        """Objective and exact penalties."""
        lower, upper = self._problem.lower, self._problem.upper
        beyond = np.maximum(lower - place.rows, place.rows - upper)[lower != upper]
        return place.objective + self._weight * share + self._penalty * float(np.maximum(beyond, 0.0).sum())


def _multipliers(problem: Problem, chart: Chart) -> FloatArray:
    """Multipliers (R,) that come nearest to a stationary Lagrangian, of the sign that each active bound asks for."""
    from scipy.optimize import nnls

    place = chart.place
    inequalities = problem.lower != problem.upper
    low = np.flatnonzero(inequalities & (place.rows - problem.lower <= BOUND))
    high = np.flatnonzero(inequalities & (problem.upper - place.rows <= BOUND))
    multipliers = np.zeros(problem.n_rows)
    if len(low) + len(high):
        slopes = np.vstack([-(place.jacobian[low] @ chart.tangents), place.jacobian[high] @ chart.tangents])
        found, _ = nnls(slopes.T, -(place.gradient @ chart.tangents))
        multipliers[low], multipliers[high] = -found[: len(low)], found[len(low) :]
    return _completed(problem, chart, multipliers)


def _completed(problem: Problem, chart: Chart, multipliers: FloatArray) -> FloatArray:
    """The same multipliers (R,) of inequalities, with those of the equations that belong to them."""
    place, equations = chart.place, problem.lower == problem.upper
    completed = np.where(equations, 0.0, multipliers)
    completed[equations] = chart.multipliers(place.gradient + place.jacobian.T @ completed)
    return completed
