"""`inverse fold`: the motion of a design as files."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter, Token

from inverse.cli.output import file_for, folder_for, is_file_name, told, write_all
from inverse.cli.terminal import ProgressLine
from inverse.errors import InputError

if TYPE_CHECKING:
    from inverse.fabricate.film.surroundings import Surroundings


def _whole(_: object, tokens: Sequence[Token]) -> int | tuple[int, ...]:
    """Whole numbers; cyclopts would cut 2.5 to 2."""
    for token in tokens:
        if not token.value.lstrip("+-").isdecimal():
            raise ValueError(f"{token.value} is no whole number")
    found = tuple(int(token.value) for token in tokens)
    return found[0] if len(found) == 1 else found


def fold(
    design: Path,
    /,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    at: Annotated[tuple[float, ...], Parameter(negative=())] = (),
    frames: Annotated[int | None, Parameter(converter=_whole)] = None,
    to: Annotated[tuple[str, ...], Parameter(negative=())] = (),
    degrees: Annotated[tuple[float, float] | None, Parameter(name="--range", negative=())] = None,
    size: Annotated[tuple[int, int] | None, Parameter(converter=_whole, negative=())] = None,
    target: Path | None = None,
    context: Path | None = None,
    figure: Annotated[bool, Parameter(negative=())] = False,
    thickness: float | None = None,
    delta: float | None = None,
    hinge: float | None = None,
    as_json: Annotated[bool, Parameter(name="--json", negative=())] = False,
) -> int:
    """Fold a design: states as FOLD files, or animations as MP4, GIF, animated glTF and HTML.

    Args:
        design: FOLD file of a design; its own state is at 90 degrees, 0 is developed and 180 flat-folded.
        out: folder for the files, by default that of the design; or a file, whose ending is the format.
        at: write this state, in degrees, instead of an animation; may be repeated.
        frames: number of frames of the animation, 100 by default; 25 are a second.
        to: mp4, gif, glb or html, html by default; may be repeated.
        degrees: first and last folding amount of the animation in degrees, 0 180 by default.
        size: width and height of mp4 and gif in pixels, 1280 720 by default.
        target: show a target surface: a mesh file, or the specification that names it.
        context: show buildings: a CityJSON file, or the specification that names it.
        figure: show a person 1.75 m tall beside the design.
        thickness: show thick panels (mp4 and gif): thickness of each of their two layers, in the design's unit.
        delta: degrees that are left when a foldline of thick panels is folded as far as it goes, 10 by default.
        hinge: thickness of a sheet between the layers.
        as_json: print the result as JSON.
    """
    from inverse.fabricate.film import motion
    from inverse.fabricate.formats import Settings, thickness_of
    from inverse.files import fold_file
    from inverse.results.folder import settle

    settle(design.parent)
    given = {
        "frames": frames is not None, "to": bool(to), "range": degrees is not None, "size": size is not None,
        "target": target is not None, "context": context is not None, "figure": figure,
        "thickness": thickness is not None, "delta": delta is not None, "hinge": hinge is not None,
    }  # fmt: skip
    others = [f"--{name}" for name, there in given.items() if there]
    if at and others:
        raise InputError(
            f"--at writes single states, and {', '.join(others)} {'are' if len(others) > 1 else 'is'} for animations",
            hint="Leave one or the other out.",
        )
    if at:
        paths = _state_paths(design, out, at)
        contents: Sequence[str | bytes] = motion.states(fold_file.read(design), list(paths))
        files = dict(zip(paths.values(), contents, strict=True))
    else:
        named = _animation_paths(design, out, to)
        count = motion.FRAMES if frames is None else frames
        motion.check_animation(list(named), count, degrees or motion.RANGE)
        mesh = fold_file.read(design)
        thick = thickness_of(mesh, Settings(thickness=thickness, delta_degrees=delta, hinge=hinge))
        if thick is None and (delta, hinge) != (None, None):
            raise InputError("delta and a hinge sheet are of thick panels", hint="Give --thickness too.")
        around = _surroundings(target, context, figure, mesh.unit)
        with ProgressLine() as line:
            line.phase("folding")
            content = motion.animation(
                mesh, list(named), frames=count, degrees=degrees, thickness=thick, size=size or motion.SIZE,
                surroundings=around, progress=lambda done, n: _told(line, done, n),
            )  # fmt: skip
        files = {named[one]: content[one] for one in named}
    write_all(files)
    if as_json:
        print(json.dumps({"files": [str(path) for path in files]}, indent=1))
    else:
        for written in told(list(files)):
            print(written)
    return 0


def _told(line: ProgressLine, done: int, of: int) -> None:
    """Show which frame is drawn; the film is made of them afterwards."""
    if done < of:
        line.share("drawing frames", done, of)
    else:
        line.phase("making the film")


def _state_paths(design: Path, out: Path | None, at: Sequence[float]) -> dict[float, Path]:
    """The file of every state."""
    amounts = list(dict.fromkeys(at))
    if out is not None and is_file_name(out):
        if out.suffix.lower() != ".fold":
            raise InputError(f"{out} is no name for a state: it is a .fold file", hint="Or give a folder as -o.")
        if len(amounts) > 1:
            raise InputError(f"{len(amounts)} states cannot be one file {out}", hint="Give a folder as -o.")
        return {amounts[0]: file_for(design, out)}
    folder = folder_for(design, out)
    return {amount: folder / f"state_{repr(amount + 0.0).removesuffix('.0')}.fold" for amount in amounts}


def _animation_paths(design: Path, out: Path | None, to: Sequence[str]) -> dict[str, Path]:
    """The file of every format."""
    formats = list(dict.fromkeys(word.lower().removeprefix(".") for word in to))
    if out is not None and is_file_name(out):
        ending = out.suffix.lower()[1:]
        if ending == "fold":
            raise InputError(f"{out} would be a single state", hint="Say which with --at DEGREES.")
        if formats not in ([], [ending]):
            raise InputError(
                f"{out} is no file of format {', '.join(formats)}", hint="Give a folder as -o, or leave out --to."
            )
        return {ending: file_for(design, out)}
    folder = folder_for(design, out)
    return {one: folder / f"motion.{one}" for one in formats or ["html"]}


def _surroundings(target: Path | None, context: Path | None, figure: bool, unit: str) -> Surroundings:
    from inverse.fabricate.film.surroundings import Surroundings, read_buildings, read_target

    surface = None if target is None else read_target(target)
    return Surroundings(surface, None if context is None else read_buildings(context, unit), figure)
