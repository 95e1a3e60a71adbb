"""Designs that several test files use: grids, tubes and general networks, residuals zero to rounding."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from inverse.model import DesignModel
from inverse.nlp.term import Constraint
from inverse.origami import seeds
from inverse.origami.pattern import CFL, FL, B, Design, Pattern

# Closed sections of Tachi's isotropic cylinders, steps (n, a, length).
SECTIONS = {
    4: [(1, 1, 1), (1, -1, 1), (-1, -1, 1), (-1, 1, 1)],
    6: [(1, 1, 2), (1, -1, 1), (-1, -1, 1), (1, -1, 1), (-1, -1, 1), (-1, 1, 2)],
    8: [(1, 1, 2), (1, -1, 2), (1, 1, 2), (1, -1, 2), (-1, -1, 3), (-1, 1, 1), (-1, -1, 1), (-1, 1, 3)],
}
HYBRID_V = ["FL", "FL", "FL", "CFL", "CFL", "FL", "FL", "FL"]


def miura(m: int = 4, n: int = 4, **options: Any) -> Design:
    return seeds.grid((m, n), "FL", "FL", **options)


def eggbox(m: int = 4, n: int = 4, **options: Any) -> Design:
    return seeds.grid((m, n), "CFL", "FL", **options)


def hybrid(m: int = 4, **options: Any) -> Design:
    return seeds.grid((m, 9), "FL", HYBRID_V, **options)


def tube(k: int = 6, rows: int = 4, **options: Any) -> Design:
    return seeds.tube(SECTIONS[k], rows, **options)


def network(parent: Design, faces: Iterable[Sequence[int]], points: np.ndarray | None = None) -> Design:
    """A design of these facets, numbered as in the parent; ``points`` may hold more vertices."""
    points = parent.vertices_coords if points is None else points
    faces = [list(face) for face in faces]
    used = np.unique(np.concatenate(faces))
    number = {old: new for new, old in enumerate(used.tolist())}
    known = dict(zip(map(frozenset, parent.pattern.edges_vertices.tolist()), parent.pattern.edges_type, strict=True))

    def types(edges: np.ndarray) -> np.ndarray:
        return np.array([known[frozenset(used[pair].tolist())] for pair in edges], np.int8)

    pattern = Pattern.from_faces([[number[v] for v in face] for face in faces], len(used), types)
    return Design(pattern, points[used], parent.unit, parent.name)


def without(parent: Design, facets: Iterable[int]) -> Design:
    """The parent without these facets."""
    gone = set(facets)
    return network(parent, [face for f, face in enumerate(parent.pattern.faces_vertices) if f not in gone])


def staircase(make: Callable[..., Design] = miura, size: int = 5) -> Design:
    """A grid cut to a region with a stepped boundary."""
    return without(make(size, size), [i * size + j for i in range(size) for j in range(size) if i + j > size])


def holed(make: Callable[..., Design] = miura, size: int = 5, holes: Sequence[tuple[int, int]] = ((2, 2),)) -> Design:
    """A grid without these interior facets (i, j)."""
    return without(make(size, size), [i * size + j for i, j in holes])


def polygonal(make: Callable[..., Design] = miura, m: int = 4, n: int = 5) -> Design:
    """A grid cut at its boundary: one facet of 3 sides, one of 5 and one of 6; two facets are gone."""
    parent = make(m, n)
    faces = [list(face) for face in parent.pattern.faces_vertices]
    points = parent.vertices_coords.tolist()

    def add(point: np.ndarray) -> int:
        points.append(point.tolist())
        return len(points) - 1

    faces[0] = faces[0][1:]  # the corner vertex (0, 0) is cut off
    a, b, c, d = faces[-1]
    at = {v: parent.vertices_coords[v] for v in (a, b, c, d)}
    faces[-1] = [a, b, add(0.4 * at[b] + 0.6 * at[c]), add(0.3 * at[d] + 0.7 * at[c]), d]
    a, b, c, d = faces[2]  # facet (0, 2) bulges out over its boundary edge d-a
    at = {v: parent.vertices_coords[v] for v in (a, b, c, d)}
    out = 0.3 * (at[a] - at[b])
    faces[2] += [add(at[d] + out + 0.25 * (at[a] - at[d])), add(at[a] + out + 0.3 * (at[d] - at[a]))]
    gone = {n - 1, (m - 1) * n}
    return network(parent, [face for f, face in enumerate(faces) if f not in gone], np.array(points))


GENERAL: dict[str, Callable[[], Design]] = {
    "staircase": staircase,
    "polygonal": polygonal,
    "polygonal_eggbox": lambda: polygonal(eggbox),
    "holed": holed,
    "two_holes": lambda: holed(miura, 7, ((2, 2), (4, 4))),
}
GRIDS: dict[str, Callable[[], Design]] = {"miura": miura, "eggbox": eggbox, "hybrid": hybrid}
TUBES: dict[str, Callable[[], Design]] = {f"tube{k}": lambda k=k: tube(k) for k in SECTIONS}
ALL = GRIDS | GENERAL | TUBES


def relabelled(design: Design, seed: int = 0) -> tuple[Design, np.ndarray, np.ndarray]:
    """The same design with its vertices and facets in another order, and each facet from another vertex on.

    Returns the design, the new number of every vertex and the new number of every facet.
    """
    rng = np.random.default_rng(seed)
    pattern = design.pattern
    vertex, order = rng.permutation(pattern.n_vertices), rng.permutation(len(pattern.faces_vertices))
    faces = []
    for f in order.tolist():
        face = vertex[list(pattern.faces_vertices[f])]
        faces.append(np.roll(face, rng.integers(len(face))).tolist())
    types = edge_types(design, vertex)
    coords = np.empty_like(design.vertices_coords)
    coords[vertex] = design.vertices_coords
    return Design(Pattern.from_faces(faces, pattern.n_vertices, types), coords), vertex, np.argsort(order)


def edge_types(design: Design, vertex: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """The types of a design's edges as :meth:`Pattern.from_faces` asks for them, vertices renumbered."""
    pattern = design.pattern
    known = {
        frozenset(vertex[pair].tolist()): kind
        for pair, kind in zip(pattern.edges_vertices, pattern.edges_type, strict=True)
    }
    return lambda edges: np.array([known[frozenset(pair)] for pair in edges.tolist()], np.int8)


def all_fl(edges: np.ndarray) -> np.ndarray:
    return np.full(len(edges), FL, np.int8)


def all_cfl(edges: np.ndarray) -> np.ndarray:
    return np.full(len(edges), CFL, np.int8)


def perturbed(design: Design, size: float, seed: int = 0) -> Design:
    """Every coordinate moved at random by about ``size``."""
    noise = np.random.default_rng(seed).standard_normal(design.vertices_coords.shape)
    return design.moved_to(design.vertices_coords + size * noise)


def rotation(seed: int = 0) -> np.ndarray:
    """A random proper rotation."""
    q, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    return q * np.sign(np.linalg.det(q))


def best_motion(points: np.ndarray, onto: np.ndarray) -> np.ndarray:
    """``points`` (N, d) moved rigidly, without reflection, as near to ``onto`` as can be."""
    a, b = points - points.mean(axis=0), onto - onto.mean(axis=0)
    u, _, vt = np.linalg.svd(a.T @ b)
    u[:, -1] *= np.sign(np.linalg.det(u @ vt))
    return a @ u @ vt + onto.mean(axis=0)


def assert_close(actual: Any, expected: Any, atol: float) -> None:
    """Equal to within an absolute error."""
    np.testing.assert_allclose(actual, expected, rtol=0, atol=atol)


def rows_of(constraint: Constraint, model: DesignModel, points: np.ndarray) -> np.ndarray:
    """Rows (N, k) at vertices (V, 3) in the seed's unit."""
    e = constraint.elements
    x = model.to_dimensionless(points).ravel()
    return np.array(e.kernel.value.map(e.count)(x[e.variables].T, e.parameters.T)).T.reshape(constraint.lower.shape)


def holds(constraint: Constraint, model: DesignModel, points: np.ndarray) -> np.ndarray:
    rows = rows_of(constraint, model, points)
    return ((rows >= constraint.lower) & (rows <= constraint.upper)).all(axis=1)


def exchanged(pattern: Pattern) -> Pattern:
    """The other reading of the same mesh: every FL a CFL and back."""
    return replace(pattern, edges_type=np.array([B, CFL, FL], np.int8)[pattern.edges_type])
