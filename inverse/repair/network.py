"""From what a file says to an oriented network of facets: found, turned one way, flat edges taken out."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.origami.pattern import FL, Design, Pattern
from inverse.repair.foreign import ForeignMesh, Pair, pair_of
from inverse.repair.planar_graph import facets_of_graph

FLAT = 1e-6  # of the size: a pattern this near to a plane is a crease pattern, not a folded state
MOST_LISTED = 10

Facets = tuple[tuple[int, ...], ...]


@dataclass(frozen=True, eq=False)
class Network:
    """An oriented 4-valency network whose line types are not known yet.

    Attributes:
        design: all interior edges typed FL; in the plane z = 0, counter-clockwise, if ``is_flat``.
        is_flat: the file holds a flat crease pattern.
        assignments: M or V by edge, as far as the file says so.
        types: FL or CFL by edge, as far as the file says so.
        file_vertices: (V,) int; the file's number of every vertex.
    """

    design: Design
    is_flat: bool
    assignments: dict[Pair, str]
    types: dict[Pair, str]
    file_vertices: IntArray


def build_network(mesh: ForeignMesh, path: Path) -> Network:
    """Make a network of a mesh as read.

    Raises:
        InputError: it is none: edges cross, facets form no orientable surface, some interior vertex has not four
            edges, or the like.
    """
    try:
        return _build(mesh)
    except InputError as error:
        raise InputError(error.message, where=str(path), hint=error.hint) from None


def _build(mesh: ForeignMesh) -> Network:
    points, is_flat = laid_flat(mesh.vertices_coords)
    facets = mesh.faces_vertices
    if facets is None:
        if not is_flat:
            raise InputError("the file has no faces_vertices, and facets can be found from the edges of a flat "
                             "crease pattern only", hint="Export the pattern with its facets.")  # fmt: skip
        border = {pair for pair, word in mesh.assignments.items() if word == "B"}
        facets = facets_of_graph(points[:, :2], list(mesh.assignments), border)
    facets = _oriented(facets)
    _check_listed_edges(facets, mesh.assignments)
    if is_flat:
        facets = _counter_clockwise(facets, points)
    flat_edges = {pair for pair, word in mesh.assignments.items() if word == "F"}
    facets = _without(facets, flat_edges)

    used = np.unique([v for facet in facets for v in facet])
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    _check_degrees(facets)
    for a, b in _sides(facets):
        if not np.linalg.norm(points[a] - points[b]) > 1e-12 * np.ptp(points[used], axis=0).max():
            raise InputError(f"edge {a}-{b} has no length", hint="Join vertices that lie upon each other.")
    renumbered = [[int(number[v]) for v in facet] for facet in facets]
    try:
        pattern = Pattern.from_faces(renumbered, len(used), lambda edges: np.full(len(edges), FL, np.int8))
    except InputError as error:
        note = "" if len(used) == len(points) else " (numbers count vertices of facets only)"
        raise InputError(error.message + note, hint=error.hint) from None
    if not len(pattern.interior_edges):
        raise InputError("the pattern has no interior edge, so that nothing folds")

    def kept(words: dict[Pair, str], allowed: str) -> dict[Pair, str]:
        found = {}
        for (a, b), word in words.items():
            if word in allowed.split() and number[a] >= 0 and number[b] >= 0:
                found[pair_of(int(number[a]), int(number[b]))] = word
        return found

    design = Design(pattern, points[used], mesh.unit, mesh.name)
    return Network(design, is_flat, kept(mesh.assignments, "M V"), kept(mesh.types, "FL CFL"), used)


def laid_flat(points: FloatArray) -> tuple[FloatArray, bool]:
    """Points (V, 3) turned into the plane z = 0 if they lie in some plane, else as they are; and which of the two.

    Raises:
        InputError: all points lie on one line.
    """
    size = float(np.ptp(points, axis=0).max())
    centred = (points - points.mean(axis=0)) / size
    _, extents, axes = np.linalg.svd(centred, full_matrices=False)
    if len(extents) < 3 or extents[1] < FLAT:
        raise InputError("all vertices lie on one line")
    if np.abs(centred @ axes[2]).max() > FLAT:
        return points, False
    if np.ptp(points[:, 2]) != 0:
        axes = axes * np.sign(np.linalg.det(axes))
        points = size * centred @ axes.T
    return points * [1.0, 1.0, 0.0], True


def _oriented(facets: Facets) -> Facets:
    """Facets turned so that neighbours run along their common edge in opposite directions."""
    at_edge: dict[Pair, list[int]] = {}
    for f, facet in enumerate(facets):
        if len(facet) < 3 or len(set(facet)) < len(facet):
            raise InputError(f"facet {f} has vertices {list(facet)[:8]}: a facet needs 3 or more different vertices")
        for a, b in _around(facet):
            at_edge.setdefault(pair_of(a, b), []).append(f)
    for (a, b), ones in at_edge.items():
        if len(ones) > 2:
            raise InputError(f"edge {a}-{b} belongs to {len(ones)} facets: at most two may share an edge")
    directed = [set(_around(facet)) for facet in facets]
    turned = {0: False}
    queue = deque([0])
    while queue:
        f = queue.popleft()
        for a, b in _around(facets[f]):
            for g in at_edge[pair_of(a, b)]:
                # Two facets that both run a -> b as listed: one of them has to be turned.
                wanted = turned[f] ^ ((a, b) in directed[g])
                if g not in turned:
                    turned[g] = wanted
                    queue.append(g)
                elif g != f and turned[g] != wanted:
                    raise InputError(f"the surface is not orientable (a Moebius band), seen at edge {a}-{b}")
    if len(turned) < len(facets):
        lost = next(f for f in range(len(facets)) if f not in turned)
        raise InputError(
            f"facet {lost} is not connected to facet 0 by shared edges",
            hint="Join vertices that lie upon each other, and give each pattern a file of its own.",
        )
    return tuple(facet[::-1] if turned[f] else facet for f, facet in enumerate(facets))


def _check_listed_edges(facets: Facets, assignments: dict[Pair, str]) -> None:
    count: dict[Pair, int] = {}
    for a, b in _sides(facets):
        count[pair_of(a, b)] = count.get(pair_of(a, b), 0) + 1
    for (a, b), word in assignments.items():
        if (a, b) not in count:
            raise InputError(f"edge {a}-{b} is no side of a facet", hint="List only sides of facets, or no facets.")
        if count[a, b] == 2 and word in ("B", "C"):
            meaning = {"B": "boundary", "C": "cut"}[word]
            raise InputError(f"edge {a}-{b} lies between two facets and is assigned {word} ({meaning})",
                             hint="Give the two sides of a cut vertices of their own.")  # fmt: skip


def _counter_clockwise(facets: Facets, points: FloatArray) -> Facets:
    """Facets of a flat pattern seen from above; none may lie upside down among the others."""
    areas = []
    for facet in facets:
        x, y, _ = (points[list(facet)] - points[facet[0]]).T
        areas.append(float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)))
    up = np.array(areas) > 0
    if up.all():
        return facets
    if not up.any():
        return tuple(facet[::-1] for facet in facets)
    odd = int(np.flatnonzero(up != (up.sum() > len(up) / 2))[0])
    raise InputError(f"the pattern is flat and facet {odd} lies upside down in it: it is folded already",
                     hint="Give the crease pattern laid out in one layer, or a semi-folded state.")  # fmt: skip


def _without(facets: Facets, flat_edges: set[Pair]) -> Facets:
    """Facets joined across interior edges that do not fold."""
    following = {step: after for facet in facets for step, after in zip(_around(facet), _around(facet, 1), strict=True)}
    gone = {step for step in following if pair_of(*step) in flat_edges and step[::-1] in following}
    if not gone:
        return facets
    region = list(range(len(facets)))

    def root(f: int) -> int:
        while region[f] != f:
            f = region[f]
        return f

    facet_of = {step: f for f, facet in enumerate(facets) for step in _around(facet)}
    for step in gone:
        region[root(facet_of[step])] = root(facet_of[step[::-1]])
    joined: dict[int, tuple[int, ...]] = {}
    left = {step: None for facet in facets for step in _around(facet) if step not in gone}
    while left:
        start = step = next(iter(left))
        walk = []
        while step in left:
            del left[step]
            walk.append(step[0])
            step = following[step]
            while step in gone:
                step = following[step[::-1]]
        if root(facet_of[start]) in joined:
            raise InputError(f"the facets joined by flat edges (F) surround others, seen at edge {start[0]}-{start[1]}")
        joined[root(facet_of[start])] = tuple(walk)
    return tuple(joined.values())


def _check_degrees(facets: Facets) -> None:
    """Every interior vertex has four edges; all others are listed."""
    neighbours: dict[int, set[int]] = {}
    count: dict[Pair, int] = {}
    for a, b in _sides(facets):
        neighbours.setdefault(a, set()).add(b)
        neighbours.setdefault(b, set()).add(a)
        count[pair_of(a, b)] = count.get(pair_of(a, b), 0) + 1
    rim = {v for pair, ones in count.items() if ones == 1 for v in pair}
    wrong = [(v, len(others)) for v, others in sorted(neighbours.items()) if v not in rim and len(others) != 4]
    if wrong:
        listed = ", ".join(f"{v} has {degree}" for v, degree in wrong[:MOST_LISTED])
        more = f" and {len(wrong) - MOST_LISTED} more" if len(wrong) > MOST_LISTED else ""
        ones, verb = ("vertex", "does") if len(wrong) == 1 else ("vertices", "do")
        raise InputError(f"{len(wrong)} interior {ones} {verb} not have four edges: vertex {listed}{more}",
                         hint="Diagonals of facets are taken out where they are assigned F (flat); a mesh that was cut "
                         "into triangles has to be exported with its polygons.")  # fmt: skip


def _around(facet: tuple[int, ...], start: int = 0) -> list[Pair]:
    """The directed sides of a facet."""
    n = len(facet)
    return [(facet[(k + start) % n], facet[(k + start + 1) % n]) for k in range(n)]


def _sides(facets: Facets) -> list[Pair]:
    return [side for facet in facets for side in _around(facet)]
