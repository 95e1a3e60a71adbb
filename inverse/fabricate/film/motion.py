"""The motion of a design as files: single states as FOLD, animations as MP4, GIF, animated glTF and HTML."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence

import numpy as np

from inverse.errors import InputError
from inverse.fabricate.film.poses import key_frames, poses
from inverse.fabricate.film.stage import set_stage
from inverse.fabricate.film.surroundings import Surroundings
from inverse.fabricate.panels.panels import Panels, panels
from inverse.fabricate.panels.thickness import Thickness
from inverse.files.fold_file import state_document
from inverse.origami import folding, geometry
from inverse.origami.pattern import Design
from inverse.words import did_you_mean

FORMATS = ("mp4", "gif", "glb", "html")
FRAMES, MOST_FRAMES = 100, 5000
SIZE = (1280, 720)
RANGE = (0.0, 180.0)
_GAP = 1e-6  # of the diagonal: facets that come further apart are no rigid folding


def states(design: Design, degrees: Sequence[float]) -> list[str]:
    """FOLD files of states of the motion.

    Args:
        design: the mesh in its design state.
        degrees: folding amounts; 0 is the developed state and 180 the flat-folded one, both exact and in the plane,
            90 the design state.

    Returns:
        The content of a file for each of them. States between the flat ones stand as in an animation.

    Raises:
        InputError: a folding amount outside 0 to 180 degrees, or a design that does not fold rigidly.
    """
    t = np.array([folding_amount(amount) for amount in degrees])
    check_motion(design)
    found = poses(design, t).vertices_coords
    documents = [state_document(design, float(one), coords) for one, coords in zip(t, found, strict=True)]
    return [json.dumps(document, allow_nan=False) + "\n" for document in documents]


def animation(
    design: Design,
    formats: Sequence[str],
    *,
    frames: int = FRAMES,
    degrees: tuple[float, float] | None = None,
    thickness: Thickness | None = None,
    size: tuple[int, int] = SIZE,
    surroundings: Surroundings | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, bytes]:
    """Animations of a motion, all of the same evenly spaced frames, seen by one camera that does not move.

    Args:
        design: the mesh in its design state.
        formats: some of "mp4", "gif", "glb" and "html".
        frames: how many; 25 of them are a second.
        degrees: folding amounts of the first and the last frame; all that there are if None.
        thickness: of thick panels, which mp4 and gif can show; they fold from limit to limit if no range is given.
        size: width and height in pixels of mp4 and gif, both even.
        surroundings: target, buildings and a person beside the design.
        progress: told how many frames of how many are drawn.

    Returns:
        The content of a file for each format.

    Raises:
        InputError: an unknown format, a frame count below 2, folding amounts outside 0 to 180 degrees or equal, a
            size that cannot be, a design that does not fold rigidly, a library or means to draw that is missing.
    """
    from inverse.fabricate.film.film import RATE, check_film, film
    from inverse.fabricate.film.glb import motion_glb
    from inverse.fabricate.film.page import motion_page

    check_animation(formats, frames, degrees or RANGE)
    films = [one for one in ("mp4", "gif") if one in formats]
    if films:
        check_film(size, films)
    check_motion(design)
    thick = None if thickness is None else _thick(design, thickness, formats, degrees)
    first, last = np.radians(degrees or RANGE) if thick is None or degrees else (thick.range.low, thick.range.high)
    t = np.linspace(first, last, frames)
    stage = set_stage(design, t, surroundings or Surroundings())
    content: dict[str, bytes] = {}
    if "glb" in formats:
        content["glb"] = motion_glb(stage, key_frames(design, stage.t), RATE)
    if "html" in formats:
        content["html"] = motion_page(stage, RATE).encode()
    if films:
        content |= film(stage, size, films, progress or (lambda done, count: None), thick)
    return content


def _thick(design: Design, thickness: Thickness, formats: Sequence[str], degrees: tuple[float, float] | None) -> Panels:
    """The panels to be shown; refuses what they cannot do."""
    other = [one for one in formats if one not in ("mp4", "gif")]
    if other:
        raise InputError(
            f"{', '.join(other)} cannot show thick panels",
            hint="mp4 and gif can; `inverse export` writes single states.",
        )
    thick = panels(design, thickness)
    low, high = np.degrees([thick.range.low, thick.range.high])
    if degrees is not None and not low <= min(degrees) <= max(degrees) <= high:
        raise InputError(
            f"the panels fold from {low:.5g} to {high:.5g} degrees, asked are {degrees[0]:g} to {degrees[1]:g}",
            hint="Leave out --range for all of it; a smaller delta folds further.",
        )
    return thick


def check_animation(formats: Sequence[str], frames: int, degrees: tuple[float, float]) -> None:
    """Refuse what is no animation, before anything is folded; see :func:`animation`."""
    for one in formats:
        if one not in FORMATS:
            raise InputError(
                f"{one!r} is no format of animations: there are {', '.join(FORMATS)}.{did_you_mean(one, FORMATS)}",
                hint="A single state is written as FOLD, with --at.",
            )
    if not 2 <= frames <= MOST_FRAMES:
        raise InputError(f"{frames} frames: an animation has from 2 to {MOST_FRAMES}", hint="25 frames are a second.")
    for amount in degrees:
        folding_amount(amount)
    if degrees[0] == degrees[1]:
        raise InputError(
            f"the motion from {degrees[0]:g} to {degrees[1]:g} degrees is none",
            hint="Give two different folding amounts, or --at for a single state.",
        )


def check_motion(design: Design) -> None:
    """Refuse a design whose facets come apart when it folds.

    Raises:
        InputError: it says how far.
    """
    gap = float(folding.fold(design).gap.max()) / geometry.diagonal(design.vertices_coords)
    if not gap <= _GAP:
        raise InputError(
            f"the design does not fold rigidly: facets come apart by {gap:.2g} of its diagonal",
            hint="`inverse check` says what is wrong, `inverse repair` makes a pattern exact.",
        )


def folding_amount(degrees: float) -> float:
    """A folding amount in radians.

    Raises:
        InputError: it is outside 0 to 180 degrees.
    """
    if not 0 <= degrees <= 180:
        raise InputError(
            f"a folding amount of {degrees:g} degrees: from 0 (developed) to 180 (flat-folded) are possible",
            hint="90 is the design state.",
        )
    return float(np.radians(degrees))
