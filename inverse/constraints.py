"""Hard constraints of a disk: developability, flat-foldability, planarity and the bounds that keep a mesh a mesh."""

from __future__ import annotations

from collections.abc import Callable

import casadi
import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.model import DesignModel
from inverse.nlp.kernels import Elements, Kernel
from inverse.nlp.term import Constraint
from inverse.origami import geometry

Range = tuple[float, float]


def opposite_angles(model: DesignModel) -> Constraint:
    """Developability (6) and flat-foldability (7) of every interior vertex.

    Together they say that opposite sector angles are supplementary at a Miura vertex and equal at a Voss
    vertex; the cosine form needs no arc cosine and has no infinite slope.
    """
    pattern = model.pattern
    vertices = np.column_stack([pattern.interior_vertices, pattern.ring_vertices])
    sign = np.where(pattern.is_miura_vertex, 1.0, -1.0)[:, None]
    labels = [f"vertex {v}" for v in pattern.interior_vertices]
    kernel = Kernel("opposite_angles", _opposite_angles, 15, 1)
    return _equations(Elements("opposite_angles", kernel, model.variables_of(vertices), sign), labels)


def _opposite_angles(q: casadi.SX, sign: casadi.SX) -> casadi.SX:
    centre = q[:3]
    spokes = [q[3 * k : 3 * k + 3] - centre for k in range(1, 5)]
    cosine = [_cosine(spokes[k], spokes[(k + 1) % 4]) for k in range(4)]
    return casadi.vertcat(cosine[0] + sign * cosine[2], cosine[1] + sign * cosine[3])


def planarity(model: DesignModel) -> list[Constraint]:
    """s - 3 equations for every facet of s > 3 sides: volumes of tetrahedra on its first three vertices.

    Each volume is divided by the seed's edge lengths there, so that the residual is of the order of an angle.
    """
    constraints = []
    for sides, facets in model.pattern.faces_by_sides.items():
        if sides == 3:
            continue
        vertices = np.array([model.pattern.faces_vertices[f] for f in facets], np.int64)
        points = model.seed_points[vertices]
        lengths = np.linalg.norm(np.roll(points, -1, axis=1) - points, axis=2)
        scale = 1 / (lengths[:, 0] * lengths[:, 1] * lengths[:, -1])[:, None]
        name = "planarity" if sides == 4 else f"planarity_{sides}"
        kernel = Kernel(name, lambda q, scale, sides=sides: _planarity(q, scale, sides), 3 * sides, 1)  # type: ignore[misc]
        elements = Elements(name, kernel, model.variables_of(vertices), scale)
        constraints.append(_equations(elements, [f"facet {f}" for f in facets]))
    return constraints


def _planarity(q: casadi.SX, scale: casadi.SX, sides: int) -> casadi.SX:
    a, b, c, *others = (q[3 * k : 3 * k + 3] for k in range(sides))
    normal = casadi.cross(b - a, c - b)
    return casadi.vertcat(*[scale * casadi.dot(normal, d - a) for d in others])


def edge_length(model: DesignModel, factors: Range) -> Constraint:
    """Every edge's squared length within a band around the seed's; a square has no singular slope at zero."""
    return _length(model, "edge_length", model.pattern.edges_vertices, factors)


def bars(model: DesignModel, name: str, pairs: IntArray) -> Constraint:
    """Pairs of vertices (N, 2) keep the distance that they have in the seed, as if a rigid bar joined them."""
    return _length(model, name, pairs, (1.0, 1.0))


def _length(model: DesignModel, name: str, pairs: IntArray, factors: Range) -> Constraint:
    lengths = np.linalg.norm(np.diff(model.seed_points[pairs], axis=1)[:, 0], axis=1)
    kernel = Kernel("length", lambda q, scale: scale * casadi.sumsqr(q[3:] - q[:3]), 6, 1)
    elements = Elements(name, kernel, model.variables_of(pairs), lengths[:, None] ** -2)
    bounds = np.full((elements.count, 1), factors[0] ** 2), np.full((elements.count, 1), factors[1] ** 2)
    return Constraint(elements, *bounds, _edge_labels(pairs))


def sector_angle(model: DesignModel, limits: Range) -> Constraint:
    """Every sector angle within (lo, hi) radians.

    Opposite angles at an interior vertex are equal or supplementary. Where the limits are symmetric about 90
    degrees two neighbouring corners therefore bound all four, and only those are constrained.
    """
    pattern = model.pattern
    corners = pattern.corners
    lo, hi = limits
    if abs(lo + hi - np.pi) < 1e-12:
        implied = {
            (f, v)
            for v, ring in zip(pattern.interior_vertices.tolist(), pattern.ring_faces.tolist(), strict=True)
            for f in ring[2:]
        }
        corners = corners[[(f, v) not in implied for f, _, v, _ in corners.tolist()]]
    kernel = Kernel("sector_angle", lambda q, _: _cosine(q[:3] - q[3:6], q[6:] - q[3:6]), 9)
    elements = Elements("sector_angle", kernel, model.variables_of(corners[:, 1:]), np.empty((len(corners), 0)))
    labels = tuple(f"facet {f} at vertex {v}" for f, _, v, _ in corners.tolist())
    shape = (elements.count, 1)
    return Constraint(elements, np.full(shape, np.cos(hi)), np.full(shape, np.cos(lo)), labels)


def fold_angle(model: DesignModel, limits: Range) -> Constraint:
    """Every fold keeps its sign (mountain or valley) and its size within (lo, hi) radians.

    With m the middle and h half the width of the limits: cos(|rho| - m) >= cos h, one smooth row per edge.
    """
    pattern = model.pattern
    inner = pattern.interior_edges
    edges, (left, right) = pattern.edges_vertices[inner], pattern.edges_faces[inner].T
    following = {(f, v): n for f, _, v, n in pattern.corners.tolist()}
    beyond = np.array(
        [
            (following[f, b], following[g, a])
            for (a, b), f, g in zip(edges.tolist(), left.tolist(), right.tolist(), strict=True)
        ],
        np.int64,
    ).reshape(-1, 2)
    sign = np.sign(geometry.fold_angles(pattern, model.seed_points)[inner])
    middle, half = (limits[0] + limits[1]) / 2, (limits[1] - limits[0]) / 2
    parameters = np.column_stack([np.full(len(inner), np.cos(middle)), sign * np.sin(middle)])
    kernel = Kernel("fold_angle", _fold_angle, 12, 2)
    variables = model.variables_of(np.column_stack([edges, beyond]))
    elements = Elements("fold_angle", kernel, variables, parameters)
    shape = (elements.count, 1)
    return Constraint(elements, np.full(shape, np.cos(half)), np.full(shape, np.inf), _edge_labels(edges))


def _fold_angle(q: casadi.SX, direction: casadi.SX) -> casadi.SX:
    a, b, c, d = (q[3 * k : 3 * k + 3] for k in range(4))
    along = b - a
    left, right = casadi.cross(along, c - b), casadi.cross(-along, d - a)
    cosine = casadi.dot(left, right)
    # cross(right, left) is parallel to the edge, so its dot product with the edge carries sign and size.
    sine = casadi.dot(along, casadi.cross(right, left)) / casadi.norm_2(along)
    size = casadi.sqrt(casadi.sumsqr(left) * casadi.sumsqr(right))
    return (direction[0] * cosine + direction[1] * sine) / size


def on_plane(model: DesignModel, name: str, vertices: IntArray, point: FloatArray, normal: FloatArray) -> Constraint:
    """Vertices (N,) held on planes: points and normals (N, 3) or (3,), in the seed's unit."""
    elements = _linear(model, name, vertices, point, normal[..., None, :])
    return _equations(elements, [f"vertex {v}" for v in vertices])


def on_point(model: DesignModel, name: str, vertices: IntArray, point: FloatArray) -> Constraint:
    """Vertices (N,) held on points (N, 3) or (3,), in the seed's unit."""
    elements = _linear(model, name, vertices, point, np.eye(3))
    return _equations(elements, [f"vertex {v}" for v in vertices])


def on_line(model: DesignModel, name: str, vertices: IntArray, point: FloatArray, direction: FloatArray) -> Constraint:
    """Vertices (N,) held on an endless line: a point (3,) and a unit direction (3,), in the seed's unit."""
    elements = _linear(model, name, vertices, point, _across(direction[None])[0])
    return _equations(elements, [f"vertex {v}" for v in vertices])


def on_segment(model: DesignModel, name: str, vertices: IntArray, start: FloatArray, end: FloatArray) -> Constraint:
    """Vertices (N,) held on segments from ``start`` to ``end``, (N, 3) in the seed's unit, free to slide."""
    along = end - start
    length = np.linalg.norm(along, axis=1)
    along = along / length[:, None]
    frame = np.concatenate([_across(along), along[:, None]], axis=1)
    elements = _linear(model, name, vertices, start, frame)
    zero = np.zeros(len(vertices))
    upper = np.stack([zero, zero, length / model.scale], axis=1)
    return Constraint(elements, np.zeros_like(upper), upper, tuple(f"vertex {v}" for v in vertices))


def _across(along: FloatArray) -> FloatArray:
    """Two unit vectors, (N, 2, 3), across each of some (N, 3), from the axis that it is least parallel to."""
    helper = np.eye(3)[np.argmin(np.abs(along), axis=1)]
    first = np.cross(along, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(along, first)], axis=1)


def on_circle(
    model: DesignModel, name: str, vertices: IntArray, centre: FloatArray, normal: FloatArray, radius: float
) -> Constraint:
    """Vertices (N,) held on a circle: centre, axis (3,) and radius in the seed's unit."""
    kernel = Kernel("circle", _circle, 3, 7)
    middle, size = model.to_dimensionless(centre[None])[0], radius / model.scale
    parameters = np.tile(np.r_[middle, normal / np.linalg.norm(normal), size], (len(vertices), 1))
    elements = Elements(name, kernel, model.variables_of(vertices[:, None]), parameters)
    return _equations(elements, [f"vertex {v}" for v in vertices])


def _circle(q: casadi.SX, p: casadi.SX) -> casadi.SX:
    offset, normal, radius = q - p[:3], p[3:6], p[6]
    # Squared radius over 2 r: a length to first order, smooth at the centre.
    return casadi.vertcat(casadi.dot(offset, normal), (casadi.sumsqr(offset) - radius**2) / (2 * radius))


def keep_out(
    model: DesignModel, name: str, point: FloatArray, normal: FloatArray, vertices: IntArray | None = None
) -> Constraint:
    """Vertices (N,), all if not given, on the side of a plane that its normal points to; point and normal (3,)."""
    vertices = np.arange(model.pattern.n_vertices) if vertices is None else vertices
    elements = _linear(model, name, vertices, point, normal[None, :] / np.linalg.norm(normal))
    shape = (elements.count, 1)
    return Constraint(elements, np.zeros(shape), np.full(shape, np.inf), tuple(f"vertex {v}" for v in vertices))


def _linear(model: DesignModel, name: str, vertices: IntArray, point: FloatArray, directions: FloatArray) -> Elements:
    """Components of (vertex - point) along k directions: point (N, 3) or (3,), directions (N, k, 3) or (k, 3)."""
    n, k = len(vertices), directions.shape[-2]
    origin = np.broadcast_to(model.to_dimensionless(np.atleast_2d(point)), (n, 3))
    rows = np.broadcast_to(directions, (n, k, 3)).reshape(n, 3 * k)
    parameters = np.column_stack([origin, rows])
    kernel = Kernel(f"linear_{k}", lambda q, p: casadi.reshape(p[3:], 3, k).T @ (q - p[:3]), 3, 3 + 3 * k)
    return Elements(name, kernel, model.variables_of(vertices[:, None]), parameters)


#: Every hard constraint of a disk by name, with its bounds in radians or as factors where it takes some.
BOUNDED: dict[str, Callable[[DesignModel, Range], Constraint]] = {
    "edge_length": edge_length,
    "sector_angle": sector_angle,
    "fold_angle": fold_angle,
}


def hard_constraints(model: DesignModel, bounds: dict[str, Range]) -> list[Constraint]:
    """Equations (6), (7) and planarity, and the non-degeneracy bounds.

    Args:
        model: the model.
        bounds: limits of each name in ``BOUNDED``; angles in radians, lengths as factors of the seed's.
    """
    terms = [opposite_angles(model), *planarity(model)]
    terms += [BOUNDED[name](model, limits) for name, limits in bounds.items()]
    return [term for term in terms if term.elements.count]


def _cosine(a: casadi.SX, b: casadi.SX) -> casadi.SX:
    return casadi.dot(a, b) / casadi.sqrt(casadi.sumsqr(a) * casadi.sumsqr(b))


def _equations(elements: Elements, labels: list[str]) -> Constraint:
    zero = np.zeros((elements.count, elements.kernel.n_residuals))
    return Constraint(elements, zero, zero, tuple(labels))


def _edge_labels(edges: IntArray) -> tuple[str, ...]:
    return tuple(f"edge {a}-{b}" for a, b in edges.tolist())
