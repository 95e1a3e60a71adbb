"""The verdict on the brief: what a specification asks, measured on the design itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from inverse._types import FloatArray
from inverse.brief import held, shape
from inverse.brief.asked import Asked
from inverse.brief.covering import Coverage, Feet, coverage
from inverse.brief.sheets import Sheet
from inverse.certify import Certificate
from inverse.crossing import triangles_of
from inverse.formulation.formulate import Formulation
from inverse.origami import geometry
from inverse.origami.pattern import Design
from inverse.spec import Loaded, RequireKeys

FIT, FIT_MAX = 0.01, 0.03  # of the design's diagonal: what fitted points may be off where nothing else is required
NEAR = 2 / 3  # of a facet: how far mesh and target may be from each other, corrugations included


@dataclass(frozen=True, eq=False)
class Brief:
    """A design beside its specification.

    Attributes:
        loaded: the specification.
        formulation: what it means; its coordinates are those of the design.
        design: the design.
        certificate: its certificate.
        limits: what of the footprint was limited and measured, as reports tell it.
    """

    loaded: Loaded
    formulation: Formulation
    design: Design
    certificate: Certificate
    limits: Sequence[Mapping[str, Any]] = ()

    @property
    def require(self) -> RequireKeys:
        """What must be come up to."""
        return self.loaded.specification.require

    @cached_property
    def asked(self) -> tuple[Asked, ...]:
        """Every request, in the order in which they are told."""
        return (
            *self._fit(), *self._surface(), *self._covering(), self._slenderness(), self._motion(),
            *held.requests(self.loaded, self.formulation, self.design, self.limits),
        )  # fmt: skip

    @cached_property
    def coverage(self) -> Coverage:
        """What of the target the mesh covers."""
        has_holes = self.design.pattern.n_holes == 0
        return coverage(self._target, self._mesh, NEAR * self._facet, has_holes=has_holes, feet=self._feet)

    @cached_property
    def _target(self) -> Sheet:
        return Sheet(self.formulation.goal.target.nearest)

    @cached_property
    def _mesh(self) -> Sheet:
        return Sheet.of(self.design.vertices_coords, triangles_of(self.design.pattern.faces_vertices)[0])

    @cached_property
    def _feet(self) -> Feet:
        """Of the target what is closest to the samples of the mesh."""
        return self._target.nearest.find(self._mesh.samples.points)

    @cached_property
    def _facet(self) -> float:
        """Largest diameter of a facet of the placed seed: how coarse a mesh was asked for."""
        seed = self.formulation.goal.model.seed
        return float(shape.diameters(seed.pattern, seed.vertices_coords).max())

    @property
    def _unit(self) -> str:
        return self.design.unit

    def _place(self, point: FloatArray) -> str:
        return held.place(point + self.formulation.goal.origin)

    def _fit(self) -> list[Asked]:
        fitting, points = self.formulation.goal.fitting, self.design.vertices_coords
        size, distances = geometry.diagonal(points), fitting.distances(points)
        rms, largest = float(np.sqrt(np.mean(distances**2))), float(distances.max())
        what = {
            "rings": "rings of facets",
            "sections": "middles of facets and of edges along the tube",
            "facets": "middles of facets",
            "vertices": "vertices",
        }.get(fitting.points, "vertices of one layer")
        advice = "Take more facets (pattern.size) or another pattern, or allow it: require.{}"
        return [
            at_most("fit", rms, self.require.fit or FIT * size, self._unit,
                    f"the {what} are {{}} from the target in the mean (rms)", advice.format("fit")),
            at_most("fit_max", largest, self.require.fit_max or FIT_MAX * size, self._unit,
                    "the worst of them is {} from the target", advice.format("fit_max")),
        ]  # fmt: skip

    def _surface(self) -> list[Asked]:
        own, there = self._mesh, self._target
        squares = np.concatenate([self._feet[0], there.nearest.find(own.vertices)[0]])
        off, worst = _largest(np.vstack([own.samples.points, own.vertices]), squares)
        places = np.vstack([there.samples.points, there.vertices[np.unique(there.triangles)]])
        missed, place = _largest(places, own.nearest.find(places)[0])
        return [
            at_most("surface", off, self.require.surface or NEAR * self._facet, self._unit,
                    f"the mesh comes as far as {{}} from the target, near {self._place(worst)}",
                    "Look there in the picture: a spike, or a place that the target does not have; take more facets, "
                    "or allow it: require.surface"),
            at_most("missed", missed, self.require.missed or NEAR * self._facet, self._unit,
                    f"of the target a place is left {{}} from the mesh, near {self._place(place)}",
                    "Take more facets (pattern.size), or a target without what the mesh cannot reach, or allow it: "
                    "require.missed"),
        ]  # fmt: skip

    def _covering(self) -> list[Asked]:
        found, least, most = self.coverage, self.require.coverage, self.require.beyond
        seen = f"{found.seen}: " + "{} of the target's area is covered"
        more = "Raise objectives.coverage, or pattern.start_size; or accept less: require.coverage"
        requests = [at_least("coverage", found.covered, least, "1", seen, more)]
        requests += [
            at_least("coverage", part.covered, least, "1",
                     f"{{}} of the part of the target at {self._place(np.array(part.place))} is covered",
                     "Solve the parts one by one, each as a target of its own")
            for part in found.parts if part.kind == "component"
        ]  # fmt: skip
        requests += [
            at_most("beyond", part.covered, most, "1",
                    f"{{}} of the target's hole at {self._place(np.array(part.place))} is covered",
                    "Leave the hole out of the target, or design the parts around it one by one")
            for part in found.parts if part.kind == "hole"
        ]  # fmt: skip
        area = held.length(found.beyond, self._unit, power=2)
        requests.append(
            at_most("beyond", found.beyond_share, most, "1", f"{{}} of the mesh ({area}) lies beyond the target's rim",
                    "Give a smaller pattern.start_size, or more facets; or accept it: require.beyond")
        )  # fmt: skip
        return requests

    def _slenderness(self) -> Asked:
        found = shape.slenderness(self.design.pattern, self.design.vertices_coords)
        worst = int(np.argmin(found))
        return at_least(
            "slenderness", float(found[worst]), self.require.slenderness, "1",
            f"the most slender facet, {worst}, is {{}} as wide as long",
            "Choose a sector angle nearer to 60, narrower constraints.edge_length and constraints.sector_angle, or a "
            "higher objectives.evenness; or accept it: require.slenderness",
        )  # fmt: skip

    def _motion(self) -> Asked:
        low, high = self.certificate.free_range or (90.0, 90.0)
        asked = self.require.motion
        reached = {
            "developed": low <= 0, "flat-folded": high >= 180, "either": low <= 0 or high >= 180,
            "both": low <= 0 and high >= 180, "any": True,
        }[asked]  # fmt: skip
        wanted = {"developed": 90.0, "flat-folded": 90.0, "either": 90.0, "both": 180.0, "any": 0.0}[asked]
        free = {"developed": 90 - low, "flat-folded": high - 90, "either": max(90 - low, high - 90), "both": high - low,
                "any": high - low}[asked]  # fmt: skip
        first = "; ".join(end.sentence for end in self.certificate.crossings)
        sentence = f"motion: free of crossing facets from t = {low:.4g} to {high:.4g} degrees"
        if first:
            sentence += f" ({first})"
        if reached:
            return Asked("motion", wanted, free, "degrees", met=True, sentence=sentence)
        advice = (
            f"Ask for more with constraints.free_range: [{max(low - 10, 5):.0f}, {min(high + 10, 175):.0f}], or accept "
            "it: require.motion: any"
        )
        return Asked(
            "motion", wanted, free, "degrees", met=False, sentence=f"{sentence}; asked is {asked}", advice=advice
        )


def _largest(points: FloatArray, squares: FloatArray) -> tuple[float, FloatArray]:
    """The largest of squared distances (N,), its root, and which of points (N, 3) has it."""
    distances = np.sqrt(squares)
    worst = int(np.argmax(distances))
    return float(distances[worst]), points[worst]


def at_most(name: str, reached: float, asked: float, unit: str, text: str, advice: str) -> Asked:
    """A request for no more than a limit."""
    return _asked(name, reached, asked, unit, text, advice, met=reached <= asked, bound="at most")


def at_least(name: str, reached: float, asked: float, unit: str, text: str, advice: str) -> Asked:
    """A request for no less than a limit."""
    return _asked(name, reached, asked, unit, text, advice, met=reached >= asked, bound="at least")


def _asked(
    name: str, reached: float, asked: float, unit: str, text: str, advice: str, *, met: bool, bound: str
) -> Asked:
    have, limit = (f"{value:.3g}" if unit == "1" and name == "slenderness" else held.length(value, unit)
                   for value in (reached, asked))  # fmt: skip
    sentence = f"{name}: {text.format(have)}, {bound} {limit} asked"
    return Asked(name, asked, reached, unit, met, sentence, "" if met else advice)
