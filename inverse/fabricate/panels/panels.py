"""Thick panels: two layers of constant thickness on either side of the ideal surface (paper, section 5)."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import ROUND_DOWN, Decimal
from functools import cached_property

import numpy as np

from inverse._types import FloatArray
from inverse.errors import InputError
from inverse.fabricate.panels.corners import with_corners_cut
from inverse.fabricate.panels.frames import local_corners, poses
from inverse.fabricate.panels.insets import Insets, joined, padded
from inverse.fabricate.panels.thickness import Range, Thickness, motion_range
from inverse.origami import geometry
from inverse.origami.pattern import Design

# On the side from which facets turn counter-clockwise, on the other one, and the sheet between them, if there is one.
LAYERS = ("upper", "lower", "hinge")
STATES = 24  # over the range, limits included, in which corners are kept apart


@dataclass(frozen=True, eq=False)
class Panels:
    """The panels of a design, one per facet, each of two layers, and of a piece of the hinge sheet if there is one.

    A piece of the sheet is what lies between both layers. The rest of it is free to bend.

    Attributes:
        design: the ideal mesh.
        thickness: of the layers.
        range: how far delta lets them fold.
        outlines: per facet the outline of every layer, (k, 2), counter-clockwise seen from the top side, in the
            facet's own frame: :func:`inverse.fabricate.panels.frames.frames`.
        largest: (F,) thickness at which a panel loses a layer, a foldline, or all that its layers have in common.
    """

    design: Design
    thickness: Thickness
    range: Range
    outlines: tuple[tuple[FloatArray, ...], ...]
    largest: FloatArray

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Name of every panel: the number of its facet, all with as many digits."""
        digits = len(str(len(self.outlines) - 1))
        return tuple(f"{facet:0{digits}d}" for facet in range(len(self.outlines)))

    @cached_property
    def padded(self) -> FloatArray:
        """(F, L, K, 2): the outlines with their last corners repeated, so that all have as many."""
        flat = padded([outline for own in self.outlines for outline in own])
        return flat.reshape(len(self.outlines), -1, *flat.shape[1:])

    @property
    def layers(self) -> tuple[str, ...]:
        """Names of the L layers."""
        return LAYERS[: 3 if self.thickness.hinge else 2]

    @property
    def heights(self) -> FloatArray:
        """(L, 2): where each layer begins and ends above the ideal surface; its inner side is the first one."""
        inner, outer = self.thickness.hinge / 2, self.thickness.height
        return np.array([[inner, outer], [-inner, -outer], [-inner, inner]])[: len(self.layers)]

    @cached_property
    def areas(self) -> FloatArray:
        """(F, L): area of every layer."""
        x, y = np.moveaxis(self.padded, -1, 0)
        return np.asarray((x * np.roll(y, -1, axis=2) - np.roll(x, -1, axis=2) * y).sum(axis=2) / 2)

    @property
    def volumes(self) -> FloatArray:
        """(F, L): volume of every layer."""
        return np.asarray(self.areas * np.abs(np.diff(self.heights)[:, 0]))

    def bodies_at(self, t: FloatArray) -> FloatArray:
        """Corners of all layers at folding amounts ``t`` (S,), radians: (S, F, L, 2, K, 3).

        Axes: state, facet, layer, its two sides as in :attr:`heights`, corner, coordinate. Facet 0 is at rest.
        """
        axes, origins = poses(self.design, t)
        level = self.padded @ axes[:, :, None, :2] + origins[:, :, None, None]
        up = self.heights[:, :, None, None] * axes[:, :, None, None, None, 2]
        return np.asarray(level[:, :, :, None] + up)


def panels(design: Design, thickness: Thickness) -> Panels:
    """Thicken a design.

    On the valley side of a foldline the layers on both sides are cut back by height * cot(delta / 2), on the mountain
    side they meet in it. Corners are cut back where layers of facets that share a vertex only would still overlap.
    Every panel keeps a part of each of its foldlines, about which it turns, and its layers overlap.

    Args:
        design: the mesh in its design state; facets convex.
        thickness: of the layers.

    Raises:
        InputError: a facet is not convex, or too small for the thickness: the message names it and the largest
            thickness that works; or no state leaves delta at every foldline.
    """
    corners = local_corners(design)
    reach = motion_range(design, thickness)
    cuts = with_corners_cut(design, _edge_cuts(design, thickness, corners), reach.states(STATES))
    largest = np.array([_largest_height(pair) for pair in cuts]) - thickness.hinge / 2
    if thickness.thickness >= largest.min():
        raise _too_thick(design, thickness, largest)
    outlines = tuple(_outlines(own, pair, thickness) for own, pair in zip(corners, cuts, strict=True))
    return Panels(design, thickness, reach, outlines, largest)


def _largest_height(cuts: tuple[Insets, Insets]) -> float:
    """The height at which a panel loses a layer, a foldline, or all that its layers have in common."""
    return min(layer.largest_height() for layer in (*cuts, joined(*cuts)))


def _outlines(corners: FloatArray, cuts: tuple[Insets, Insets], thickness: Thickness) -> tuple[FloatArray, ...]:
    """Outlines of a panel's layers."""
    layers = tuple(cut.outline(corners, thickness.height) for cut in cuts)
    return (*layers, joined(*cuts).outline(corners, thickness.height)) if thickness.hinge else layers


def _edge_cuts(design: Design, thickness: Thickness, corners: list[FloatArray]) -> list[tuple[Insets, Insets]]:
    """The lines along the edges of every facet, for its upper and its lower layer."""
    pattern = design.pattern
    if not geometry.are_convex(pattern, design.vertices_coords):
        raise InputError(
            "a facet is not convex: panels need convex facets",
            hint="`inverse check` names the facet.",
        )
    angles = geometry.fold_angles(pattern, design.vertices_coords)
    slopes = 1 / np.tan(thickness.deltas(pattern) / 2)
    cuts = []
    for own, edges in zip(corners, map(list, pattern.faces_edges), strict=True):
        along = geometry.unit(np.roll(own, -1, axis=0) - own)
        normals = np.stack([-along[:, 1], along[:, 0]], axis=1)
        offsets = (normals * own).sum(axis=1)
        upper, lower = (
            Insets(normals, offsets, np.where(side * angles[edges] > 0, slopes[edges], 0.0), side * angles[edges] < 0)
            for side in (1, -1)
        )
        cuts.append((upper, lower))
    return cuts


def _too_thick(design: Design, thickness: Thickness, largest: FloatArray) -> InputError:
    worst = int(np.argmin(largest))
    unit = "" if design.unit == "unit" else f" {design.unit}"
    if largest[worst] <= 0:
        return InputError(
            f"no thickness works for facet {worst}: its corners would be cut back without end",
            hint="Facets that meet there in a vertex only cross in the motion; `inverse check` tells where it is free.",
        )
    many = int((largest <= thickness.thickness).sum())
    others = f", as for {many - 1} others" if many > 1 else ""
    return InputError(
        f"layers {thickness.thickness:g}{unit} thick are too thick for facet {worst}{others}: cut back by "
        "thickness * cot(delta / 2), it loses a layer, a foldline or all that its layers have in common",
        hint=f"The largest thickness that works is {_four_digits_below(largest[worst])}{unit}; "
        "a larger delta cuts back less.",
    )


def _four_digits_below(value: float) -> str:
    """The largest number of four digits below a positive one."""
    exact = Decimal(value)
    digit = Decimal(1).scaleb(exact.adjusted() - 3)
    down = exact.quantize(digit, ROUND_DOWN)
    return f"{float(down if down < exact else down - digit):.4g}"
