"""What is measured of a design beside its target: fit, footprint. Plain data, as reports tell it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, TypeVar

import numpy as np

from inverse._types import FloatArray
from inverse.errors import InputError
from inverse.extending.loading import told
from inverse.extending.registry import Registry
from inverse.origami import footprint as folded
from inverse.origami import geometry
from inverse.origami.pattern import Design
from inverse.terms.goal import Goal
from inverse.terms.packed import SIDES
from inverse.terms.tube_fit import RingFit

Measure = Callable[[Design], float]
M = TypeVar("M", bound=Measure)


@dataclass(frozen=True)
class OwnMeasure:
    """A measure of a user.

    Attributes:
        function: of a design.
        unit: of what it returns, for reports.
    """

    function: Measure
    unit: str


MEASURES: Registry[OwnMeasure] = Registry("a measure")


def measure(name: str, *, unit: str = "") -> Callable[[M], M]:
    """Register a function of a design that every report tells the value of, under ``measures``.

    Args:
        name: in the report.
        unit: of what it returns, for whoever reads it.

    Returns:
        A decorator of functions ``f(design)`` that return a number.

    Raises:
        InputError: the name is taken or no word.
    """

    def add(function: M) -> M:
        if not callable(function):
            raise InputError(f"measure {name} is no function")
        MEASURES.add(name, OwnMeasure(function, unit))
        return function

    return add


def own(design: Design, failures: list[str] | None = None) -> dict[str, float]:
    """The registered measures of a design, by name.

    Args:
        design: the design.
        failures: where given, a measure that fails is NaN and its sentence is added here.

    Raises:
        InputError: a measure raised something, which is the cause, or returned no number.
    """
    found = {}
    for name, one in MEASURES.items():
        try:
            found[name] = _value(name, one, design)
        except InputError as error:
            if failures is None:
                raise
            found[name] = float("nan")
            failures.append(error.message)
    return found


def _value(name: str, one: OwnMeasure, design: Design) -> float:
    try:
        value = one.function(design)
    except Exception as error:
        raise InputError(f"measure {name} raised {told(error)}") from error
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        raise InputError(f"measure {name} returns a {type(value).__name__}: a number is wanted")
    return float(value)


@dataclass(frozen=True)
class Fit:
    """Distances of the fitted points from the target.

    Attributes:
        points: what is fitted: facets, layer, vertices or rings.
        rms: root of the mean square, in length units.
        max: the largest, in length units.
        rms_relative: relative to the diagonal of the design's bounding box.
        max_relative: the same of the largest.
        start_rms: of the placed seed, before solving.
        start_rms_relative: relative to the diagonal of the placed seed.
        rings: what is told of tubes besides, or None.
    """

    points: str
    rms: float
    max: float
    rms_relative: float
    max_relative: float
    start_rms: float
    start_rms_relative: float
    rings: RingFit | None

    def document(self) -> dict[str, Any]:
        """As in ``report.json``."""
        found = asdict(self)
        return found | (found.pop("rings") or {})


def fit(goal: Goal, design: Design) -> Fit:
    """The fit of a design, and the placed seed's."""
    distances = goal.fitting.distances(design.vertices_coords)
    at_start = goal.fitting.distances(goal.model.seed.vertices_coords)
    size, start_size = (geometry.diagonal(d.vertices_coords) for d in (design, goal.model.seed))
    rms, start_rms = (float(np.sqrt(np.mean(d**2))) for d in (distances, at_start))
    largest = float(distances.max())
    return Fit(
        goal.fitting.points, rms, largest, rms / size, largest / size, start_rms, start_rms / start_size,
        goal.fitting.told(design.vertices_coords),
    )  # fmt: skip


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
