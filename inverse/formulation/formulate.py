"""From a specification to the parts of an optimization: target, placed seed, terms. Degrees end here."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from inverse import constraints as hard
from inverse import cylinder_loop
from inverse._types import FloatArray
from inverse.errors import InputError
from inverse.formulation import anchors, contradictions, own_terms, seeding
from inverse.formulation.anchors import Anchored, PolylineAnchor
from inverse.formulation.calls import called
from inverse.formulation.given import NOTHING, Given
from inverse.formulation.places import Flat, lies_in
from inverse.formulation.sizes import check_sizes
from inverse.formulation.within import within
from inverse.limits import check_coordinates, check_extent
from inverse.model import DesignModel
from inverse.nlp.term import Constraint, Objective
from inverse.spec import (
    BetweenKeys,
    HeightKeys,
    KeepOut,
    Loaded,
    SurfaceKeys,
    TubeKeys,
)
from inverse.spec.footprint import FootprintLimits, State, radians
from inverse.surfaces import Target
from inverse.surfaces.named import TARGETS
from inverse.surfaces.section import SectionTarget
from inverse.surfaces.tube import TubeTarget
from inverse.terms.fitting import Fitting
from inverse.terms.goal import Goal
from inverse.terms.packed import Measure, Packed
from inverse.terms.section_fit import SectionFitting
from inverse.terms.surface_fit import SurfaceFitting
from inverse.terms.tube_fit import TubeFitting, is_tube

if TYPE_CHECKING:
    from inverse.surfaces.mesh import MeshTarget

OTHER_UNIT = "Choose a unit in which domain and height are neither huge nor tiny."

FAR = 100.0  # sizes of the target from the origin: what lies farther is solved from an origin of its own
SLENDER = 1e5  # length of a tube over its width, or width over length: beyond, facets have no shape left in numbers
NOWHERE = np.zeros(3)  # the origin of the specification itself


@dataclass(frozen=True, eq=False)
class Formulation:
    """What is solved.

    Attributes:
        goal: model, target and fitted points.
        objectives: weighted terms.
        fixed: constraints that stay as they are.
        sliding: anchors on polylines.
        free_range: (low, high) radians, the part of the motion in which no facets may cross; None if none is asked.
        given: what a caller gave besides the specification.
        anchored: where vertices are held, and what the design stays within.
    """

    goal: Goal
    objectives: list[Objective]
    fixed: list[Constraint]
    sliding: list[PolylineAnchor]
    free_range: tuple[float, float] | None
    given: Given
    anchored: Anchored


def formulate(loaded: Loaded, share: float = 1.0, given: Given = NOTHING) -> Formulation:
    """Read what the specification names and build all terms.

    A task far from the origin is moved to ``goal.origin``: large coordinates leave few digits for lengths.

    Args:
        loaded: the specification.
        share: of the target's heights over its plan; below 1 for a task on the way to it, with the same seed.
        given: what a caller gave besides.

    Raises:
        InputError: with the place in the specification.
    """
    specification = loaded.specification
    target = build_target(loaded, given=given)
    origin = NOWHERE if isinstance(given.target, TubeTarget) else _origin(target)
    if origin.any():
        target = build_target(loaded, origin, given)
    made = seeding.made(loaded, given)
    target, outline = seeding.outlined(loaded, target, given, made)
    model = within(loaded, ("pattern",), lambda: seeding.build(loaded, target, outline, origin, made))
    seed = model.seed
    if isinstance(target, TubeTarget) and not (is_tube(seed.pattern) and (seed.pattern.grid or (0, 0))[1] > 1):
        raise loaded.source.error(
            ("pattern",), "a target around an axis needs a tube of two or more rows, numbered as a grid",
            "Give a pattern of kind tube, or a file of one with bdffpq:grid.",
        )  # fmt: skip
    check_sizes(loaded, seed, target)
    surface = target if share == 1 else target.flattened(share)
    goal = Goal(_fitting(loaded, model, surface), _packed(loaded, model), origin)
    goal, terms = own_terms.minimized(loaded, goal, given)
    limits = specification.constraints
    bounds = {
        "edge_length": limits.edge_length,
        "sector_angle": _radians(limits.sector_angle),
        "fold_angle": _radians(limits.fold_angle),
    }
    fixed = hard.hard_constraints(model, bounds)
    anchored = anchors.build(loaded, model, origin)
    if share == 1:
        held = {k: vertices for k, vertices in enumerate(anchored.held) if len(vertices)}
        contradictions.check(loaded, model, held, origin)
    packed = [constraint for state in goal.packed for constraint in state.constraints()]
    loops = _loops(loaded, model)
    free_range = None if limits.free_range is None else _radians(limits.free_range)
    own = own_terms.constrained(loaded, goal, given)
    fixed = [*fixed, *loops, *anchored.fixed, *_keep_outs(loaded, model, origin, anchored), *packed, *own]
    return Formulation(goal, terms, fixed, anchored.sliding, free_range, given, anchored)


def _fitting(loaded: Loaded, model: DesignModel, target: Target) -> Fitting:
    """How the target's kind is fitted."""
    if isinstance(target, SectionTarget):
        return SectionFitting(model, target)
    if isinstance(target, TubeTarget):
        return TubeFitting(model, target)
    return SurfaceFitting(model, target, loaded.specification.fit.points)


def moved_back(loaded: Loaded, formulation: Formulation) -> Formulation:
    """A formulation in the coordinates of its specification: the terms, which have no lengths, are the same."""
    goal = formulation.goal
    model = replace(goal.model, seed=goal.model.seed.moved_to(goal.model.seed.vertices_coords + goal.origin))
    sliding = [replace(anchor, polyline=anchor.polyline + goal.origin) for anchor in formulation.sliding]
    target = build_target(loaded, given=formulation.given)
    if len(model.left_out):
        target = formulation.goal.target.moved(-formulation.goal.origin)  # with its holes filled
    fitting = _fitting(loaded, model, target)
    goal = replace(goal, fitting=fitting, origin=NOWHERE)
    return replace(formulation, goal=goal, sliding=sliding)


def _origin(target: Target) -> FloatArray:
    """Where coordinates begin, (3,): near the target, if that lies far from the specification's origin."""
    frame = target.frame
    size = max(frame.extent)
    if np.abs(frame.origin).max() <= FAR * size:
        return NOWHERE
    step = 2.0 ** np.ceil(np.log2(size))  # a round number, so that what is near by is subtracted exactly
    return np.asarray(np.round(frame.origin / step) * step)


def build_target(loaded: Loaded, origin: FloatArray = NOWHERE, given: Given = NOTHING) -> Target:
    """The target surface of a specification.

    Args:
        loaded: the specification.
        origin: (3,) point of its coordinates that the surface's are relative to.
        given: what a caller gave besides.

    Raises:
        InputError: with the place in the specification; a surface that reaches too far is refused here, whatever it is.
    """
    target = _target(loaded, origin) if given.target is None else given.target.moved(origin)

    def check() -> None:
        points, _ = target.triangles()
        check_coordinates(points, None)
        check_extent(points, "the target", None)
        along, across, _ = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        if across < 1e-6 * along:
            raise InputError(
                f"the target is a line: {along / max(across, 1e-300):.2g} times as long as wide",
                hint="Look for a wrong number in it: up to 1e6 is allowed.",
            )

    within(loaded, ("target",), check)
    return target


def _target(loaded: Loaded, origin: FloatArray) -> Target:
    keys = loaded.specification.target
    if isinstance(keys, HeightKeys):
        from inverse.surfaces.parametric import HeightTarget, height_over

        def make() -> Target:
            if keys.polygon is not None:
                return height_over(keys.height, np.array(keys.polygon), origin)
            target = HeightTarget(keys.height, keys.domain, origin)
            target.triangles()  # refuses a height that has no value somewhere on its domain
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                if not np.isfinite(target.frame.origin).all():
                    raise InputError("areas of the target are beyond what a number can hold", hint=OTHER_UNIT)
            return target

        return within(loaded, ("target", "height"), make)
    if isinstance(keys, BetweenKeys):
        from inverse.surfaces.parametric import BetweenTarget

        curves = [np.array(curve) - origin for curve in keys.between]
        return within(loaded, ("target", "rise"), lambda: BetweenTarget(curves, keys.rise, keys.profile))
    if isinstance(keys, TubeKeys):
        return _tube_target(loaded, keys, origin)
    if isinstance(keys, SurfaceKeys):
        return called(loaded, "target", "surface", TARGETS, keys.parameters).moved(origin)
    return within(loaded, ("target", "mesh"), lambda: _mesh(loaded.folder / keys.mesh, origin))


def _mesh(path: Path, origin: FloatArray) -> MeshTarget:
    from inverse.surfaces.mesh import read_mesh

    return read_mesh(path).moved(origin)


def _tube_target(loaded: Loaded, keys: TubeKeys, origin: FloatArray) -> Target:
    """A tube around an axis."""
    from inverse.surfaces import around
    from inverse.surfaces.axis import Axis, arc
    from inverse.surfaces.expression import SPACE, parse

    def axis() -> Axis:
        if keys.axis.arc is not None:
            return arc(*(np.array(keys.axis.arc) - origin))
        points = np.array(keys.axis.spline or keys.axis.polyline) - origin
        return Axis(points, smooth=keys.axis.spline is not None)

    found = within(loaded, ("target", "axis"), axis)
    if keys.mesh is not None:
        path = loaded.folder / keys.mesh
        radius = within(loaded, ("target", "mesh"), lambda: around.of_mesh(found, _mesh(path, origin)))
    elif keys.implicit is not None:
        value = parse(keys.implicit, SPACE, "implicit expression")
        radius = within(loaded, ("target", "implicit"), lambda: around.of_implicit(found, value, origin))
    elif keys.radius is not None:
        radius = np.array(keys.radius)
    if keys.section is not None:
        target: TubeTarget = within(loaded, ("target", "section"), lambda: SectionTarget(found, keys.sections))
    else:
        target = TubeTarget(found, radius)
    length, width = target.frame.extent
    if not 1 / SLENDER <= length / width <= SLENDER:
        raise loaded.source.error(
            ("target", "section" if keys.section else "axis" if keys.radius is None else "radius"),
            f"a tube with a mean radius of {width / 2:g} around an axis of length {length:g} cannot be made of "
            f"facets: length and width may differ by a factor of {SLENDER:g} at most",
            "Give the radius and the points of the axis in the same unit.",
        )
    return target


def _loops(loaded: Loaded, model: DesignModel) -> list[Constraint]:
    """One strip around every hole that closes through the whole motion, or keeps its shape."""
    asked = loaded.specification.constraints.loop
    return within(
        loaded,
        ("constraints", "loop") if asked else ("pattern",),
        lambda: cylinder_loop.around_holes(model, asked or "exact"),
    )


def _keep_outs(loaded: Loaded, model: DesignModel, origin: FloatArray, anchored: Anchored) -> list[Constraint]:
    """Half-spaces; vertices that anchors hold in their planes are there already, and no independent rows."""
    found = []
    for k, keep_out in enumerate(loaded.specification.constraints.keep_out):
        plane = keep_out_plane(keep_out, origin)
        held = [v for v, place in anchored.at.items() if lies_in(place, plane, anchors.MEET * model.scale)]
        free = np.setdiff1d(np.arange(model.pattern.n_vertices), np.array(held, np.int64))
        found.append(hard.keep_out(model, f"keep_out_{k}", plane.point, plane.normal, free))
    return found


def keep_out_plane(keep_out: KeepOut, origin: FloatArray) -> Flat:
    """The plane of a keep-out, relative to a point (3,), with its normal to where the design stays."""
    if keep_out.plane is not None:
        point, normal = np.array(keep_out.plane.point), np.array(keep_out.plane.normal)
    elif keep_out.below is not None:
        point, normal = np.array([0.0, 0.0, keep_out.below]), np.array([0.0, 0.0, 1.0])
    else:
        point, normal = np.array([0.0, 0.0, keep_out.above]), np.array([0.0, 0.0, -1.0])
    return Flat(point - origin, normal / np.linalg.norm(normal))


def _packed(loaded: Loaded, model: DesignModel) -> tuple[Packed, ...]:
    """The states that are measured by the objective or limited, one set of variables for each."""
    specification = loaded.specification
    measured, limited = specification.footprint, specification.constraints.footprint
    uses: dict[State, tuple[Measure | None, FootprintLimits | None]] = {}
    if specification.objectives.get("footprint", 0.0) > 0:
        uses[measured.state] = measured.measure, None
    if limited is not None:
        uses[limited.state] = uses.get(limited.state, (None,))[0], limited
    found: list[Packed] = []
    for state, (measure, keys) in uses.items():
        limits = np.full(2 if isinstance(state, str) else 3, np.inf)
        area = np.inf
        if keys is not None:
            given = [np.inf if k is None else k for k in (keys.length, keys.width, keys.height)]
            # No side is longer than the length: without this a box of length 5 could lie across a state of width 4.
            limits = np.minimum.accumulate(given[: limits.size])
            area = keys.area or np.inf
        first = model.n_variables + sum(packed.n_variables for packed in found)
        found.append(Packed(model, radians(state), measure, limits, area, first))
    return tuple(found)


def _radians(degrees: tuple[float, float]) -> tuple[float, float]:
    return float(np.radians(degrees[0])), float(np.radians(degrees[1]))
