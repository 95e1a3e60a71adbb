"""Closed strips of facets around the holes, and whether they stay closed through the whole motion.

The interior edges that a spanning tree of facets does not cross form a spanning tree of the other kind: its
nodes are the interior vertices and the boundary loops. Cut along its paths from every hole to the outer
boundary, the surface is a disk. So a strip that crosses these cuts once, in the first stretch of one hole's
path, is that hole's generator of the fundamental group: with the vertex conditions, one such strip per hole
speaks for all closed strips.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.sparse.csgraph import breadth_first_order, dijkstra

from inverse._types import IntArray
from inverse.certify import dual_quaternions as dual
from inverse.certify.certificate import Loop, Measured
from inverse.certify.mesh import Mesh, graph
from inverse.certify.motion import Motion

N_SPOT_CHECKS = 41

# Facets of a closed strip in order, (k,), and the edges crossed on leaving them, (k,).
Strip = tuple[IntArray, IntArray]


@dataclass(frozen=True, eq=False)
class Cuts:
    """The cuts from the holes to the outer boundary.

    Attributes:
        windings: (E, n_holes) int; how often crossing an edge from its left to its right facet goes around
            each hole.
        stretches: for each hole the first edges of its cut, up to where the cut of another hole joins.
    """

    windings: IntArray
    stretches: tuple[tuple[int, ...], ...]


def cut_open(mesh: Mesh) -> Cuts:
    """Cut a disk with holes open along edges; the boundary loop with most edges counts as the outer one."""
    n_loops, label = mesh.boundary_labels
    rim = mesh.edges[mesh.sides[:, 1] < 0, 0]
    loops = np.argsort(-np.bincount(label[rim], minlength=n_loops), kind="stable")
    n_vertices = len(label)
    node = np.where(label < 0, np.arange(n_vertices), n_vertices + label)
    edges = mesh.off_tree
    ends = node[mesh.edges[edges]]
    root = n_vertices + int(loops[0])
    _, up = breadth_first_order(graph(n_vertices + n_loops, ends), root, directed=False)
    edge_between = {}
    for edge, (a, b) in zip(edges.tolist(), ends.tolist(), strict=True):
        edge_between[a, b], edge_between[b, a] = (edge, 1), (edge, -1)

    windings = np.zeros((len(mesh.edges), n_loops - 1), np.int64)
    paths: list[list[int]] = []
    for hole, loop in enumerate(loops[1:].tolist()):
        at, path = n_vertices + loop, []
        while at != root:
            edge, sign = edge_between[at, int(up[at])]
            windings[edge, hole] = sign
            path.append(edge)
            at = int(up[at])
        paths.append(path)
    stretches = []
    for path in paths:
        alone = [edge for edge in path if (np.abs(windings[edge]) == np.abs(windings[path[0]])).all()]
        stretches.append(tuple(alone))
    return Cuts(windings, tuple(stretches))


def shortest_strips(mesh: Mesh) -> tuple[Strip, ...]:
    """For each hole the shortest strip that crosses its stretch of the cuts once and no other cut."""
    if not mesh.n_holes:
        return ()
    cuts = cut_open(mesh)
    uncut = mesh.inner[(cuts.windings[mesh.inner] == 0).all(axis=1)]
    edge_between = {}
    for edge, (a, b) in zip(uncut.tolist(), mesh.sides[uncut].tolist(), strict=True):
        edge_between[a, b] = edge_between[b, a] = edge
    links = graph(len(mesh.facets), mesh.sides[uncut])
    strips = []
    for stretch in cuts.stretches:
        left, right = mesh.sides[list(stretch)].T
        distance, back = dijkstra(links, False, left, True, unweighted=True)
        best = int(distance[np.arange(len(stretch)), right].argmin())
        facets = [int(right[best])]
        while facets[-1] != left[best]:
            facets.append(int(back[best, facets[-1]]))
        edges = [edge_between[pair] for pair in pairwise(facets)] + [stretch[best]]
        strips.append((np.array(facets), np.array(edges)))
    return tuple(strips)


def closure(motion: Motion, strips: tuple[Strip, ...]) -> tuple[Measured, tuple[Loop, ...]]:
    """How far the strip around each hole opens: a bound on how far its motion around moves any vertex.

    The product of the k hinge motions of a strip is a polynomial of degree k in the folding amount: if it is
    the identity at k + 1 values, it is at all. The values are equispaced on the projective line, which keeps
    the interpolation well conditioned, and half of them are negative, where all folds change sign; further
    ones in between are a check on this argument.

    Args:
        motion: in units of the bounding-box diagonal, its points within half a diagonal of the origin.
        strips: one around each hole.

    Returns:
        The worst gap, and every loop with its own.
    """
    loops = []
    worst, where = 0.0, "no holes"
    for hole, (facets, edges) in enumerate(strips):
        nodes = np.pi * np.arange(len(facets) + 1) / (len(facets) + 1)
        between = np.pi * (np.arange(N_SPOT_CHECKS) + 0.5) / N_SPOT_CHECKS
        theta = np.concatenate([nodes, between])
        hinges = motion.hinges(theta, edges, facets)
        product = hinges[:, :, 0]
        for k in range(1, len(facets)):
            product = dual.multiply(product, hinges[:, :, k])
        turn, shift = np.linalg.norm(product[1:4], axis=0), np.linalg.norm(product[4:], axis=0)
        # 2 sin(angle/2) times the half diagonal within which all vertices lie, and the length of the shift.
        gap = turn + 2 * shift
        if not np.isfinite(gap).all():
            return (None, "the motion is not defined"), ()
        k, n = int(gap.argmax()), len(nodes)
        at_nodes, others = float(gap[:n].max()), float(gap[n:].max(initial=0.0))
        loops.append(Loop(tuple(facets.tolist()), n, at_nodes, others, _conditioning(n)))
        if gap[k] > worst or hole == 0:
            worst = float(gap[k])
            where = (
                f"hole {hole}, strip of {len(facets)} facets from facet {facets[0]},"
                f" at t = {180 - (180 - np.degrees(2 * theta[k])) % 360:.1f} degrees"
            )
    return (worst, where), tuple(loops)


def _conditioning(n: int) -> float:
    """Lebesgue constant of n nodes equispaced on the projective line, for polynomials of degree n - 1."""
    from_node = np.pi * (np.arange(8 * n) + 0.5) / (8 * n)
    distance = from_node[:, None] - np.pi * np.arange(n) / n
    return float(np.abs(np.sin(n * distance) / (n * np.sin(distance))).sum(axis=1).max())
