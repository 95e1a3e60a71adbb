"""Topology of a design, derived from the facets of its file and from nothing else."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from inverse._types import IntArray


@dataclass(frozen=True, eq=False)
class Walk:
    """Facets in the order of a tree, facet 0 first.

    Attributes:
        facets: (F,) int; the facets.
        parents: (F - 1,) int; for every facet but the first the place of its parent in this list.
        edges: (F - 1,) int; the edges between.
        levels: where levels begin in this list, from the second one on, and its length.
    """

    facets: IntArray
    parents: IntArray
    edges: IntArray
    levels: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Mesh:
    """An oriented manifold surface in one piece, as half-edges: one per facet corner, facet after facet.

    Attributes:
        facets: vertices of each facet.
        starts: (F,) int; first half-edge of each facet.
        tail: (C,) int; vertex where a half-edge starts.
        head: (C,) int; vertex where it ends.
        facet: (C,) int; the facet on its left.
        previous: (C,) int; the half-edge before it in its facet.
        twin: (C,) int; the half-edge of the neighbour, -1 on the boundary.
    """

    facets: tuple[tuple[int, ...], ...]
    starts: IntArray
    tail: IntArray
    head: IntArray
    facet: IntArray
    previous: IntArray
    twin: IntArray

    @cached_property
    def half_edges(self) -> IntArray:
        """(E,) int: the half-edge that stands for each edge, boundary edges included."""
        return np.flatnonzero((self.twin < 0) | (self.tail < self.head))

    @cached_property
    def edges(self) -> IntArray:
        """(E, 2) int: vertices of each edge, the facet ``sides[:, 0]`` on the left of their direction."""
        return np.stack([self.tail[self.half_edges], self.head[self.half_edges]], axis=1)

    @cached_property
    def sides(self) -> IntArray:
        """(E, 2) int: facets on the left and on the right of each edge, -1 beyond the boundary."""
        other = self.twin[self.half_edges]
        return np.stack([self.facet[self.half_edges], np.where(other < 0, -1, self.facet[other])], axis=1)

    @cached_property
    def edge_of(self) -> IntArray:
        """(C,) int: edge of each half-edge."""
        edge = np.empty(len(self.tail), np.int64)
        edge[self.half_edges] = np.arange(len(self.half_edges))
        inner = self.half_edges[self.twin[self.half_edges] >= 0]
        edge[self.twin[inner]] = edge[inner]
        return edge

    @cached_property
    def inner(self) -> IntArray:
        """(K,) int: the interior edges."""
        return np.flatnonzero(self.sides[:, 1] >= 0)

    @cached_property
    def interior_vertices(self) -> IntArray:
        """(I,) int: vertices surrounded by facets."""
        on_boundary = self.edges[self.sides[:, 1] < 0].ravel()
        return np.setdiff1d(self.tail, on_boundary)

    @cached_property
    def degrees(self) -> IntArray:
        """(I,) int: number of edges at each interior vertex."""
        return np.bincount(self.tail)[self.interior_vertices]

    @cached_property
    def rings(self) -> IntArray:
        """(I, 4) int: half-edges leaving each interior vertex counter-clockwise, if all have degree 4."""
        ring = [np.zeros(len(self.interior_vertices), np.int64)]
        order = np.argsort(self.tail, kind="stable")
        ring[0] = order[np.searchsorted(self.tail[order], self.interior_vertices)]
        for _ in range(3):
            ring.append(self.twin[self.previous[ring[-1]]])
        return np.stack(ring, axis=1)

    @cached_property
    def boundary_labels(self) -> tuple[int, IntArray]:
        """Number of boundary loops, and (V,) int: the loop of each vertex, -1 off the boundary."""
        rim = self.edges[self.sides[:, 1] < 0]
        vertices, ends = np.unique(rim, return_inverse=True)
        labels = np.full(int(self.tail.max()) + 1, -1, np.int64)
        if not len(vertices):
            return 0, labels
        count, found = components(len(vertices), ends.reshape(-1, 2))
        labels[vertices] = found
        return count, labels

    @cached_property
    def n_holes(self) -> int | None:
        """0 for a disk, 1 for a cylinder; None if the surface is no disk with or without holes."""
        loops, _ = self.boundary_labels
        euler = len(np.unique(self.tail)) - len(self.edges) + len(self.facets)
        return loops - 1 if loops and euler == 2 - loops else None

    @property
    def topology(self) -> str:
        """``disk``, ``cylinder``, ``holes:<n>`` or ``unknown``."""
        if self.n_holes is None:
            return "unknown"
        return {0: "disk", 1: "cylinder"}.get(self.n_holes, f"holes:{self.n_holes}")

    @cached_property
    def tree(self) -> tuple[tuple[IntArray, IntArray, IntArray], ...]:
        """Breadth-first tree of facets from facet 0: per level facets, their parents, the edges between."""
        n_facets = len(self.facets)
        pairs = np.sort(self.sides[self.inner], axis=1)
        keys, first = np.unique(pairs[:, 0] * n_facets + pairs[:, 1], return_index=True)
        pairs = pairs[first]
        order, parent = breadth_first_order(graph(n_facets, pairs), 0, directed=False)
        depth = np.zeros(n_facets, np.int64)
        for facet in order[1:].tolist():
            depth[facet] = depth[parent[facet]] + 1
        levels = []
        for d in range(1, int(depth.max()) + 1):
            facets = np.flatnonzero(depth == d)
            parents = parent[facets].astype(np.int64)
            key = np.minimum(facets, parents) * n_facets + np.maximum(facets, parents)
            levels.append((facets, parents, self.inner[first[np.searchsorted(keys, key)]]))
        return tuple(levels)

    @cached_property
    def walk(self) -> Walk:
        """The tree as one list of facets, level after level."""
        count = len(self.facets)
        levels = np.cumsum([0, 1, *(len(facets) for facets, _, _ in self.tree)])
        facets = np.concatenate([[0], *(facets for facets, _, _ in self.tree)]).astype(np.int64)
        place = np.empty(count, np.int64)
        place[facets] = np.arange(count)
        parents = np.concatenate([np.empty(0, np.int64), *(parents for _, parents, _ in self.tree)]).astype(np.int64)
        edges = np.concatenate([np.empty(0, np.int64), *(edges for _, _, edges in self.tree)]).astype(np.int64)
        return Walk(facets, place[parents], edges, tuple(levels[1:].tolist()))

    @cached_property
    def off_tree(self) -> IntArray:
        """(N,) int: the interior edges that the tree does not cross."""
        used = [edges for _, _, edges in self.tree]
        return np.setdiff1d(self.inner, np.concatenate(used) if used else [])

    def name(self, edge: int) -> str:
        """An edge for people: ``edge 3-9``."""
        low, high = sorted(self.edges[edge].tolist())
        return f"edge {low}-{high}"


def graph(n_nodes: int, pairs: IntArray) -> csr_array:
    """Links between nodes, ``pairs`` (N, 2), as scipy's graph functions take them."""
    return coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(n_nodes, n_nodes)).tocsr()


def components(n_nodes: int, pairs: IntArray) -> tuple[int, IntArray]:
    """Number of connected components of a graph with links ``pairs``, (N, 2), and each node's, (n_nodes,)."""
    count, labels = connected_components(graph(n_nodes, pairs), directed=False)
    return int(count), labels.astype(np.int64)


def build_mesh(facets: Sequence[Sequence[int]], n_vertices: int) -> tuple[Mesh | None, list[str]]:
    """Derive the surface that facets form.

    Args:
        facets: vertices of each facet, numbers below ``n_vertices``.
        n_vertices: number of vertices in the file.

    Returns:
        The surface, or None if the facets form none, and the faults found.
    """
    faults = [
        f"facet {f} has vertices {list(facet)[:8]}: 3 or more different ones are needed"
        for f, facet in enumerate(facets)
        if len(facet) < 3 or len(set(facet)) < len(facet)
    ]
    if faults or not facets:
        return None, faults or ["there are no facets"]
    sides = np.array([len(facet) for facet in facets])
    starts = np.cumsum(sides) - sides
    start, count = np.repeat(starts, sides), np.repeat(sides, sides)
    place = np.arange(len(start)) - start
    tail = np.fromiter((v for facet in facets for v in facet), np.int64, len(start))
    head = tail[start + (place + 1) % count]
    facet_of = np.repeat(np.arange(len(facets)), sides)

    faults = [f"vertex {v} belongs to no facet" for v in np.setdiff1d(np.arange(n_vertices), tail)]
    order = np.argsort(tail * n_vertices + head, kind="stable")
    key = (tail * n_vertices + head)[order]
    doubled = np.flatnonzero(key[1:] == key[:-1])
    if len(doubled):
        for h, g in zip(order[doubled], order[doubled + 1], strict=True):
            faults.append(
                f"facets {facet_of[h]} and {facet_of[g]} both run from vertex {tail[h]} to {head[h]}:"
                " the surface is no oriented manifold"
            )
        return None, faults
    back = head * n_vertices + tail
    found = np.minimum(np.searchsorted(key, back), len(key) - 1)
    twin = np.where(key[found] == back, order[found], -1)
    mesh = Mesh(
        tuple(tuple(facet) for facet in facets), starts, tail, head, facet_of,
        start + (place - 1) % count, twin,
    )  # fmt: skip
    apart = _pieces(mesh) or _pinches(mesh)
    return (None if apart else mesh), faults + apart


def _pieces(mesh: Mesh) -> list[str]:
    count, labels = components(len(mesh.facets), mesh.sides[mesh.inner])
    return [f"facet {np.argmax(labels == k)} is not connected to facet 0 by shared edges" for k in range(1, count)]


def _pinches(mesh: Mesh) -> list[str]:
    """Vertices around which the facets form more than one fan."""
    onward = mesh.twin[mesh.previous]
    turning = np.flatnonzero(onward >= 0)
    _, fan = components(len(onward), np.stack([turning, onward[turning]], axis=1))
    _, first = np.unique(fan, return_index=True)
    n_fans = np.bincount(mesh.tail[first])
    return [f"the surface touches itself at vertex {v}" for v in np.flatnonzero(n_fans > 1)]
