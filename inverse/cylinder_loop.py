"""Closed strips of facets around holes: rigid loop bars (the paper), or closed through the whole motion (exact).

Around a hole the vertex conditions are not enough: a strip of k facets may open as it folds. The paper keeps one strip
as it is in the seed. The exact condition lets it change. The planes of the facets are the corners of a polygon with
the hinges as its sides. Cut into quadrilaterals, each of them is a vertex that is not there: four planes through one
point (at infinity where the hinges are parallel), whose fold angles are equal in opposite pairs as at any vertex of
the mesh. The cuts are hinges that are not there either, each between two of these vertices. So the strip bounds a disk
of degree-4 vertices with two flat states, which moves by Theorem 1, and the strip with it.

These are 3 (k - 2) / 2 equations, as many as closure takes freedoms at a generic tube, and their Jacobian has full
rank at Tachi's cylinders already, although there as many families of tubes meet as the polygon has cuts into
quadrilaterals. Closure itself, the product of the hinge motions at k + 1 amounts of folding, is what the certificate
looks at. As constraints those 6 (k + 1) rows are redundant everywhere, and singular where families meet.

Where the hole is one missing facet, the disk that fills it is that facet with its four vertices: 9 equations.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Literal

import casadi
import numpy as np
from numpy.typing import NDArray

from inverse import constraints
from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.model import DesignModel
from inverse.nlp.kernels import Elements, Kernel
from inverse.nlp.term import Constraint
from inverse.origami import geometry
from inverse.origami.holes import boundary_loops, hole_strips
from inverse.origami.pattern import Pattern
from inverse.terms.fillings import Filling, Quadrilateral, fillings, quadrilaterals

FITS = 1e-6  # of a seed's equations: a filling that it leaves further off is not one of its families


def around_holes(model: DesignModel, how: Literal["exact", "bars"] = "exact") -> list[Constraint]:
    """One strip around every hole closes through the whole motion, or keeps its shape; nothing for a disk.

    Args:
        model: the model.
        how: by :func:`exact` or :func:`bars`.

    Raises:
        InputError: a strip does not close in the seed's motion.
    """
    pattern = model.pattern
    if pattern.n_holes == 1 and pattern.grid is not None:
        k, rows = pattern.grid
        # The paper keeps the strip along one end of a tube; in the middle the exact condition is best conditioned.
        row = 0 if how == "bars" else rows // 2
        strips: tuple[tuple[int, ...], ...] = (tuple(i * rows + row for i in range(k)),)
    else:
        strips = hole_strips(pattern)
    if how == "bars":
        return [bars(model, f"loop_{h}", strip) for h, strip in enumerate(strips)]
    return [term for h, strip in enumerate(strips) for term in exact(model, f"loop_{h}", strip)]


def exact(model: DesignModel, name: str, strip: tuple[int, ...], filling: Filling | None = None) -> list[Constraint]:
    """A strip stays closed through the whole motion.

    Args:
        model: the model.
        name: unique name of the constraint, or beginning of the names where there are several.
        strip: (k,) facets in order around a hole; the last shares an edge with the first.
        filling: of the polygon of their planes; by default the best conditioned one at the seed.

    Returns:
        Three rows for every quadrilateral: its planes meet in a point, and two pairs of opposite folds are equal. For
        a hole of one facet its planarity and the conditions of its vertices.

    Raises:
        InputError: the seed does not close in any of these ways.
    """
    if filling is None:
        missing = missing_facet(model.pattern, strip)
        if missing is not None:
            return _filled_in(model, name, missing)
        filling = suited(model, strip)[0]
    corners, vertices = _corners(model, strip)
    points = model.seed_points[vertices]
    centre, size = points.mean(axis=0), _size(points)
    normals = geometry.facet_normals(model.pattern, model.seed_points)[list(strip)]
    signs = [_signs(normals, quadrilateral) for quadrilateral in filling]

    def residual(q: casadi.SX, p: casadi.SX) -> casadi.SX:
        planes = _planes((casadi.reshape(q, 3, len(vertices)) - p[:3]) * p[3], corners)
        return casadi.vertcat(*(_vertex(planes, *one) for one in zip(filling, signs, strict=True)))

    kernel = Kernel(name, residual, 3 * len(vertices), 4)
    elements = Elements(name, kernel, model.variables_of(vertices[None]), np.r_[centre, 1 / size][None])
    zero = np.zeros((1, kernel.n_residuals))
    # Where a line of vertices goes round beside the strip, what closes the strip closes the next one.
    rings = any(line[0] == line[-1] for line in model.pattern.lines)
    return [Constraint(elements, zero, zero, (_label(strip),), implies_others=rings)]


def suited(model: DesignModel, strip: tuple[int, ...]) -> list[Filling]:
    """Fillings whose equations hold at the seed, the best conditioned first.

    Raises:
        InputError: there is none.
    """
    k = len(strip)
    corners, vertices = _corners(model, strip)
    points = model.seed_points[vertices]
    normals = geometry.facet_normals(model.pattern, model.seed_points)[list(strip)]
    cuts = tuple(quadrilaterals(k))
    slopes = _slopes(tuple(map(tuple, corners)), cuts, tuple(_signs(normals, quadrilateral) for quadrilateral in cuts))
    values, slope = (found.full() for found in slopes(((points - points.mean(axis=0)) / _size(points)).T))
    jacobians: dict[Quadrilateral, FloatArray] = {}
    for number, quadrilateral in enumerate(cuts):
        own = slice(3 * number, 3 * number + 3)
        if np.abs(values[own]).max() < FITS:
            jacobians[quadrilateral] = slope[own]
    found = [
        (float(np.linalg.svd(np.vstack([jacobians[q] for q in filling]), compute_uv=False)[-1]), filling)
        for filling in fillings(k, frozenset(jacobians))
    ]
    if not found:
        raise InputError(
            f"the strip of {k} facets around a hole, from facet {strip[0]}, cannot be kept closed through the motion",
            hint="Start from a seed that folds without opening: a tube of a section of signed steps, or a sheet with "
            "holes of one or two facets.",
        )
    best = max(size for size, _ in found)
    # Mirror images are as good as each other up to rounding, which is not to decide.
    return [filling for _, filling in sorted(found, key=lambda one: (-round(one[0] / best, 6), one[1]))]


@lru_cache(maxsize=8)
def _slopes(
    corners: tuple[tuple[int, ...], ...], cuts: tuple[Quadrilateral, ...], signs: tuple[tuple[float, float], ...]
) -> casadi.Function:
    """Residuals of all vertices that are not there, and their Jacobian, of a strip's vertices (3, N)."""
    q = casadi.SX.sym("q", 3, len({vertex for face in corners for vertex in face}))
    planes = _planes(q, corners)
    rows = casadi.vertcat(*(_vertex(planes, *one) for one in zip(cuts, signs, strict=True)))
    return casadi.Function("vertices", [q], [rows, casadi.jacobian(rows, q)])


def missing_facet(pattern: Pattern, strip: tuple[int, ...]) -> tuple[int, ...] | None:
    """The four vertices of the facet within a strip, counter-clockwise, if only one is missing there; else None."""
    vertices = {v for f in strip for v in pattern.faces_vertices[f]}
    for loop in boundary_loops(pattern):
        if len(strip) == 8 and len(loop) == 4 and vertices.issuperset(loop):
            return tuple(loop[::-1])  # facets lie on the left of the border, the hole on its right
    return None


def bars(model: DesignModel, name: str, strip: tuple[int, ...]) -> Constraint:
    """The paper's sufficient condition: a strip keeps its seed's shape, as if rigid bars joined all its vertices.

    All pairwise distances would depend on each other and on planarity. Three vertices keep their distances, and the
    others their places relative to these; but a vertex of a facet that has three already only two coordinates, since
    planarity gives the third: 5k - 5 rows for a strip of quads.

    Args:
        model: the model.
        name: unique name of the constraint.
        strip: (k,) facets in order around a hole.
    """
    corners, vertices = _corners(model, strip)
    points = model.seed_points[vertices]
    size = _size(points)
    first = corners[0][:3]
    a, b, c = points[first]
    axes = np.array([b - a, c - a, np.cross(b - a, c - a) / size])
    kept = _coordinates(corners, geometry.facet_normals(model.pattern, model.seed_points)[list(strip)], axes, first)

    def shape(q: casadi.SX, size: casadi.SX) -> casadi.SX:
        placed = casadi.reshape(q, 3, len(vertices)) / size
        a, b, c = (placed[:, v] for v in first)
        u, v = b - a, c - a
        own = (u, v, casadi.cross(u, v))
        rows = [casadi.sumsqr(u), casadi.sumsqr(v), casadi.dot(u, v)]
        return casadi.vertcat(*rows, *(casadi.dot(own[k], placed[:, vertex] - a) for vertex, k in kept))

    kernel = Kernel(name, shape, 3 * len(vertices), 1)
    given = np.asarray(kernel.value(points.ravel(), size)).ravel()
    elements = Elements(name, kernel, model.variables_of(vertices[None]), np.array([[size]]))
    return Constraint(elements, given[None], given[None], (_label(strip),), implies_others=True)


def _coordinates(
    corners: list[list[int]], normals: FloatArray, axes: FloatArray, first: list[int]
) -> list[tuple[int, int]]:
    """Vertices of a strip and the axes along which each of them is held, facet after facet from three that are."""
    found: list[tuple[int, int]] = []
    held = set(first)
    for face, normal in zip(corners, normals, strict=True):
        # Planarity speaks most for the axis that is nearest to the normal.
        steepness = np.abs(axes @ normal) / np.linalg.norm(axes, axis=1)
        flat = np.sort(np.argsort(steepness)[:2]).tolist()
        for vertex in face:
            if vertex not in held:
                enough = sum(v in held for v in face) >= 3
                held.add(vertex)
                found += [(vertex, k) for k in (flat if enough else range(3))]
    return found


def _filled_in(model: DesignModel, name: str, missing: tuple[int, ...]) -> list[Constraint]:
    """The conditions that a missing facet (4,) makes for its vertices and for itself."""
    whole = DesignModel(replace(model.seed, pattern=_with_facet(model.pattern, missing)))
    corners = np.isin(whole.pattern.interior_vertices, missing)
    angles = constraints.opposite_angles(whole).only(corners, f"{name}_opposite_angles")
    planarity = next(c for c in constraints.planarity(whole) if c.name == "planarity")
    return [angles, planarity.only(np.arange(planarity.elements.count) == planarity.elements.count - 1, name)]


def _with_facet(pattern: Pattern, missing: tuple[int, ...]) -> Pattern:
    """The pattern with one more facet; the lines that end at the hole go on along its edges."""
    known = {
        frozenset(pair): kind
        for pair, kind in zip(pattern.edges_vertices.tolist(), pattern.edges_type.tolist(), strict=True)
    }
    faces = [*pattern.faces_vertices, missing]
    for a, b in zip(missing, np.roll(missing, -1).tolist(), strict=True):
        beside = {v for face in faces if a in face and b in face for v in face}
        known[frozenset((a, b))] = next(kind for pair, kind in known.items() if a in pair and not pair <= beside)

    def types(edges: IntArray) -> NDArray[np.int8]:
        return np.array([known[frozenset(pair)] for pair in edges.tolist()], np.int8)

    return Pattern.from_faces(faces, pattern.n_vertices, types)


def _label(strip: tuple[int, ...]) -> str:
    return f"strip of {len(strip)} facets from facet {strip[0]}"


def _corners(model: DesignModel, strip: tuple[int, ...]) -> tuple[list[list[int]], IntArray]:
    """The vertices of a strip, (N,) int, and the place of each facet's corners among them."""
    faces = [model.pattern.faces_vertices[f] for f in strip]
    vertices = np.unique(np.concatenate([np.array(face) for face in faces]))
    return [np.searchsorted(vertices, face).tolist() for face in faces], vertices


def _size(points: FloatArray) -> float:
    """Root mean square distance from the centre, which makes equations of a small and of a long strip alike."""
    return float(np.sqrt(np.mean(np.sum((points - points.mean(axis=0)) ** 2, axis=1))))


def _planes(q: casadi.SX, corners: Sequence[Sequence[int]]) -> list[casadi.SX]:
    """Unit normal and distance from the origin, (1, 4), of every facet of a strip with vertices q, (3, N)."""
    planes = []
    for face in corners:
        first, second, third, last = (q[:, v] for v in (face[0], face[1], face[2], face[-1]))
        quad = len(face) > 3
        normal = casadi.cross(third - first, last - second) if quad else casadi.cross(second - first, third - first)
        normal = normal / casadi.norm_2(normal)
        planes.append(casadi.horzcat(normal.T, casadi.dot(normal, first + second + third + last) / 4))
    return planes


def _signs(seed_normals: FloatArray, quadrilateral: Quadrilateral) -> tuple[float, float]:
    """Whether the two pairs of opposite folds are equal, or together 180 degrees, where an FL is opposite a CFL.

    Planes do not know the difference but for the sides of their normals, which stay as they are in the seed.
    """
    i, j, k, m = quadrilateral
    products = [
        float(seed_normals[a] @ seed_normals[b]) * float(seed_normals[c] @ seed_normals[d])
        for a, b, c, d in ((i, j, k, m), (j, k, m, i))
    ]
    return (1.0 if products[0] >= 0 else -1.0), (1.0 if products[1] >= 0 else -1.0)


def _vertex(planes: list[casadi.SX], quadrilateral: Quadrilateral, signs: tuple[float, float]) -> casadi.SX:
    """Residuals (3,) of a vertex that is not there: four planes through one point, two pairs of opposite folds."""
    i, j, k, m = quadrilateral
    rows = [casadi.det(casadi.vertcat(planes[i], planes[j], planes[k], planes[m]))]
    for (a, b, c, d), sign in zip(((i, j, k, m), (j, k, m, i)), signs, strict=True):
        rows.append(_cosine(planes, a, b) - sign * _cosine(planes, c, d))
    return casadi.vertcat(*rows)


def _cosine(planes: list[casadi.SX], a: int, b: int) -> casadi.SX:
    return casadi.dot(planes[a][:, :3], planes[b][:, :3])
