"""Drawings by their names, in the formats that are asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from inverse.boards.board import board
from inverse.boards.page import Layout, page
from inverse.boards.pdf import pdf
from inverse.boards.png import SIZE, check_size, png
from inverse.boards.sheet import Sheet
from inverse.boards.svg import svg
from inverse.boards.views import VIEWS, Subject
from inverse.errors import InputError
from inverse.words import did_you_mean

BOARD = "board"
FORMATS = ("pdf", "svg", "png")
MOST_STATES = 12
#: Words for several views.
GROUPS = {
    "elevations": ("front", "right", "back", "left"),
    "usual": (BOARD, "plan", "front", "right", "section", "axonometric", "worms-eye", "motion", "exploded"),
    "all": (BOARD, *VIEWS),
}


def views_of(words: Sequence[str]) -> list[str]:
    """The names of views, those of groups in their place, each once.

    Raises:
        InputError: a word that is none of them.
    """
    found: list[str] = []
    for word in (part.strip().lower() for one in words for part in one.split(",")):
        if word not in (BOARD, *VIEWS, *GROUPS):
            known = (BOARD, *VIEWS, *GROUPS)
            raise InputError(
                f"{word!r} is no view: there are {', '.join(known)}.{did_you_mean(word, known)}",
                hint="Name views with --what, separated by commas.",
            )
        found += GROUPS.get(word, (word,))
    return list(dict.fromkeys(found))


def formats_of(words: Sequence[str]) -> list[str]:
    """The names of formats, each once.

    Raises:
        InputError: a word that is none.
    """
    found = [part.strip().lower().removeprefix(".") for one in words for part in one.split(",")]
    for word in found:
        if word not in FORMATS:
            raise InputError(
                f"{word!r} is no format of drawings: there are {', '.join(FORMATS)}.{did_you_mean(word, FORMATS)}",
                hint="Name formats with --to, separated by commas.",
            )
    return list(dict.fromkeys(found))


def check(subject: Subject, size: int) -> None:
    """Refuse what no drawing can be made with.

    Raises:
        InputError: a number that is out of its range.
    """
    if not 0 < subject.at < 1:
        raise InputError(
            f"a section at {subject.at:g} cuts nothing: it is a share of the design, between 0 and 1",
            hint="--at 0.5 cuts it in the middle.",
        )
    if not 2 <= subject.states <= MOST_STATES:
        raise InputError(
            f"{subject.states} states: from 2 to {MOST_STATES} have room side by side", hint="Change --states."
        )
    check_size(size)


def drawings(
    subject: Subject,
    names: Sequence[str],
    formats: Sequence[str],
    layout: Layout,
    *,
    size: int = SIZE,
) -> dict[str, bytes]:
    """Draw views.

    Args:
        subject: what is drawn.
        names: of views, or "board".
        formats: some of "pdf", "svg" and "png".
        layout: paper, scale and date.
        size: pixels of the longer side of PNG.

    Returns:
        The contents of the files by their names. The same drawing gives the same bytes.

    Raises:
        InputError: a number that is out of its range, a scale or paper that cannot be, or at which a view has no room.
    """
    check(subject, size)
    write: dict[str, Callable[[Sheet], bytes]] = {"pdf": pdf, "svg": svg, "png": lambda sheet: png(sheet, size)}
    found: dict[str, bytes] = {}
    for done, name in enumerate(names):
        subject.tell(f"{name}, {done} of {len(names)} done")
        sheet = board(subject, layout) if name == BOARD else page(subject, name, layout)
        found |= {f"{name}.{one}": write[one](sheet) for one in formats}
    return found
