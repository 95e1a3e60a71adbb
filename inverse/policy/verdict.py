"""Our own verdict on a design: stationary, feasible, fitted; from unscaled residuals, whatever a solver says."""

from __future__ import annotations

from typing import Any

import numpy as np

from inverse import objectives
from inverse._types import FloatArray
from inverse.certify import Certificate
from inverse.crossing import triangles_of
from inverse.nlp.problem import Problem
from inverse.objectives import Goal
from inverse.origami import footprint as folded
from inverse.origami import geometry
from inverse.origami.pattern import Design
from inverse.surfaces.mesh import MeshTarget
from inverse.surfaces.tube import TubeTarget
from inverse.terms import tube_fit
from inverse.terms.packed import SIDES

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
    seed, n = goal.seed_variables, goal.model.n_variables
    moved = seed.copy()
    moved[:n] += MOVED * geometry.diagonal(goal.model.seed_points) * np.random.default_rng(0).standard_normal(n)
    parameters = problem.parameters()
    at_seed, there = (problem.objective_and_gradient(x, parameters)[1] for x in (seed, moved))
    sizes = [float(np.abs(gradient).max()) for gradient in (at_seed, there - at_seed)]
    return max((size for size in sizes if np.isfinite(size)), default=0.0) or 1.0


def stationarity(problem: Problem, x: FloatArray, multipliers: FloatArray, parameters: FloatArray, goal: Goal) -> float:
    """Largest component of the Lagrangian's gradient, relative to :func:`gradient_scale`."""
    _, gradient = problem.objective_and_gradient(x, parameters)
    _, jacobian = problem.rows_and_jacobian(x, parameters)
    return float(np.abs(gradient + jacobian.T @ multipliers).max() / gradient_scale(problem, goal))


def judge(
    problem: Problem, x: FloatArray, multipliers: FloatArray, parameters: FloatArray, goal: Goal
) -> dict[str, Any]:
    """Stationarity, complementarity and violations of every constraint; ``failed`` says in sentences what fails."""
    value, _ = problem.objective_and_gradient(x, parameters)
    rows = problem.rows(x, parameters)
    steepness = stationarity(problem, x, multipliers, parameters, goal)
    # A multiplier pushes inward from the bound that its sign belongs to; at a bound that is not there it is a
    # fault of its own size.
    slack = np.maximum(np.where(multipliers > 0, problem.upper - rows, rows - problem.lower), 0.0)
    gap = float(np.abs(multipliers) @ np.where(np.isfinite(slack), slack, 1.0))
    violations = problem.violations(x, parameters)
    equations = {c.name for c in problem.constraints if c.is_equation}
    failed = []
    if not steepness <= STATIONARITY:
        failed.append(f"the design is not stationary: relative gradient {steepness:.2g}, {STATIONARITY:g} allowed")
    if not gap <= COMPLEMENTARITY * value + SETTLED_GAP:
        failed.append(f"bounds are not settled: multipliers times slacks {gap:.2g}, objective {value:.2g}")
    for name, (size, where) in violations.items():
        allowed = EQUATION if name in equations else BOUND
        if not size <= allowed:
            failed.append(f"constraint {name} is violated by {size:.2g} at {where}, {allowed:g} allowed")
    for bound in limits(goal, x):
        if not bound["value"] <= bound["limit"] * (1 + LIMIT):
            failed.append("the {state} {measure} is {value:.6g}, {limit:g} allowed".format(**bound))
    return {
        "stationarity": steepness,
        "complementarity": gap,
        "violations": {name: {"value": size, "worst": where} for name, (size, where) in violations.items()},
        "failed": failed,
    }


def range_faults(asked: tuple[float, float] | None, certificate: Certificate) -> list[str]:
    """What of an asked range of motion, (low, high) in radians, is not free of crossing facets, as sentences."""
    free = certificate.free_range
    if asked is None or free is None:  # then the certificate says what is wrong
        return []
    low, high = np.degrees(asked)
    if free[0] <= low and free[1] >= high:
        return []
    beyond = "; ".join(end.sentence for end in certificate.crossings)
    return [
        f"the motion is free from {free[0]:.4g} to {free[1]:.4g} degrees, not from {low:.4g} to {high:.4g}: {beyond}"
    ]


def fit_distances(goal: Goal, points: FloatArray) -> FloatArray:
    """Distances (N,) of the fitted points of vertices ``points`` (V, 3) from the target, border included.

    Of a tube those of its rings: offsets from the axis and excess of radius, by Pythagoras.
    """
    if goal.tube is not None:
        centroids = tube_fit.ring_centroids(goal.model.pattern, points)
        return np.asarray(np.hypot(*tube_fit.deviations(goal.tube, centroids)))
    return goal.target.distances(objectives.mean_points(points, objectives.fit_vertices(goal.model, goal.fit_points)))


def fit(goal: Goal, design: Design) -> dict[str, Any]:
    """The fit as reported: rms and max in length units and relative to the diagonal, and the placed seed's."""
    distances = fit_distances(goal, design.vertices_coords)
    at_start = fit_distances(goal, goal.model.seed.vertices_coords)
    size, start_size = (geometry.diagonal(d.vertices_coords) for d in (design, goal.model.seed))
    rms, start_rms = (float(np.sqrt(np.mean(d**2))) for d in (distances, at_start))
    found = {
        "points": "rings" if goal.tube is not None else goal.fit_points,
        "rms": rms,
        "max": float(distances.max()),
        "rms_relative": rms / size,
        "max_relative": float(distances.max()) / size,
        "start_rms": start_rms,
        "start_rms_relative": start_rms / start_size,
    }
    return found if goal.tube is None else found | _tube_fit(goal, goal.tube, design, distances)


def _tube_fit(goal: Goal, target: TubeTarget, design: Design, distances: FloatArray) -> dict[str, Any]:
    """What is told of tubes besides: relative to the radius of each ring, and of the facets by themselves."""
    centroids = tube_fit.ring_centroids(goal.model.pattern, design.vertices_coords)
    relative = distances / target.stations(centroids.mean(axis=1)).radii
    facets = target.distances(centroids.reshape(-1, 3))
    ends = design.vertices_coords[tube_fit.ring_vertices(goal.model.pattern)[[0, -1]]].mean(axis=1)
    reached = target.stations(ends).fractions
    return {
        "mean_over_radius": float(relative.mean()),
        "max_over_radius": float(relative.max()),
        "facets_rms": float(np.sqrt(np.mean(facets**2))),
        "facets_max": float(facets.max()),
        "ends": reached.tolist(),
    }


def coverage(goal: Goal, design: Design) -> float:
    """Fraction of the target's area within one (mean) facet diameter of the mesh."""
    faces, points = design.pattern.faces_vertices, design.vertices_coords
    diameters = [max(np.linalg.norm(points[a] - points[b]) for a in face for b in face) for face in faces]
    samples, areas = goal.target.samples()
    distances = MeshTarget(points, triangles_of(faces)[0]).distances(samples)
    return float(areas[distances <= np.mean(diameters)].sum() / areas.sum())


def footprint(goal: Goal, x: FloatArray) -> dict[str, Any]:
    """The footprint as reported: of the flat states, of those with variables of their own, and what was limited."""
    states = folded.FLAT_STATES | {state.name: state.t for state in goal.packed}
    return {**folded.measured(goal.model.design(x), states), "limits": limits(goal, x)}


def limits(goal: Goal, x: FloatArray) -> list[dict[str, Any]]:
    """Every limited extent and area: its limit and its value, in the box's directions, of the design as it folds.

    Of the packed state's variables only the directions are believed: that a box so turned is large enough proves that
    there is one.
    """
    found: list[dict[str, Any]] = []
    design = goal.model.design(x)
    for state in goal.packed:
        points = folded.laid_out(design, state.t)[:, : state.dimension]
        sizes = folded.extents(points, state.axes(x)).tolist()
        limited = [(SIDES[k], size, float(state.limits[k])) for k, size in zip(state.sides, sizes, strict=True)]
        limited.append(("area", sizes[0] * sizes[-1], state.area))
        found += [
            {"state": state.name, "measure": word, "value": value, "limit": limit}
            for word, value, limit in limited
            if np.isfinite(limit)
        ]
    return found
