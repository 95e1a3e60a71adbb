"""What of a target a mesh covers, seen from the sky or along the target's normals, and what of the mesh lies beyond."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from inverse._types import FloatArray, IntArray
from inverse.brief.rays import met, met_from_above
from inverse.brief.samples import Samples
from inverse.brief.sheets import Sheet

SINGLE = 0.98  # of a roof's area in plan: what remains of it where parts that face down count against it
STEEP = 0.3  # area in plan of a surface relative to its own, below which it is no roof but a wall


Feet = tuple[FloatArray, IntArray, FloatArray]  # squared distances (N,), triangles (N,) and places (N, 3)


@dataclass(frozen=True)
class Part:
    """A component of a target, or a hole in it.

    Attributes:
        kind: which of the two.
        area: of it, of a roof in plan.
        covered: share of that area over which there is mesh; of a hole it should be none.
        place: (3,) its middle.
    """

    kind: Literal["component", "hole"]
    area: float
    covered: float
    place: tuple[float, float, float]


@dataclass(frozen=True)
class Coverage:
    """How a mesh covers its target.

    Attributes:
        covered: share of the target's area that the mesh covers.
        beyond: area of the mesh outside the target's rim, holes included.
        beyond_share: the same as a share of the mesh's area.
        seen: how it was looked: ``open to sky`` (areas are those in plan) or ``along the normal``.
        parts: components and holes of the target, where there is more than one component or a hole.
    """

    covered: float
    beyond: float
    beyond_share: float
    seen: Literal["open to sky", "along the normal"]
    parts: tuple[Part, ...]


def is_roof(target: Sheet) -> bool:
    """Whether a surface keeps the rain off: over every place of its plan it has one height."""
    a, b, c = target.vertices[target.triangles].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    plan = np.abs(normals[:, 2]).sum()
    return bool(abs(normals[:, 2].sum()) >= SINGLE * plan and plan >= STEEP * np.linalg.norm(normals, axis=1).sum())


def coverage(target: Sheet, mesh: Sheet, reach: float, *, has_holes: bool = True, feet: Feet | None = None) -> Coverage:
    """How a mesh covers a target.

    Args:
        target: the target.
        mesh: the mesh.
        reach: how far from the target along its normal the mesh may be to cover it; a roof covers from any height.
        has_holes: whether borders within are holes; those of a tube are its ends.
        feet: what of the target is closest to the mesh's samples, where that is known.
    """
    roof = is_roof(target)
    asked, own = target.samples, mesh.samples
    over = _covered(asked, mesh, reach, roof=roof)
    weights = _weights(asked, roof=roof)
    within = _covered(own, target, reach, roof=roof) if roof else ~_is_outside(own.points, target, feet)
    mine = _weights(own, roof=roof)
    beyond = float(mine[~within].sum())
    parts = _parts(target, asked, over, weights)
    holes = (
        [_hole(loop, target.vertices, mesh, reach, roof=roof) for loop in _inner_borders(target)] if has_holes else []
    )
    told = (*parts, *holes) if len(parts) > 1 or holes else ()
    return Coverage(
        float(weights[over].sum() / weights.sum()), beyond, beyond / float(mine.sum()),
        "open to sky" if roof else "along the normal", tuple(told),
    )  # fmt: skip


def _weights(samples: Samples, *, roof: bool) -> FloatArray:
    return samples.areas * np.abs(samples.normals[:, 2]) if roof else samples.areas


def _covered(samples: Samples, by: Sheet, reach: float, *, roof: bool) -> NDArray[np.bool_]:
    """Which samples have a surface over them."""
    if roof:
        return met_from_above(samples.points, by.nearest)
    return met(samples.points, samples.normals, by.nearest, reach)


def _parts(target: Sheet, asked: Samples, over: NDArray[np.bool_], weights: FloatArray) -> list[Part]:
    """The components of a target."""
    component = target.component[target.triangles[:, 0]][asked.triangles]
    found = []
    for one in np.unique(component).tolist():
        own = component == one
        area = float(weights[own].sum())
        middle = tuple(((asked.points[own].T @ weights[own]) / max(area, 1e-300)).tolist())
        found.append(Part("component", area, float(weights[own & over].sum() / max(area, 1e-300)), middle))
    return found


def _inner_borders(target: Sheet) -> list[IntArray]:
    """Closed borders of a surface by their vertices, but for the longest of every component."""
    edges = np.sort(target.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    border = edges[target.is_border.ravel()]
    following: dict[int, list[int]] = {}
    for a, b in border.tolist():
        following.setdefault(a, []).append(b)
        following.setdefault(b, []).append(a)
    loops: list[IntArray] = []
    while following:
        first = next(iter(following))
        ring, vertex = [first], first
        while following.get(vertex):
            onward = following[vertex].pop()
            following[onward].remove(vertex)
            ring.append(onward)
            vertex = onward
        following = {a: some for a, some in following.items() if some}
        if len(ring) > 3 and ring[0] == ring[-1]:
            loops.append(np.array(ring[:-1]))
    component, vertices = target.component, target.vertices
    lengths = [float(np.linalg.norm(np.diff(vertices[np.r_[one, one[0]]], axis=0), axis=1).sum()) for one in loops]
    outer: dict[int, int] = {}
    for k, loop in enumerate(loops):
        own = int(component[loop[0]])
        if own not in outer or lengths[k] > lengths[outer[own]]:
            outer[own] = k
    return [loop for k, loop in enumerate(loops) if k not in outer.values()]


def _hole(loop: IntArray, vertices: FloatArray, mesh: Sheet, reach: float, *, roof: bool) -> Part:
    """What of a hole is covered; its filling is the fan around its middle, where parts that turn back count against."""
    rim = vertices[loop]
    middle = rim.mean(axis=0)
    count = len(loop)
    fan = np.column_stack([np.arange(count), np.roll(np.arange(count), -1), np.full(count, count)])
    filling = Sheet.of(np.vstack([rim, middle]), fan).samples
    across = np.cross(rim - middle, np.roll(rim, -1, axis=0) - middle).sum(axis=0)
    across /= max(float(np.linalg.norm(across)), 1e-300)
    signed = filling.areas * (filling.normals[:, 2] * np.sign(across[2]) if roof else filling.normals @ across)
    over = _covered(filling, mesh, reach, roof=roof)
    area = float(signed.sum())
    return Part("hole", area, float(signed[over].sum() / max(area, 1e-300)), tuple(middle.tolist()))


def _is_outside(points: FloatArray, target: Sheet, feet: Feet | None) -> NDArray[np.bool_]:
    """Which points (N, 3) lie beyond the border of a surface: the closest points are on it, but not straight below."""
    _, facet, places = feet or target.nearest.find(points)
    a, b, c = target.vertices[target.triangles[facet]].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    size = np.sqrt(np.linalg.norm(normals, axis=1))
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    offset = points - places
    beside = np.linalg.norm(offset - np.einsum("ij,ij->i", offset, normals)[:, None] * normals, axis=1)
    return np.asarray((beside > 1e-6 * size) & _are_on_border(places, facet, target))


def _are_on_border(feet: FloatArray, facet: IntArray, target: Sheet) -> NDArray[np.bool_]:
    vertices, triangles, is_border = target.vertices, target.triangles, target.is_border
    on = np.zeros(len(feet), np.bool_)
    beside = np.flatnonzero(is_border[facet].any(axis=1))
    facet, feet = facet[beside], feet[beside]
    for side in range(3):
        a, b = vertices[triangles[facet, side]], vertices[triangles[facet, (side + 1) % 3]]
        along = (b - a) / np.maximum(np.linalg.norm(b - a, axis=1, keepdims=True), 1e-300)
        distance = np.linalg.norm(np.cross(feet - a, along), axis=1)
        on[beside] |= is_border[facet, side] & (distance <= 1e-6 * np.linalg.norm(b - a, axis=1))
    return on
