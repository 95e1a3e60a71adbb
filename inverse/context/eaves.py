"""Eaves of buildings: where a roof begins above a wall, and where two of them face each other."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike

from inverse._types import FloatArray
from inverse.context.building import Building, Context, Surface
from inverse.errors import InputError

# An eave is level: it rises less than this per metre (a verge, the roof's sloping edge, rises more).
_LEVEL = 0.05
# Points of different surfaces are one point when they agree to this length, in metres (files keep mm).
_GRID = 0.002
# An eave faces a direction when its outward normal is within 45 degrees of it.
_FACING = np.cos(np.pi / 4)

Key = tuple[int, int, int]


def eaves(building: Building, towards: ArrayLike, tolerance: float = 0.02) -> list[FloatArray]:
    """The eaves of a building that face a direction.

    An eave is a level edge shared by a roof surface and a wall surface, with the wall below it and the roof
    not falling towards the inside. Edges that meet are chained. Vertices closer than ``tolerance`` to the
    polyline through the others are left out, so a front drawn in several straight pieces gives one segment;
    the vertices that stay are vertices of the file, unmoved.

    Args:
        building: the building.
        towards: (2,) direction in plan, of any length.
        tolerance: largest distance of a left-out vertex from the polyline, in metres.

    Returns:
        Polylines (n, 3) in metres, longest first; walking along one, the roof is on the left.
    """
    direction = np.asarray(towards, dtype=np.float64)
    if direction.shape != (2,) or not np.linalg.norm(direction) > 0.0:
        raise InputError(f"a direction in plan must be two numbers, not both zero, not {towards!r}")
    direction = direction / np.linalg.norm(direction)
    walls = _wall_edges(building)
    edges: dict[Key, list[FloatArray]] = {}
    for roof in building.of_kind("RoofSurface"):
        for edge in _lower_edges(roof, tolerance):
            if frozenset(map(_key, edge)) in walls and _outward(edge[1] - edge[0]) @ direction >= _FACING:
                edges.setdefault(_key(edge[0]), []).append(edge)
    lines = [_merged(line, tolerance) for line in _chains(edges)]
    return sorted(lines, key=lambda line: -_length(line))


def facing_eaves(context: Context, name_a: str, name_b: str, tolerance: float = 0.02) -> tuple[FloatArray, FloatArray]:
    """The two eaves at which two buildings face each other, trimmed to the stretch that both have.

    Of all pairs of eaves that look at each other the pair with the longest common stretch is taken. The
    stretch is measured along the gap, the mean direction of the two eaves, and its ends are cut square to it.

    Args:
        context: the buildings.
        name_a: one building, by name.
        name_b: the other.
        tolerance: as for ``eaves``, in metres.

    Returns:
        Polylines (n, 3) and (m, 3) in metres, both running the same way, A on the left and B on the right.

    Raises:
        InputError: a name is unknown, or no eaves of the two face each other.
    """
    a, b = context.building(name_a), context.building(name_b)
    towards = (_middle(b) - _middle(a))[:2]
    best: tuple[float, FloatArray, FloatArray] | None = None
    if np.linalg.norm(towards) > 0.0:
        for line_a in eaves(a, towards, tolerance):
            for line_b in eaves(b, -towards, tolerance):
                trimmed = _trimmed(line_a, line_b[::-1])
                if trimmed is not None and (best is None or trimmed[0] > best[0]):
                    best = trimmed
    if best is None:
        hint = "eaves face each other when level roof edges above walls look at each other across a gap"
        raise InputError(f"no eaves of {name_a} and {name_b} face each other", hint=hint)
    return best[1], best[2]


def _key(point: FloatArray) -> Key:
    x, y, z = np.round(point / _GRID).astype(int)
    return int(x), int(y), int(z)


def _outward(along: FloatArray) -> FloatArray:
    """Unit normal in plan, (2,), on the right of a direction (3,)."""
    return np.asarray(np.array([along[1], -along[0]]) / np.hypot(along[0], along[1]))


def _length(line: FloatArray) -> float:
    return float(np.sum(np.linalg.norm(np.diff(line, axis=0), axis=1)))


def _middle(building: Building) -> FloatArray:
    points = building.points
    return np.asarray(0.5 * (points.min(axis=0) + points.max(axis=0)))


def _wall_edges(building: Building) -> set[frozenset[Key]]:
    """Upper edges of walls: those with wall below them."""
    edges = set()
    for wall in building.of_kind("WallSurface"):
        foot = min(float(ring[:, 2].min()) for ring in wall.rings)
        for ring in wall.rings:
            keys = [_key(point) for point in ring]
            for k in range(len(ring)):
                if min(ring[k - 1, 2], ring[k, 2]) > foot + 1.0:
                    edges.add(frozenset((keys[k - 1], keys[k])))
    return edges


def _lower_edges(roof: Surface, tolerance: float) -> Iterator[FloatArray]:
    """Level edges (2, 3) of a roof that is not lower inside than at the edge, with the roof on their left."""
    outer = roof.rings[0]
    height = float(np.mean([outer[:, 2].min(), outer[:, 2].max()]))
    for k, ring in enumerate(roof.rings):
        x, y = ring[:, 0] - ring[0, 0], ring[:, 1] - ring[0, 1]
        turns_left = float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) > 0.0
        around = ring if turns_left == (k == 0) else ring[::-1]
        for edge in np.stack([around, np.roll(around, -1, axis=0)], axis=1):
            along = edge[1] - edge[0]
            run, rise = float(np.hypot(along[0], along[1])), abs(float(along[2]))
            if run > _GRID and rise <= max(_LEVEL * run, _GRID) and edge[:, 2].max() <= height + tolerance:
                yield edge


def _chains(edges: dict[Key, list[FloatArray]]) -> Iterator[FloatArray]:
    """Polylines (n, 3) of directed edges, by start, that meet end to start."""
    ends = {_key(edge[1]) for group in edges.values() for edge in group}
    # Chains first begin where no edge arrives; what is left after them would be a ring, begun anywhere.
    for start in [*(key for key in edges if key not in ends), *edges]:
        while edges.get(start):
            line = list(edges[start].pop(0))
            while following := edges.get(_key(line[-1])):
                line.append(following.pop(0)[1])
            yield np.array(line)


def _merged(line: FloatArray, tolerance: float) -> FloatArray:
    """The line (n, 3) without vertices that are within the tolerance of it (Douglas and Peucker)."""
    span = line[-1] - line[0]
    along = (line - line[0]) @ span / max(float(span @ span), _GRID**2)
    off = np.linalg.norm(line - line[0] - np.clip(along, 0.0, 1.0)[:, None] * span, axis=1)[1:-1]
    if not np.any(off > tolerance):
        return line[[0, -1]]
    k = int(np.argmax(off)) + 1
    return np.concatenate([_merged(line[: k + 1], tolerance)[:-1], _merged(line[k:], tolerance)])


def _trimmed(a: FloatArray, b: FloatArray) -> tuple[float, FloatArray, FloatArray] | None:
    """Two lines running the same way, cut to their common stretch, with its length; None if there is none.

    B must be on the right of A, wholly.
    """
    chords = [(line[-1] - line[0])[:2] / np.linalg.norm((line[-1] - line[0])[:2]) for line in (a, b)]
    along = (chords[0] + chords[1]) / np.linalg.norm(chords[0] + chords[1])
    across = np.array([along[1], -along[0]])
    low = max(float(np.min(line[:, :2] @ along)) for line in (a, b))
    high = min(float(np.max(line[:, :2] @ along)) for line in (a, b))
    if high - low <= _GRID or np.max(a[:, :2] @ across) >= np.min(b[:, :2] @ across):
        return None
    return high - low, _cut(a, along, low, high), _cut(b, along, low, high)


def _cut(line: FloatArray, along: FloatArray, low: float, high: float) -> FloatArray:
    """The part of a line (n, 3) between two stations along a plan direction (2,)."""
    stations = line[:, :2] @ along
    inner = stations[(stations > low + _GRID) & (stations < high - _GRID)]
    kept = np.array([low, *inner, high])
    return np.stack([np.interp(kept, stations, line[:, k]) for k in range(3)], axis=1)
