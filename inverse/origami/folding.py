"""The one-parameter motion of a rigid-foldable mesh, equations (2)-(5), limits included."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.origami import geometry
from inverse.origami.pattern import CFL, Design


@dataclass(frozen=True, eq=False)
class Motion:
    """States of a design.

    Attributes:
        t: (S,) folding amount in radians; 0 developed, pi/2 the design state, pi flat-folded.
        fold_angles: (S, E) signed fold angles in radians, valley positive.
        vertices_coords: (S, V, 3) vertices; facet 0 stays where it is in the design state.
        gap: (S,) largest distance by which facets that meet in an edge disagree on it, in length units.
    """

    t: FloatArray
    fold_angles: FloatArray
    vertices_coords: FloatArray
    gap: FloatArray


def half_angle(t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """sin and cos of t/2, exact (0 and 1) at the flat states t = 0 and t = pi."""
    sine, cosine = np.sin(t / 2), np.cos(t / 2)
    return np.where(t >= np.pi, 1.0, sine), np.where(t >= np.pi, 0.0, cosine)


def fold_angles_at(design: Design, t: FloatArray) -> FloatArray:
    """Fold angles (S, E) at folding amounts ``t`` (S,), both in radians: equations (3) and (5).

    tan(rho/2) grows with tan(t/2) at an FL and with cot(t/2) at a CFL; in the flat states it is exactly 0 or
    infinite, so that the angles are exactly 0 or +-pi.
    """
    rho = geometry.fold_angles(design.pattern, design.vertices_coords)
    sine, cosine = half_angle(t)
    complementary = design.pattern.edges_type == CFL
    numerator = np.where(complementary, cosine[:, None], sine[:, None])
    denominator = np.where(complementary, sine[:, None], cosine[:, None])
    return np.asarray(2 * np.arctan2(numerator * np.sin(rho / 2), denominator * np.cos(rho / 2)))


def fold(design: Design, t: FloatArray | None = None) -> Motion:
    """Fold a design to each of the given states.

    Facet 0 is held; every further facet follows its neighbour by a rotation about their common edge along
    a spanning tree. Edges outside the tree test the motion: :attr:`Motion.gap`.

    Args:
        design: the mesh in its design state.
        t: (S,) folding amounts in radians within [0, pi]; by default 64 states, both limits included.

    Returns:
        The motion, facet 0 at rest.

    Raises:
        ValueError: a folding amount outside [0, pi].
    """
    t = np.linspace(0.0, np.pi, 64) if t is None else np.atleast_1d(np.asarray(t, np.float64))
    if not np.all((t >= 0) & (t <= np.pi)):
        raise ValueError(f"folding amounts run from 0 (developed) to pi (flat-folded), given {t.min()} to {t.max()}")
    pattern, points = design.pattern, design.vertices_coords
    angles = fold_angles_at(design, t)
    turned = angles - geometry.fold_angles(pattern, points)
    hinges = _hinge_rotations(design, turned)
    rotation, shift = _facet_motions(design, hinges)
    n_states = len(t)

    coords = np.empty((n_states, pattern.n_vertices, 3))
    owner = np.empty(pattern.n_vertices, np.int64)
    owner[pattern.corners[::-1, 2]] = pattern.corners[::-1, 0]
    coords[:] = _apply(rotation[:, owner], points) + shift[:, owner]

    gap = np.zeros(n_states)
    tests = np.setdiff1d(pattern.interior_edges, pattern.facet_tree[1:, 2])
    if len(tests):
        left, right = pattern.edges_faces[tests].T
        turn, offset = hinges.across(tests, left)
        expected_rotation = rotation[:, left] @ turn
        expected_shift = _apply(rotation[:, left], offset) + shift[:, left]
        # Compared at every vertex of the right-hand facet, so that a wrong angle about the edge counts too.
        n_sides = max(len(f) for f in pattern.faces_vertices)
        for k in range(n_sides):
            probe = points[[pattern.faces_vertices[f][k % len(pattern.faces_vertices[f])] for f in right]]
            placed = _apply(rotation[:, right], probe) + shift[:, right]
            expected = _apply(expected_rotation, probe) + expected_shift
            gap = np.maximum(gap, np.linalg.norm(placed - expected, axis=2).max(axis=1))
    return Motion(t, angles, coords, gap)


def facet_motions(design: Design, t: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where every facet moves from its place in the design state: p -> rotation p + shift, facet 0 at rest.

    Args:
        design: the mesh in its design state.
        t: (S,) folding amounts in radians within [0, pi].

    Returns:
        Rotations (S, F, 3, 3) and shifts (S, F, 3).
    """
    turned = fold_angles_at(design, t) - geometry.fold_angles(design.pattern, design.vertices_coords)
    return _facet_motions(design, _hinge_rotations(design, turned))


def folded_by(design: Design, turned: FloatArray) -> FloatArray:
    """Vertices (V, 3) after every edge has been folded further by its own angle, facet 0 at rest.

    Where the angles are not those of a motion, facets disagree on their common vertices: each takes the mean of the
    places that its facets give it.

    Args:
        design: any state of a mesh.
        turned: (E,) radians, valley positive.
    """
    rotation, shift = _facet_motions(design, _hinge_rotations(design, turned[None]))
    facet, _, vertex, _ = design.pattern.corners.T
    places = _apply(rotation[0, facet], design.vertices_coords[vertex]) + shift[0, facet]
    total = np.zeros_like(design.vertices_coords)
    np.add.at(total, vertex, places)
    return np.asarray(total / np.bincount(vertex)[:, None])


def _facet_motions(design: Design, hinges: _Hinges) -> tuple[FloatArray, FloatArray]:
    """Rotation (S, F, 3, 3) and shift (S, F, 3) of every facet, along the spanning tree from facet 0."""
    n_states, n_faces = len(hinges.rotation), len(design.pattern.faces_vertices)
    rotation = np.empty((n_states, n_faces, 3, 3))
    shift = np.zeros((n_states, n_faces, 3))
    rotation[:, 0] = np.eye(3)
    for faces, parents, edges in _levels(design.pattern.facet_tree):
        turn, offset = hinges.across(edges, parents)
        rotation[:, faces] = rotation[:, parents] @ turn
        shift[:, faces] = _apply(rotation[:, parents], offset) + shift[:, parents]
    return rotation, shift


def flat_state(design: Design, t: float) -> FloatArray:
    """The developed (``t`` = 0) or flat-folded (``t`` = pi) state laid in the plane z = 0, (V, 3)."""
    pattern = design.pattern
    coords = fold(design, np.array([t])).vertices_coords[0]
    a, b, c = coords[list(pattern.faces_vertices[0][:3])]
    x, z = geometry.unit(b - a), geometry.unit(np.cross(b - a, c - a))
    flat = (coords - coords.mean(axis=0)) @ np.stack([x, np.cross(z, x), z], axis=1)
    return np.asarray(flat)


@dataclass(frozen=True, eq=False)
class _Hinges:
    """Rotation of every edge's right facet relative to its left one, from the design state on."""

    rotation: FloatArray  # (S, E, 3, 3)
    shift: FloatArray  # (S, E, 3)
    left: IntArray

    def across(self, edges: IntArray, parents: IntArray) -> tuple[FloatArray, FloatArray]:
        """Rotation (S, k, 3, 3) and shift (S, k, 3) met on crossing the edges out of the parent facets."""
        forward = self.left[edges] == parents
        rotation = self.rotation[:, edges]
        shift = self.shift[:, edges]
        back = np.swapaxes(rotation, 2, 3)
        turn = np.where(forward[:, None, None], rotation, back)
        return turn, np.where(forward[:, None], shift, -_apply(back, shift))


def _hinge_rotations(design: Design, turned: FloatArray) -> _Hinges:
    points, pattern = design.vertices_coords, design.pattern
    a, b = points[pattern.edges_vertices].transpose(1, 0, 2)
    axis = geometry.unit(b - a)
    # A growing valley angle lifts the right-hand facet, which turns it negatively about the edge direction.
    sine, versine = np.sin(-turned)[..., None, None], (1 - np.cos(turned))[..., None, None]
    x, y, z = axis.T
    zero = np.zeros_like(x)
    cross = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    rotation = np.eye(3) + sine * cross + versine * (cross @ cross)
    return _Hinges(rotation, a - _apply(rotation, a), pattern.edges_faces[:, 0])


def _levels(tree: IntArray) -> list[tuple[IntArray, IntArray, IntArray]]:
    """The breadth-first tree cut into levels whose facets can be placed at once."""
    depth = np.zeros(len(tree), np.int64)
    for face, parent, _ in tree[1:].tolist():
        depth[face] = depth[parent] + 1
    row_depth = depth[tree[:, 0]]
    return [tuple(tree[row_depth == d].T) for d in range(1, int(row_depth.max(initial=0)) + 1)]


def _apply(rotation: FloatArray, vectors: FloatArray) -> FloatArray:
    return np.asarray((rotation @ vectors[..., None])[..., 0])
