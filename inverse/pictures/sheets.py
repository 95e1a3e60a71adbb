"""The developed state taken apart into sheets that lie side by side.

At a complementary foldline the developed state doubles back over itself. The facets that foldlines join make one
flat sheet; every sheet is shown with its top side up, next to the sheets it is joined to.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from inverse._types import FloatArray, IntArray
from inverse.origami import folding, geometry
from inverse.origami.pattern import CFL, FL, Design, Pattern

ComplexArray = NDArray[np.complex128]
NEARLY = 0.01  # radians before the developed state


@dataclass(frozen=True, eq=False)
class Sheet:
    """A flat piece of the developed state at its place in the drawing.

    Attributes:
        faces: (k,) int; facets, all upwards.
        edges: (e,) int; edges of these facets. An edge between two sheets belongs to both.
        vertices: (v,) int; vertices, ascending.
        points: (v, 2) place of each vertex, in the design's unit.
    """

    faces: IntArray
    edges: IntArray
    vertices: IntArray
    points: FloatArray

    def place_of(self, vertices: IntArray) -> FloatArray:
        """Places, (..., 2), of vertices of this sheet."""
        return np.asarray(self.points[np.searchsorted(self.vertices, vertices)])


def lay_out(design: Design) -> list[Sheet]:
    """The sheets of the developed state, true to scale, none over another, neighbours side by side.

    Returns:
        One sheet per set of facets joined by foldlines, in the order of their first facets. The whole is
        wider than high.
    """
    pattern = design.pattern
    sheet_of = _components(pattern)
    parts = _parts(pattern, sheet_of)
    flat = folding.flat_state(design, 0.0)
    plane = flat[:, 0] + 1j * flat[:, 1]
    upwards = pattern.facet_signs(CFL) > 0
    places = [plane[v] if upwards[f[0]] else plane[v].conj() for f, _, v in parts]
    if len(parts) == 1:
        placed = [_turned_flat(places[0])]
    else:
        turns, cells = _arrange(_seams(pattern, sheet_of, plane, upwards))
        turned = [p * t for p, t in zip(places, turns, strict=True)]
        placed = _spread(turned, cells, 0.4 * float(np.median(geometry.edge_lengths(pattern, flat))))
    whole = np.concatenate(placed)
    if np.ptp(whole.imag) > np.ptp(whole.real):
        placed = [p * -1j for p in placed]
    return [Sheet(f, e, v, np.stack([p.real, p.imag], axis=1)) for (f, e, v), p in zip(parts, placed, strict=True)]


def stacked(design: Design) -> list[Sheet]:
    """The same sheets where they lie in the developed state, one over another, the lowest first."""
    sheets, flat = lay_out(design), folding.flat_state(design, 0.0)
    plane = flat[:, 0] + 1j * flat[:, 1]
    plane -= plane.mean()
    long = np.exp(0.5j * np.angle((plane**2).sum()))  # the direction in which it extends farthest
    plane = plane * long.conjugate()
    points = np.stack([plane.real, plane.imag], axis=1)
    near = folding.flat_state(design, NEARLY)  # which lies over which is seen shortly before
    level = np.c_[near[:, :2], np.ones(len(near))]
    heights = near[:, 2] - level @ np.linalg.lstsq(level, near[:, 2], rcond=None)[0]
    means = np.array([heights[sheet.vertices].mean() for sheet in sheets])
    order = np.argsort(np.round(means / max(np.ptp(means), 1e-300), 6), kind="stable")  # side by side: as they were
    return [replace(sheets[k], points=points[sheets[k].vertices]) for k in order]


def _components(pattern: Pattern) -> IntArray:
    """Number of the sheet of every facet, (F,), counted in the order of the facets."""
    left, right = pattern.edges_faces[pattern.edges_type == FL].T
    n = len(pattern.faces_vertices)
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    joined = coo_array((np.ones(len(left)), (left, right)), shape=(n, n))
    labels = connected_components(joined, directed=False)[1]
    _, first, number = np.unique(labels, return_index=True, return_inverse=True)
    return np.asarray(np.argsort(np.argsort(first))[number], np.int64)


def _parts(pattern: Pattern, sheet_of: IntArray) -> list[tuple[IntArray, IntArray, IntArray]]:
    """Facets, edges and vertices of every sheet, each ascending."""
    count = int(sheet_of.max()) + 1
    corner_sheet, corner_vertex = sheet_of[pattern.corners[:, 0]], pattern.corners[:, 2]
    edge = np.tile(np.arange(len(pattern.edges_vertices)), 2)
    face = pattern.edges_faces.T.ravel()
    edge, edge_sheet = edge[face >= 0], sheet_of[face[face >= 0]]

    def split(sheets: IntArray, items: IntArray) -> list[IntArray]:
        pairs = np.unique(np.stack([sheets, items], axis=1), axis=0)
        return np.split(pairs[:, 1], np.searchsorted(pairs[:, 0], np.arange(1, count)))

    faces = split(sheet_of, np.arange(len(sheet_of)))
    return list(zip(faces, split(edge_sheet, edge), split(corner_sheet, corner_vertex), strict=True))


@dataclass
class _Seam:
    """A line along which a sheet meets another; the chords are the sums of its edges, this sheet on the left."""

    other: int
    chord: complex = 0j  # as this sheet sees it
    other_chord: complex = 0j  # as the other one does


def _seams(pattern: Pattern, sheet_of: IntArray, plane: ComplexArray, upwards: NDArray[np.bool_]) -> list[list[_Seam]]:
    """The seams of every sheet."""
    line_of = {edge: k for k, edges in enumerate(pattern.lines_edges) for edge in edges}
    found: list[dict[tuple[int, int], _Seam]] = [{} for _ in range(int(sheet_of.max()) + 1)]
    for edge in np.flatnonzero(pattern.edges_type == CFL).tolist():
        tail, head = pattern.edges_vertices[edge].tolist()
        faces = pattern.edges_faces[edge].tolist()
        line = line_of[edge]
        step = complex(plane[head] - plane[tail])
        seen = [step if upwards[face] else step.conjugate() for face in faces]  # left facet first
        for here, there, way in ((0, 1, 1), (1, 0, -1)):
            other = int(sheet_of[faces[there]])
            seam = found[sheet_of[faces[here]]].setdefault((other, line), _Seam(other))
            seam.chord += way * seen[here]
            seam.other_chord += way * seen[there]
    return [list(seams.values()) for seams in found]


def _arrange(seams: list[list[_Seam]]) -> tuple[list[complex], list[tuple[int, int]]]:
    """A turn (unit complex number) and a cell (column, row) for every sheet, breadth first from sheet 0.

    A sheet goes to the side of the seam that joins it; then all are turned so that the chords of their seams
    are as upright (or as level) as they can be.
    """
    turns: list[complex] = [1.0 + 0j] * len(seams)
    cells: list[tuple[int, int]] = [(0, 0)] * len(seams)
    turns[0] = _unit(1j * max((seam.chord for seam in seams[0]), key=abs).conjugate())
    taken, reached, queue = {(0, 0)}, {0}, deque([0])
    while queue:
        here = queue.popleft()
        for seam in seams[here]:
            if seam.other in reached:
                continue
            side = _nearest_quarter(-1j * seam.chord * turns[here])
            turns[seam.other] = _unit(1j * side * seam.other_chord.conjugate())
            column, row = cells[here]
            while (column, row) in taken:
                column, row = column + round(side.real), row + round(side.imag)
            cells[seam.other] = (column, row)
            taken.add((column, row))
            reached.add(seam.other)
            queue.append(seam.other)
    # Chords across columns and across rows can be incompatible: the longer family of seams decides.
    families: dict[bool, list[tuple[int, complex]]] = {True: [], False: []}
    for here, turn in enumerate(turns):
        for seam in seams[here]:
            step = complex(*cells[seam.other]) - complex(*cells[here])
            if step == _nearest_quarter(-1j * seam.chord * turn):
                families[step.imag == 0].append((here, 1j * step * seam.chord.conjugate()))
    totals = np.zeros(len(seams), complex)
    for here, alignment in max(families.values(), key=lambda family: sum(abs(z) for _, z in family)):
        totals[here] += alignment
    turns = [_unit(complex(total)) if total else turn for total, turn in zip(totals, turns, strict=True)]
    return turns, cells


def _spread(places: list[ComplexArray], cells: list[tuple[int, int]], gap: float) -> list[ComplexArray]:
    """Move every sheet to the middle of its cell of a table as narrow as the sheets allow."""
    low = np.array([[p.real.min(), p.imag.min()] for p in places])
    size = np.array([[np.ptp(p.real), np.ptp(p.imag)] for p in places])
    middle = np.empty_like(size)
    for axis in (0, 1):
        line = np.unique(np.array(cells)[:, axis], return_inverse=True)[1]
        widths = np.zeros(line.max() + 1)
        np.maximum.at(widths, line, size[:, axis])
        ends = np.cumsum(widths + gap)
        middle[:, axis] = (ends - gap - widths / 2)[line]
    shift = middle - low - size / 2
    return [p + complex(*s) for p, s in zip(places, shift, strict=True)]


def _turned_flat(place: ComplexArray) -> ComplexArray:
    """Turn points so that their bounding rectangle is the smallest, the long side level."""
    from scipy.spatial import ConvexHull

    hull = place[ConvexHull(np.stack([place.real, place.imag], axis=1)).vertices]
    sides = np.roll(hull, -1) - hull
    turned = [hull * _unit(complex(s).conjugate()) for s in sides]
    areas = np.array([np.ptp(t.real) * np.ptp(t.imag) for t in turned])
    best = int(np.flatnonzero(areas <= areas.min() * (1 + 1e-9))[0])
    return place * _unit(complex(sides[best]).conjugate())


def _unit(z: complex) -> complex:
    return z / abs(z) if abs(z) > 0 else 1.0 + 0j


def _nearest_quarter(z: complex) -> complex:
    """The nearest of 1, i, -1 and -i."""
    if abs(z.real) >= abs(z.imag):
        return 1.0 + 0j if z.real >= 0 else -1.0 + 0j
    return 1j if z.imag > 0 else -1j
