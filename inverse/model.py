"""The design as an optimization model in the language of geometry: variables, scales, terms."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.origami import geometry
from inverse.origami.pattern import Design, Pattern
from inverse.origami.trimming import without


@dataclass(frozen=True, eq=False)
class DesignModel:
    """Vertex coordinates of a seed as variables.

    Variables are dimensionless: coordinates relative to the seed's centre, divided by its mean edge length, so
    that the same design in millimetres and in kilometres is the same problem.

    Attributes:
        seed: the placed seed; lengths and signs of folds are bounded relative to it.
        left_out: (k,) int, facets over holes of the target, with which the mesh is solved but which the design lacks:
            what is left moves as it does with them.
        trimmed: whether the seed is a grid without the facets outside its target's outline.
    """

    seed: Design
    left_out: IntArray = field(default_factory=lambda: np.empty(0, np.int64))
    trimmed: bool = False

    @property
    def pattern(self) -> Pattern:
        """Topology and line types."""
        return self.seed.pattern

    @cached_property
    def scale(self) -> float:
        """Mean edge length of the seed, in the seed's unit."""
        return float(geometry.edge_lengths(self.pattern, self.seed.vertices_coords).mean())

    @cached_property
    def refinement(self) -> float:
        """Edges per sixteenth of the model: 1 for 16 x 16 facets, 4 for 64 x 64.

        Objectives measure lengths in sixteenths of the model, not in edges, so that the same weights mean the same
        design at every number of facets.
        """
        return float(np.sqrt(len(self.pattern.faces_vertices)) / 16)

    @cached_property
    def centre(self) -> FloatArray:
        """(3,) mean of the seed's vertices."""
        return np.asarray(self.seed.vertices_coords.mean(axis=0))

    @cached_property
    def seed_points(self) -> FloatArray:
        """(V, 3) dimensionless vertices of the seed."""
        return self.to_dimensionless(self.seed.vertices_coords)

    def to_dimensionless(self, points: FloatArray) -> FloatArray:
        """Points (N, 3) in the seed's unit as dimensionless ones."""
        return np.asarray((points - self.centre) / self.scale)

    def to_lengths(self, points: FloatArray) -> FloatArray:
        """Dimensionless points (N, 3) in the seed's unit."""
        return np.asarray(points * self.scale + self.centre)

    @property
    def n_variables(self) -> int:
        """Length of the vector of variables."""
        return 3 * self.pattern.n_vertices

    def points(self, variables: FloatArray) -> FloatArray:
        """Vertices (V, 3), in the seed's unit, that a vector of variables stands for."""
        return self.to_lengths(variables[: 3 * self.pattern.n_vertices].reshape(-1, 3))

    def whole(self, variables: FloatArray) -> Design:
        """The mesh that a vector of variables stands for, with all facets."""
        return self.seed.moved_to(self.points(variables))

    def design(self, variables: FloatArray) -> Design:
        """The design that a vector of variables stands for, without the facets that are left out."""
        if not len(self.left_out):
            return self.whole(variables)
        pattern, used = self.rest
        return Design(pattern, self.points(variables)[used], self.seed.unit, self.seed.name)

    @cached_property
    def rest(self) -> tuple[Pattern, IntArray]:
        """The design's pattern, and for each of its vertices (V,) the number it has in the model's."""
        return without(self.pattern, self.left_out)

    @property
    def kept_vertices(self) -> IntArray:
        """Numbers (V,) in the model of the design's vertices."""
        return self.rest[1] if len(self.left_out) else np.arange(self.pattern.n_vertices)

    @staticmethod
    def variables_of(vertices: IntArray) -> IntArray:
        """Places, (N, 3k), of the coordinates of vertices (N, k) in the vector of variables."""
        places = 3 * vertices[:, :, None] + np.arange(3)
        return places.reshape(len(vertices), 3 * vertices.shape[1])
