"""What of a task contradicts itself, found before anything is solved.

Every rule here is a proof: necessary conditions that are linear, or intervals, or lengths of paths. What none of them
refuses may still have no solution.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.csgraph import dijkstra

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.formulation.apart import Flat, HalfSpaces, Place, largest_distance, least_distance, place_of
from inverse.model import DesignModel
from inverse.origami import geometry
from inverse.spec import Anchor, KeepOut, Loaded

MARGIN = 1e-6  # mean edges, and parts of a length: what is missed by less may be rounding

Key = tuple[str | int, ...]


def check(loaded: Loaded, model: DesignModel, held: Mapping[int, IntArray], origin: FloatArray) -> None:
    """Refuse a task that has no solution, where that can be proven at once.

    Args:
        loaded: the specification.
        model: the model.
        held: vertices (N,) of every anchor, by its number in the specification.
        origin: (3,) point of the specification's coordinates that the model's are relative to.

    Raises:
        InputError: with the places of what contradicts each other.
    """
    task = _Task(loaded, model, held, origin)
    task.check_mechanism()
    task.check_sector_angles()
    task.check_footprint()
    task.check_ends()
    task.check_keep_outs()
    task.check_anchors_in_keep_outs()
    task.check_anchors_apart()
    task.check_anchors_together()


@dataclass(frozen=True, eq=False)
class _Task:
    """A task in mean edges about the model's centre, as :class:`DesignModel` has it."""

    loaded: Loaded
    model: DesignModel
    held: Mapping[int, IntArray]
    origin: FloatArray

    def check_mechanism(self) -> None:
        """Without an interior vertex folds are independent: only a single one is a motion of one freedom."""
        pattern = self.model.pattern
        folds = len(pattern.interior_edges)
        if len(pattern.interior_vertices) or folds == 1 or pattern.n_holes:
            return
        m, n = pattern.grid or (0, 0)
        what = f"a grid of {m} x {n} facets" if pattern.grid else f"a pattern of {len(pattern.faces_vertices)} facets"
        why = "it has no folds" if folds == 0 else f"its {folds} folds move independently of each other"
        raise self.loaded.source.error(
            ("pattern", "size") if pattern.grid else ("pattern",),
            f"{what} has no interior vertex: {why}, so that it is no mechanism with one degree of freedom",
            "Take two or more facets along u and along v.",
        )

    def check_sector_angles(self) -> None:
        """The angles of a facet of s sides have the mean 180 (s - 2) / s degrees."""
        low, high = self.loaded.specification.constraints.sector_angle
        for sides in self.model.pattern.faces_by_sides:
            mean = 180 * (sides - 2) / sides
            if not low <= mean <= high:
                raise self.loaded.source.error(
                    ("constraints", "sector_angle"),
                    f"the angles of a facet with {sides} sides are {mean:g} degrees in the mean, which is not between "
                    f"{low:g} and {high:g}",
                    f"Give limits with {mean:g} between them.",
                )

    def check_footprint(self) -> None:
        """Facets are rigid: in every state the longest edge and the widest facet have to fit into the box."""
        limits = self.loaded.specification.constraints.footprint
        if limits is None:
            return
        flat = isinstance(limits.state, str)
        given = [np.inf if side is None else side for side in (limits.length, limits.width, limits.height)]
        sides = np.minimum.accumulate(given[:2] if flat else given)
        edge, width = (self._said(float(sizes.max())) for sizes in (self._edges, self._widths))
        key: Key = ("constraints", "footprint")
        shortest, diagonal = float(self._edges.max() * self.model.scale), float(np.linalg.norm(sides))
        if shortest > diagonal * (1 + MARGIN):
            a, b = self.model.pattern.edges_vertices[int(np.argmax(self._edges))].tolist()
            raise self.loaded.source.error(
                key,
                f"edge {a}-{b} is at least {edge} long, but the box's diagonal is {self._length(diagonal)}",
                "Take more facets, a lower limit in constraints.edge_length, or a larger box.",
            )
        if flat and float(self._widths.max() * self.model.scale) > sides[-1] * (1 + MARGIN):
            raise self.loaded.source.error(
                key,
                f"facet {int(np.argmax(self._widths))} is at least {width} wide, but the box {self._length(sides[-1])}",
                "Take more facets, a lower limit in constraints.edge_length, or a larger box.",
            )

    def check_ends(self) -> None:
        """Both ends of a tube on one curve would lie in one another; two curves can be named by two anchors."""
        for k, anchor in enumerate(self.loaded.specification.constraints.anchors):
            if anchor.side == "ends" and anchor.to.plane is None:
                curve = next(name for name in anchor.to.one_of if getattr(anchor.to, name) is not None)
                raise self.loaded.source.error(
                    ("constraints", "anchors", k, "to"),
                    f"both ends of the tube would be held on one {curve}",
                    "Hold each end by an anchor of its own: side v0 and side v1.",
                )

    def check_keep_outs(self) -> None:
        """There has to be room between the keep-outs, for a facet that is folded as well as for a point."""
        missing, weights = self._spaces.missing()
        if missing > MARGIN:
            culprits = np.flatnonzero(weights > MARGIN * weights.max()).tolist()
            last, others = culprits[-1], culprits[:-1]
            raise self.loaded.source.error(
                ("constraints", "keep_out", last),
                f"the keep-outs leave no room: no point {self._meets(last, 'this one')} and "
                + " and ".join(self._meets(k, self._place("keep_out", k)) for k in others),
                "Leave one of them out, or move it.",
            )
        normals, offsets = self._spaces.normals, self._spaces.offsets
        if not len(self.model.pattern.interior_edges):
            return
        for k in range(len(offsets)):
            for i in range(k):
                if normals[k] @ normals[i] > -1 + 1e-12:
                    continue
                gap = -float(offsets[i] + offsets[k])
                if gap < self._thickness * (1 - MARGIN):
                    raise self.loaded.source.error(
                        ("constraints", "keep_out", k),
                        f"between this keep-out and {self._place('keep_out', i)} there are {self._said(gap)}, but with "
                        f"these limits of folds and edges the mesh is at least {self._said(self._thickness)} thick",
                        "Move one of them, take more facets, or loosen constraints.fold_angle.",
                    )

    def check_anchors_in_keep_outs(self) -> None:
        """Every anchor's place has to reach into the room that the keep-outs leave."""
        for k, place in self._places.items():
            if place.missing(self._spaces) <= MARGIN:
                continue
            alone = [i for i in range(len(self._spaces.offsets)) if place.missing(self._spaces.only(i)) > MARGIN]
            if alone:
                missing = place.missing(self._spaces.only(alone[0]))
                what = f"{self._said(missing)} or more within {self._place('keep_out', alone[0])}"
            else:
                what = "nowhere outside of all keep-outs"
            raise self.loaded.source.error(
                ("constraints", "anchors", k, "to"), f"this anchor's place is {what}", "Move one of them."
            )

    def check_anchors_apart(self) -> None:
        """No two vertices can be farther apart than the longest that the edges between them may be."""
        _, high = self.loaded.specification.constraints.edge_length
        a, b = self.model.pattern.edges_vertices.T
        n = self.model.pattern.n_vertices
        graph = sparse.csr_matrix((high * self._seed_edges, (a, b)), (n, n))
        numbers = list(self._places)
        for k in numbers[:-1]:
            reach, _, sources = dijkstra(
                graph, directed=False, indices=self.held[k], min_only=True, return_predecessors=True
            )
            for other in numbers[numbers.index(k) + 1 :]:
                apart = least_distance(self._places[k], self._places[other])
                w = int(self.held[other][np.argmin(reach[self.held[other]])])
                if apart <= reach[w] * (1 + MARGIN) + MARGIN:
                    continue
                v = int(sources[w])
                where = self._place("anchors", k)
                raise self._refused(
                    other,
                    f"vertices {v} ({where}) and {w} are held {self._said(apart)} or more apart, but the edges between "
                    f"them are {self._said(reach[w])} long at most",
                    "Move the anchors together, take a larger pattern, or raise the limit in constraints.edge_length.",
                )

    def check_anchors_together(self) -> None:
        """The ends of an edge cannot be nearer to each other than it may be short."""
        anchor = np.full(self.model.pattern.n_vertices, -1)
        for k in self._places:
            if not isinstance(self._places[k], Flat):
                anchor[self.held[k]] = k
        ends = self.model.pattern.edges_vertices
        held = np.flatnonzero((anchor[ends] >= 0).all(axis=1))
        for k, other in np.unique(np.sort(anchor[ends[held]], axis=1), axis=0).tolist():
            own = held[(np.sort(anchor[ends[held]], axis=1) == (k, other)).all(axis=1)]
            edge = int(own[np.argmax(self._edges[own])])
            room = largest_distance(self._places[k], self._places[other])
            if self._edges[edge] > room * (1 + MARGIN) + MARGIN:
                a, b = ends[edge].tolist()
                raise self._refused(
                    other,
                    f"vertices {a} and {b} are held {self._said(room)} or less apart, but the edge between them is "
                    f"{self._said(float(self._edges[edge]))} long at least",
                    "Move the anchors apart, hold fewer vertices (`every: 2`), or lower the limit in "
                    "constraints.edge_length.",
                )

    @cached_property
    def _places(self) -> dict[int, Place]:
        """Where the vertices of every anchor are held, by its number."""
        anchors: tuple[Anchor, ...] = self.loaded.specification.constraints.anchors
        origin, scale = self.origin + self.model.centre, np.array([self.model.scale])
        return {k: place_of(anchors[k].to, scale, origin) for k in sorted(self.held)}

    @cached_property
    def _spaces(self) -> HalfSpaces:
        """Where the keep-outs let the design be."""
        normals, offsets = [], []
        for keep_out in self._keep_outs:
            if keep_out.plane is not None:
                point, normal = np.array(keep_out.plane.point), np.array(keep_out.plane.normal)
            else:
                z, sign = (keep_out.below, 1.0) if keep_out.below is not None else (keep_out.above, -1.0)
                point, normal = np.array([0.0, 0.0, z]), np.array([0.0, 0.0, sign])
            normals.append(normal / np.linalg.norm(normal))
            offsets.append(float(normals[-1] @ self.model.to_dimensionless((point - self.origin)[None])[0]))
        return HalfSpaces(np.array(normals).reshape(-1, 3), np.array(offsets))

    @property
    def _keep_outs(self) -> tuple[KeepOut, ...]:
        return self.loaded.specification.constraints.keep_out

    @cached_property
    def _seed_edges(self) -> FloatArray:
        """(E,) lengths of the seed's edges."""
        return geometry.edge_lengths(self.model.pattern, self.model.seed_points)

    @cached_property
    def _edges(self) -> FloatArray:
        """(E,) how long every edge is at least."""
        return np.asarray(self.loaded.specification.constraints.edge_length[0] * self._seed_edges)

    @cached_property
    def _widths(self) -> FloatArray:
        """(F,) how wide every facet is at least, in the direction in which it is narrowest.

        It contains the triangle of any corner, which is narrowest at one end of the limits of its angle.
        """
        pattern = self.model.pattern
        edge = np.full(len(pattern.faces_vertices), 0.0)
        lengths = {key: float(self._edges[e]) for key, e in pattern.edge_between.items()}
        limits = np.radians(self.loaded.specification.constraints.sector_angle)
        facet, before, corner, after = pattern.corners.T
        a = np.array([lengths[frozenset(pair)] for pair in zip(corner.tolist(), before.tolist(), strict=True)])
        b = np.array([lengths[frozenset(pair)] for pair in zip(corner.tolist(), after.tolist(), strict=True)])
        widths = np.full(len(a), np.inf)
        for angle in limits.tolist():
            c = np.sqrt(np.maximum(a**2 + b**2 - 2 * a * b * np.cos(angle), 0.0))
            widths = np.minimum(widths, a * b * np.sin(angle) / np.maximum(np.maximum(a, b), c))
        np.maximum.at(edge, facet, widths)
        return edge

    @cached_property
    def _thickness(self) -> float:
        """How thick the mesh is at least, in whatever direction.

        Of two facets with a fold between them one is tilted against any plane by half the fold, or half of what the
        fold leaves to 180 degrees.
        """
        low, high = self.loaded.specification.constraints.fold_angle
        tilt = np.radians(min(low, 180 - high)) / 2
        pattern = self.model.pattern
        pairs = self._widths[pattern.edges_faces[pattern.interior_edges]]
        return float(pairs.min(axis=1).max() * np.sin(tilt))

    def _refused(self, k: int, message: str, hint: str) -> InputError:
        return self.loaded.source.error(("constraints", "anchors", k), message, hint)

    def _meets(self, k: int, name: str) -> str:
        """What it is to be where keep-out k, which is called so, lets the design be."""
        keep_out, unit = self._keep_outs[k], self._unit
        if keep_out.plane is not None:
            return f"meets {name}"
        side = f"above {keep_out.below:g}" if keep_out.below is not None else f"below {keep_out.above:g}"
        return f"is {side}{unit} ({name})"

    def _place(self, key: str, k: int) -> str:
        return self.loaded.source.place(("constraints", key, k))

    def _said(self, edges: float) -> str:
        """A length in mean edges, in the file's unit."""
        return self._length(edges * self.model.scale)

    def _length(self, length: float) -> str:
        return f"{length:.3g}{self._unit}"

    @property
    def _unit(self) -> str:
        unit = self.loaded.specification.units
        return "" if unit == "unit" else f" {unit}"
