"""A surface with what is asked of it more than once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from inverse._types import FloatArray, IntArray
from inverse.brief.samples import Samples, spread
from inverse.surfaces.edges import edges_of
from inverse.surfaces.nearest import Nearest
from inverse.surfaces.sheet import connected


@dataclass(frozen=True, eq=False)
class Sheet:
    """A surface of triangles.

    Attributes:
        nearest: its triangles, for closest points.
    """

    nearest: Nearest

    @classmethod
    def of(cls, vertices: FloatArray, triangles: IntArray) -> Sheet:
        """The surface of triangles (T, 3) of vertices (V, 3)."""
        return cls(Nearest(vertices, triangles))

    @property
    def vertices(self) -> FloatArray:
        """(V, 3)."""
        return self.nearest.vertices

    @property
    def triangles(self) -> IntArray:
        """(T, 3) int."""
        return self.nearest.triangles

    @cached_property
    def samples(self) -> Samples:
        """Points spread over it."""
        return spread(self.vertices, self.triangles)

    @cached_property
    def is_border(self) -> NDArray[np.bool_]:
        """(T, 3): which sides of the triangles are on the border."""
        edge, count = edges_of(self.triangles)
        return np.asarray(count[edge] == 1)

    @cached_property
    def component(self) -> IntArray:
        """Number of the component (V,) that each vertex belongs to; triangles that share a vertex are of one."""
        return connected(self.triangles[:, :2].T.ravel(), self.triangles[:, 1:].T.ravel(), len(self.vertices))
