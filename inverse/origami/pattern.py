"""A 4-valency network of facets whose lines of opposite edges are foldlines or complementary foldlines."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError

# Edge types, stored as small integers; EDGE_TYPE_NAMES gives the words used in files.
B, FL, CFL = 0, 1, 2
EDGE_TYPE_NAMES = ("B", "FL", "CFL")


@dataclass(frozen=True, eq=False)
class Pattern:
    """Topology and line types of a BDFFPQ mesh (paper, section 2.3). Build it with :meth:`from_faces`.

    Attributes:
        n_vertices: number of vertices.
        faces_vertices: vertices of each facet, counter-clockwise seen from the top side.
        edges_vertices: (E, 2) int; the facet on the left of the direction v0 -> v1 is ``edges_faces[:, 0]``.
        edges_faces: (E, 2) int; left and right facet, the right one -1 on the boundary.
        edges_type: (E,) int8; ``B``, ``FL`` or ``CFL``.
        interior_vertices: (I,) int.
        ring_vertices: (I, 4) int; neighbours of each interior vertex, counter-clockwise.
        ring_edges: (I, 4) int; the edges to them.
        ring_faces: (I, 4) int; facet k lies between ring edges k and k + 1.
        corners: (C, 4) int; facet, previous vertex, vertex and next vertex of every facet corner.
        grid: (m, n) where the mesh is a grid or tube in the numbering of the file format.
        n_holes: 0 for a disk, 1 for a cylinder.
    """

    n_vertices: int
    faces_vertices: tuple[tuple[int, ...], ...]
    edges_vertices: IntArray
    edges_faces: IntArray
    edges_type: NDArray[np.int8]
    interior_vertices: IntArray
    ring_vertices: IntArray
    ring_edges: IntArray
    ring_faces: IntArray
    corners: IntArray
    n_holes: int
    grid: tuple[int, int] | None = field(default=None)

    @classmethod
    def from_faces(
        cls,
        faces_vertices: Sequence[Sequence[int]],
        n_vertices: int,
        edges_type: Callable[[IntArray], NDArray[np.int8]],
        grid: tuple[int, int] | None = None,
    ) -> Pattern:
        """Build and validate a pattern from its facets.

        Args:
            faces_vertices: vertices of each facet, all facets turning the same way.
            n_vertices: number of vertices.
            edges_type: function of the interior edges' end vertices, (k, 2) int, that returns their
                types, (k,) int8 of ``FL`` and ``CFL``.
            grid: (m, n) of a grid or tube.

        Raises:
            InputError: the network is not an oriented manifold disk (with or without holes), an interior
                vertex has not four edges, or a line of opposite edges changes its type. The message names
                the vertex, edge or facet.
        """
        faces = tuple(tuple(int(v) for v in face) for face in faces_vertices)
        corners = _corners(faces, n_vertices)
        edges_vertices, edges_faces = _edges(corners)
        interior = edges_faces[:, 1] >= 0
        types = np.zeros(len(edges_vertices), np.int8)
        types[interior] = edges_type(edges_vertices[interior])
        rings = _rings(corners, edges_vertices, edges_faces, n_vertices)
        pattern = cls(
            n_vertices, faces, edges_vertices, edges_faces, types, *rings, corners,
            _count_holes(n_vertices, edges_vertices, edges_faces, len(faces)), grid,
        )  # fmt: skip
        pattern._check_types()
        return pattern

    @cached_property
    def interior_edges(self) -> IntArray:
        """(K,) int: the edges that fold."""
        return np.flatnonzero(self.edges_type != B)

    @cached_property
    def is_miura_vertex(self) -> NDArray[np.bool_]:
        """(I,) bool: 4FL or 4CFL interior vertices; the others are Voss vertices (2FL + 2CFL)."""
        ring_types = self.edges_type[self.ring_edges]
        return np.asarray(ring_types[:, 0] == ring_types[:, 1])

    @cached_property
    def topology(self) -> str:
        """``disk``, ``cylinder`` or ``holes:<n>``."""
        return {0: "disk", 1: "cylinder"}.get(self.n_holes, f"holes:{self.n_holes}")

    @cached_property
    def degrees_of_freedom(self) -> int:
        """The dimension of the solution space, rigid motions and the motion itself included.

        Of a disk 3V - 2 V_int - sum(s - 3), which is 5(m + n) + 1 for a grid. Around a tube one strip of k facets
        closes by 3(k - 2)/2 more equations, and three of every closed line of vertices then follow from the others: of
        n rows of facets 3n + 7k/2 is left, as measured at generic tubes.
        """
        planarity = sum(len(face) - 3 for face in self.faces_vertices)
        count = 3 * self.n_vertices - 2 * len(self.interior_vertices) - planarity
        closed = [len(line) - 1 for line in self.lines if line[0] == line[-1]] if self.n_holes == 1 else []
        return count - 3 * (closed[0] - 2) // 2 + 3 * len(closed) if closed else count

    @cached_property
    def lines(self) -> tuple[tuple[int, ...], ...]:
        """Vertices along every interior line of opposite edges; a closed line repeats its first vertex."""
        onward: dict[tuple[int, int], int] = {}
        for v, ring in zip(self.interior_vertices.tolist(), self.ring_vertices.tolist(), strict=True):
            for k in range(4):
                onward[ring[k], v] = ring[(k + 2) % 4]
        seen: set[tuple[int, int]] = set()
        lines = []
        edges = self.edges_vertices[self.interior_edges].tolist()
        # Lines that end on the boundary are walked from their ends; what is left is closed.
        starts = [(a, b) for e in edges for a, b in (e, e[::-1]) if (b, a) not in onward]
        for a, b in starts + [tuple(e) for e in edges]:
            if (a, b) in seen or (b, a) in seen:
                continue
            line = [a, b]
            seen.add((a, b))
            while (step := onward.get((line[-2], line[-1]))) is not None and (line[-1], step) not in seen:
                seen.add((line[-1], step))
                line.append(step)
            lines.append(tuple(line))
        return tuple(lines)

    def facet_signs(self, flips_across: int) -> IntArray:
        """(F,) of +-1: orientation of each facet in a flat state.

        Args:
            flips_across: ``CFL`` gives sigma_dev (signs in the developed state), ``FL`` gives sigma_ff.

        Raises:
            InputError: the signs contradict each other around a hole, so that the flat state does not exist.
        """
        signs = np.zeros(len(self.faces_vertices), np.int64)
        flips = np.where(self.edges_type == flips_across, -1, 1)
        signs[0] = 1
        for face, parent, edge in self.facet_tree[1:].tolist():
            signs[face] = signs[parent] * flips[edge]
        inner = self.interior_edges
        left, right = self.edges_faces[inner].T
        wrong = inner[signs[left] * flips[inner] != signs[right]]
        if len(wrong):
            word = EDGE_TYPE_NAMES[flips_across]
            raise InputError(
                f"the number of {word} lines around a hole is odd, seen at edge {_name(self.edges_vertices[wrong[0]])}",
                hint="Around every hole the numbers of FL and of CFL lines are both even, else a flat state lacks.",
            )
        return signs

    @cached_property
    def faces_by_sides(self) -> dict[int, list[int]]:
        """Facets by their numbers of sides, in the order in which these first occur."""
        found: dict[int, list[int]] = {}
        for f, face in enumerate(self.faces_vertices):
            found.setdefault(len(face), []).append(f)
        return found

    @cached_property
    def edge_between(self) -> dict[frozenset[int], int]:
        """Number of the edge between two vertices."""
        return _numbers(self.edges_vertices)

    @cached_property
    def lines_edges(self) -> tuple[tuple[int, ...], ...]:
        """Edges along every line of :attr:`lines`."""
        return tuple(tuple(self.edge_between[frozenset(pair)] for pair in pairwise(line)) for line in self.lines)

    @cached_property
    def faces_edges(self) -> tuple[tuple[int, ...], ...]:
        """Edges of every facet; the first one runs from its first vertex to its second."""
        return tuple(
            tuple(self.edge_between[frozenset(pair)] for pair in zip(face, face[1:] + face[:1], strict=True))
            for face in self.faces_vertices
        )

    @cached_property
    def facet_tree(self) -> IntArray:
        """(F, 3) int, breadth first from facet 0: facet, its parent and the edge between (-1, -1 for the root)."""
        neighbours: list[list[tuple[int, int]]] = [[] for _ in self.faces_vertices]
        for edge in self.interior_edges.tolist():
            left, right = self.edges_faces[edge].tolist()
            neighbours[left].append((right, edge))
            neighbours[right].append((left, edge))
        rows = [(0, -1, -1)]
        reached = {0}
        for face, _, _ in rows:
            for other, edge in neighbours[face]:
                if other not in reached:
                    reached.add(other)
                    rows.append((other, face, edge))
        if len(rows) < len(self.faces_vertices):
            lost = next(f for f in range(len(self.faces_vertices)) if f not in reached)
            raise InputError(f"facet {lost} is not connected to facet 0 by shared edges")
        return np.array(rows, np.int64)

    def _check_types(self) -> None:
        """Opposite edges of one type at every interior vertex; flat states consistent."""
        ring_types = self.edges_type[self.ring_edges]
        wrong = np.flatnonzero((ring_types[:, :2] != ring_types[:, 2:]).any(axis=1))
        if len(wrong):
            k = wrong[0]
            words = ", ".join(EDGE_TYPE_NAMES[t] for t in ring_types[k])
            raise InputError(
                f"vertex {self.interior_vertices[k]} has edges {words}: opposite edges must be of one type",
                hint="A line of opposite edges is FL or CFL over its whole length.",
            )
        self.facet_signs(CFL)
        self.facet_signs(FL)


@dataclass(frozen=True, eq=False)
class Design:
    """A pattern with the coordinates of its design state (t = 90 degrees).

    Attributes:
        pattern: topology and line types.
        vertices_coords: (V, 3) float64, in ``unit``.
        unit: length unit, a word of FOLD's ``frame_unit``.
        name: title of the design.
    """

    pattern: Pattern
    vertices_coords: FloatArray
    unit: str = "m"
    name: str = "design"

    def moved_to(self, vertices_coords: FloatArray) -> Design:
        """The same pattern with other coordinates, (V, 3)."""
        return replace(self, vertices_coords=np.array(vertices_coords, np.float64))


def _numbers(edges_vertices: IntArray) -> dict[frozenset[int], int]:
    return {frozenset(pair): k for k, pair in enumerate(edges_vertices.tolist())}


def _name(vertices: IntArray) -> str:
    return f"{int(vertices[0])}-{int(vertices[1])}"


def _corners(faces: tuple[tuple[int, ...], ...], n_vertices: int) -> IntArray:
    if not faces:
        raise InputError("the pattern has no facets")
    for f, face in enumerate(faces):
        if len(face) < 3 or len(set(face)) < len(face):
            raise InputError(f"facet {f} has vertices {list(face)}: a facet needs 3 or more different vertices")
    lengths = np.array([len(face) for face in faces])
    vertex = np.fromiter((v for face in faces for v in face), np.int64, int(lengths.sum()))
    unused = np.setdiff1d(np.arange(n_vertices), vertex)
    outside = vertex[(vertex < 0) | (vertex >= n_vertices)]
    if len(outside):
        raise InputError(f"a facet names vertex {outside[0]}, but there are {n_vertices} vertices, numbered from 0")
    if len(unused):
        raise InputError(f"vertex {unused[0]} belongs to no facet")
    starts = np.cumsum(lengths) - lengths
    facet = np.repeat(np.arange(len(faces)), lengths)
    place = np.arange(len(vertex)) - starts[facet]
    following = vertex[starts[facet] + (place + 1) % lengths[facet]]
    previous = vertex[starts[facet] + (place - 1) % lengths[facet]]
    return np.stack([facet, previous, vertex, following], axis=1).astype(np.int64)


def _edges(corners: IntArray) -> tuple[IntArray, IntArray]:
    face, tail, head = corners[:, 0], corners[:, 2], corners[:, 3]
    low, high = np.minimum(tail, head), np.maximum(tail, head)
    order = np.lexsort((tail > head, high, low))
    low, high, face, upward = low[order], high[order], face[order], (tail < head)[order]
    new = np.r_[True, (np.diff(low) != 0) | (np.diff(high) != 0)]
    edge = np.cumsum(new) - 1
    count = np.bincount(edge)
    first = np.flatnonzero(new)
    if (count > 2).any():
        k = first[np.argmax(count > 2)]
        raise InputError(f"edge {low[k]}-{high[k]} belongs to more than two facets")
    two = count == 2
    same = two & (upward[first] == upward[np.minimum(first + 1, len(low) - 1)])
    if same.any():
        k = first[np.argmax(same)]
        raise InputError(
            f"the facets on both sides of edge {low[k]}-{high[k]} run along it in the same direction",
            hint="List every facet's vertices counter-clockwise seen from the same side of the surface.",
        )
    # In each pair the half-edge low -> high comes first, so its facet is the left one; a lone half-edge
    # keeps its own direction, so that the left facet of a boundary edge always exists.
    forward = upward[first]
    edges_vertices = np.where(forward[:, None], np.c_[low, high][first], np.c_[high, low][first])
    edges_faces = np.full((len(first), 2), -1, np.int64)
    edges_faces[:, 0] = face[first]
    edges_faces[two, 1] = face[first[two] + 1]
    return edges_vertices.astype(np.int64), edges_faces


def _rings(
    corners: IntArray, edges_vertices: IntArray, edges_faces: IntArray, n_vertices: int
) -> tuple[IntArray, IntArray, IntArray, IntArray]:
    on_boundary = np.zeros(n_vertices, bool)
    on_boundary[edges_vertices[edges_faces[:, 1] < 0]] = True
    fans: list[dict[int, tuple[int, int]]] = [{} for _ in range(n_vertices)]
    for face, previous, vertex, following in corners.tolist():
        fans[vertex][following] = (face, previous)
    edge_between = _numbers(edges_vertices)
    interior, ring_vertices, ring_edges, ring_faces = [], [], [], []
    for vertex, fan in enumerate(fans):
        starts = set(fan) - {previous for _, previous in fan.values()}
        at = min(starts) if starts else min(fan)
        ring: list[int] = []
        faces: list[int] = []
        while at in fan and len(ring) < len(fan):
            ring.append(at)
            face, at = fan[at]
            faces.append(face)
            if at == ring[0]:
                break
        if len(ring) < len(fan) or (len(starts) > 1) or (not starts and at != ring[0]):
            raise InputError(f"the facets around vertex {vertex} do not form one fan: the surface touches itself there")
        if on_boundary[vertex]:
            continue
        if len(ring) != 4:
            raise InputError(
                f"interior vertex {vertex} has {len(ring)} edges: every interior vertex must have 4",
            )
        interior.append(vertex)
        ring_vertices.append(ring)
        ring_edges.append([edge_between[frozenset((vertex, other))] for other in ring])
        ring_faces.append(faces)
    shape = (len(interior), 4)
    return (
        np.array(interior, np.int64),
        np.array(ring_vertices, np.int64).reshape(shape),
        np.array(ring_edges, np.int64).reshape(shape),
        np.array(ring_faces, np.int64).reshape(shape),
    )


def _count_holes(n_vertices: int, edges_vertices: IntArray, edges_faces: IntArray, n_faces: int) -> int:
    onward = dict(edges_vertices[edges_faces[:, 1] < 0].tolist())
    loops = 0
    while onward:
        loops += 1
        start, at = onward.popitem()
        while at != start:
            at = onward.pop(at)
    euler = n_vertices - len(edges_vertices) + n_faces
    if loops == 0 or euler != 2 - loops:
        raise InputError(
            f"the surface has {loops} boundary loops and Euler characteristic {euler}, so it is no disk, with or "
            "without holes",
            hint="Allowed are disks, cylinders and disks with holes, in one piece.",
        )
    return loops - 1
