"""What must hold to the letter, in lengths: anchors, keep-outs, limits of the footprint; and how lengths are told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from inverse._types import FloatArray
from inverse.brief.asked import Asked
from inverse.formulation.formulate import Formulation
from inverse.origami import geometry
from inverse.origami.pattern import Design
from inverse.spec import Loaded, PlaceKeys

EXACT = 1e-6  # of the design's diagonal: nearer than anybody builds


def length(value: float, unit: str, power: int = 1) -> str:
    """A length, an area (power 2) or, of unit ``1``, a share, for people."""
    if unit == "1":
        return f"{value:.1%}"
    if unit == "unit":
        return f"{value:.3g}"
    return f"{value:.3g} {unit}{'' if power == 1 else power}"


def place(point: FloatArray) -> str:
    """A point (3,) for people, with as many digits as show where it is."""
    return f"({', '.join(f'{k:.6g}' for k in np.round(point, 6) + 0.0)})"


def requests(
    loaded: Loaded, formulation: Formulation, design: Design, limits: Sequence[Mapping[str, Any]]
) -> list[Asked]:
    """What a specification holds exactly, measured on a design.

    Args:
        loaded: the specification.
        formulation: what it means.
        design: the design, in the formulation's coordinates.
        limits: what of the footprint was limited and measured, as reports tell it.
    """
    allowed = EXACT * geometry.diagonal(design.vertices_coords)
    return [
        *_anchors(loaded, formulation, design, allowed),
        *_walls(formulation, design, allowed),
        *_keep_outs(loaded, formulation, design, allowed),
        *_footprint(design, limits),
    ]


def _anchors(loaded: Loaded, formulation: Formulation, design: Design, allowed: float) -> list[Asked]:
    origin, points, model = formulation.goal.origin, design.vertices_coords, formulation.goal.model
    found = []
    asked = loaded.specification.constraints.anchors
    for k, (anchor, vertices) in enumerate(zip(asked, formulation.anchored.held, strict=True)):
        if not len(vertices):
            continue  # others hold all that it names; the notes say so
        off = distances(points[np.searchsorted(model.kept_vertices, vertices)] + origin, anchor.to)
        worst = int(np.argmax(off))
        found.append(
            _exact(f"anchors[{k}]", float(off[worst]), allowed, design.unit,
                   f"vertex {vertices[worst]} is {{}} from its place", "Anchor fewer vertices, or look "
                   "whether they can reach their places at all")
        )  # fmt: skip
    return found


def _walls(formulation: Formulation, design: Design, allowed: float) -> list[Asked]:
    found, kept = [], formulation.goal.model.kept_vertices
    for wall in formulation.anchored.walls:
        vertices = np.intersect1d(wall.vertices, kept)
        depth = -wall.plane.heights(design.vertices_coords[np.searchsorted(kept, vertices)])
        worst = int(np.argmax(depth))
        found.append(
            _exact(wall.name.replace("_", "[", 1) + "]", max(float(depth[worst]), 0.0), allowed, design.unit,
                   f"vertex {vertices[worst]} is {{}} behind the wall of an anchor",
                   "Move the target, or write `within: false` at that anchor")
        )  # fmt: skip
    return found


def distances(points: FloatArray, to: PlaceKeys) -> FloatArray:
    """Distances (N,) of points (N, 3) from an anchor's place, both in the coordinates of the specification."""
    if to.point is not None:
        return np.asarray(np.linalg.norm(points - np.array(to.point), axis=1))
    if to.plane is not None:
        normal = geometry.unit(np.array(to.plane.normal))
        return np.asarray(np.abs((points - np.array(to.plane.point)) @ normal))
    if to.circle is not None:
        normal = geometry.unit(np.array(to.circle.normal))
        offset = points - np.array(to.circle.center)
        height = offset @ normal
        across = np.linalg.norm(offset - height[:, None] * normal, axis=1)
        return np.asarray(np.hypot(height, across - to.circle.radius))
    line = np.array(to.polyline if to.polyline is not None else [*(to.polygon or ()), (to.polygon or ())[0]])
    a, b = line[:-1], line[1:]
    along = np.einsum("nsk,sk->ns", points[:, None] - a, b - a) / np.einsum("sk,sk->s", b - a, b - a)
    feet = a + np.clip(along, 0, 1)[..., None] * (b - a)
    return np.asarray(np.linalg.norm(points[:, None] - feet, axis=2).min(axis=1))


def _keep_outs(loaded: Loaded, formulation: Formulation, design: Design, allowed: float) -> list[Asked]:
    points = design.vertices_coords + formulation.goal.origin
    found = []
    for k, one in enumerate(loaded.specification.constraints.keep_out):
        if one.plane is not None:
            depth = (np.array(one.plane.point) - points) @ geometry.unit(np.array(one.plane.normal))
            way = "behind the plane"
        elif one.below is not None:
            depth, way = one.below - points[:, 2], "too low"
        else:
            depth, way = points[:, 2] - (one.above or 0.0), "too high"
        worst = int(np.argmax(depth))
        found.append(
            _exact(f"keep_out[{k}]", max(float(depth[worst]), 0.0), allowed, design.unit,
                   f"vertex {worst} is {{}} {way}", "Move the target, or loosen the keep-out")
        )  # fmt: skip
    return found


def _footprint(design: Design, limits: Sequence[Mapping[str, Any]]) -> list[Asked]:
    found = []
    for one in limits:
        power = 2 if one["measure"] == "area" else 1
        have, most = (length(one[key], design.unit, power) for key in ("value", "limit"))
        met = one["value"] <= one["limit"] * (1 + EXACT)
        sentence = f"footprint: the {one['state']} {one['measure']} is {have}, at most {most} asked"
        advice = "" if met else "Allow it more: constraints.footprint"
        name = f"footprint.{one['measure']}"
        found.append(Asked(name, one["limit"], one["value"], design.unit, met, sentence, advice))
    return found


def _exact(name: str, off: float, allowed: float, unit: str, text: str, advice: str) -> Asked:
    met = off <= allowed
    sentence = f"{name}: held" if met else f"{name}: {text.format(length(off, unit))}"
    return Asked(name, 0.0, off, unit, met, sentence, "" if met else advice)
