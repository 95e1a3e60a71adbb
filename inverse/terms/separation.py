"""Facets that crossed are kept apart: in the design state, and in states of its motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import casadi
import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order

from inverse._types import FloatArray, IntArray
from inverse.model import DesignModel
from inverse.nlp.kernels import Elements, Kernel
from inverse.nlp.term import Constraint
from inverse.origami import folding
from inverse.origami.pattern import CFL, Pattern
from inverse.terms.packed_state import cosine_and_sine, laid

CLEARANCE = 0.05  # in mean edge lengths
TOUCHING = 1e-3  # mean edge lengths from a plane that say nothing about the side of it


@dataclass(frozen=True)
class Side:
    """One facet of a pair lies on one side of the other's plane.

    Attributes:
        facet: the facet with the plane.
        others: vertices of the other one, those on the common edge or vertex left out.
        sign: 1 above the plane, -1 below.
        least: least distance from it.
    """

    facet: int
    others: tuple[int, ...]
    sign: float
    least: float


def side_of(faces_vertices: Sequence[Sequence[int]], points: FloatArray, pair: Sequence[int]) -> Side | None:
    """How two facets lie apart, by the plane that separates them most; None if neither's plane does.

    Args:
        faces_vertices: vertices of all facets.
        points: (V, 3) vertices.
        pair: two facets.
    """
    best: Side | None = None
    for f, g in (pair, pair[::-1]):
        a, b, c = faces_vertices[f][:3]
        normal = np.cross(points[b] - points[a], points[c] - points[b])
        others = tuple(v for v in faces_vertices[g] if v not in faces_vertices[f])
        heights = (points[list(others)] - points[a]) @ (normal / np.linalg.norm(normal))
        least = float(np.abs(heights).min(initial=np.inf))
        if others and abs(np.sign(heights).sum()) == len(others) and (best is None or least > best.least):
            best = Side(f, others, float(np.sign(heights[0])), least)
    return best if best is not None and best.least > TOUCHING else None


def in_design(model: DesignModel, pairs: IntArray) -> Constraint | None:
    """Facets that do not touch in the seed stay on their sides of each other's plane.

    Args:
        model: the model.
        pairs: (N, 2) int, facets to keep apart.

    Returns:
        One row for every vertex kept off a plane, by ``CLEARANCE`` or half the distance in the seed where that is
        less; None if no pair is separated by a facet's plane in the seed.
    """
    faces, points = model.pattern.faces_vertices, model.seed_points
    rows, bounds = [], []
    for pair in pairs.tolist():
        side = side_of(faces, points, pair)
        if side is not None:
            a, b, c = faces[side.facet][:3]
            rows += [(a, b, c, v, side.sign) for v in side.others]
            bounds += [min(CLEARANCE, side.least / 2)] * len(side.others)
    if not rows:
        return None
    table = np.array(rows)
    vertices = table[:, :4].astype(np.int64)
    kernel = Kernel("separation", _separation, 12, 1)
    elements = Elements("separation", kernel, model.variables_of(vertices), table[:, 4:])
    labels = tuple(f"vertex {v}" for v in vertices[:, 3])
    return Constraint(elements, np.array(bounds)[:, None], np.full((len(rows), 1), np.inf), labels)


def _separation(q: casadi.SX, sign: casadi.SX) -> casadi.SX:
    a, b, c, p = (q[3 * k : 3 * k + 3] for k in range(4))
    normal = casadi.cross(b - a, c - b)
    return sign * casadi.dot(normal, p - a) / casadi.norm_2(normal)


def in_state(model: DesignModel, pairs: IntArray, t: float) -> list[Constraint]:
    """Facets that do not touch in a state of the seed's motion stay on their sides of each other's plane there.

    The second facet is laid beside the first along the shortest strip of facets between them, so that only the
    vertices of this strip matter.

    Args:
        model: the model.
        pairs: (N, 2) int, facets to keep apart.
        t: the state in radians, between the flat states.

    Returns:
        For every pair that is separated by a facet's plane in the seed one constraint, a row for every vertex kept
        off the plane.
    """
    pattern, points = model.pattern, folding.fold(model.seed, np.array([t])).vertices_coords[0] / model.scale
    found = []
    for pair in pairs.tolist():
        side = side_of(pattern.faces_vertices, points, pair)
        if side is not None:
            other = pair[0] if side.facet == pair[1] else pair[1]
            found.append(_apart(model, side, _strip(pattern, side.facet, other), t))
    return found


def _apart(model: DesignModel, side: Side, strip: list[int], t: float) -> Constraint:
    """A facet, the first of a strip, has the last one on one side of its plane at a state t."""
    pattern = model.pattern
    faces = [pattern.faces_vertices[f] for f in strip]
    vertices = np.unique([v for face in faces for v in face])
    place = {v: 3 * k for k, v in enumerate(vertices.tolist())}
    steps = [_step(pattern, f, g, t) for f, g in pairwise(strip)]

    def residual(q: casadi.SX, _: casadi.SX) -> casadi.SX:
        design = {v: q[k : k + 3] for v, k in place.items()}
        state = {v: design[v] for v in faces[0]}
        for a, b, p, new, cosine, sine in steps:
            at = [state[v] for v in (a, b, p)]
            state = {a: state[a], b: state[b]} | {
                c: laid([design[v] for v in (a, b, p, c)], at, cosine, sine) for c in new
            }
        first, second, third = (design[v] for v in faces[0][:3])
        normal = casadi.cross(second - first, third - second)
        heights = [casadi.dot(normal, state[v] - first) / casadi.norm_2(normal) for v in side.others]
        return side.sign * casadi.vertcat(*heights)

    name = f"apart_{strip[0]}_{strip[-1]}_at_{round(np.degrees(t) * 1000)}"  # millidegrees: names have no points
    kernel = Kernel(name, residual, 3 * len(vertices))
    elements = Elements(name, kernel, model.variables_of(vertices[None]), np.empty((1, 0)))
    least = np.full((1, len(side.others)), min(CLEARANCE, side.least / 2))
    label = f"facets {strip[0]} and {strip[-1]} at t = {np.degrees(t):.4g} degrees"
    return Constraint(elements, least, np.full(least.shape, np.inf), (label,))


def _step(pattern: Pattern, facet: int, following: int, t: float) -> tuple[int, int, int, list[int], float, float]:
    """From one facet to the next: the edge a-b, a vertex p behind it, those beyond, and how the fold moves."""
    behind, beyond = pattern.faces_vertices[facet], pattern.faces_vertices[following]
    a, b = next((u, v) for u, v in zip(behind, (*behind[1:], behind[0]), strict=True) if u in beyond and v in beyond)
    ends = np.sort(pattern.edges_vertices, axis=1) == sorted((a, b))
    kind = pattern.edges_type[np.flatnonzero(ends.all(axis=1))[0]]
    p = behind[behind.index(a) - 1]  # next to a, so not on the edge's line
    return a, b, p, [v for v in beyond if v not in (a, b)], *cosine_and_sine(t, bool(kind == CFL))


def _strip(pattern: Pattern, first: int, last: int) -> list[int]:
    """The shortest strip of facets from one to another."""
    left, right = pattern.edges_faces[pattern.interior_edges].T
    n = len(pattern.faces_vertices)
    links = coo_array((np.ones(2 * len(left)), (np.r_[left, right], np.r_[right, left])), (n, n)).tocsr()
    _, back = breadth_first_order(links, first, directed=False)
    strip = [last]
    while strip[-1] != first:
        strip.append(int(back[strip[-1]]))
    return strip[::-1]
