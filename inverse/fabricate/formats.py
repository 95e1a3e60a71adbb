"""What `inverse export` writes: a function for each format, and the settings that it takes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from inverse.errors import InputError
from inverse.fabricate import cutting, meshes, rhino
from inverse.fabricate.motion import folding_amount
from inverse.fabricate.thickness import Thickness
from inverse.pattern import B, Design, FloatArray
from inverse.words import did_you_mean


@dataclass(frozen=True)
class Settings:
    """How something is made from a design. What is None is not given.

    Attributes:
        at_degrees: folding amount; the design state if None.
        thickness: of each layer of thick panels, in the design's unit; None for the ideal surface.
        delta_degrees: angle left at foldlines folded as far as they go.
        deltas_degrees: the same for the foldlines that some edges are on, by the two vertices of the edge.
        hinge: thickness of a sheet between the layers.
        density: kilograms in a cubic metre.
        sheet: width and height of what panels are cut from, in the design's unit.
    """

    at_degrees: float | None = None
    thickness: float | None = None
    delta_degrees: float | None = None
    deltas_degrees: tuple[tuple[int, int, float], ...] = ()
    hinge: float | None = None
    density: float | None = None
    sheet: tuple[float, float] | None = None


@dataclass(frozen=True)
class Format:
    """A kind of file.

    Attributes:
        words: what is in it.
        takes: names of the settings that it knows.
        write: makes the content of its files by their names.
    """

    words: str
    takes: tuple[str, ...]
    write: Callable[[Design, Settings], dict[str, bytes]]


def _solid(write: Callable[..., dict[str, bytes]]) -> Callable[[Design, Settings], dict[str, bytes]]:
    def made(design: Design, settings: Settings) -> dict[str, bytes]:
        t = folding_amount(90.0 if settings.at_degrees is None else settings.at_degrees)
        return write(design, t=t, thickness=thickness_of(design, settings))

    return made


def _sheets(design: Design, settings: Settings) -> dict[str, bytes]:
    thickness = thickness_of(design, settings)
    if thickness is None or settings.sheet is None:
        raise InputError("panels are cut from sheets of a size", hint="Give --sheet WIDTH HEIGHT in the design's unit.")
    return cutting.dxf(design, thickness=thickness, sheet=settings.sheet, density=settings.density)


_THICK = ("thickness", "delta_degrees", "deltas_degrees", "hinge")
_SURFACES = {
    "obj": (meshes.obj, "polygons, each facet or layer an object"),
    "ply": (meshes.ply, "polygons, numbered by their facets"),
    "stl": (meshes.stl, "triangles"),
    "glb": (meshes.glb, "glTF in metres, a node for each facet or layer"),
    "3mf": (meshes.threemf, "millimetres, an object for each layer"),
    "3dm": (rhino.threedm, "surfaces or solids on layers, and lines by kind of fold"),
}
#: Of the ideal surface.
SURFACES = {name: Format(words, ("at_degrees",), _solid(write)) for name, (write, words) in _SURFACES.items()}
#: Of thick panels.
PANELS = {
    **{name: Format(words, ("at_degrees", *_THICK), _solid(write)) for name, (write, words) in _SURFACES.items()},
    "dxf": Format("panels nested on sheets, and their list as CSV", (*_THICK, "density", "sheet"), _sheets),
}


def check(name: str, settings: Settings) -> Format:
    """The format of a name that takes all settings that are given.

    Raises:
        InputError: there is none.
    """
    formats = SURFACES if settings.thickness is None else PANELS
    chosen = formats.get(name)
    if chosen is None:
        kind = "format" if settings.thickness is None else "format of thick panels"
        known = sorted({*SURFACES, *PANELS})
        raise InputError(
            f"{name!r} is no {kind}: there are {', '.join(formats)}.{did_you_mean(name, set(known) - {name})}",
            hint="Thick panels are made where --thickness is given." if name in known else None,
        )
    given = [key for key, value in vars(settings).items() if value not in (None, ())]
    strange = [option(key) for key in given if key not in chosen.takes]
    if strange:
        takes = ", ".join(option(key) for key in chosen.takes)
        raise InputError(f"{name}, {chosen.words}, does not take {', '.join(strange)}", hint=f"It takes {takes}.")
    return chosen


def export(design: Design, name: str, settings: Settings) -> dict[str, bytes]:
    """Make files of a format.

    Args:
        design: the design.
        name: of the format.
        settings: how.

    Returns:
        The contents of the files by their names.

    Raises:
        InputError: there is no such format, it does not take a setting, or the design cannot be made so.
    """
    return check(name, settings).write(design, settings)


def option(setting: str) -> str:
    """The option of the command line that gives a setting."""
    words = {"deltas_degrees": "delta-of"}.get(setting, setting.removesuffix("_degrees").replace("_", "-"))
    return f"--{words}"


def thickness_of(design: Design, settings: Settings) -> Thickness | None:
    """The thickness that settings ask for, or None.

    Raises:
        InputError: a value out of its range, or an edge that is not there.
    """
    if settings.thickness is None:
        return None
    delta: float | FloatArray = np.radians(10.0 if settings.delta_degrees is None else settings.delta_degrees)
    if settings.deltas_degrees:
        delta = np.full(len(design.pattern.edges_vertices), delta)
        for a, b, degrees in settings.deltas_degrees:
            delta[_foldline(design, a, b)] = np.radians(degrees)
    return Thickness(settings.thickness, delta, settings.hinge or 0.0)


def _foldline(design: Design, a: int, b: int) -> list[int]:
    """Numbers of all edges of the foldline that the edge a-b is on."""
    pattern = design.pattern
    number = {frozenset(pair): e for e, pair in enumerate(pattern.edges_vertices.tolist())}
    edge = number.get(frozenset((a, b)))
    if edge is None or pattern.edges_type[edge] == B:
        raise InputError(f"there is no foldline between vertices {a} and {b}", hint="Name an edge by its two vertices.")
    for line in pattern.lines:
        edges = [number[frozenset(pair)] for pair in pairwise(line)]
        if edge in edges:
            return edges
    raise AssertionError("every edge that folds is on a line")
