"""Closest points of triangles, searched in a tree that is built once."""

from __future__ import annotations

import atexit
from typing import TYPE_CHECKING, Any
from weakref import WeakSet

import numpy as np

from inverse._types import FloatArray, IntArray

if TYPE_CHECKING:
    import igl


_with_trees: WeakSet[Nearest] = WeakSet()


@atexit.register
def _let_go() -> None:
    """Give trees back before Python ends: the library of those that a script still holds complains about them."""
    for nearest in _with_trees:
        nearest.drop()


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

    def drop(self) -> None:
        """Forget the tree."""
        self._tree = None

    @property
    def _built(self) -> igl.AABB:
        import igl  # loaded when used: the package itself must import fast

        if self._tree is None:
            self._tree = igl.AABB()
            self._tree.init(self.vertices, self.triangles)
            _with_trees.add(self)
        return self._tree

    def first_met(self, points: FloatArray, directions: FloatArray, reach: float) -> IntArray:
        """Triangles (N,) that rays meet first, -1 where none is seen; of one that passes an edge none may be.

        Args:
            points: (N, 3) where they begin.
            directions: (N, 3) unit vectors.
            reach: how far they are followed.
        """
        given = (np.ascontiguousarray(k, np.float64) for k in (points, directions))
        facet, _, _ = self._built.intersect_ray_first(self.vertices, self.triangles, *given, reach)
        return np.asarray(facet).ravel()

    def find(self, points: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
        """Squared distances (N,) of points (N, 3), the triangles (N,) that are closest and the places (N, 3) there."""
        given = np.ascontiguousarray(points, np.float64)
        squares, facet, feet = self._built.squared_distance(self.vertices, self.triangles, given)
        return np.asarray(squares).ravel(), np.asarray(facet).ravel(), np.asarray(feet).reshape(-1, 3)
