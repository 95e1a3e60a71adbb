"""Functions of users that specifications call by name, with parameters: they make a target or a pattern."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from inverse.errors import InputError
from inverse.extending.loading import told
from inverse.words import did_you_mean

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Maker(Generic[T]):
    """A function of keyword parameters, after positional ones that the framework gives.

    Attributes:
        what: what it is called in messages.
        name: under which it is registered.
        function: the function.
        kind: what it returns.
        n_positional: how many arguments it is given by position.
        taken: keys of a specification that cannot be parameters.
    """

    what: str
    name: str
    function: Callable[..., T]
    kind: type[T]
    n_positional: int = 0
    taken: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise InputError(f"{self} is no function")
        for name in self._named:
            if name in self.taken:
                raise InputError(f"{self} has a parameter {name}, which is a key of specifications already")

    def __str__(self) -> str:
        return f"{self.what} {self.name}"

    def wrong(self, parameters: Mapping[str, Any]) -> tuple[str | None, str] | None:
        """What is wrong with the names of parameters: the unknown one, if it is that, and a sentence; or None."""
        known = self._named
        for name in () if self._takes_all else parameters:
            if name not in known:
                allowed = ", ".join(known) or "none"
                return name, f'"{name}" is no parameter of {self}: allowed are {allowed}.{did_you_mean(name, known)}'
        for name, parameter in known.items():
            if parameter.default is parameter.empty and name not in parameters:
                return None, f'the parameter "{name}" of {self} is missing'
        return None

    def make(self, *given: Any, **parameters: Any) -> T:
        """What the function returns.

        Raises:
            InputError: it raised something, which is the cause, or returned something else.
        """
        try:
            found = self.function(*given, **parameters)
        except InputError as error:
            raise InputError(f"{self}: {error.message}", hint=error.hint) from error
        except Exception as error:
            raise InputError(f"{self} raised {told(error)}") from error
        if not isinstance(found, self.kind):
            raise InputError(f"{self} returns a {type(found).__name__}: a {self.kind.__name__} is wanted")
        return found

    @property
    def _named(self) -> dict[str, inspect.Parameter]:
        parameters = list(inspect.signature(self.function).parameters.values())[self.n_positional :]
        return {p.name: p for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)}

    @property
    def _takes_all(self) -> bool:
        return any(p.kind == p.VAR_KEYWORD for p in inspect.signature(self.function).parameters.values())
