"""How many independent motions a design has: a mechanism of this kind must have exactly one.

The fold lines that meet in interior vertices move together, one parameter per group of them; the strips
around the holes tie groups to each other. The count, of first order, is an upper bound: 1 proves one.
"""

from __future__ import annotations

import numpy as np

from inverse._types import IntArray
from inverse.certify.loops import Strip
from inverse.certify.measures import CFL
from inverse.certify.mesh import Mesh, components
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


def freedom(motion: Motion, strips: tuple[Strip, ...]) -> int:
    """Upper bound for the number of independent motions from the design state.

    Args:
        motion: points in units of the bounding-box diagonal.
        strips: one closed strip around each hole.
    """
    mesh = motion.mesh
    count, group = groups(mesh)
    if count <= 1 or not strips:
        return count
    # Equations (3) and (5) differentiated at the design state; in a group all rates grow alike.
    rate = np.where(motion.types == CFL, -2.0, 2.0) * motion.sine * motion.cosine
    group_of = np.zeros(len(mesh.edges), np.int64)
    group_of[mesh.inner] = group
    # A strip stays closed if the twists of its hinges, each a rate times a line, sum to zero.
    twists = np.zeros((len(strips), 6, count))
    for total, (facets, edges) in zip(twists, strips, strict=True):
        forward = np.where(mesh.sides[edges, 0] == facets, 1.0, -1.0)
        np.add.at(total.T, group_of[edges], (forward * rate[edges] * motion.axes[:, edges]).T)
    singular = np.linalg.svd(twists.reshape(-1, count), compute_uv=False)
    return count - int(np.count_nonzero(singular > RANK_TOLERANCE * singular.max()))


def faults(motion: Motion, strips: tuple[Strip, ...]) -> list[str]:
    """Whether the design has other motions than the measured one; arguments as for :func:`freedom`."""
    number = freedom(motion, strips)
    if number <= 1:
        return []
    mesh = motion.mesh
    count, group = groups(mesh)
    first, other = mesh.inner[0], mesh.inner[np.argmax(group != group[0])]
    return [
        f"there are {number} independent motions: the fold lines fall into {count} groups that no vertex"
        f" joins, for example {mesh.name(first)} and {mesh.name(other)}"
    ]
