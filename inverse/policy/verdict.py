"""Our own verdict on a design: stationary, feasible, fitted; from unscaled residuals, whatever a solver says."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from inverse._types import FloatArray
from inverse.certify import Certificate
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import geometry
from inverse.policy import violations
from inverse.policy.measures import limits
from inverse.spec import Constraints
from inverse.terms.goal import Goal

# All relative. Gradients: to :func:`gradient_scale`. Multipliers times slacks: to the objective.
# Equations and bounds: in mean edge lengths, radians or the dimensionless form of the constraint.
STATIONARITY = 1e-6
COMPLEMENTARITY = 1e-2
EQUATION = 1e-9
SETTLED_GAP = 1e-10  # where the objective itself vanishes: (a hundred-thousandth of an edge) squared
BOUND = 1e-7  # IPOPT relaxes bounds by 1e-8 to have an interior
LIMIT = 1e-6  # of a footprint's limits, relative to them
MOVED = 1e-3  # of the seed's diagonal: what a seed that is the answer is moved by, to have a gradient to compare with


def gradient_scale(problem: Problem, goal: Goal) -> float:
    """What gradients are compared with: the largest component of the objective's at the seed.

    Where the seed is the answer already there is only rounding. What it changes by where every vertex is moved by a
    thousandth of the seed's size, each in a direction of its own so that no term overlooks it, then is larger. A seed
    that is far from its target has 20 to 280 times as much, in all tasks of ``benchmarks/``.
    """
    known = _SCALES.get(problem)
    if known is None or known[0] is not goal:
        known = _SCALES[problem] = goal, _gradient_scale(problem, goal)
    return known[1]


# Asked for several times in every round.
_SCALES: WeakKeyDictionary[Problem, tuple[Goal, float]] = WeakKeyDictionary()


def _gradient_scale(problem: Problem, goal: Goal) -> float:
    seed, n = goal.seed_variables, goal.model.n_variables
    moved = seed.copy()
    moved[:n] += MOVED * geometry.diagonal(goal.model.seed_points) * np.random.default_rng(0).standard_normal(n)
    parameters = problem.parameters()
    at_seed, there = (_by_vertices(Point(problem, x, parameters), goal) for x in (seed, moved))
    sizes = [float(np.abs(gradient).max()) for gradient in (at_seed, there - at_seed)]
    return max((size for size in sizes if np.isfinite(size)), default=0.0) or 1.0


def _by_vertices(point: Point, goal: Goal) -> FloatArray:
    """The objective's gradient (n,) with values of the whole mesh followed back: one of them is worth all vertices."""
    gradient = point.gradient
    for carried in goal.carried:
        gradient = carried.brought_back(gradient, point)
    return gradient


@dataclass(frozen=True)
class Judgement:
    """How near a point is to a solution, by our own test.

    Attributes:
        stationarity: largest component of the Lagrangian's gradient, relative to :func:`gradient_scale`.
        complementarity: multipliers times slacks.
        violations: largest violation of every constraint, dimensionless, and where it is.
        failed: what fails, as sentences.
    """

    stationarity: float
    complementarity: float
    violations: Mapping[str, tuple[float, str]]
    failed: tuple[str, ...]

    def document(self) -> dict[str, Any]:
        """As in ``report.json``."""
        return {
            "stationarity": self.stationarity,
            "complementarity": self.complementarity,
            "violations": {name: {"value": size, "worst": where} for name, (size, where) in self.violations.items()},
            "failed": list(self.failed),
        }


def stationarity(point: Point, goal: Goal) -> float:
    """Largest component of the Lagrangian's gradient, relative to :func:`gradient_scale`."""
    return float(np.abs(point.lagrangian_gradient).max() / gradient_scale(point.problem, goal))


def judge(point: Point, goal: Goal, asked: Constraints | None = None) -> Judgement:
    """Stationarity, complementarity and violations of every constraint, and what of them fails.

    Args:
        point: the design.
        goal: what is fitted.
        asked: the specification's constraints, in whose terms violations are told; without, they have no unit.
    """
    problem, rows, multipliers = point.problem, point.rows, point.balance
    steepness = stationarity(point, goal)
    # A multiplier pushes inward from the bound that its sign belongs to; at a bound that is not there it is a
    # fault of its own size.
    slack = np.maximum(np.where(multipliers > 0, problem.upper - rows, rows - problem.lower), 0.0)
    gap = float(np.abs(multipliers) @ np.where(np.isfinite(slack), slack, 1.0))
    failed = []
    if not steepness <= STATIONARITY:
        failed.append(f"the design is not stationary: relative gradient {steepness:.2g}, {STATIONARITY:g} allowed")
    if not gap <= COMPLEMENTARITY * point.objective + SETTLED_GAP:
        failed.append(f"bounds are not settled: multipliers times slacks {gap:.2g}, objective {point.objective:.2g}")
    failed += violated(point, goal, asked)
    for bound in limits(goal, point.variables):
        if not bound["value"] <= bound["limit"] * (1 + LIMIT):
            failed.append("the {state} {measure} is {value:.6g}, {limit:g} allowed".format(**bound))
    return Judgement(steepness, gap, point.violations, tuple(failed))


def violated(point: Point, goal: Goal, asked: Constraints | None = None) -> list[str]:
    """Sentences on the constraints that do not hold, each with the worst place."""
    found = []
    for violation in violations.worst(point):
        allowed = EQUATION if violation.constraint.is_equation else BOUND
        if violation.size <= allowed:
            continue
        sentence = None
        if asked is not None and np.isfinite(violation.size):
            sentence = violations.Sentences(goal, point.variables, asked).of(violation)
        found.append(
            sentence
            or f"constraint {violation.constraint.name} is violated by {violation.size:.2g} at {violation.label}, "
            f"{allowed:g} allowed"
        )
    return found


def range_faults(asked: tuple[float, float] | None, certificate: Certificate) -> tuple[str, ...]:
    """What of an asked range of motion, (low, high) in radians, is not free of crossing facets, as sentences."""
    free = certificate.free_range
    if asked is None or free is None:  # then the certificate says what is wrong
        return ()
    low, high = np.degrees(asked)
    if free[0] <= low and free[1] >= high:
        return ()
    beyond = "; ".join(end.sentence for end in certificate.crossings)
    return (
        f"the motion is free from {free[0]:.4g} to {free[1]:.4g} degrees, not from {low:.4g} to {high:.4g}: {beyond}",
    )
