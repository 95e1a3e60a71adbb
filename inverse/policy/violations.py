"""Violated constraints as people say them: what is where, how far off, which way, and the key that asks for it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from inverse._types import FloatArray
from inverse.nlp.point import Point
from inverse.nlp.term import Constraint
from inverse.origami import geometry
from inverse.origami.pattern import Pattern
from inverse.spec import Constraints
from inverse.terms.goal import Goal
from inverse.terms.own_constraints import CONSTRAINTS


@dataclass(frozen=True, eq=False)
class Violation:
    """The worst violation of one constraint.

    Attributes:
        constraint: which.
        element: number of the element where it is.
        rows: (k,) the element's rows.
        excess: (k,) how far they are beyond their bounds, dimensionless.
    """

    constraint: Constraint
    element: int
    rows: FloatArray
    excess: FloatArray

    @property
    def size(self) -> float:
        """The largest of it, dimensionless."""
        return float(self.excess.max())

    @property
    def label(self) -> str:
        """The element's name."""
        return self.constraint.labels[self.element]

    @property
    def vertices(self) -> list[int]:
        """The vertices that the element is made of, where it is made of vertices."""
        places = self.constraint.elements.variables[self.element]
        return [int(v) // 3 for v in places[::3]]


def worst(point: Point) -> Iterator[Violation]:
    """The worst violation of every constraint that has elements."""
    start = 0
    for constraint in point.problem.constraints:
        count, k = constraint.lower.shape
        own = slice(start, start + count * k)
        start += count * k
        if count:
            excess, rows = point.excess[own].reshape(count, k), point.rows[own].reshape(count, k)
            element = int(np.argmax(excess.max(axis=1)))
            yield Violation(constraint, element, rows[element], excess[element])


@dataclass(frozen=True, eq=False)
class Sentences:
    """What is said of violations at one point.

    Attributes:
        goal: what is fitted; its model has the unit.
        variables: (n,) where.
        asked: the constraints of the specification.
    """

    goal: Goal
    variables: FloatArray
    asked: Constraints

    def of(self, violation: Violation) -> str | None:
        """A sentence without full stop; None for what has none of its own."""
        found = re.fullmatch(r"(keep_out|anchor|within)_(\d+)(.*)", violation.constraint.name)
        if found is not None:
            kind, number, rest = found[1], int(found[2]), found[3]
            if kind == "within":
                far = self._length(violation.size)
                return f"{violation.label} is {far} behind the wall of its anchor (constraints.anchors.{number}.within)"
            if rest.startswith("+"):
                far = self._length(float(np.linalg.norm(violation.excess)))
                return f"{violation.label} is {far} from where its anchors meet (constraints.anchors.{number})"
            return self._keep_out(violation, number) if kind == "keep_out" else self._anchor(violation, number)
        own: dict[str, Callable[[Violation], str]] = {
            "edge_length": self._edge,
            "sector_angle": self._sector,
            "fold_angle": self._fold,
            "opposite_angles": self._vertex,
        }
        if violation.constraint.name in own:
            return own[violation.constraint.name](violation)
        if violation.constraint.name.startswith("planarity"):
            return self._facet(violation)
        return self._of_ones_own(violation)

    def _keep_out(self, violation: Violation, k: int) -> str:
        keep_out, far = self.asked.keep_out[k], self._length(violation.size)
        key = f"constraints.keep_out.{k}"
        if keep_out.plane is not None:
            return f"{violation.label} is {far} on the wrong side of its plane ({key})"
        if keep_out.below is not None:
            return f"{violation.label} is {far} too low ({key}: below {keep_out.below:g}{self._unit})"
        return f"{violation.label} is {far} too high ({key}: above {keep_out.above:g}{self._unit})"

    def _anchor(self, violation: Violation, k: int) -> str:
        to = self.asked.anchors[k].to
        place = next(name for name in to.one_of if getattr(to, name) is not None)
        far = float(np.linalg.norm(violation.excess))
        if place == "circle":
            middle, normal, size = np.split(violation.constraint.elements.parameters[violation.element], [3, 6])
            offset = self.variables[violation.constraint.elements.variables[violation.element]] - middle
            along = float(offset @ normal)
            far = float(np.hypot(along, np.linalg.norm(offset - along * normal) - size[0]))
        return f"{violation.label} is {self._length(far)} from its {place} (constraints.anchors.{k})"

    def _edge(self, violation: Violation) -> str:
        a, b = violation.vertices
        length, seed = (float(np.linalg.norm(points[b] - points[a])) for points in (self._points, self._seed))
        low, high = (factor * seed for factor in self.asked.edge_length)
        is_long = length > high
        bound, words = (high, "long (at most") if is_long else (low, "short (at least")
        return (
            f"edge {a}-{b} is {self._length(abs(length - bound))} too {words} {self._length(bound)}, "
            "constraints.edge_length)"
        )

    def _sector(self, violation: Violation) -> str:
        before, corner, after = (self._points[v] for v in violation.vertices)
        u, v = before - corner, after - corner
        angle = float(np.degrees(np.arctan2(np.linalg.norm(np.cross(u, v)), u @ v)))
        low, high = self.asked.sector_angle
        bound, words = (high, "blunt (at most") if angle > high else (low, "sharp (at least")
        return (
            f"the angle of {violation.label} is {abs(angle - bound):.2g} degrees too {words} {bound:g}, "
            "constraints.sector_angle)"
        )

    def _fold(self, violation: Violation) -> str:
        a, b = violation.vertices[:2]
        edge = self._pattern.edge_between[frozenset((a, b))]
        angle, seed = (float(np.degrees(folds[edge])) for folds in (self._folds, self._seed_folds))
        low, high = self.asked.fold_angle
        if np.sign(angle) != np.sign(seed):
            kind = "valley" if angle > 0 else "mountain"
            return f"the fold of edge {a}-{b} is turned over: a {kind} of {abs(angle):.2g} degrees"
        is_flat = abs(angle) < (low + high) / 2
        bound, words = (low, "flat (at least") if is_flat else (high, "sharp (at most")
        return (
            f"the fold of edge {a}-{b} is {abs(abs(angle) - bound):.2g} degrees too {words} {bound:g}, "
            "constraints.fold_angle)"
        )

    def _vertex(self, violation: Violation) -> str:
        centre, *ring = violation.vertices
        spokes = geometry.unit(self._points[ring] - self._points[centre])
        angles = np.arccos(np.clip(np.einsum("ij,ij->i", spokes, np.roll(spokes, -1, axis=0)), -1, 1))
        sign = float(violation.constraint.elements.parameters[violation.element][0])
        pairs = angles[:2] + angles[2:] - np.pi if sign > 0 else angles[:2] - angles[2:]
        off = float(np.degrees(np.abs(pairs).max()))
        return f"{violation.label} does not fold flat: its opposite angles are {off:.2g} degrees off"

    def _facet(self, violation: Violation) -> str:
        a, b, c, *others = (self._points[v] for v in violation.vertices)
        normal = geometry.unit(np.cross(b - a, c - b)[None])[0]
        far = max(abs(float(normal @ (d - a))) for d in others)
        return f"{violation.label} is not plane: a corner is {self._length(far)} off"

    def _of_ones_own(self, violation: Violation) -> str | None:
        name = violation.constraint.name.split(" of ")[0]
        term = next((term for key, term in CONSTRAINTS.items() if key == name), None)
        if term is None:
            return None
        size = violation.size * term.size(self._scale)
        unit = {"1": "", "angle": " degrees", "length": self._unit}.get(term.unit, f" {term.unit}")
        size = float(np.degrees(size)) if term.unit == "angle" else size
        return f"{violation.label} is {size:.2g}{unit} beyond what is allowed (constraints.own.{name})"

    @property
    def _pattern(self) -> Pattern:
        return self.goal.model.pattern

    @property
    def _scale(self) -> float:
        return self.goal.model.scale

    @cached_property
    def _points(self) -> FloatArray:
        """(V, 3) in mean edges."""
        return self.variables[: self.goal.model.n_variables].reshape(-1, 3)

    @property
    def _seed(self) -> FloatArray:
        return self.goal.model.seed_points

    @cached_property
    def _folds(self) -> FloatArray:
        return geometry.fold_angles(self._pattern, self._points)

    @cached_property
    def _seed_folds(self) -> FloatArray:
        return geometry.fold_angles(self._pattern, self._seed)

    @property
    def _unit(self) -> str:
        unit = self.goal.model.seed.unit
        return "" if unit == "unit" else f" {unit}"

    def _length(self, edges: float) -> str:
        """A length in mean edges, in the file's unit."""
        return f"{edges * self._scale:.3g}{self._unit}"
