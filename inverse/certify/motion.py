"""The motion, equations (2)-(5) of the paper, by dual quaternions relative to the design state."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.certify import dual_quaternions as dual
from inverse.certify.certificate import Measured
from inverse.certify.measures import CFL
from inverse.certify.mesh import Mesh

N_STATES = 65  # equispaced over 0..180 degrees: both flat states and the design state are among them
AT_ONCE = 2**15  # facets of all states that are placed together: bounds the memory


@dataclass(frozen=True, eq=False)
class Motion:
    """The motion of a mesh away from its design state.

    Attributes:
        mesh: topology.
        points: (V, 3) vertices of the design state.
        types: (E,) edge types, FL or CFL on every interior edge.
        sine: (E,) sin(rho/2) in the design state.
        cosine: (E,) cos(rho/2) in the design state.
    """

    mesh: Mesh
    points: FloatArray
    types: IntArray
    sine: FloatArray
    cosine: FloatArray

    @cached_property
    def axes(self) -> FloatArray:
        """(6, E): line of every edge, so directed that a valley turns the right facet right-handed."""
        a, b = self.points[self.mesh.edges].transpose(1, 0, 2)
        return dual.screw_axes(a, (a - b) / np.linalg.norm(b - a, axis=1, keepdims=True))

    def hinges(self, theta: FloatArray, edges: IntArray, facets: IntArray) -> FloatArray:
        """Motion across edges, relative to the design state and to the facet from which they are crossed.

        With c = tan(rho/2) and tau = tan(theta), theta = t/2, a fold turned from rho to rho(t) is the dual
        quaternion (1 + c^2 tau) + c (tau - 1) h along its axis h; for a CFL, 1/tau takes the place of tau.
        Multiplied by cos(rho/2)^2 cos(theta) it has no infinities, and the flat states are exact.

        Args:
            theta: (S,) half the folding amount in radians; any value closes a rigid-foldable loop.
            edges: (N,) interior edges.
            facets: (N,) the facet on one side of each, which is left.

        Returns:
            (8, S, N).
        """
        # Rounding of pi/2 must not leave a flat state almost flat.
        at_end = theta == np.pi / 2
        fold, opposite = np.where(at_end, 1.0, np.sin(theta)), np.where(at_end, 0.0, np.cos(theta))
        complementary = self.types[edges] == CFL
        x = np.where(complementary, fold[:, None], opposite[:, None])
        y = np.where(complementary, opposite[:, None], fold[:, None])
        s, c = self.sine[edges], self.cosine[edges]
        size = np.hypot(c * x, s * y)
        # An edge that does not fold at all stays as it is (size 0 only in a flat state of such a design).
        stays = size == 0
        size = np.where(stays, 1.0, size)
        turn = np.where(self.mesh.sides[edges, 0] == facets, s * c, -s * c) * (y - x) / size
        return dual.rotations(np.where(stays, 1.0, (c * c * x + s * s * y) / size), turn, self.axes[:, edges])

    def placements(self, theta: FloatArray) -> FloatArray:
        """Motion of every facet from its place in the design state, facet 0 held, (8, S, F)."""
        walk = self.mesh.walk
        steps = dual.factors(self.hinges(theta, walk.edges, walk.facets[walk.parents]))
        placed = np.zeros((8, len(theta), len(walk.facets)))
        placed[0, :, 0] = 1.0
        for first, last in pairwise(walk.levels):
            before = placed.take(walk.parents[first - 1 : last - 1], axis=2)
            placed[:, :, first:last] = dual.times(before, steps[..., first - 1 : last - 1])
        return placed.take(np.argsort(walk.facets), axis=2)

    def vertices(self, theta: FloatArray) -> FloatArray:
        """Vertices at the given states, (S, V, 3), each as the first facet that has it says."""
        return self._vertices(self.placements(theta))

    def _vertices(self, placed: FloatArray) -> FloatArray:
        owner = np.zeros(len(self.points), np.int64)
        owner[self.mesh.tail[::-1]] = self.mesh.facet[::-1]
        found = dual.move(placed.take(owner, axis=2), self.points.T[:, None, :])
        return np.ascontiguousarray(np.moveaxis(found, 0, -1))

    def gap(self) -> Measured:
        """Largest distance by which two facets that share an edge disagree, in the unit of the points.

        Every edge that the facet tree does not cross is tested in every state, at all vertices of both
        facets: a wrong angle about the edge counts too.
        """
        return self._sampled[0]

    @property
    def sampled(self) -> FloatArray:
        """(N_STATES, V, 3): vertices in the states that the gap is measured in, as of :meth:`vertices`."""
        return self._sampled[1]

    @cached_property
    def _sampled(self) -> tuple[Measured, FloatArray]:
        """The gap and the vertices in all states, each facet placed once for both."""
        edges = self.mesh.off_tree
        worst, where = (-1.0, "") if len(edges) else (0.0, "no closed chain of facets")
        states, some = np.linspace(0.0, np.pi / 2, N_STATES), max(AT_ONCE // len(self.mesh.facets), 1)
        vertices, is_defined = [], True
        for theta in np.array_split(states, range(some, N_STATES, some)):
            placed = self.placements(theta)
            vertices.append(self._vertices(placed))
            gap = self._disagreement(theta, placed, edges)
            is_defined = is_defined and bool(np.isfinite(gap).all())
            if is_defined and gap.max(initial=-1.0) > worst:
                state, edge = np.unravel_index(gap.argmax(), gap.shape)
                worst = float(gap.max())
                where = f"{self.mesh.name(edges[edge])} at t = {np.degrees(2 * theta[state]):.1f} degrees"
        measured: Measured = (worst, where) if is_defined else (None, "the motion is not defined")
        return measured, np.concatenate(vertices)

    def _disagreement(self, theta: FloatArray, placed: FloatArray, edges: IntArray) -> FloatArray:
        """(S, N) for N edges off the tree, facets placed (8, S, F)."""
        square = np.zeros((len(theta), len(edges)))
        sides = self.mesh.sides[edges]
        n_sides = np.diff(np.append(self.mesh.starts, len(self.mesh.tail)))
        for here, there in (sides.T, sides.T[::-1]):
            # Where the facet beyond the edge is, and where it should be, seen from this side.
            found = dual.matrices(placed.take(there, axis=2))
            expected = dual.matrices(dual.multiply(placed.take(here, axis=2), self.hinges(theta, edges, here)))
            turn, shift = (a - b for a, b in zip(found, expected, strict=True))
            for k in range(int(n_sides[there].max(initial=0))):
                corner = self.mesh.tail[self.mesh.starts[there] + k % n_sides[there]]
                apart = dual.placed(turn, shift, self.points[corner].T[:, None, :])
                square = np.maximum(square, apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2])
        return np.sqrt(square)
