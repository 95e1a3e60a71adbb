"""The nearest exact mesh: Newton steps of least norm, in stages where the way is long."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from inverse import constraints
from inverse.model import DesignModel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import geometry
from inverse.origami.pattern import Design
from inverse.solvers.projection import polish

STAGE = 0.05  # radians or the like: the largest residual that one stage removes
SETTLED = 1e-9  # a stage that leaves more has failed
LENGTHS = (0.2, 5.0)  # edges may change by these factors
FLAT_FOLD = np.radians(1.0)  # a fold below this has no sign to keep


@dataclass(frozen=True, eq=False)
class Snapped:
    """What came out.

    Attributes:
        design: the design, exact to rounding unless ``faults`` says otherwise.
        residual: largest dimensionless residual of the equations.
        faults: sentences, empty where the mesh stayed a mesh.
    """

    design: Design
    residual: float
    faults: tuple[str, ...]


def snapped(design: Design) -> Snapped:
    """Move a design onto the exact set by the least move.

    The equations are brought to zero in equal stages of at most :data:`STAGE`, each by Newton's method, so that a
    pattern that is far off goes by a continuous path instead of jumping to some other solution.

    Args:
        design: near the exact set, in an intermediate state.

    Returns:
        The moved design, also where it could not be made exact.
    """
    model = DesignModel(design)
    equations = constraints.hard_constraints(model, {})
    if not equations:  # triangles without an interior vertex are exact as they are
        return Snapped(design, 0.0, tuple(faults_of(design, design, 0.0)))
    problem = Problem(model.n_variables, [], equations)
    point = Point(problem, model.seed_points.ravel(), problem.parameters())
    wanted = point.rows
    stages = max(1, int(np.ceil(np.abs(wanted).max(initial=0.0) / STAGE)))
    for stage in range(1, stages + 1):
        left = wanted * (1 - stage / stages)
        point = polish(replace(point, problem=problem.bounded(left, left)))
        if point.violation > SETTLED:
            break
    residual = replace(point, problem=problem).violation
    result = model.design(point.variables)
    return Snapped(result, residual, tuple(faults_of(design, result, residual)))


def faults_of(before: Design, after: Design, residual: float) -> list[str]:
    """What Newton's method may have broken, as sentences: equations, lengths, signs of folds, convexity.

    Args:
        before: the mesh as given.
        after: the moved mesh.
        residual: largest dimensionless residual of the equations after the move.
    """
    pattern = after.pattern
    faults = []
    if residual > SETTLED:
        faults.append(f"the equations could not be satisfied: a residual of {residual:.2g} is left")
    factors = geometry.edge_lengths(pattern, after.vertices_coords) / geometry.edge_lengths(
        pattern, before.vertices_coords
    )
    e = int(np.argmax(np.abs(np.log(np.maximum(factors, 1e-300)))))
    if not LENGTHS[0] < factors[e] < LENGTHS[1]:
        faults.append(f"edge {_name(pattern.edges_vertices[e])} became {factors[e]:.3g} times as long")
    folds = [geometry.fold_angles(pattern, d.vertices_coords) for d in (before, after)]
    turned = np.flatnonzero((folds[0] * folds[1] < 0) & (np.abs(folds[0]) > FLAT_FOLD))
    if len(turned):
        faults.append(f"edge {_name(pattern.edges_vertices[turned[0]])} changed between mountain and valley")
    if not geometry.are_convex(pattern, after.vertices_coords):
        faults.append("a facet is not convex")
    return faults


def _name(edge: np.ndarray) -> str:
    return f"{edge[0]}-{edge[1]}"
