"""`inverse export`: crease patterns to cut, meshes for other programs, thick panels."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter, Token

from inverse.cli.output import file_for, folder_for, is_file_name, told, write_all
from inverse.cli.terminal import ProgressLine
from inverse.errors import InputError
from inverse.fabricate.units import scale_of

if TYPE_CHECKING:
    from inverse.fabricate.formats import Settings
    from inverse.origami.pattern import Design


def _foldline(_: object, tokens: Sequence[Token]) -> tuple[tuple[int, int, float], ...]:
    """Words such as 12-19=20: an edge of a foldline by its vertices, and degrees."""
    found = []
    for token in tokens:
        edge, _, degrees = token.value.partition("=")
        a, _, b = edge.partition("-")
        try:
            found.append((int(a), int(b), float(degrees)))
        except ValueError:
            raise ValueError(f"{token.value} is no foldline with an angle, such as 12-19=20") from None
    return tuple(found)


def _scale(_: object, tokens: Sequence[Token]) -> float:
    """1:50 or 0.02."""
    return scale_of(tokens[0].value)


def export(
    design: Path,
    /,
    *,
    to: str | None = None,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    at: float | None = None,
    thickness: float | None = None,
    delta: float | None = None,
    delta_of: Annotated[tuple[tuple[int, int, float], ...], Parameter(converter=_foldline, n_tokens=1)] = (),
    hinge: float | None = None,
    density: float | None = None,
    sheet: tuple[float, float] | None = None,
    scale: Annotated[float | None, Parameter(converter=_scale)] = None,
    dash: float | None = None,
    gap: float | None = None,
    flaps: float | None = None,
    layers: Literal["apart", "stacked"] | None = None,
    paper: str | None = None,
    as_json: Annotated[bool, Parameter(name="--json", negative=())] = False,
) -> int:
    """Write a design for cutting, building or other programs.

    Args:
        design: FOLD file of a design.
        to: crease patterns: svg, dxf, pdf, fold; surfaces: obj, ply, stl, glb, 3mf, 3dm; with --thickness panels: those
            of surfaces, and dxf for sheets to cut them from.
        out: folder for the files, by default that of the design; or a file, whose ending is the format.
        at: folding amount in degrees, 90 (the design state) by default.
        thickness: of each of the two layers of thick panels, in the design's unit.
        delta: degrees that are left when a foldline of thick panels is folded as far as it goes, 10 by default.
        delta_of: the same for one foldline, as A-B=DEGREES by the vertices of one of its edges; may be repeated.
        hinge: thickness of a sheet between the layers, in the design's unit.
        density: of the panels in kilograms per cubic metre, for their masses in the list of panels.
        sheet: width and height of what panels are cut from, in the design's unit.
        scale: of a crease pattern, 1 (full size) by default; 1:50 or 0.02 makes a model of which 20 mm are 1 m.
        dash: perforate what is folded by cuts of this length in mm, with --gap between them.
        gap: least length in mm between the cuts of a perforation.
        flaps: depth in mm of flaps to glue pieces together with.
        layers: no pieces to cut, but the layers of the developed state where they lie: one beside the other (apart) or
            over the other (stacked).
        paper: of a pdf: A0 to A4, letter or tabloid; A4 by default.
        as_json: print the result as JSON.
    """
    from inverse.fabricate import formats
    from inverse.files import fold_file
    from inverse.results.folder import settle

    settle(design.parent)
    name = _format(to, out)
    settings = formats.Settings(
        at, thickness, delta, delta_of, hinge, density, sheet, scale, dash, gap, flaps, layers, paper
    )
    formats.check(name, settings)
    mesh = fold_file.read(design)
    with ProgressLine() as line:
        line.phase(f"making {name}")
        contents = formats.export(mesh, name, settings)
        notes = _notes(mesh, name, settings, line)
    if out is not None and is_file_name(out):
        if len(contents) > 1:
            raise InputError(f"{len(contents)} files cannot be one file {out}", hint="Give a folder as -o.")
        paths = [file_for(design, out)]
    else:
        paths = [folder_for(design, out) / file for file in contents]
    files = dict(zip(paths, contents.values(), strict=True))
    for path in files:
        file_for(design, path)
    write_all(files)
    for note in notes:
        print(note, file=sys.stderr)
    if as_json:
        print(json.dumps({"files": [str(path) for path in files], "notes": notes}, indent=1))
    else:
        for written_line in told(list(files)):
            print(written_line)
    return 0


def _format(to: str | None, out: Path | None) -> str:
    """The format by its name or by the ending of the file."""
    ending = out.suffix.lower()[1:] if out is not None and is_file_name(out) else None
    given = None if to is None else to.lower().removeprefix(".")
    if given is None and ending is None:
        raise InputError("no format is given", hint="Name it with --to, or by the ending of -o.")
    if given is not None and ending is not None and given != ending:
        raise InputError(f"{out} is no file of format {given}", hint="Give a folder as -o, or leave out --to.")
    return given or ending or ""


def _notes(design: Design, name: str, settings: Settings, line: ProgressLine) -> list[str]:
    """What is told besides: pieces that pages cut; how far thick panels fold, and who meets whom."""
    from inverse.fabricate import formats

    if name == "pdf":
        note = formats.pages_note(design, settings)
        return [] if note is None else [note]
    thickness = formats.thickness_of(design, settings)
    if thickness is None:
        return []
    from inverse.fabricate.panels.panels import panels
    from inverse.fabricate.panels.report import report_lines

    return report_lines(panels(design, thickness), progress=line.share)
