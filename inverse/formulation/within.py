"""Faults from deeper down, told with their place in the specification."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from inverse.errors import InputError
from inverse.spec import Loaded

T = TypeVar("T")


def within(loaded: Loaded, key: tuple[str | int, ...] | None, make: Callable[[], T], *, at_key: bool = False) -> T:
    """Give an error from deeper down the place in the specification that caused it, if there is one."""
    try:
        return make()
    except InputError as error:
        if key is None:
            raise
        message = str(error).split("\n")[0]
        raise loaded.source.error(key, message, error.hint, at_key=at_key) from error.__cause__
