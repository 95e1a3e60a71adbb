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
"""

from __future__ import annotations

from functools import cache

import casadi
import numpy as np
import scipy.linalg

from inverse import geometry
from inverse.errors import InputError
from inverse.kernels import Elements, Kernel
from inverse.model import Constraint, DesignModel
from inverse.pattern import FloatArray, IntArray

Quadrilateral = tuple[int, int, int, int]
Filling = tuple[Quadrilateral, ...]

FITS = 1e-6  # of a seed's equations: a filling that it leaves further off is not one of its families


@cache
def fillings(k: int) -> tuple[Filling, ...]:
    """All ways to cut a polygon with corners 0 .. k - 1, k even, into quadrilaterals: 1, 3, 12, 55 for 4, 6, 8, 10."""

    def between(low: int, high: int) -> list[Filling]:
        """Of the part between the corners low and high, by the quadrilateral on the side that joins these two."""
        if high - low == 1:
            return [()]
        return [
            ((low, a, b, high), *first, *second, *third)
            for a in range(low + 1, high, 2)
            for b in range(a + 1, high, 2)
            for first in between(low, a)
            for second in between(a, b)
            for third in between(b, high)
        ]

    return tuple(between(0, k - 1))


def exact(model: DesignModel, name: str, strip: tuple[int, ...], filling: Filling | None = None) -> Constraint:
    """A strip stays closed through the whole motion.

    Args:
        model: the model.
        name: unique name of the constraint.
        strip: (k,) facets in order around a hole; the last shares an edge with the first.
        filling: of the polygon of their planes; by default the best conditioned one at the seed.

    Returns:
        Three rows for every quadrilateral: its planes meet in a point, and two pairs of opposite folds are equal.

    Raises:
        InputError: the seed does not close in any of these ways.
    """
    filling = suited(model, strip)[0] if filling is None else filling
    places, vertices = _corners(model, strip)
    normals = geometry.facet_normals(model.pattern, model.seed_points)[list(strip)]
    points = model.seed_points[vertices]
    centre = points.mean(axis=0)
    size = float(np.sqrt(np.mean(np.sum((points - centre) ** 2, axis=1))))

    def residual(q: casadi.SX, _: casadi.SX) -> casadi.SX:
        return _filled((casadi.reshape(q, 3, len(vertices)) - centre) / size, places, normals, filling)

    kernel = Kernel(name, residual, 3 * len(vertices))
    elements = Elements(name, kernel, model.variables_of(vertices[None]), np.empty((1, 0)))
    zero = np.zeros((1, kernel.n_residuals))
    return Constraint(elements, zero, zero, (f"strip of {len(strip)} facets from facet {strip[0]}",))


def suited(model: DesignModel, strip: tuple[int, ...]) -> list[Filling]:
    """Fillings whose equations hold at the seed, the best conditioned first.

    Raises:
        InputError: there is none.
    """
    k = len(strip)
    found: list[tuple[float, Filling]] = []
    x = model.seed_points.ravel()
    for filling in fillings(k) if k % 2 == 0 else ():
        elements = exact(model, "filling", strip, filling).elements
        rows = np.asarray(elements.kernel.value(x[elements.variables[0]], []))
        if np.abs(rows).max() < FITS:
            jacobian = np.asarray(elements.kernel.jacobian(x[elements.variables[0]], []).full())
            found.append((float(np.linalg.svd(jacobian, compute_uv=False)[-1]), filling))
    if not found:
        raise InputError(
            f"the strip of {k} facets around a hole, from facet {strip[0]}, does not stay closed in the seed's motion",
            hint="Start from a seed that folds without opening, such as a tube of a section of signed steps.",
        )
    best = max(size for size, _ in found)
    # Mirror images are as good as each other up to rounding, which is not to decide.
    return [filling for _, filling in sorted(found, key=lambda one: (-round(one[0] / best, 6), one[1]))]


def bars(model: DesignModel, name: str, strip: tuple[int, ...]) -> Constraint:
    """The paper's sufficient condition: a strip keeps its seed's shape, as if rigid bars joined all its vertices.

    All pairwise distances would depend on each other. Three vertices keep their distances, and every other one its
    place relative to these: 6k - 6 rows for the 2k vertices of a strip of quads.

    Args:
        model: the model.
        name: unique name of the constraint.
        strip: (k,) facets in order around a hole.
    """
    _, vertices = _corners(model, strip)
    points = model.seed_points[vertices]
    first = _spread(points)
    order = np.r_[first, np.setdiff1d(np.arange(len(vertices)), first)]
    vertices, points = vertices[order], points[order]
    size = float(np.sqrt(np.mean(np.sum((points - points.mean(axis=0)) ** 2, axis=1))))

    def shape(q: casadi.SX) -> casadi.SX:
        a, b, c, *others = (q[3 * k : 3 * k + 3] / size for k in range(len(vertices)))
        u, v = b - a, c - a
        w = casadi.cross(u, v)
        rows = [casadi.sumsqr(u), casadi.sumsqr(v), casadi.dot(u, v)]
        return casadi.vertcat(*rows, *(casadi.dot(axis, p - a) for p in others for axis in (u, v, w)))

    q = casadi.SX.sym("q", 3 * len(vertices))
    kept = np.asarray(casadi.Function("shape", [q], [shape(q)])(points.ravel())).ravel()
    kernel = Kernel(name, lambda q, _: shape(q), 3 * len(vertices))
    elements = Elements(name, kernel, model.variables_of(vertices[None]), np.empty((1, 0)))
    return Constraint(elements, kept[None], kept[None], (f"strip of {len(strip)} facets from facet {strip[0]}",))


def independent(jacobian: FloatArray) -> IntArray:
    """Rows of a Jacobian that span all of them, as far from dependent as a pivoted factorization finds.

    Where a strip closes through the whole motion, three equations of every further ring of vertices around the hole
    follow from the others: which strip comes next is a matter of one plane. A solver that is given all of them
    finds no multipliers.

    Args:
        jacobian: (R, n).

    Returns:
        (r,) int, ascending; r is the rank.
    """
    sizes = np.linalg.norm(jacobian, axis=1, keepdims=True)
    scaled = jacobian / np.where(sizes > 0, sizes, 1.0)
    _, triangle, order = scipy.linalg.qr(scaled.T, mode="economic", pivoting=True)
    diagonal = np.abs(np.diag(triangle))
    return np.sort(order[: int((diagonal > RANK * diagonal[0]).sum())]).astype(np.int64)


RANK = 1e-8  # pivots of rows that depend on others are 1e-14; the smallest of others 1e-4 at 8 x 24 facets


def _corners(model: DesignModel, strip: tuple[int, ...]) -> tuple[list[list[int]], IntArray]:
    """The vertices of a strip, (N,) int, and the place of each facet's corners among them."""
    faces = [model.pattern.faces_vertices[f] for f in strip]
    vertices = np.unique(np.concatenate([np.array(face) for face in faces]))
    return [np.searchsorted(vertices, face).tolist() for face in faces], vertices


def _spread(points: FloatArray) -> IntArray:
    """Three points, (3,) int, that span a large triangle."""
    a = 0
    b = int(np.argmax(np.linalg.norm(points - points[a], axis=1)))
    c = int(np.argmax(np.linalg.norm(np.cross(points - points[a], points[b] - points[a]), axis=1)))
    return np.array([a, b, c])


def _filled(q: casadi.SX, corners: list[list[int]], seed_normals: FloatArray, filling: Filling) -> casadi.SX:
    """Residuals of all quadrilaterals of a filling at the vertices q, (3, N)."""
    normals: list[casadi.SX] = []
    planes: list[casadi.SX] = []
    for face in corners:
        first, second, third, last = (q[:, v] for v in (face[0], face[1], face[2], face[-1]))
        quad = len(face) > 3
        normal = casadi.cross(third - first, last - second) if quad else casadi.cross(second - first, third - first)
        normals.append(normal / casadi.norm_2(normal))
        planes.append(casadi.horzcat(normals[-1].T, casadi.dot(normals[-1], first + second + third + last) / 4))
    rows: list[casadi.SX] = []
    for i, j, k, m in filling:
        rows.append(casadi.det(casadi.vertcat(planes[i], planes[j], planes[k], planes[m])))
        for a, b, c, d in ((i, j, k, m), (j, k, m, i)):
            # Folds are equal, or together 180 degrees where an FL is opposite a CFL; planes do not know the difference
            # but for the sides of their normals, which stay as they are in the seed.
            product = float(seed_normals[a] @ seed_normals[b]) * float(seed_normals[c] @ seed_normals[d])
            opposite = casadi.dot(normals[c], normals[d])
            rows.append(casadi.dot(normals[a], normals[b]) - (opposite if product >= 0 else -opposite))
    return casadi.vertcat(*rows)
