"""Lengths, angles and normals of a design, in plain numpy."""

from __future__ import annotations

import numpy as np

from inverse._types import FloatArray
from inverse.origami.pattern import Pattern


def diagonal(points: FloatArray) -> float:
    """Length of the bounding-box diagonal of points, (N, 3): the size that tolerances refer to."""
    return float(np.linalg.norm(np.ptp(points, axis=0)))


def unit(vectors: FloatArray) -> FloatArray:
    """Vectors (..., 3) divided by their lengths; zero stays zero, so that a degenerate mesh can be looked at."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(np.divide(vectors, lengths, out=np.zeros_like(vectors), where=lengths > 0))


def edge_lengths(pattern: Pattern, points: FloatArray) -> FloatArray:
    """Edge lengths, (E,), of vertices ``points`` (V, 3)."""
    a, b = pattern.edges_vertices.T
    return np.asarray(np.linalg.norm(points[b] - points[a], axis=1))


def facet_centroids(pattern: Pattern, points: FloatArray) -> FloatArray:
    """Mean of each facet's vertices, (F, 3)."""
    face, _, vertex, _ = pattern.corners.T
    total = np.zeros((len(pattern.faces_vertices), 3))
    np.add.at(total, face, points[vertex])
    return np.asarray(total / np.bincount(face)[:, None])


def facet_normals(pattern: Pattern, points: FloatArray) -> FloatArray:
    """Unit normals, (F, 3), on the side from which the facets turn counter-clockwise (Newell)."""
    face, _, vertex, following = pattern.corners.T
    origin = points[[f[0] for f in pattern.faces_vertices]][face]
    total = np.zeros((len(pattern.faces_vertices), 3))
    np.add.at(total, face, np.cross(points[vertex] - origin, points[following] - origin))
    return unit(total)


def sector_angles(pattern: Pattern, points: FloatArray) -> FloatArray:
    """Angle in every facet corner, (C,) in radians, in the order of ``pattern.corners``."""
    _, previous, vertex, following = pattern.corners.T
    a, b = points[following] - points[vertex], points[previous] - points[vertex]
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.einsum("ij,ij->i", a, b)))


def fold_angles(pattern: Pattern, points: FloatArray) -> FloatArray:
    """Signed fold angle of every edge, (E,) in radians, valley positive as in FOLD; 0 on the boundary."""
    normals = facet_normals(pattern, points)
    inner = pattern.interior_edges
    left, right = normals[pattern.edges_faces[inner]].transpose(1, 0, 2)
    a, b = points[pattern.edges_vertices[inner]].transpose(1, 0, 2)
    along = unit(b - a)
    # Walking along the edge with the left facet on the left, a valley turns the right facet's normal back
    # over the left one: positive about the edge direction from right to left.
    sine = np.einsum("ij,ij->i", along, np.cross(right, left))
    angles = np.zeros(len(pattern.edges_vertices))
    angles[inner] = np.arctan2(sine, np.einsum("ij,ij->i", left, right))
    return angles


def turn_onto(points: FloatArray, onto: FloatArray) -> FloatArray:
    """The rotation, (3, 3), of points (N, 3) about the origin that brings them nearest to others (Kabsch)."""
    u, _, vt = np.linalg.svd(onto.T @ points)
    u[:, -1] *= np.sign(np.linalg.det(u @ vt))
    return np.asarray(u @ vt)


def are_convex(pattern: Pattern, points: FloatArray) -> bool:
    """Whether every facet turns the same way at all its corners: none is reflex, none a bow-tie."""
    face, previous, vertex, following = pattern.corners.T
    turn = np.cross(points[vertex] - points[previous], points[following] - points[vertex])
    return bool((np.einsum("ij,ij->i", turn, facet_normals(pattern, points)[face]) > 0).all())
