"""Equations of a state of the motion: every vertex laid beside the facets that lie already.

Each vertex is laid once, along ``pattern.facet_tree``, with as many equations as it has coordinates. The block is
square and triangular, so it is never redundant, also on tubes and around holes, and the design stays as free as it was.
"""

from __future__ import annotations

import casadi
import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.model import DesignModel
from inverse.nlp.kernels import Kernel
from inverse.origami.folding import half_angle
from inverse.origami.pattern import CFL

RIGID = (0.0, 1.0)  # cosine and sine of t = pi / 2, where nothing has moved


def root_kernel(dimension: int, scale: float) -> Kernel:
    """The first three vertices of facet 0: one in the origin, one on the x axis, one beside it (y positive).

    Args:
        dimension: d, 2 for flat states, else 3. Local variables are the three vertices in the design, then in the
            state, 9 + 3 d.
        scale: unit of the state's coordinates.
    """

    def residual(q: casadi.SX, _: casadi.SX) -> casadi.SX:
        a, b, c = (q[3 * k : 3 * k + 3] for k in range(3))
        at_a, at_b, at_c = (scale * q[9 + dimension * k : 9 + dimension * (k + 1)] for k in range(3))
        along, aside = b - a, c - a
        length = casadi.norm_2(along)
        rest = casadi.SX.zeros(dimension - 2)
        on_axis = casadi.vertcat(length, 0, rest)
        beside = casadi.vertcat(
            casadi.dot(aside, along) / length, casadi.norm_2(casadi.cross(along, aside)) / length, rest
        )
        return casadi.vertcat(at_a, at_b - on_axis, at_c - beside)

    return Kernel("root", residual, 9 + 3 * dimension)


def placement_kernel(dimension: int, scale: float) -> Kernel:
    """A vertex c of a facet beyond the edge a-b of a facet that lies already and has a further vertex p.

    With the design's fold angle rho, cos rho_t = (C + cos rho) / (1 + C cos rho) and sin rho_t = S sin rho / (the
    same), where C = cos t at an FL and -cos t at a CFL, and S = sin t: equations (3) and (5) without a tangent. In
    flat states C is 1 or -1 and S is 0, so that facets come to lie exactly in the plane.

    Args:
        dimension: d, 2 for flat states, else 3. Local variables are a, b, p, c in the design, then in the state,
            12 + 4 d; parameters are C and S.
        scale: unit of the state's coordinates.
    """

    def residual(q: casadi.SX, cosine_and_sine: casadi.SX) -> casadi.SX:
        design = [q[3 * k : 3 * k + 3] for k in range(4)]
        *state, at_c = (scale * q[12 + dimension * k : 12 + dimension * (k + 1)] for k in range(4))
        return at_c - laid(design, state, cosine_and_sine[0], cosine_and_sine[1])

    return Kernel("placement", residual, 12 + 4 * dimension, 2)


def laid(
    design: list[casadi.SX], state: list[casadi.SX], cosine: casadi.SX | float, sine: casadi.SX | float
) -> casadi.SX:
    """Where a vertex c beyond the edge a-b comes to lie beside a facet with a further vertex p.

    Args:
        design: a, b, p and c in the design.
        state: a, b and p in a state, of two coordinates in flat states, else three.
        cosine: C of :func:`placement_kernel`.
        sine: S.
    """
    a, b, p, c = design
    at_a, at_b, at_p = state
    along = b - a
    square = casadi.sumsqr(along)
    share_p, share_c = casadi.dot(p - a, along) / square, casadi.dot(c - a, along) / square
    across_p, across_c = p - a - share_p * along, c - a - share_c * along
    normal = casadi.cross(along, across_p)
    height_p, height_c = casadi.norm_2(across_p), casadi.norm_2(across_c)
    # c lies across the edge from p, by height_c cos(rho) in the plane of a, b, p and height_c sin(rho) above it.
    level, above = -casadi.dot(across_c, across_p) / height_p, casadi.dot(across_c, normal) / casadi.norm_2(normal)
    stretch = height_c / (height_c + cosine * level)
    level_t, above_t = stretch * (cosine * height_c + level), stretch * sine * above
    at_along, at_aside = at_b - at_a, at_p - at_a
    place = at_a + share_c * at_along - level_t / height_p * (at_aside - share_p * at_along)
    if at_a.numel() == 3:
        # Lengths are those of the design, so that the only roots are of lengths that edge bounds keep from zero.
        place += above_t / casadi.norm_2(normal) * casadi.cross(at_along, at_aside)
    return place


def cosine_and_sine(t: float, is_cfl: bool) -> tuple[float, float]:
    """C and S of :func:`placement_kernel` at a state t in radians, exact in flat states."""
    half_sine, half_cosine = (float(k) for k in half_angle(np.array(t)))
    cosine = half_cosine**2 - half_sine**2
    return -cosine if is_cfl else cosine, 2 * half_sine * half_cosine


def placements(model: DesignModel, t: float) -> tuple[IntArray, FloatArray]:
    """Which vertex is laid from which others, and how the fold between them moves.

    Args:
        model: the model; of the parent facet's vertices the one farthest from the edge in the seed is taken.
        t: the state, in radians.

    Returns:
        (V - 3, 4) vertices a, b, p, c and (V - 3, 2) parameters of :func:`placement_kernel`, in the order of laying.
    """
    pattern, points = model.pattern, model.seed_points
    a, b, p, *others = pattern.faces_vertices[0]
    vertices, parameters = [(a, b, p, c) for c in others], [RIGID] * len(others)
    placed = set(pattern.faces_vertices[0])
    for facet, parent, edge in pattern.facet_tree[1:].tolist():
        a, b = pattern.edges_vertices[edge].tolist()
        if pattern.edges_faces[edge, 0] != parent:
            a, b = b, a  # the parent lies on the left of the direction a -> b
        behind = np.array(pattern.faces_vertices[parent])
        heights = np.linalg.norm(np.cross(points[behind] - points[a], points[b] - points[a]), axis=1)
        p = int(behind[np.argmax(heights)])
        new = [c for c in pattern.faces_vertices[facet] if c not in placed]
        vertices += [(a, b, p, c) for c in new]
        parameters += [cosine_and_sine(t, bool(pattern.edges_type[edge] == CFL))] * len(new)
        placed.update(new)
    return np.array(vertices, np.int64).reshape(-1, 4), np.array(parameters).reshape(-1, 2)
