"""Closest points of triangles, searched in a tree that is built once."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from inverse._types import FloatArray, IntArray

if TYPE_CHECKING:
    import igl


class Nearest:
    """Triangles whose closest points are asked for more than once.

    Args:
        vertices: (V, 3), not to be changed.
        triangles: (T, 3) int, not to be changed.
    """

    def __init__(self, vertices: FloatArray, triangles: IntArray) -> None:
        self.vertices = np.ascontiguousarray(vertices, np.float64)
        self.triangles = np.ascontiguousarray(triangles, np.int64)
        self._tree: igl.AABB | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Without the tree, which is built again where it is needed."""
        return {**self.__dict__, "_tree": None}

    def find(self, points: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
        """Squared distances (N,) of points (N, 3), the triangles (N,) that are closest and the places (N, 3) there."""
        import igl  # loaded when used: the package itself must import fast

        if self._tree is None:
            self._tree = igl.AABB()
            self._tree.init(self.vertices, self.triangles)
        given = np.ascontiguousarray(points, np.float64)
        squares, facet, feet = self._tree.squared_distance(self.vertices, self.triangles, given)
        return np.asarray(squares).ravel(), np.asarray(facet).ravel(), np.asarray(feet).reshape(-1, 3)
