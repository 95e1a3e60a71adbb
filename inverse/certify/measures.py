"""What is measured on the design state itself: planes, sector angles, fold angles.

Everything is computed from differences of vertices within a facet. These are as good as the vertices themselves,
however far from the origin and however small beside the design: differences of close numbers lose nothing.
"""

from __future__ import annotations

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.certify.certificate import LIMITS, Measured, told_apart
from inverse.certify.mesh import Mesh

# Codes of the edge types as the certificate keeps them; UNKNOWN where the file says nothing usable.
UNKNOWN, BOUNDARY, FL, CFL = -1, 0, 1, 2


def planarity(mesh: Mesh, points: FloatArray) -> Measured:
    """Largest distance of a vertex from the best-fit plane of its facet, in edge lengths.

    It is told in mean edges of the mesh or, where that is shorter, in the facet's own shortest edge: a facet that is
    small beside the others must be flat in itself.
    """
    lengths = edge_lengths(mesh, points)
    mean_edge = float(lengths.mean())
    shortest = np.minimum.reduceat(lengths[mesh.edge_of], mesh.starts)
    worst, where = 0.0, "facet 0"
    sides = np.diff(np.append(mesh.starts, len(mesh.tail)))
    for count in np.unique(sides[sides > 3]):
        facets = np.flatnonzero(sides == count)
        polygons = points[mesh.tail[mesh.starts[facets][:, None] + np.arange(count)]]
        polygons = polygons - polygons[:, :1]
        polygons -= polygons.mean(axis=1, keepdims=True)
        normals = np.linalg.svd(polygons)[2][:, 2]
        distance = np.abs(np.einsum("fsk,fk->fs", polygons, normals)).max(axis=1)
        distance /= np.minimum(mean_edge, shortest[facets])
        if distance.max() > worst:
            facet = facets[distance.argmax()]
            by = "its shortest edge" if shortest[facet] < mean_edge else "the mean edge"
            worst, where = float(distance.max()), f"facet {facet}, by {by}"
    return worst, where


def edge_lengths(mesh: Mesh, points: FloatArray) -> FloatArray:
    """(E,) length of every edge."""
    a, b = points[mesh.edges].transpose(1, 0, 2)
    return np.asarray(np.linalg.norm(b - a, axis=1))


def sector_angles(mesh: Mesh, points: FloatArray) -> FloatArray:
    """Unsigned angle at the tail of every half-edge within its facet, (C,) in radians."""
    corner = points[mesh.tail]
    a, b = points[mesh.head] - corner, points[mesh.tail[mesh.previous]] - corner
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.einsum("ij,ij->i", a, b)))


def flatness(mesh: Mesh, points: FloatArray, types: IntArray, signs: IntArray, open_type: int) -> Measured:
    """Largest residual of equation (6) or (7) of the paper over the interior vertices, in radians.

    Args:
        mesh: with interior vertices of degree 4.
        points: (V, 3) vertices.
        types: (E,) edge types.
        signs: (F,) +-1, sides of the facets in the flat state.
        open_type: the edges that lie unfolded in that state. ``FL`` gives developability (6), ``CFL``
            flat-foldability (7): a vertex with these edges only is surrounded once by its facets, 2 pi;
            at any other one the signed angles sum to zero.
    """
    if not len(mesh.rings):
        return 0.0, "no interior vertices"
    angles = sector_angles(mesh, points)[mesh.rings]
    unfolded = (types[mesh.edge_of[mesh.rings]] == open_type).all(axis=1)
    signed = np.sum(signs[mesh.facet[mesh.rings]] * angles, axis=1)
    residual = np.abs(np.where(unfolded, 2 * np.pi - angles.sum(axis=1), signed))
    worst = int(residual.argmax())
    return float(residual[worst]), f"vertex {mesh.interior_vertices[worst]}"


def fold_halves(mesh: Mesh, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """sin and cos of half the fold angle of every edge, (E,) each; valley positive; 0 and 1 on the boundary.

    The unit vectors from an edge into its two facets, at right angles to the edge, are opposite where the
    sheet is flat: half their sum has length |sin(rho/2)| and half their difference cos(rho/2). It is a valley
    where the right-hand one rises over the left-hand facet.
    """
    a, b = points[mesh.edges[mesh.inner]].transpose(1, 0, 2)
    along = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
    following = np.empty_like(mesh.previous)
    following[mesh.previous] = np.arange(len(following))
    arms = []
    left_hand = mesh.half_edges[mesh.inner]
    for side in (left_hand, mesh.twin[left_hand]):
        # The facet's edges at both ends of this one lead into it.
        arm = points[mesh.head[following[side]]] - points[mesh.head[side]]
        arm += points[mesh.tail[mesh.previous[side]]] - points[mesh.tail[side]]
        arm -= np.einsum("ij,ij->i", arm, along)[:, None] * along
        arms.append(arm / np.linalg.norm(arm, axis=1, keepdims=True))
    left, right = arms
    rises = np.einsum("ij,ij->i", along, np.cross(left, right)) >= 0
    sine, cosine = np.zeros(len(mesh.edges)), np.ones(len(mesh.edges))
    sine[mesh.inner] = np.where(rises, 0.5, -0.5) * np.linalg.norm(left + right, axis=1)
    cosine[mesh.inner] = 0.5 * np.linalg.norm(left - right, axis=1)
    return sine, cosine


def fold_angle(mesh: Mesh, sine: FloatArray, cosine: FloatArray) -> Measured:
    """How far the fold angle nearest to 0 or 180 degrees stays away from it, in degrees."""
    rho = np.degrees(2 * np.arctan2(np.abs(sine), cosine))[mesh.inner]
    margin = np.minimum(rho, 180 - rho)
    if not len(margin):
        return None, "no interior edges"
    worst = int(margin.argmin())
    limit, _ = LIMITS["fold_angle"]
    folded_by = told_apart(rho[worst], limit if rho[worst] < 90 else 180 - limit)
    return float(margin[worst]), f"{mesh.name(mesh.inner[worst])}, folded by {folded_by} degrees"
