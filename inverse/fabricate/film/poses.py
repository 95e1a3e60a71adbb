"""States of a motion as poses of rigid facets, the body as a whole held so that it neither drifts nor tumbles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inverse._types import FloatArray
from inverse.origami import folding, geometry
from inverse.origami.pattern import Design

# States between which the body is held, this far apart at most; the design state is one of them.
_STEP = np.radians(5.0)
_STATES_AT_ONCE = 16  # bounds the memory
# A shared edge may open this much between key frames, of the median edge length: too little to be seen.
OPENING = 1e-3
MOST_KEYS = 961


@dataclass(frozen=True, eq=False)
class Poses:
    """States of a design, told by where its facets are.

    A facet with centroid c moves from its place in the design state by p -> R (p - c) + m: in between two states,
    R turned evenly and m moved evenly keep every facet rigid.

    Attributes:
        t: (S,) folding amounts in radians.
        quaternions: (S, F, 4) of R, as x, y, z, w with length 1; the sign is that of the state before.
        centroids: (S, F, 3) of m, in the design's unit.
        vertices_coords: (S, V, 3) vertices, in the design's unit.
    """

    t: FloatArray
    quaternions: FloatArray
    centroids: FloatArray
    vertices_coords: FloatArray


def poses(design: Design, t: FloatArray) -> Poses:
    """Poses of all facets in the given states; the place of each depends on its own ``t`` alone.

    The body is held by its vertices: from state to state, away from the design state, they turn as little as can be
    (least squares), their mean stays where it is in plan, and the lowest of them stays at its height, so that the body
    stands on the ground.

    Args:
        design: the mesh in its design state.
        t: (S,) folding amounts in radians within [0, pi].

    Raises:
        ValueError: a folding amount outside [0, pi].
    """
    t = np.atleast_1d(np.asarray(t, np.float64))
    nodes = _nodes(design)
    parts = [_held(design, some, nodes) for some in np.array_split(t, range(_STATES_AT_ONCE, len(t), _STATES_AT_ONCE))]
    quaternions, centroids, coords = (np.concatenate(part) for part in zip(*parts, strict=True))
    # q and -q are one rotation, but an animation between them would go the long way round.
    back = np.cumprod(np.where((quaternions[1:] * quaternions[:-1]).sum(axis=-1) < 0, -1.0, 1.0), axis=0)
    quaternions[1:] *= back[..., None]
    return Poses(t, quaternions, centroids, coords)


def placed(design: Design, quaternions: FloatArray, centroids: FloatArray) -> FloatArray:
    """Where facets in these poses, (..., F, 4) and (..., F, 3), have their corners, (..., C, 3)."""
    pattern = design.pattern
    face, _, vertex, _ = pattern.corners.T
    own = design.vertices_coords[vertex] - geometry.facet_centroids(pattern, design.vertices_coords)[face]
    turned = _turned(quaternions[..., face, :], own)
    return np.asarray(turned + centroids[..., face, :])


def opening(design: Design, keys: Poses) -> float:
    """How far corners that meet in a vertex are apart halfway between key frames, at most, in the design's unit.

    Players of animations turn and move every facet evenly from key frame to key frame. Facets stay as they are then,
    but their common edges open a little.
    """
    a, b = keys.quaternions[:-1], keys.quaternions[1:]
    between = a + b  # halfway along the great circle
    between /= np.linalg.norm(between, axis=-1, keepdims=True)
    middle = (keys.centroids[:-1] + keys.centroids[1:]) / 2
    vertex = design.pattern.corners[:, 2]
    order = np.argsort(vertex, kind="stable")
    starts = np.flatnonzero(np.diff(vertex[order], prepend=-1))
    count = np.diff(np.append(starts, len(order)))
    largest = 0.0
    for quaternions, centroids in zip(between, middle, strict=True):
        corners = placed(design, quaternions, centroids)[order]
        mean = np.add.reduceat(corners, starts) / count[:, None]
        apart = np.linalg.norm(corners - np.repeat(mean, count, axis=0), axis=1)
        largest = max(largest, 2 * float(apart.max()))
    return largest


def key_frames(design: Design, t: FloatArray) -> Poses:
    """Key frames at the given states, and so many between them that shared edges open by ``OPENING`` at most.

    Args:
        design: the mesh in its design state.
        t: (S,) folding amounts in radians, evenly spaced; at least two.

    Returns:
        The key frames, evenly spaced. Where more than ``MOST_KEYS`` would be needed, edges open further.
    """
    limit = OPENING * float(np.median(geometry.edge_lengths(design.pattern, design.vertices_coords)))
    most = max(1, (MOST_KEYS - 1) // (len(t) - 1))
    parts = 1
    while True:
        keys = poses(design, np.interp(np.arange(parts * (len(t) - 1) + 1) / parts, np.arange(len(t)), t))
        found = opening(design, keys)
        if found <= limit or parts == most:
            return keys
        # The opening falls with the square of the step.
        parts = min(max(int(np.ceil(np.sqrt(found / limit) * parts)), parts + 1), most)


@dataclass(frozen=True, eq=False)
class _Nodes:
    """States every few degrees, as the body is held: about their mean at the origin."""

    t: FloatArray  # (N,)
    coords: FloatArray  # (N, V, 3)


def _nodes(design: Design) -> _Nodes:
    n = 2 * int(np.ceil(np.pi / 2 / _STEP))
    t = np.linspace(0.0, np.pi, n + 1)
    free = folding.fold(design, t).vertices_coords
    coords = free - free.mean(axis=1, keepdims=True)
    coords[n // 2] = design.vertices_coords - design.vertices_coords.mean(axis=0)
    for way in (1, -1):
        for k in range(n // 2 + way, n + 1 if way > 0 else -1, way):
            coords[k] = coords[k] @ geometry.turn_onto(coords[k], coords[k - way]).T
    return _Nodes(t, coords)


def _held(design: Design, t: FloatArray, nodes: _Nodes) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Quaternions, centroids and vertices of a few states."""
    from scipy.spatial.transform import Rotation

    rotation, shift = folding.facet_motions(design, t)
    free = folding.fold(design, t).vertices_coords
    middle = free.mean(axis=1, keepdims=True)
    # Each state follows the node before it on the way from the design state.
    half, step = len(nodes.t) // 2, nodes.t[1]
    before = half + np.trunc((t - np.pi / 2) / step).astype(np.int64)
    hold = np.stack([geometry.turn_onto(one, nodes.coords[k]) for one, k in zip(free - middle, before, strict=True)])
    centroids = geometry.facet_centroids(design.pattern, design.vertices_coords)
    moved = (rotation @ centroids[..., None])[..., 0] + shift - middle
    quaternions = Rotation.from_matrix((hold[:, None] @ rotation).reshape(-1, 3, 3)).as_quat()
    turn = np.swapaxes(hold, 1, 2)
    coords = (free - middle) @ turn
    home = np.tile(design.vertices_coords.mean(axis=0), (len(t), 1, 1))
    home[..., 2] = design.vertices_coords[:, 2].min() - coords[..., 2].min(axis=1, keepdims=True)
    return quaternions.reshape(*rotation.shape[:2], 4), moved @ turn + home, coords + home


def _turned(quaternions: FloatArray, vectors: FloatArray) -> FloatArray:
    """Vectors (..., 3) turned by unit quaternions (..., 4)."""
    axis, w = quaternions[..., :3], quaternions[..., 3:]
    twice = 2 * np.cross(axis, vectors)
    return np.asarray(vectors + w * twice + np.cross(axis, twice))
