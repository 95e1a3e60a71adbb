"""How thick panels are, and how far a thick structure folds (paper, section 5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inverse._types import FloatArray
from inverse.errors import InputError
from inverse.origami import geometry
from inverse.origami.pattern import CFL, FL, Design, Pattern


@dataclass(frozen=True, eq=False)
class Thickness:
    """How thick panels are and how far they fold.

    Attributes:
        thickness: of each of the two layers, in the design's unit.
        delta: angle that is left when a foldline is folded as far as it goes, radians in (0, pi); one for all
            foldlines, or (E,) one for each edge.
        hinge: thickness of a sheet between the layers, whose middle is the ideal surface; 0 without one.

    Raises:
        InputError: a value out of its range.
    """

    thickness: float
    delta: float | FloatArray = np.pi / 18
    hinge: float = 0.0

    def __post_init__(self) -> None:
        if not (np.isfinite(self.thickness) and self.thickness > 0):
            raise InputError(f"the thickness of a layer is {self.thickness:g}: it must be greater than 0")
        if not (np.isfinite(self.hinge) and self.hinge >= 0):
            raise InputError(f"the thickness of the hinge sheet is {self.hinge:g}: 0 (no sheet) or more is needed")
        delta = np.ravel(self.delta)
        wrong = delta[~((delta > 0) & (delta < np.pi))]
        if len(wrong):
            raise InputError(
                f"delta is {np.degrees(wrong[0]):g} degrees: it must lie between 0 and 180",
                hint="Panels fold up to 180 - delta degrees; 10 is usual.",
            )

    @property
    def height(self) -> float:
        """Distance from the ideal surface to the outside of a layer."""
        return self.thickness + self.hinge / 2

    def deltas(self, pattern: Pattern) -> FloatArray:
        """(E,) delta of every edge, radians.

        Raises:
            InputError: their number is neither one nor that of the edges.
        """
        count = len(pattern.edges_vertices)
        if np.ndim(self.delta) and np.shape(self.delta) != (count,):
            raise InputError(f"{np.size(self.delta)} values of delta are given for {count} edges: one each is needed")
        return np.broadcast_to(np.asarray(self.delta, np.float64), (count,))


@dataclass(frozen=True)
class Range:
    """How far delta lets a thick structure fold.

    Attributes:
        low: smallest folding amount in radians; 0 if the developed state is reached.
        high: largest folding amount in radians; pi if the flat-folded state is reached.
        low_edge: the complementary foldline that is folded to pi - delta at ``low``, None if there is none.
        high_edge: the foldline that is folded to pi - delta at ``high``, None if there is none.
    """

    low: float
    high: float
    low_edge: int | None
    high_edge: int | None

    def states(self, count: int) -> FloatArray:
        """Folding amounts (count,) in radians, evenly spread over the range, both limits included."""
        return np.linspace(self.low, self.high, count)


def motion_range(design: Design, thickness: Thickness) -> Range:
    """The folding amounts at which no foldline is folded further than pi - delta.

    max over CFL |tan(rho/2)| tan(delta/2) <= tan(t/2) <= min over FL cot(delta/2) / |tan(rho/2)|.

    Raises:
        InputError: there is no such state.
    """
    pattern = design.pattern
    half = np.abs(np.tan(geometry.fold_angles(pattern, design.vertices_coords) / 2))
    reach = half * np.tan(thickness.deltas(pattern) / 2)
    complementary, foldlines = np.flatnonzero(pattern.edges_type == CFL), np.flatnonzero(pattern.edges_type == FL)
    low_edge = int(complementary[np.argmax(reach[complementary])]) if len(complementary) else None
    high_edge = int(foldlines[np.argmax(reach[foldlines])]) if len(foldlines) else None
    low = 0.0 if low_edge is None else 2 * float(np.arctan(reach[low_edge]))
    high = np.pi if high_edge is None else 2 * float(np.arctan2(1.0, reach[high_edge]))
    if low_edge is not None and high_edge is not None and low > high:
        ends = pattern.edges_vertices
        raise InputError(
            f"no state leaves delta at every foldline: edge {'-'.join(map(str, ends[low_edge]))} needs t of at least "
            f"{np.degrees(low):.4g} degrees, edge {'-'.join(map(str, ends[high_edge]))} of at most "
            f"{np.degrees(high):.4g}",
            hint="Take a smaller delta.",
        )
    return Range(low, high, low_edge, high_edge)
