"""Pattern families of users: seeds of any size, by the names that specifications use."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from inverse.extending.makers import Maker
from inverse.extending.registry import Registry
from inverse.origami.pattern import Design

F = TypeVar("F", bound=Callable[..., Design])

PATTERN_FAMILIES: Registry[Maker[Design]] = Registry("a pattern family")


def pattern_family(name: str) -> Callable[[F], F]:
    """Register a function that makes seeds, for ``pattern: {kind: family, family: name, size: [m, n], ...}``.

    Args:
        name: behind ``family`` in a specification.

    Returns:
        A decorator of functions ``f(m, n, **parameters)`` that return a :class:`Design` in a semi-folded state, in any
        unit: it is scaled and placed over the target as a pattern from a file is.

    Raises:
        InputError: the name is taken or no word.
    """

    def add(function: F) -> F:
        taken = ("kind", "family", "size", "turn")
        maker = Maker("the pattern family", name, function, Design, n_positional=2, taken=taken)
        PATTERN_FAMILIES.add(name, maker)
        return function

    return add
