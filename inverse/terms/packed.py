"""A state of the motion as variables, and the box around it that an objective makes small or a bound limits."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import casadi
import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.model import DesignModel
from inverse.nlp.kernels import Elements, Kernel
from inverse.nlp.term import Constraint
from inverse.origami import footprint
from inverse.terms.packed_state import placement_kernel, placements, root_kernel

Measure = Literal["extent", "area"]
SIDES = ("length", "width", "height")


@dataclass(frozen=True, eq=False)
class Packed:
    """Variables of one state: coordinates of its vertices, a turn of the box, its lower corner and its extents.

    A flat state has two coordinates per vertex, any other one three. It lies as
    :func:`inverse.origami.footprint.laid_out` lays it; the axes of its box are those around the seed's, turned. Of the
    box there is what the measure and the limits need, since variables that nothing holds make steps singular.

    Lengths are relative to the longest extent of the seed's state: a small change of the design moves far vertices of
    the state a lot, and a solver that weighs the steps of all variables alike is to take that for small.

    Attributes:
        model: the design that is folded.
        t: the state, in radians; 0 developed, pi flat-folded.
        measure: what an objective makes small, or None.
        limits: (d,) largest extents, length first, in the seed's unit; inf where there is none.
        area: largest length times width, in the seed's unit squared; inf if there is none.
        first: place of its first variable in the vector of all variables.
    """

    model: DesignModel
    t: float
    measure: Measure | None
    limits: FloatArray
    area: float
    first: int

    @property
    def name(self) -> str:
        """The state, which its constraints are named after."""
        words = {t: word for word, t in footprint.FLAT_STATES.items()}
        return words.get(self.t, f"{np.degrees(self.t):g} degrees")

    @property
    def dimension(self) -> int:
        """2 for a flat state, else 3."""
        return 2 if self.t in footprint.FLAT_STATES.values() else 3

    @cached_property
    def seed_axes(self) -> FloatArray:
        """(d, d) axes of the box around the seed's state."""
        return footprint.box_axes(self._laid_out(self.model.seed_points))

    @cached_property
    def seed_extents(self) -> FloatArray:
        """(d,) extents of the seed's state, in mean edge lengths."""
        return footprint.extents(self._laid_out(self.model.seed_points), self.seed_axes)

    @property
    def scale(self) -> float:
        """Unit of the variables, in mean edge lengths."""
        return float(self.seed_extents[0])

    @cached_property
    def sides(self) -> list[int]:
        """Axes of the box that are measured or limited."""
        all_of_them = self.measure is not None or np.isfinite(self.area)
        return [k for k in range(self.dimension) if all_of_them or np.isfinite(self.limits[k])]

    @property
    def n_variables(self) -> int:
        """How many variables there are."""
        return int(self._extents[-1]) + 1 - self.first

    def start(self, points: FloatArray) -> FloatArray:
        """Variables of the state that a design folds to, with the box around it.

        Args:
            points: (V, 3) dimensionless vertices of the design.

        Returns:
            (n_variables,); extents that have to be at their limits are so, even if the state is larger.
        """
        state = self._laid_out(points) / self.scale
        along = state @ self.seed_axes[self.sides].T
        sizes = self._limits[self.sides] if self._at_limits else np.ptp(along, axis=0)
        return np.concatenate([state.ravel(), np.zeros(self._turn.size), along.min(axis=0), sizes])

    def axes(self, variables: FloatArray) -> FloatArray:
        """(k, d) directions of the box's sides in a vector of all variables."""
        turn = casadi.SX.sym("turn", self._turn.size)
        function = casadi.Function("axes", [turn], [self._turned_axes(turn)])
        return np.array(function(variables[self._turn]))

    def constraints(self) -> list[Constraint]:
        """Where the vertices lie, that they lie in the box, and how large it may be."""
        d, facet = self.dimension, self.model.pattern.faces_vertices[0]
        vertices, parameters = placements(self.model, self.t)
        laid = [
            self._laid("first facet", root_kernel(d, self.scale), np.array([facet[:3]]), np.empty((1, 0))),
            self._laid("placement", placement_kernel(d, self.scale), vertices, parameters),
        ]
        return [*laid, self._box(), *self._bounds()]

    def measured(self) -> list[Elements]:
        """Extents relative to the seed's, or the root of the relative area: their mean square is the measure."""
        if self.measure is None:
            return []
        m = len(self.sides)
        if self.measure == "extent":
            kernel = Kernel("extent", lambda q, p: q / p, m, m)
        else:
            kernel = Kernel("area", lambda q, p: casadi.sqrt(q[0] * q[1] / (p[0] * p[1])), m, m)
        return [Elements("footprint", kernel, self._extents[None], self.seed_extents[None] / self.scale)]

    @cached_property
    def _state(self) -> IntArray:
        """(V, d) places of the vertices' coordinates."""
        n, d = self.model.pattern.n_vertices, self.dimension
        return self.first + np.arange(n * d).reshape(n, d)

    @cached_property
    def _turn(self) -> IntArray:
        return int(self._state[-1, -1]) + 1 + np.arange(1 if self.dimension == 2 else len(self._turning))

    @cached_property
    def _corner(self) -> IntArray:
        return int(self._turn[-1]) + 1 + np.arange(len(self.sides))

    @cached_property
    def _extents(self) -> IntArray:
        return int(self._corner[-1]) + 1 + np.arange(len(self.sides))

    @cached_property
    def _limits(self) -> FloatArray:
        """(d,) in the unit of the variables."""
        return self.limits / (self.model.scale * self.scale)

    @property
    def _at_limits(self) -> bool:
        """Whether extents are held at their limits, since nothing else would determine them."""
        return self.measure is None and not np.isfinite(self.area)

    @property
    def _turning(self) -> FloatArray:
        """(k, 3) directions about which the box turns in space; not about its only side, which would not notice."""
        return np.delete(self.seed_axes, self.sides if len(self.sides) == 1 else [], axis=0)

    def _turned_axes(self, turn: casadi.SX) -> casadi.SX:
        """(k, d) the seed's axes after Cayley's rotation, by twice the arc tangent of the turn's length: rational."""
        if self.dimension == 2:
            cross = casadi.vertcat(casadi.horzcat(0, -turn), casadi.horzcat(turn, 0))
        else:
            cross = casadi.skew(casadi.DM(self._turning.T) @ turn)
        rotation = casadi.SX.eye(self.dimension) + 2 / (1 + casadi.sumsqr(turn)) * (cross + cross @ cross)
        return casadi.DM(self.seed_axes[self.sides]) @ rotation

    def _laid(self, name: str, kernel: Kernel, vertices: IntArray, parameters: FloatArray) -> Constraint:
        own = self._state[vertices].reshape(len(vertices), -1)
        variables = np.hstack([self.model.variables_of(vertices), own])
        zero = np.zeros((len(vertices), kernel.n_residuals))
        labels = tuple(f"vertex {row[-1]}" for row in vertices)
        return Constraint(Elements(f"{self.name} {name}", kernel, variables, parameters), zero, zero, labels)

    def _box(self) -> Constraint:
        """Every vertex above the lower corner of the box and below the upper one."""
        n, d, m, r = self.model.pattern.n_vertices, self.dimension, len(self.sides), self._turn.size

        def inside(q: casadi.SX, _: casadi.SX) -> casadi.SX:
            height = self._turned_axes(q[d : d + r]) @ q[:d] - q[d + r : d + r + m]
            return self.scale * casadi.vertcat(height, q[d + r + m :] - height)

        box = np.tile(np.concatenate([self._turn, self._corner, self._extents]), (n, 1))
        kernel = Kernel("box", inside, d + r + 2 * m)
        elements = Elements(f"{self.name} box", kernel, np.hstack([self._state, box]), np.empty((n, 0)))
        bounds = np.zeros((n, 2 * m)), np.full((n, 2 * m), np.inf)
        return Constraint(elements, *bounds, tuple(f"vertex {v}" for v in range(n)))

    def _bounds(self) -> list[Constraint]:
        """Limits of extents and of the area."""
        found = []
        limited = [k for k, side in enumerate(self.sides) if np.isfinite(self.limits[side])]
        if limited:
            upper = self.scale * self._limits[self.sides][limited][:, None]
            lower = upper if self._at_limits else np.full_like(upper, -np.inf)
            kernel = Kernel("limit", lambda q, _: self.scale * q, 1)
            places, labels = self._extents[limited][:, None], tuple(SIDES[self.sides[k]] for k in limited)
            elements = Elements(f"{self.name} limits", kernel, places, np.empty((len(limited), 0)))
            found.append(Constraint(elements, lower, upper, labels))
        if np.isfinite(self.area):
            upper = np.array([[self.area / (self.model.scale**2 * self.scale)]])
            kernel = Kernel("area_limit", lambda q, _: self.scale * q[0] * q[1], 2)
            elements = Elements(f"{self.name} area", kernel, self._extents[None], np.empty((1, 0)))
            found.append(Constraint(elements, np.full_like(upper, -np.inf), upper, ("length times width",)))
        return found

    def _laid_out(self, points: FloatArray) -> FloatArray:
        """The state (V, d) of dimensionless vertices (V, 3)."""
        return footprint.laid_out(self.model.seed.moved_to(points), self.t)[:, : self.dimension]
