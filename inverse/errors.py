"""The one exception that wrong input raises."""

from __future__ import annotations


class InputError(ValueError):
    """Input that cannot be used: says what was given, what is allowed and what to do.

    Args:
        message: what is wrong, as a sentence.
        where: place of the fault, for example ``vault.yaml:7:3``.
        hint: what to do about it, as a sentence.
    """

    def __init__(self, message: str, *, where: str | None = None, hint: str | None = None) -> None:
        self.message = message
        self.where = where
        self.hint = hint
        text = message if where is None else f"{where}: {message}"
        super().__init__(text if hint is None else f"{text}\n{hint}")
