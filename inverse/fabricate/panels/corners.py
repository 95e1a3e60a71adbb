"""How far panels are cut back at their corners, where facets meet that share a vertex only.

Cutting back from the foldlines keeps neighbours apart. Two facets opposite each other at a vertex can still meet near
it: where all four foldlines are folded to one side and the facets between the two are narrow. Both then lose
their corner behind a line across its bisector. As everything near a vertex grows with the height of the layers, so does
the distance of that line; what is found here is the distance for layers of height 1, from the sectors alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.fabricate.panels.frames import local_corners, poses
from inverse.fabricate.panels.insets import Insets, clipped, padded
from inverse.fabricate.panels.separation import gaps
from inverse.origami import geometry
from inverse.origami.pattern import Design, Pattern

_REACH = 1.0e3  # length of the sectors, where the longest way from a vertex to its cut-back corner is 1
_STEPS = 36  # bisections of the distance
_CONTACT = 1e-13  # depth of an overlap that counts as mere contact, of the sectors' length

Corner = tuple[int, int]  # a facet, and which of its vertices


def with_corners_cut(design: Design, cuts: list[tuple[Insets, Insets]], t: FloatArray) -> list[tuple[Insets, Insets]]:
    """Cut corners back where layers of facets that share a vertex only would overlap.

    Args:
        design: the mesh.
        cuts: upper and lower layer of every facet, one line for each of its edges.
        t: (S,) folding amounts at which the layers are kept apart, radians.

    Returns:
        The cuts, with one more line for every corner that is cut back.
    """
    pairs = _opposite_corners(design.pattern)
    if not pairs:
        return cuts
    corners = local_corners(design)
    reach = _reach(design, cuts)
    sectors = {(facet, k): _sector(corners[facet], cuts[facet], k, reach) for pair in pairs for facet, k in pair}
    axes = poses(design, t)[0]
    distances: dict[tuple[Corner, int], float] = {}
    for pair, layers, states in _overlaps(pairs, sectors, axes):
        outlines = [(sectors[corner], layer) for corner, layer in zip(pair, layers, strict=True)]
        found = _least_distance(outlines, [axes[states, facet] for facet, _ in pair])
        for key in zip(pair, layers, strict=True):
            distances[key] = max(distances.get(key, 0.0), found)
    result = [list(layers) for layers in cuts]
    for ((facet, k), layer), distance in distances.items():
        bisector = sectors[facet, k].bisector
        result[facet][layer] = result[facet][layer].with_line(bisector, float(bisector @ corners[facet][k]), distance)
    return [(upper, lower) for upper, lower in result]


@dataclass(frozen=True, eq=False)
class _Sector:
    """A corner of a facet, its sides prolonged, the vertex at the origin.

    Attributes:
        bisector: (2,) unit.
        outlines: of the upper and the lower layer of height 1.
        contact: depth of an overlap that counts as mere contact.
    """

    bisector: FloatArray
    outlines: tuple[FloatArray, FloatArray]
    contact: float

    def solid(self, layer: int, axes: FloatArray, distance: float = 0.0) -> FloatArray:
        """(S, 2, K, 3): the layer turned by (S, 3, 3), its corner cut back by a distance."""
        outline = self.outlines[layer]
        outline = clipped(outline, outline @ self.bisector - distance)
        return _solid(outline[None], layer, axes)


def _reach(design: Design, cuts: list[tuple[Insets, Insets]]) -> float:
    """A length beside which everything at a vertex is small: the lines of a corner meet slope / sin(angle) from it."""
    steepest = max(float(layer.slopes.max()) for pair in cuts for layer in pair)
    return (
        _REACH
        * max(steepest, 1.0)
        / float(np.sin(geometry.sector_angles(design.pattern, design.vertices_coords)).min())
    )


def _sector(corners: FloatArray, cuts: tuple[Insets, Insets], k: int, reach: float) -> _Sector:
    before, here, after = corners[k - 1], corners[k], corners[(k + 1) % len(corners)]
    sides = geometry.unit(np.array([after - here, before - here]))
    lines = [k, k - 1]
    open_end = np.vstack([np.zeros(2), reach * sides])
    upper, lower = (
        Insets(layer.normals[lines], np.zeros(2), layer.slopes[lines], layer.hinges[lines]).outline(open_end, 1.0)
        for layer in cuts
    )
    return _Sector(geometry.unit(sides.sum(axis=0)), (upper, lower), _CONTACT * reach)


def _opposite_corners(pattern: Pattern) -> list[tuple[Corner, Corner]]:
    """Pairs of facet corners at one vertex that no edge joins."""
    at: list[list[Corner]] = [[] for _ in range(pattern.n_vertices)]
    for facet, vertices in enumerate(pattern.faces_vertices):
        for k, vertex in enumerate(vertices):
            at[vertex].append((facet, k))
    joined = {frozenset(faces) for faces in pattern.edges_faces.tolist()}
    return [
        (one, other)
        for around in at
        for one, other in combinations(around, 2)
        if frozenset((one[0], other[0])) not in joined
    ]


def _overlaps(
    pairs: list[tuple[Corner, Corner]], sectors: dict[Corner, _Sector], axes: FloatArray
) -> Iterator[tuple[tuple[Corner, Corner], tuple[int, int], IntArray]]:
    """Pairs of corners, which of their layers overlap, and the states in which they do."""
    contact = next(iter(sectors.values())).contact
    facets = np.array([[facet for facet, _ in pair] for pair in pairs])
    outlines = [
        [padded([sectors[pair[side]].outlines[layer] for pair in pairs]) for layer in (0, 1)] for side in (0, 1)
    ]
    for layers in ((0, 0), (0, 1), (1, 0), (1, 1)):
        apart = []
        for turned in axes:
            one, other = (
                _solid(outlines[side][layer], layer, turned[facets[:, side]]) for side, layer in enumerate(layers)
            )
            apart.append(gaps(one, other))
        overlapping = np.array(apart) < -contact
        for k in np.flatnonzero(overlapping.any(axis=0)).tolist():
            yield pairs[k], layers, np.flatnonzero(overlapping[:, k])


def _least_distance(outlines: list[tuple[_Sector, int]], axes: list[FloatArray]) -> float:
    """By how much both corners are cut back for their layers to be apart in all states; 0 if nothing helps."""

    def overlap(distance: float) -> bool:
        one, other = (
            sector.solid(layer, turned, distance) for (sector, layer), turned in zip(outlines, axes, strict=True)
        )
        return bool((gaps(one, other) < -outlines[0][0].contact).any())

    # Half of what the shorter sector reaches along its bisector: what is left of it is then still large.
    low, high = 0.0, min(float((sector.outlines[layer] @ sector.bisector).max()) for sector, layer in outlines) / 2
    if overlap(high):
        return 0.0  # the ideal facets cross: this is for the collision check to report
    for _ in range(_STEPS):
        middle = (low + high) / 2
        low, high = (middle, high) if overlap(middle) else (low, middle)
    return high


def _solid(outlines: FloatArray, layer: int, axes: FloatArray) -> FloatArray:
    """Layers of height 1 over outlines (N or 1, K, 2), turned by axes (N, 3, 3): (N, 2, K, 3)."""
    flat = outlines @ axes[:, :2]
    up = (axes[:, 2] if layer == 0 else -axes[:, 2])[:, None]
    return np.stack([flat, flat + up], axis=1)
