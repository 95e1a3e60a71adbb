"""How many independent motions a design has: a mechanism of this kind must have exactly one.

The fold lines that meet in interior vertices move together, one parameter per group of them; the strips
around the holes tie groups to each other. The first-order count below is an upper bound, so that 1 proves one.
"""

from __future__ import annotations

import numpy as np

from inverse.certify.loops import Strip
from inverse.certify.measures import CFL
from inverse.certify.mesh import IntArray, Mesh, components
from inverse.certify.motion import Motion

# Singular values below this part of the largest count as zero. Entries are exact to rounding; the motion
# itself keeps the strips closed to 1e-9.
RANK_TOLERANCE = 1e-7


def groups(mesh: Mesh) -> tuple[int, IntArray]:
    """Number of groups of interior edges that interior vertices join, and (K,) the group of each."""
    inside = np.zeros(int(mesh.tail.max()) + 1, bool)
    inside[mesh.interior_vertices] = True
    n_edges = len(mesh.inner)
    edge = np.arange(n_edges)
    a, b = mesh.edges[mesh.inner].T
    links = np.concatenate([np.stack([edge[inside[v]], n_edges + v[inside[v]]], axis=1) for v in (a, b)])
    _, labels = components(n_edges + len(inside), links)
    names, group = np.unique(labels[:n_edges], return_inverse=True)
    return len(names), group


def faults(motion: Motion, strips: tuple[Strip, ...]) -> list[str]:
    """Whether the design has another motion than the one that was measured.

    Args:
        motion: points in units of the bounding-box diagonal.
        strips: one closed strip around each hole.
    """
    mesh = motion.mesh
    count, group = groups(mesh)
    if count <= 1:
        return []
    # Equations (3) and (5) differentiated at the design state; in a group all rates grow alike.
    rate = np.where(motion.types == CFL, -2.0, 2.0) * motion.sine * motion.cosine
    group_of = np.zeros(len(mesh.edges), np.int64)
    group_of[mesh.inner] = group
    closed = np.zeros((6 * len(strips), count))
    for k, (facets, edges) in enumerate(strips):
        forward = np.where(mesh.sides[edges, 0] == facets, 1.0, -1.0)
        np.add.at(
            closed[6 * k : 6 * k + 6].T, group_of[edges], (forward * rate[edges] * motion.axes[:, edges]).T
        )
    singular = np.linalg.svd(closed, compute_uv=False) if len(strips) else np.zeros(0)
    freedom = count - int(np.count_nonzero(singular > RANK_TOLERANCE * singular.max(initial=0.0)))
    if freedom <= 1:
        return []
    first, other = mesh.inner[0], mesh.inner[np.argmax(group != group[0])]
    return [
        f"there are {freedom} independent motions: the fold lines fall into {count} groups that no vertex"
        f" joins, for example {mesh.name(first)} and {mesh.name(other)}"
    ]
