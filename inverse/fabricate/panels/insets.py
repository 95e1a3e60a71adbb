"""Convex outlines cut back from their edges, and how far they can be cut."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from inverse._types import FloatArray

_ROUNDING = 1e-9  # of an outline's size: what a corner may lie outside a line through which it is computed

_SMALLEST = 1e-6  # of an outline's size: corners nearer to each other are one


@dataclass(frozen=True, eq=False)
class Insets:
    """Lines that bound a layer of a panel: it keeps the points with ``normals @ x >= offsets + height * slopes``.

    Attributes:
        normals: (K, 2), unit, into the panel.
        offsets: (K,) place of each line when nothing is cut back.
        slopes: (K,) distance by which it is cut back per unit of the layer's height, 0 where it keeps its edge.
        hinges: (K,) bool; lines of which the layer must keep a part, because the panel turns about it.
    """

    normals: FloatArray
    offsets: FloatArray
    slopes: FloatArray
    hinges: NDArray[np.bool_]

    def with_line(self, normal: FloatArray, offset: float, slope: float) -> Insets:
        """One more line, no hinge."""
        return replace(
            self, normals=np.vstack([self.normals, normal]), offsets=np.r_[self.offsets, offset],
            slopes=np.r_[self.slopes, slope], hinges=np.r_[self.hinges, False],
        )  # fmt: skip

    def outline(self, corners: FloatArray, height: float) -> FloatArray:
        """The part of a convex outline (k, 2) that these lines leave to a layer of this height."""
        cut = self.slopes > 0
        size = np.ptp(corners, axis=0).max()
        for normal, bound in zip(self.normals[cut], (self.offsets + height * self.slopes)[cut], strict=True):
            corners = clipped(corners, corners @ normal - bound)
        apart = np.abs(corners - np.roll(corners, 1, axis=0)).max(axis=1) > _SMALLEST * size
        return corners[apart] if apart.sum() > 2 else corners

    def largest_height(self) -> float:
        """The height at which the layer vanishes, or what it keeps of a hinge: infinite where nothing is cut.

        A linear program in x, y and the height. Three lines are active at its optimum, so all triples are tried.
        """
        if not (self.slopes > 0).any():
            return np.inf
        triples = np.array(list(combinations(range(len(self.slopes)), 3)))
        size = np.ptp(self.offsets)
        rows = np.c_[self.normals, -self.slopes / self.slopes.max()]
        systems, right = rows[triples], self.offsets[triples]
        regular = np.abs(np.linalg.det(systems)) > _ROUNDING
        triples, found = triples[regular], np.linalg.solve(systems[regular], right[regular, :, None])[..., 0]
        inside = (found @ rows.T >= self.offsets - _ROUNDING * size).all(axis=1)
        triples, heights = triples[inside], found[inside, 2] / self.slopes.max()
        on_hinges = [heights[(triples == k).any(axis=1)] for k in np.flatnonzero(self.hinges)]
        return float(min(some.max(initial=0.0) for some in [heights, *on_hinges]))


def joined(one: Insets, other: Insets) -> Insets:
    """The lines of both, none of them a hinge: they bound what both layers have in common."""
    normals, offsets, slopes = (
        np.concatenate(pair)
        for pair in ((one.normals, other.normals), (one.offsets, other.offsets), (one.slopes, other.slopes))
    )
    return Insets(normals, offsets, slopes, np.zeros(len(slopes), bool))


def clipped(corners: FloatArray, depth: FloatArray) -> FloatArray:
    """The part of a convex outline with non-negative ``depth``, which is linear and given at the corners (k,)."""
    kept = []
    for k in range(len(corners)):
        a, b = depth[k - 1], depth[k]
        if (a >= 0) != (b >= 0):
            kept.append(corners[k - 1] + a / (a - b) * (corners[k] - corners[k - 1]))
        if b >= 0:
            kept.append(corners[k])
    return np.array(kept).reshape(-1, 2)


def padded(outlines: Sequence[FloatArray]) -> FloatArray:
    """(N, K, 2): outlines with their last corners repeated, so that all have as many."""
    most = max(len(outline) for outline in outlines)
    return np.array([outline[np.minimum(np.arange(most), len(outline) - 1)] for outline in outlines])
