"""Grids over targets whose plan is no rectangle: strips that follow its outline, and facets outside it left out."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.origami import geometry
from inverse.origami.pattern import Design
from inverse.origami.trimming import in_one_piece, part_of
from inverse.surfaces import Frame, Target
from inverse.surfaces.base import SQUEEZE
from inverse.surfaces.holes import HoledTarget
from inverse.surfaces.mesh import without_repetitions
from inverse.surfaces.nearest import Nearest
from inverse.surfaces.sheet import borders_of

FULL = 0.85  # share of its rectangle that a plan fills from which on the whole grid is used
LOOKED_AT = 64  # places along each side of the rectangle where the plan is looked for
PARALLEL = np.cos(np.radians(10.0))  # of a border that grid lines may run along
LONG = 0.15  # of the rectangle's side: a border that a grid line is laid along
LOST = 0.1  # share of the wanted facets that may hang on nothing


@dataclass(frozen=True, eq=False)
class Outline:
    """The plan of a target, in the rectangle around it.

    Attributes:
        target: the target.
        frame: its rectangle; where the borders have a direction, along it.
        border: (B, 2, 2) ends of the border's edges in plan, from the rectangle's centre.
    """

    target: Target
    frame: Frame
    border: FloatArray

    @classmethod
    def of(cls, target: Target, *, always: bool) -> Outline | None:
        """The outline that a grid is trimmed to; None where the whole grid is used.

        Args:
            target: a mesh, with holes or without.
            always: also where its plan fills ``FULL`` of its rectangle.
        """
        whole = cls._within(target, target.frame)
        trims = always or isinstance(target, HoledTarget) or whole.share < FULL
        return cls._within(target, whole._along_borders()) if trims else None

    @classmethod
    def _within(cls, target: Target, frame: Frame) -> Outline:
        vertices, triangles = target.triangles()
        plan = (vertices - frame.origin) @ frame.axes[:2].T
        return cls(target, frame, plan[borders_of(triangles).edges])

    @property
    def share(self) -> float:
        """Share of the rectangle that the plan fills."""
        a, b = ((np.arange(LOOKED_AT) + 0.5) / LOOKED_AT - 0.5 for _ in range(2))
        x, y = (k.ravel() for k in np.meshgrid(a * self.frame.extent[0], b * self.frame.extent[1], indexing="ij"))
        return float(self.holds(np.stack([x, y], axis=1)).mean())

    def holds(self, plan: FloatArray, *, filled: bool = False) -> np.ndarray:
        """Whether places (N, 2), from the rectangle's centre, lie in the plan, (N,).

        Args:
            plan: the places.
            filled: whether holes count as if they were filled.
        """
        flat = self._filled if filled and isinstance(self.target, HoledTarget) else self._flat
        _, _, feet = flat.find(np.column_stack([plan, np.zeros(len(plan))]))
        return np.asarray(np.linalg.norm(feet[:, :2] - plan, axis=1) < 1e-3 * min(self.frame.extent))

    @cached_property
    def _flat(self) -> Nearest:
        return self._flattened(self.target)

    @cached_property
    def _filled(self) -> Nearest:
        assert isinstance(self.target, HoledTarget)  # nothing else is filled
        return self._flattened(self.target.filled)

    def _flattened(self, target: Target) -> Nearest:
        vertices, triangles = target.triangles()
        local = (vertices - self.frame.origin) @ self.frame.axes.T
        vertices, triangles, _ = without_repetitions(local * SQUEEZE, triangles)
        return Nearest(vertices, triangles)

    def _along_borders(self) -> Frame:
        """The rectangle turned so that as much of the border as can be runs along its sides."""
        steps = self.border[:, 1] - self.border[:, 0]
        lengths, angles = np.linalg.norm(steps, axis=1), np.arctan2(steps[:, 1], steps[:, 0])
        turns = np.radians(np.arange(-45.0, 45.0, 0.5))
        beside = np.abs((angles - turns[:, None] + np.pi / 4) % (np.pi / 2) - np.pi / 4)
        along = ((beside < np.radians(3.0)) * lengths).sum(axis=1)
        if along.max() < 0.5 * lengths.sum():
            return self.frame
        # Of turns that are as good the middle one.
        best = float(turns[along >= along.max() * (1 - 1e-9)].mean())
        turn = np.array([[np.cos(best), np.sin(best)], [-np.sin(best), np.cos(best)]])
        axes = np.vstack([turn @ self.frame.axes[:2], self.frame.axes[2]])
        plan = (self.target.triangles()[0] - self.frame.origin) @ axes[:2].T
        low, high = plan.min(axis=0), plan.max(axis=0)
        extent = high - low
        return Frame(self.frame.origin + (low + high) / 2 @ axes[:2], axes, (float(extent[0]), float(extent[1])))

    def strips(self, size: tuple[int, int], turn: int) -> tuple[FloatArray, FloatArray]:
        """Relative lengths (m,) and (n,) of the strips of a grid, with lines along the long borders.

        Args:
            size: facets along u and v, (m, n).
            turn: 0: u along the rectangle's x; 90: u along its y and v against its x.
        """
        if turn == 0:
            return self._lengths(0, size[0]), self._lengths(1, size[1])
        return self._lengths(1, size[0]), self._lengths(0, size[1])[::-1]

    def _lengths(self, axis: int, count: int) -> FloatArray:
        """Relative lengths (count,) of strips along an axis of the rectangle, with lines along the long borders.

        Args:
            axis: 0 for x, 1 for y.
            count: number of strips, at least one.
        """
        size, across = self.frame.extent[axis], self.frame.extent[1 - axis]
        steps = self.border[:, 1] - self.border[:, 0]
        length = np.linalg.norm(steps, axis=1)
        facing = np.abs(steps[:, 1 - axis]) > PARALLEL * length
        places = self.border[facing].mean(axis=1)[:, axis] / size + 0.5
        cuts = [0.0, 1.0]
        # The longest borders first; what is too near to another line of theirs goes with it.
        bins = np.round(places * 4 * count).astype(int)
        total = np.bincount(bins.clip(0), length[facing], minlength=1)
        for k in np.argsort(-total, kind="stable"):
            if total[k] < LONG * across:
                break
            here = float(places[bins == k] @ length[facing][bins == k] / total[k])
            if min(abs(here - cut) for cut in cuts) * count > 1.5:
                cuts.append(here)
        parts = np.diff(np.sort(cuts))
        strips = np.maximum(np.round(parts * count).astype(int), 2)
        while strips.sum() != count and len(parts) > 1:
            step = int(np.sign(count - strips.sum()))
            room = strips > 2 if step < 0 else np.ones(len(strips), bool)
            if not room.any():
                return np.ones(count)
            # The part whose facets are least near to the mean with one more or less.
            strips[np.argmin(np.where(room, step * strips / parts, np.inf))] += step
        return np.repeat(parts / strips, strips) if len(parts) > 1 else np.ones(count)

    def trim(self, seed: Design) -> tuple[Design, IntArray]:
        """A placed grid without the facets outside the plan.

        Args:
            seed: the grid.

        Returns:
            What is left, and (k,) facets of it over holes.

        Raises:
            InputError: the plan is too narrow somewhere for facets of this size.
        """
        m, n = seed.pattern.grid or (0, 0)
        centres = geometry.facet_centroids(seed.pattern, seed.vertices_coords) - self.frame.origin
        plan = (centres @ self.frame.axes[:2].T).reshape(m, n, 2)
        # Corrugations put centroids beside the lines between strips, by turns.
        u, v = plan.mean(axis=1), plan.mean(axis=0)
        along, beside = _directions(u, v)
        places = ((u @ along)[:, None, None] * along + (v @ beside)[None, :, None] * beside).reshape(-1, 2)
        wanted = self.holds(places).reshape(m, n)
        shown = in_one_piece(wanted)
        lost = int((wanted & ~shown).sum())
        if not shown.any() or lost > LOST * wanted.sum():
            raise InputError(
                f"the target's plan is too narrow somewhere for facets of this size: of {int(wanted.sum())} facets "
                f"over it {lost} would hang on others by an edge or a corner alone",
                hint="Take more facets, so that the narrowest part is three of them wide.",
            )
        solved = in_one_piece(shown | self.holds(places, filled=True).reshape(m, n))
        shown = in_one_piece(shown & solved)
        left = seed if solved.all() else part_of(seed, solved.ravel())  # a whole grid keeps its sides
        return left, np.flatnonzero(~shown[solved])


def _directions(u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Unit vectors (2,) of the rectangle along which strips (m, 2) and (n, 2) follow each other."""
    x, y = np.eye(2)
    first = np.ptp(u @ x) * np.ptp(v @ y) >= np.ptp(u @ y) * np.ptp(v @ x)
    return (x, y) if first else (y, x)
