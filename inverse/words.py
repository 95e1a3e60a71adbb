"""Words of users: help with misspelt ones, and titles that every format can hold."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def printable(text: str) -> str:
    """The same on one line, without what some formats cannot hold: controls and halves of characters.

    Args:
        text: what somebody wrote, such as the title of a file.
    """
    return "".join(letter if letter.isprintable() else " " for letter in text)


def did_you_mean(word: str, allowed: Iterable[str]) -> str:
    """`` Did you mean grid?`` with a space before it, or nothing where no allowed word is near.

    Args:
        word: what was given.
        allowed: what could have been meant.
    """
    names = {name.lower(): name for name in allowed}
    near = difflib.get_close_matches(word.lower(), names, n=1, cutoff=0.5)
    return f" Did you mean {names[near[0]]}?" if near else ""
