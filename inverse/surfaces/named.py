"""Target surfaces of users, by the names that specifications use."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from inverse.extending.makers import Maker
from inverse.extending.registry import Registry
from inverse.surfaces.base import Target

F = TypeVar("F", bound=Callable[..., Target])

TARGETS: Registry[Maker[Target]] = Registry("a target surface")


def target(name: str) -> Callable[[F], F]:
    """Register a function that makes a target, for ``target: {surface: name, parameter: value, ...}``.

    Args:
        name: behind ``surface`` in a specification.

    Returns:
        A decorator of functions of keyword parameters that return a :class:`Target` in the specification's unit.

    Raises:
        InputError: the name is taken or no word.
    """

    def add(function: F) -> F:
        kind: type[Target] = Target  # type: ignore[type-abstract]  # for isinstance only
        TARGETS.add(name, Maker("the target surface", name, function, kind, taken=("surface",)))
        return function

    return add
