"""YAML read as plain data that remembers where every value stands, so that refusals can point at it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from inverse.errors import InputError
from inverse.files.reading import read_text
from inverse.spec.yaml_data import LINE_BREAK, MAX_DEPTH, Fail, KeyPath, Place, Position, parse

MAX_BYTES = 10_000_000
_WIDTH = 110


class Source:
    """The places of all values of one specification.

    Attributes:
        name: the file's path as it was given, or a word for data that comes from no file.
    """

    def __init__(self, name: str, text: str | None = None) -> None:
        self.name = name
        self._lines = None if text is None else LINE_BREAK.split(text)
        self._places: dict[KeyPath, Place] = {}

    def error(self, path: KeyPath, message: str, hint: str | None = None, *, at_key: bool = False) -> InputError:
        """A refusal that points at a value; it is returned, not raised.

        Args:
            path: keys and list indices from the top; where the last ones are not given, the nearest key
                above them is pointed at.
            message: what is wrong, as a sentence.
            hint: what to do about it.
            at_key: point at the key instead of its value.
        """
        known = self._known(path)
        place = self._places[known]
        if place.override is not None:
            return InputError(message, where=f"--set {place.override}", hint=hint)
        position = place.key if at_key or len(known) < len(path) else place.value
        if position is None:
            return InputError(message, where=f"{self.name}:{dotted(path)}" if path else self.name, hint=hint)
        return self._error_at(position, message, hint)

    def place(self, path: KeyPath) -> str:
        """A value by its key and, where it has one, its line, to be named in a refusal of another."""
        place = self._places[self._known(path)]
        name = dotted(path)
        if place.override is not None:
            return f"{name} (--set {place.override})"
        return name if place.value is None else f"{name} (line {place.value[0] + 1})"

    def rank(self, path: KeyPath) -> int:
        """A number that grows with the place of a value in the file; overrides come last."""
        return self._ranks[self._known(path)]

    @cached_property
    def _ranks(self) -> dict[KeyPath, int]:
        return {path: k for k, path in enumerate(self._places)}

    def _known(self, path: KeyPath) -> KeyPath:
        while path and path not in self._places:
            path = path[:-1]
        return path

    def _error_at(self, position: Position, message: str, hint: str | None = None) -> InputError:
        line, column = position
        lines = self._lines or []
        excerpt = _excerpt(lines[line] if line < len(lines) else "", column)
        return InputError(f"{message}\n{excerpt}", where=f"{self.name}:{line + 1}:{column + 1}", hint=hint)

    def override(self, data: dict[str, Any], text: str) -> None:
        """Apply ``key.path=value`` to the data."""

        def fail(_: Position, message: str, hint: str | None = None) -> InputError:
            return InputError(message, where=f"--set {text}", hint=hint)

        keys, _, value = text.partition("=")
        words = [word.strip() for word in keys.split(".")]
        if not all(words) or not value.strip():
            example = "For example --set 'pattern.size=[16,24]' or --set constraints.anchors.0.every=3."
            raise fail((0, 0), "an override is a key path, an equals sign and a value", example)
        new = parse(value, fail, {})
        holder: Any = data
        path: KeyPath = ()
        for k, word in enumerate(words):
            path = (*path, _step(holder, word, path, fail))
            if k == len(words) - 1:
                holder[path[-1]] = new
            elif isinstance(holder, dict) and holder.get(word) is None:
                self._places.setdefault(path, Place(override=text))
                holder[word] = holder = {}
            else:
                holder = holder[path[-1]]
        kept = {p: place for p, place in self._places.items() if p[: len(path)] != path}
        self._places = kept | {path: Place(override=text)}


def read(path: Path) -> tuple[dict[str, Any], Source]:
    """The mapping in a YAML 1.2 file, as plain data, and where everything in it stands.

    Args:
        path: the file, UTF-8.

    Raises:
        InputError: the file is missing or unreadable, no valid YAML, or no mapping; a key is given twice;
            there are tags, or aliases of nothing.
    """
    text = read_text(path, MAX_BYTES)
    source = Source(str(path), text)
    data = parse(text, source._error_at, source._places)
    if data is None:
        raise InputError("the file is empty", where=str(path), hint="It must hold a mapping of keys to values.")
    if not isinstance(data, dict):
        hint = "Write one `key: value` per line."
        raise source.error((), "the file must hold a mapping of keys to values at its top level", hint)
    return data, source


def from_mapping(mapping: Mapping[str, Any], name: str) -> tuple[dict[str, Any], Source]:
    """A script's own data, copied to plain lists and dictionaries, with a source that names key paths.

    Args:
        mapping: nested mappings, sequences, NumPy arrays, paths and plain values.
        name: stands before the key path in messages.

    Raises:
        InputError: the data is no mapping, or nested too deeply.
    """
    source = Source(name)
    data = _plain(mapping, (), source)
    if not isinstance(data, dict):
        raise source.error((), "a specification is a mapping of keys to values")
    return data, source


def dotted(path: KeyPath) -> str:
    """``constraints.anchors.0.every``."""
    return ".".join(map(str, path))


def _plain(value: Any, path: KeyPath, source: Source) -> Any:
    source._places[path] = Place()
    if len(path) > MAX_DEPTH:
        raise source.error(path[:3], f"this is nested more than {MAX_DEPTH} deep")
    if isinstance(value, Mapping):
        return {str(k): _plain(v, (*path, str(k)), source) for k, v in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, list | tuple):
        return [_plain(v, (*path, k), source) for k, v in enumerate(value)]
    return str(value) if isinstance(value, Path) else value


def _step(holder: Any, word: str, path: KeyPath, fail: Fail) -> str | int:
    """A word of an override's key path as key or index of what it is looked up in."""
    if isinstance(holder, dict):
        return word
    if not isinstance(holder, list):
        raise fail((0, 0), f'{dotted(path)} is a single value and has no "{word}"', None)
    if not re.fullmatch("[0-9]{1,9}", word) or int(word) >= len(holder):
        entries = f"entries 0 to {len(holder) - 1}" if holder else "no entries"
        raise fail((0, 0), f'{dotted(path)} is a list with {entries}, given "{word}"', None)
    return int(word)


def _excerpt(line: str, column: int) -> str:
    """A line, cut around a column if it is long, and below it a caret under that column."""
    line = "".join(c if c.isprintable() else " " for c in line)
    start = max(0, column - _WIDTH // 2) if len(line) > _WIDTH else 0
    before = "  ..." if start else "  "
    shown = before + line[start : start + _WIDTH]
    return f"{shown.rstrip()}\n{' ' * (len(before) + column - start)}^"
