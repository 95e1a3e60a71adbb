"""`inverse draw`: drawings and boards of a design."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter, Token

from inverse.cli.output import file_for, folder_for, is_file_name, write_all
from inverse.cli.terminal import ProgressLine
from inverse.errors import InputError

if TYPE_CHECKING:
    from inverse.boards.views import Subject
    from inverse.origami.pattern import Design


def _whole(_: object, tokens: Sequence[Token]) -> int:
    """A whole number; cyclopts would cut 2.5 to 2."""
    value = tokens[0].value
    if not value.lstrip("+-").isdecimal():
        raise ValueError(f"{value} is no whole number")
    return int(value)


def draw(
    design: Path,
    /,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    what: Annotated[tuple[str, ...], Parameter(negative=())] = (),
    to: Annotated[tuple[str, ...], Parameter(negative=())] = (),
    paper: str | None = None,
    scale: str | None = None,
    style: Literal["line", "shaded", "shadow"] | None = None,
    target: Path | None = None,
    context: Path | None = None,
    at: float = 0.5,
    states: Annotated[int, Parameter(converter=_whole)] = 5,
    hidden: Annotated[bool, Parameter(negative=())] = False,
    date: str | None = None,
    size: Annotated[int, Parameter(converter=_whole)] = 2400,
    as_json: Annotated[bool, Parameter(name="--json", negative=())] = False,
) -> int:
    """Draw a design for a board: plan, elevations, sections, axonometric and motion, to scale on paper.

    Args:
        design: FOLD file of a design.
        out: folder for the files, `drawings` beside the design by default; or a file, whose ending is the format.
        what: board, plan, front, back, left, right (or elevations), north, east, south, west, section, long-section,
            axonometric, worms-eye, motion, exploded, or all; several with commas between. By default board, plan,
            front, right, section, axonometric, worms-eye, motion, exploded.
        to: pdf, svg, png; all three by default.
        paper: A0 to A4; A3 by default, A1 for boards.
        scale: such as 1:50; by default the largest usual one that fits on the paper.
        style: line (lines alone), shaded (facets in the light) or shadow (with that on the ground); by default what
            suits each view.
        target: show the outline of a target surface: a mesh file, or the specification that names it.
        context: show buildings: a CityJSON file, or the specification that names it.
        at: where sections cut, as a share of the design from 0 to 1.
        states: number of states of the motion, from flat to packed.
        hidden: dash the hidden lines of the design.
        date: written into the title block as it is.
        size: pixels of the longer side of png.
        as_json: print the result as JSON.
    """
    from inverse.boards.drawings import drawings, formats_of, views_of
    from inverse.boards.page import Layout
    from inverse.files import fold_file
    from inverse.results.folder import settle

    settle(design.parent)
    single = out if out is not None and is_file_name(out) else None
    formats = formats_of(to or ("pdf,svg,png",))
    names = views_of(what or ("usual" if single is None else _named(single),))
    if single is not None:
        formats = _one_format(single, formats if to else None, names)
    mesh = fold_file.read(design)
    layout = Layout(paper, scale, date)
    with ProgressLine() as line:
        line.show("reading")
        subject = _subject(design, mesh, target, context, style, at, states, hidden)
        subject = replace(subject, tell=lambda what: line.show(f"drawing {what}"))
        contents = drawings(subject, names, formats, layout, size=size)
    if single is not None:
        paths = [_not_ours(file_for(design, single))]
    else:
        folder = folder_for(design, design.parent / "drawings" if out is None else out)
        paths = [folder / name for name in contents]
    write_all(dict(zip(paths, contents.values(), strict=True)))
    if as_json:
        print(json.dumps({"files": [str(path) for path in paths]}, indent=1))
    elif single is not None:
        print(f"wrote     {single}")
    else:
        endings = formats[0] if len(formats) == 1 else f"{{{','.join(formats)}}}"
        views = names[0] if len(names) == 1 else f"{{{','.join(names)}}}"
        print(f"wrote     {folder}/{views}.{endings}")
    return 0


def _named(file: Path) -> str:
    """The view that a file is named after, else the board."""
    from inverse.boards.views import VIEWS

    return file.stem if file.stem in VIEWS else "board"


def _one_format(file: Path, formats: Sequence[str] | None, names: Sequence[str]) -> list[str]:
    """The format of the one file to write.

    Raises:
        InputError: another one is asked for, or several views.
    """
    from inverse.boards.drawings import formats_of

    ending = formats_of((file.suffix,))
    if formats is not None and list(formats) != ending:
        raise InputError(
            f"{file} is no file of format {', '.join(formats)}", hint="Give a folder as -o, or leave out --to."
        )
    if len(names) > 1:
        raise InputError(f"{len(names)} views cannot be one file {file}", hint="Give a folder as -o.")
    return ending


def _not_ours(path: Path) -> Path:
    """The path, unless it is that of a picture that `solve` writes.

    Raises:
        InputError: it is.
    """
    from inverse.results.folder import NAMES

    if path.name in NAMES and path.exists():
        raise InputError(f"{path} is written by `inverse solve`", hint="Choose another -o.")
    return path


def _subject(
    path: Path, mesh: Design, target: Path | None, context: Path | None,
    style: Literal["line", "shaded", "shadow"] | None, at: float, states: int, hidden: bool,
) -> Subject:  # fmt: skip
    """The design with all that is drawn around it; what a report beside it tells is taken from there."""
    from inverse.boards import supports
    from inverse.boards.views import Subject
    from inverse.fabricate.film.surroundings import read_buildings, read_target

    report = supports.read_json(path.parent / "report.json") if path.name == "design.fold" else {}
    certificate = supports.read_json(path.parent / "certificate.json") if path.name == "design.fold" else {}
    return Subject(
        mesh,
        target=None if target is None else read_target(target),
        context=None if context is None else read_buildings(context, mesh.unit),
        supports=supports.supports(mesh, report),
        style=style,
        at=at,
        states=states,
        free=supports.free_range(certificate),
        hidden=hidden,
        verdicts=supports.verdicts(report),
    )
