"""What `inverse export` writes: a function for each format, and the settings that it takes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from inverse._types import FloatArray
from inverse.errors import InputError
from inverse.fabricate import meshes, rhino
from inverse.fabricate.cut.crease_plan import crease_plan, layers_plan
from inverse.fabricate.cut.dashes import perforated
from inverse.fabricate.cut.dxf import crease_dxf
from inverse.fabricate.cut.fold import crease_fold
from inverse.fabricate.cut.labels import LARGEST
from inverse.fabricate.cut.pages import fitting_share, laid_out
from inverse.fabricate.cut.pdf import pdf
from inverse.fabricate.cut.plan import Plan
from inverse.fabricate.cut.svg import svg
from inverse.fabricate.film.motion import folding_amount
from inverse.fabricate.panels import cutting
from inverse.fabricate.panels.thickness import Thickness
from inverse.fabricate.units import ratio_below
from inverse.origami.pattern import B, Design
from inverse.words import did_you_mean, printable

PAPER = "A4"


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
        scale: of a crease pattern, 1 for full size.
        dash: length in mm of the cuts that perforate what is folded.
        gap: least length in mm between them.
        flaps: depth in mm of flaps along seams.
        layers: layers are drawn where they lie instead of being cut apart, side by side (apart) or stacked.
        paper: of the pages.
    """

    at_degrees: float | None = None
    thickness: float | None = None
    delta_degrees: float | None = None
    deltas_degrees: tuple[tuple[int, int, float], ...] = ()
    hinge: float | None = None
    density: float | None = None
    sheet: tuple[float, float] | None = None
    scale: float | None = None
    dash: float | None = None
    gap: float | None = None
    flaps: float | None = None
    layers: Literal["apart", "stacked"] | None = None
    paper: str | None = None


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


def _drawing(name: str, write: Callable[[Plan], bytes]) -> Callable[[Design, Settings], dict[str, bytes]]:
    def made(design: Design, settings: Settings) -> dict[str, bytes]:
        return {f"cut_pattern.{name}": write(plan_of(design, settings))}

    return made


def _pages(design: Design, settings: Settings) -> dict[str, bytes]:
    return {"cut_pattern.pdf": pdf(plan_of(design, settings), settings.paper or PAPER)}


def pages_note(design: Design, settings: Settings) -> str | None:
    """A sentence about pieces that a PDF cuts into parts, with the scale at which it does not; None where none is.

    Raises:
        InputError: settings that cannot be, or not together.
    """
    plan, paper = plan_of(design, replace(settings, dash=None, gap=None)), settings.paper or PAPER
    cut = {page.placed[0].piece for page in laid_out(plan, paper) if not page.is_whole}
    if not cut:
        return None
    constant = (settings.flaps or 0.0) + (2 * LARGEST if settings.layers else 0.0)
    share = fitting_share(plan, paper, constant)
    pieces = 1 + max(line.piece for line in plan.lines)
    which = "the piece is" if pieces == 1 else f"{len(cut)} of {pieces} pieces are"
    told = f"{which} larger than {paper}, and cut into parts"
    if share <= 0:
        return told
    return f"{told}; with --scale {ratio_below(_scale(settings) * share)} each fits on a page"


def _pieces(design: Design, settings: Settings) -> dict[str, bytes]:
    return {"cut_pattern.fold": crease_fold(design, scale=_scale(settings))}


def plan_of(design: Design, settings: Settings) -> Plan:
    """The drawing that settings ask for.

    Raises:
        InputError: settings that cannot be, or not together.
    """
    if settings.layers and settings.flaps is not None:
        raise InputError("layers where they lie have no flaps", hint="Leave out --layers or --flaps.")
    if (settings.dash is None) != (settings.gap is None):
        raise InputError("perforation needs both --dash and --gap", hint="--dash 3 --gap 2 suits card.")
    scale = _scale(settings)
    plan = (
        layers_plan(design, scale=scale, apart=settings.layers == "apart")
        if settings.layers
        else crease_plan(design, scale=scale, flaps=settings.flaps or 0.0)
    )
    return plan if settings.dash is None or settings.gap is None else perforated(plan, settings.dash, settings.gap)


def _scale(settings: Settings) -> float:
    return 1.0 if settings.scale is None else settings.scale


_THICK = ("thickness", "delta_degrees", "deltas_degrees", "hinge")
_SURFACES = {
    "obj": (meshes.obj, "polygons, each facet or layer an object"),
    "ply": (meshes.ply, "polygons, numbered by their facets"),
    "stl": (meshes.stl, "triangles"),
    "glb": (meshes.glb, "glTF in metres, a node for each facet or layer"),
    "3mf": (meshes.threemf, "millimetres, an object for each layer"),
    "3dm": (rhino.threedm, "surfaces or solids on layers, and lines by kind of fold"),
}
_LINES = ("scale", "dash", "gap", "flaps", "layers")
#: Of the crease pattern.
PATTERNS = {
    "svg": Format("crease pattern to cut", _LINES, _drawing("svg", svg)),
    "dxf": Format("crease pattern to cut", _LINES, _drawing("dxf", crease_dxf)),
    "pdf": Format("crease pattern on pages", (*_LINES, "paper"), _pages),
    "fold": Format("crease pattern in flat pieces", ("scale",), _pieces),
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
    formats = PATTERNS | SURFACES if settings.thickness is None else PANELS
    chosen = formats.get(name)
    if chosen is None:
        kind = "format" if settings.thickness is None else "format of thick panels"
        known = sorted({*PATTERNS, *SURFACES, *PANELS})
        raise InputError(
            f"{name!r} is no {kind}: there are {', '.join(formats)}.{did_you_mean(name, set(known) - {name})}",
            hint="Without --thickness it is one." if name in known else None,
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
    named = replace(design, name=printable(design.name), unit=printable(design.unit))
    return check(name, settings).write(named, settings)


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
    edge = pattern.edge_between.get(frozenset((a, b)))
    if edge is None or pattern.edges_type[edge] == B:
        raise InputError(f"there is no foldline between vertices {a} and {b}", hint="Name an edge by its two vertices.")
    for edges in pattern.lines_edges:
        if edge in edges:
            return list(edges)
    raise AssertionError("every edge that folds is on a line")
