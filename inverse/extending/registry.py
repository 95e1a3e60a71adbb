"""What users and the framework register under names that specifications may use."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Generic, TypeVar

from inverse.errors import InputError
from inverse.extending import loading
from inverse.words import did_you_mean

T = TypeVar("T")
_NAME = re.compile(r"\w(-?\w)*", re.ASCII)


class Registry(Mapping[str, T], Generic[T]):
    """Items by name, in the order in which they came.

    Args:
        what: what an item is called in messages, with its article: ``an objective``.
        items: those there are from the beginning.
    """

    def __init__(self, what: str, items: Mapping[str, T] | None = None) -> None:
        self.what = what
        self._items = dict(items or {})

    def __getitem__(self, name: str) -> T:
        return self._items[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def add(self, name: str, item: T) -> None:
        """Register an item.

        Raises:
            InputError: the name is no word, or taken.
        """
        if str(name) != name or not _NAME.fullmatch(name):
            raise InputError(
                f"{name!r} cannot name {self.what}", hint="A name is made of letters, digits, _ and - within."
            )
        if name in self._items:
            raise InputError(
                f"{name!r} is {self.what} already",
                hint="Choose another name.",
            )
        self._items[name] = item

    def remove(self, name: str) -> None:
        """Forget an item, to register another under its name."""
        del self._items[name]

    def find(self, name: str) -> T:
        """The item of a name; installed packages that register some are imported if it is not known yet.

        Raises:
            InputError: there is none, with the names there are and the nearest.
        """
        if name not in self._items:
            loading.load_installed()
        if name not in self._items:
            known = ", ".join(sorted(self._items)) or "none"
            raise InputError(f"{name!r} is no {self._noun}: registered are {known}.{did_you_mean(name, self._items)}")
        return self._items[name]

    @property
    def _noun(self) -> str:
        return self.what.split(" ", 1)[1]
