"""How far a mesh is from the exact set, vertex by vertex and facet by facet, and how far one mesh is from another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from inverse._types import FloatArray
from inverse.origami import geometry
from inverse.origami.pattern import FL, Design
from inverse.repair.line_types import ring_angles


@dataclass(frozen=True, eq=False)
class Residuals:
    """What is left of the equations.

    Attributes:
        developability: (I,) |c_dev| of equation (6) at every interior vertex, radians.
        flat_foldability: (I,) |c_ff| of equation (7), radians.
        planarity: (F,) largest distance of a vertex from its facet's best-fit plane, in mean edges of the mesh.
    """

    developability: FloatArray
    flat_foldability: FloatArray
    planarity: FloatArray

    @property
    def angles(self) -> FloatArray:
        """(I,) the larger of the two angle errors at every interior vertex, radians."""
        return np.maximum(self.developability, self.flat_foldability)

    def document(self) -> dict[str, Any]:
        """The largest values, JSON-safe."""
        return {
            "developability": float(self.developability.max(initial=0.0)),
            "flat_foldability": float(self.flat_foldability.max(initial=0.0)),
            "planarity": float(self.planarity.max(initial=0.0)),
        }


def residuals(design: Design) -> Residuals:
    """Residuals of (6), (7) and planarity of a design, whatever its state."""
    pattern, points = design.pattern, design.vertices_coords
    theta = ring_angles(pattern, points)
    miura = pattern.is_miura_vertex
    # Errors of the two pairs of opposite angles: supplementary at a Miura vertex, equal at a Voss vertex.
    first, second = np.where(
        miura[:, None], theta[:, :2] + theta[:, 2:] - np.pi, theta[:, :2] - theta[:, 2:]
    ).T  # fmt: skip
    together, apart = np.abs(first + second), np.abs(first - second)
    # Their sum is the angle deficit of 4FL, the alternating sum of 4CFL; at a Voss vertex the facets on the two
    # sides of the CFL line, or of the FL line, are added.
    starts_fl = pattern.edges_type[pattern.ring_edges[:, 0]] == FL
    is_deficit = starts_fl == miura
    return Residuals(np.where(is_deficit, together, apart), np.where(is_deficit, apart, together), _planarity(design))


def moved(before: FloatArray, after: FloatArray) -> dict[str, Any]:
    """Distances between two sets of vertices (V, 3): in length units and relative to the diagonal."""
    distance = np.linalg.norm(after - before, axis=1)
    size = geometry.diagonal(before)
    rms = float(np.sqrt(np.mean(distance**2)))
    return {
        "max": float(distance.max()),
        "max_relative": float(distance.max() / size),
        "worst_vertex": int(np.argmax(distance)),
        "rms": rms,
        "rms_relative": rms / size,
        "vertices": distance.tolist(),
    }


def laid_upon(points: FloatArray, onto: FloatArray) -> FloatArray:
    """Points (V, 3) of a plane z = 0 moved within it, without reflection, as near to ``onto`` as can be."""
    middle, goal = points.mean(axis=0), onto.mean(axis=0)
    (xx, xy), (yx, yy) = ((points - middle)[:, :2].T @ (onto - goal)[:, :2]).tolist()
    angle = np.arctan2(xy - yx, xx + yy)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return np.asarray((points - middle) @ turn.T + goal)


def _planarity(design: Design) -> FloatArray:
    faces, points = design.pattern.faces_vertices, design.vertices_coords
    mean_edge = geometry.edge_lengths(design.pattern, points).mean()
    normals = geometry.facet_normals(design.pattern, points)
    centroids = geometry.facet_centroids(design.pattern, points)
    face, _, vertex, _ = design.pattern.corners.T
    height = np.abs(np.einsum("ij,ij->i", points[vertex] - centroids[face], normals[face]))
    found = np.zeros(len(faces))
    np.maximum.at(found, face, height)
    return np.asarray(found / mean_edge)
