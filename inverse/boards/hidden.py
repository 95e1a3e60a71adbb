"""What facets hide from a viewer far away: exact for flat facets, those that cross included.

Every line is compared with every facet that it passes in the drawing. Where it is within the facet, how far it lies
behind the facet changes evenly along it, so that the hidden part is one interval, by a few inequalities. No order of
the facets is needed, and none need exist. Areas are compared in the same way, pair by pair.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.boards.body import normals
from inverse.boards.overlay import less
from inverse.fabricate.extras import needed

NEAR = 1e-7  # of the size of all that is drawn: what is nearer than this touches
_PAIRS = 200_000  # bounds the memory


class Facets:
    """Facets that may hide something.

    Args:
        polygons: corners of convex facets, (k, 3) each: to the right, up, and towards the viewer.

    Attributes:
        near: length below which things touch.
        shown: (F,) bool, facets that are not seen edge on.
        areas: (F,) polygons of shapely, without depth; empty where a facet is seen edge on.
    """

    def __init__(self, polygons: Sequence[FloatArray]) -> None:
        shapely = needed("shapely")
        count = max((len(polygon) for polygon in polygons), default=3)
        points = np.concatenate(polygons) if polygons else np.zeros((1, 3))
        self.near = NEAR * float(np.linalg.norm(np.ptp(points, axis=0)))
        normal = normals(polygons)
        size = np.linalg.norm(normal, axis=1)
        self.shown = np.abs(normal[:, 2]) > 1e-6 * np.maximum(size, 1e-300)
        upright = np.where(self.shown, normal[:, 2], 1.0)
        # Depth of a facet's plane at (x, y): rise . (x, y) + level.
        self._rise = np.where(self.shown[:, None], -normal[:, :2] / upright[:, None], 0.0)
        middle = np.array([polygon.mean(axis=0) for polygon in polygons]).reshape(-1, 3)
        self._level = middle[:, 2] - (self._rise * middle[:, :2]).sum(axis=1)
        # Sides as inequalities across . p >= offset; those that are missing hold everywhere.
        self._across = np.zeros((len(polygons), count, 2))
        self._offset = np.full((len(polygons), count), -np.inf)
        for f, polygon in enumerate(polygons):
            flat = polygon[:, :2] if normal[f, 2] > 0 else polygon[::-1, :2]
            step = np.roll(flat, -1, axis=0) - flat
            length = np.linalg.norm(step, axis=1)
            there = length > self.near
            across = np.stack([-step[:, 1], step[:, 0]], axis=1)[there] / length[there, None]
            self._across[f, : len(across)] = across
            self._offset[f, : len(across)] = (across * flat[there]).sum(axis=1)
        self.areas = np.array(
            [
                shapely.Polygon(polygon[:, :2]) if seen else shapely.Polygon()
                for polygon, seen in zip(polygons, self.shown, strict=True)
            ],
            dtype=object,
        )
        self._tree = shapely.STRtree(self.areas)
        self._shapely = shapely

    def hidden(self, edges: FloatArray) -> tuple[IntArray, FloatArray]:
        """The parts of lines that facets hide.

        Args:
            edges: (S, 2, 3) ends of lines.

        Returns:
            (N,) int, the line of each part, ascending, and (N, 2) shares of its length between which it is hidden;
            parts of a line are apart.
        """
        owners, parts = [], []
        lines = self._shapely.linestrings(edges[:, :, :2])
        for some in np.array_split(np.arange(len(edges)), max(1, len(edges) // 500)):
            pairs = self._tree.query(lines[some])
            for part in np.array_split(pairs, max(1, pairs.shape[1] // _PAIRS), axis=1):
                line, facet = some[part[0]], part[1]
                low, high = self._interval(edges[line], facet)
                found = low < high
                owners.append(line[found])
                parts.append(np.stack([low[found], high[found]], axis=1))
        if not owners:
            return np.zeros(0, np.int64), np.zeros((0, 2))
        return united(np.concatenate(owners), np.concatenate(parts))

    def visible_areas(self) -> list[Any]:
        """What is seen of every facet, polygons of shapely in their order."""
        shapely = self._shapely
        first, second = self._tree.query(self.areas)
        pairs = np.stack([first, second])[:, first < second]
        before: list[list[Any]] = [[] for _ in self.areas]
        for f, g in (part for part in np.array_split(pairs, max(1, pairs.shape[1] // _PAIRS), axis=1)):
            # Convex hulls are what they are, without the lines along which facets touch besides.
            common = shapely.convex_hull(shapely.intersection(self.areas[f], self.areas[g]))
            large = shapely.area(common) > self.near * np.sqrt(shapely.area(self.areas[f]) + self.near**2)
            f, g, common = f[large], g[large], common[large]
            if not len(common):
                continue
            points, owner = shapely.get_coordinates(common, return_index=True)
            rise, level = self._rise[g] - self._rise[f], self._level[g] - self._level[f]
            ahead = (rise[owner] * points).sum(axis=1) + level[owner]
            starts = np.flatnonzero(np.diff(owner, prepend=-1))
            lowest, highest = (bound.reduceat(ahead, starts) for bound in (np.minimum, np.maximum))
            near = self.near * (1 + np.linalg.norm(self._rise[f], axis=1) + np.linalg.norm(self._rise[g], axis=1))
            over, under = highest > near, lowest < -near
            for k in np.flatnonzero(over & ~under):
                before[f[k]].append(common[k])
            for k in np.flatnonzero(under & ~over):
                before[g[k]].append(common[k])
            for k in np.flatnonzero(over & under):  # they cross
                of_k = owner == k
                upper = _half(shapely, ahead[of_k], points[of_k])
                before[f[k]].append(upper)
                before[g[k]].append(_half(shapely, -ahead[of_k], points[of_k]))
        return [self._rest(area, shapes) for area, shapes in zip(self.areas, before, strict=True)]

    def _rest(self, area: Any, shapes: list[Any]) -> Any:
        """What shapes leave of an area; the largest ones first, because little may be left after a few."""
        if not shapes:
            return area
        shapely = self._shapely
        for k in np.argsort(-shapely.area(shapes), kind="stable"):
            area = less(area, shapes[k], self.near)
            if area.area <= self.near**2:
                return shapely.Polygon()
        return area

    def _interval(self, edges: FloatArray, facet: IntArray) -> tuple[FloatArray, FloatArray]:
        """Between which shares of their lengths lines (N, 2, 3) are behind facets (N,)."""
        start, step = edges[:, 0], edges[:, 1] - edges[:, 0]
        across, rise = self._across[facet], self._rise[facet]
        value = np.einsum("nkd,nd->nk", across, start[:, :2]) - self._offset[facet] - self.near
        slope = np.einsum("nkd,nd->nk", across, step[:, :2])
        steep = 1 + np.linalg.norm(rise, axis=1)
        ahead = (rise * start[:, :2]).sum(axis=1) + self._level[facet] - start[:, 2] - self.near * steep
        gain = (rise * step[:, :2]).sum(axis=1) - step[:, 2]
        value, slope = np.column_stack([value, ahead]), np.column_stack([slope, gain])
        with np.errstate(divide="ignore", invalid="ignore"):
            root = -value / slope
        never = ((slope == 0) & (value <= 0)).any(axis=1)
        low = np.where(slope > 0, root, -np.inf).max(axis=1).clip(0, 1)
        high = np.where(slope < 0, root, np.inf).min(axis=1).clip(0, 1)
        return np.where(never, 1.0, low), np.where(never, 0.0, high)


def _half(shapely: Any, ahead: FloatArray, points: FloatArray) -> Any:
    """The part of a convex shape where a function, known at its outline, is positive."""
    found: list[FloatArray] = []
    for p, q, a, b in zip(points[:-1], points[1:], ahead[:-1], ahead[1:], strict=True):
        if a > 0:
            found.append(p)
        if (a > 0) != (b > 0):
            found.append(p + a / (a - b) * (q - p))
    shape = shapely.MultiPoint(found).convex_hull
    return shape if shape.geom_type == "Polygon" else shapely.Polygon()


def united(owners: IntArray, parts: FloatArray) -> tuple[IntArray, FloatArray]:
    """Intervals of every owner without overlaps, in their order."""
    order = np.lexsort((parts[:, 0], owners))
    found: list[tuple[int, float, float]] = []
    for owner, (low, high) in zip(owners[order].tolist(), parts[order].tolist(), strict=True):
        if found and found[-1][0] == owner and low <= found[-1][2]:
            found[-1] = (owner, found[-1][1], max(found[-1][2], high))
        else:
            found.append((owner, low, high))
    table = np.array(found).reshape(-1, 3)
    return table[:, 0].astype(np.int64), table[:, 1:]


def rest_of(count: int, owners: IntArray, parts: FloatArray) -> tuple[IntArray, FloatArray]:
    """What intervals (N, 2) of owners (N,), ascending and apart, leave of [0, 1] of each of ``count`` owners."""
    found: list[tuple[int, float, float]] = []
    at = 0
    rows = list(zip(owners.tolist(), parts.tolist(), strict=True))
    for owner in range(count):
        last = 0.0
        while at < len(rows) and rows[at][0] == owner:
            low, high = rows[at][1]
            if low > last:
                found.append((owner, last, low))
            last, at = high, at + 1
        if last < 1:
            found.append((owner, last, 1.0))
    table = np.array(found).reshape(-1, 3)
    return table[:, 0].astype(np.int64), table[:, 1:]
