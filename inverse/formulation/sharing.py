"""Vertices that several anchors name: each is held where their places meet, with independent equations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.formulation.places import Path, Place, Spot, foot, meet
from inverse.model import DesignModel
from inverse.spec import Anchor, Loaded
from inverse.spec.yaml_data import KeyPath

BEND = np.radians(30)  # a polyline that turns by more has a corner, into which the corner of the mesh goes


@dataclass(eq=False)
class Shared:
    """Who holds each vertex, and where.

    Attributes:
        at: place of every vertex that is held.
        by: numbers of the anchors that hold it there, ascending.
        notes: sentences about vertices that several anchors name.
    """

    at: dict[int, Place] = field(default_factory=dict)
    by: dict[int, tuple[int, ...]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def shared(
    loaded: Loaded, model: DesignModel, places: Sequence[Place], lines: Sequence[Sequence[IntArray]], tolerance: float
) -> Shared:
    """Share the vertices out among the anchors.

    Where the places of two anchors meet, a vertex that both name is held there. Where they do not, an anchor that
    names the vertex by its number goes before one that names a side, and else the first before the others.

    Args:
        loaded: the specification.
        model: the model.
        places: of every anchor.
        lines: of every anchor the vertices that it names, line by line.
        tolerance: how far apart places may be and still meet.

    Raises:
        InputError: vertices share a point, two anchors name a vertex by its number but do not meet, or freedoms run
            out.
    """
    anchors = loaded.specification.constraints.anchors
    found, freedoms = Shared(), model.pattern.degrees_of_freedom
    alone: list[str] = []
    total = 0
    for k, place in enumerate(places):
        before, named = total, {int(v): line for line in lines[k] for v in line}
        if isinstance(place, Spot) and len(named) > 1:
            raise _refused(
                loaded, k, f"{len(named)} vertices are anchored to one point, where they would coincide",
                "Anchor a single vertex to a point, or a side to a polyline.",
            )  # fmt: skip
        for v in named:
            owners = found.by.get(v, ())
            total -= found.at[v].rows if owners else 0
            common: Place | None = place
            if owners:
                common = _common(model, v, (found.at[v], place), (_line_of(lines[owners[0]], v), named[v]), tolerance)
            if common is not None:
                found.at[v], found.by[v] = common, (*owners, k)
            else:
                keeps = _keeper(loaded, model, found, k, v, place)
                alone.append(_apart(anchors, owners, k, v, keeps, _gap(found.at[v], place, model, v), model.seed.unit))
                if keeps == k:
                    found.at[v], found.by[v] = place, (k,)
            total += found.at[v].rows
        _check_spots(loaded, k, found, list(named), tolerance)
        if total > freedoms:
            raise _refused(
                loaded, k,
                f"this anchor takes {total - before} freedoms, but of the pattern's {freedoms} only "
                f"{freedoms - before} are left",
                "Anchor fewer vertices, for example with `every: 2`.", at="",
            )  # fmt: skip
    found.notes = (*_meetings(found), *alone)
    return found


def _refused(loaded: Loaded, k: int, message: str, hint: str | None = None, at: str = "to") -> Exception:
    path: KeyPath = ("constraints", "anchors", k)
    return loaded.source.error((*path, at) if at else path, message, hint)


def _line_of(lines: Sequence[IntArray], vertex: int) -> IntArray:
    return next(line for line in lines if vertex in line)


def _common(
    model: DesignModel, v: int, places: tuple[Place, Place], lines: tuple[IntArray, IntArray], tolerance: float
) -> Place | None:
    """Where a vertex is held by two anchors."""
    points = model.seed.vertices_coords
    a, b = places
    if isinstance(a, Path) and isinstance(b, Path):
        # Of one polygon around a courtyard each side of the mesh has its own segment, and the corner is between them.
        first, second = (p.piece(points[_beside(line, v)]) for p, line in zip((a, b), lines, strict=True))
        d, e = (np.diff(piece.points, axis=0)[0] for piece in (first, second))
        if abs(d @ e) < np.cos(BEND) * np.linalg.norm(d) * np.linalg.norm(e):
            corner = meet(first, second, points[v], tolerance)
            if corner is not None:
                return corner
    return meet(a, b, points[v], tolerance)


def _beside(line: IntArray, vertex: int) -> int:
    """The next vertex along a line to one at its end, or the vertex itself."""
    if len(line) < 2 or vertex not in (line[0], line[-1]):
        return vertex
    return int(line[1] if line[0] == vertex else line[-2])


def _keeper(loaded: Loaded, model: DesignModel, found: Shared, k: int, v: int, place: Place) -> int:
    """Which anchor keeps a vertex where places do not meet."""
    anchors = loaded.specification.constraints.anchors
    other = found.by[v][0]
    by_number = [one for one in (*found.by[v], k) if anchors[one].vertices is not None]
    if k in by_number and len(by_number) > 1:
        gap = _gap(found.at[v], place, model, v)
        raise _refused(
            loaded, k, f"vertex {v} cannot be here and where {name_of(anchors, by_number[0])} holds it, "
            f"{gap:.3g}{_unit(model.seed.unit)} away", "Leave the vertex out of one of the two.",
        )  # fmt: skip
    return k if k in by_number else other


def _gap(a: Place, b: Place, model: DesignModel, v: int) -> float:
    """About how far apart two places are near to a vertex, by projecting to and fro."""
    point: FloatArray = model.seed.vertices_coords[v]
    for _ in range(20):
        here = foot(a, point)
        point = foot(b, here)
    return float(np.linalg.norm(point - here))


def _check_spots(loaded: Loaded, k: int, found: Shared, vertices: list[int], tolerance: float) -> None:
    for v in reversed(vertices):
        place = found.at[v]
        if not isinstance(place, Spot):
            continue
        for other, there in found.at.items():
            if other != v and isinstance(there, Spot) and np.linalg.norm(place.at - there.at) <= tolerance:
                raise _refused(loaded, k, f"vertex {v} is anchored to the point where vertex {other} is")


def name_of(anchors: Sequence[Anchor], k: int) -> str:
    """What an anchor is called in sentences."""
    side = anchors[k].side
    return f"anchor {k}" if side is None else f"anchor {k} (side {side})"


def _meetings(found: Shared) -> list[str]:
    vertices = [str(v) for v in sorted(found.by) if len(found.by[v]) > 1]
    if not vertices:
        return []
    *others, last = vertices
    subject = f"Vertices {', '.join(others)} and {last}" if others else f"Vertex {last}"
    are = "are held where the places of these" if others else "is held where their places"
    return [f"{subject}, which several anchors name, {are} meet."]


def _apart(
    anchors: Sequence[Anchor], owners: tuple[int, ...], k: int, v: int, keeps: int, gap: float, unit: str
) -> str:
    loses = owners[0] if keeps == k else k
    return (
        f"Vertex {v} is held by {name_of(anchors, keeps)} and not by {name_of(anchors, loses)}: their places are "
        f"{gap:.3g}{_unit(unit)} apart there."
    )


def _unit(unit: str) -> str:
    return "" if unit == "unit" else f" {unit}"
