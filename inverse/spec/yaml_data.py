"""YAML 1.2 text as plain data, with the place of every value."""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.events import (
    AliasEvent,
    DocumentStartEvent,
    Event,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
)
from ruamel.yaml.reader import ReaderError

from inverse.errors import InputError
from inverse.words import did_you_mean

KeyPath = tuple[str | int, ...]
Position = tuple[int, int]  # line and column, counted from 0
Fail = Callable[[Position, str, str | None], InputError]

MAX_DEPTH = 50
MAX_COPIED = 100_000  # values that aliases stand for: a few short lines can stand for billions
LINE_BREAK = re.compile("\r\n|\r|\n")
# The plain scalars of YAML 1.2's core schema; everything else is text.
_WORDS = dict.fromkeys(("", "~", "null", "Null", "NULL")) | {
    w: w.lower() == "true" for w in ("true", "True", "TRUE", "false", "False", "FALSE")
}
_INTEGER = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+", re.ASCII)
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?", re.ASCII)
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")


@dataclass(frozen=True)
class Place:
    """Where a key and its value stand: in the file, or in an override."""

    key: Position | None = None
    value: Position | None = None
    override: str | None = None


def parse(text: str, fail: Fail, places: dict[KeyPath, Place]) -> Any:
    """The plain data of one YAML document.

    Args:
        text: the document.
        fail: makes the exception for a fault: position, message, hint.
        places: is filled with the places of all values, in the order of the text.

    Raises:
        InputError: no valid YAML 1.2, a key given twice, an alias of nothing, a tag, a second document, or nested
            too deeply.
    """
    try:
        events: Iterator[Event] = YAML(typ="safe", pure=True).parse(text)
        data, documents = None, 0
        for event in events:
            if isinstance(event, DocumentStartEvent):
                documents += 1
                if documents > 1:
                    raise fail(_start(event), "a second document starts here: only one is allowed", None)
                if event.version not in (None, (1, 2)):
                    raise fail(_start(event), "the file asks for an older YAML: it is read as YAML 1.2", None)
                data = _Builder(events, fail, places).value(next(events), (), None)
        return data
    except InputError:
        raise
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        position = (mark.line, mark.column) if mark else (0, 0)
        raise fail(position, f"this is no valid YAML: {_reason(error)}", None) from None
    except ReaderError as error:
        before = LINE_BREAK.split(text[: error.position])
        what = f"the character U+{ord(text[error.position]):04X} is not allowed in YAML"
        raise fail((len(before) - 1, len(before[-1])), what, None) from None
    except (YAMLError, OverflowError, ValueError) as error:  # a letter beyond Unicode is either, by the Python
        raise fail((0, 0), f"this is no valid YAML: {error}", None) from None


@dataclass(eq=False)
class _Builder:
    """Makes values of events.

    Attributes:
        events: those to come.
        fail: makes the exception for a fault.
        places: of all values so far.
        order: the keys of ``places`` as they came, which an alias copies a part of.
        anchors: value of every anchor, and which part of ``order`` it covers; None inside of it.
        copied: number of values that aliases stand for.
    """

    events: Iterator[Event]
    fail: Fail
    places: dict[KeyPath, Place]
    order: list[KeyPath] = field(default_factory=list)
    anchors: dict[str, tuple[Any, int, int] | None] = field(default_factory=dict)
    copied: int = 0

    def value(self, event: Event, path: KeyPath, key: Position | None) -> Any:
        """The value that starts with an event; reads its other events."""
        here = _start(event)
        if isinstance(event, AliasEvent):
            return self._copy(str(event.anchor), here, path, key)
        if (tag := getattr(event, "tag", None)) is not None:
            raise self.fail(here, f"the tag {tag} is not allowed", "Leave the tag out.")
        first = len(self.order)
        self._put(path, Place(key or here, here), here)
        anchor = getattr(event, "anchor", None)
        if anchor is not None:
            self.anchors[anchor] = None
        value = self._plain(event, path)
        if anchor is not None:
            self.anchors[anchor] = value, first, len(self.order)
        return value

    def _plain(self, event: Event, path: KeyPath) -> Any:
        if isinstance(event, ScalarEvent):
            return _scalar(event.value) if event.implicit[0] else event.value
        if not isinstance(event, MappingStartEvent):
            items: list[Any] = []
            while not isinstance(event := next(self.events), SequenceEndEvent):
                items.append(self.value(event, (*path, len(items)), None))
            return items
        data: dict[str, Any] = {}
        while not isinstance(event := next(self.events), MappingEndEvent):
            here = _start(event)
            if not isinstance(event, ScalarEvent) or event.tag is not None:
                raise self.fail(here, "a key must be a word", None)
            name = str(event.value)
            if name in data:
                first = self.places[(*path, name)].key or here
                raise self.fail(here, f'"{name}" is given twice, first in line {first[0] + 1}', None)
            data[name] = self.value(next(self.events), (*path, name), here)
        return data

    def _copy(self, name: str, here: Position, path: KeyPath, key: Position | None) -> Any:
        """The value that an alias stands for. What lies within keeps its place: that is where it is to be mended."""
        if name not in self.anchors:
            meant = did_you_mean(name, self.anchors)
            message = f"the alias *{name} stands for nothing: no value before it is marked &{name}.{meant}"
            raise self.fail(here, message, None)
        if (found := self.anchors[name]) is None:
            raise self.fail(here, f"the alias *{name} stands within the value that it stands for", None)
        value, first, last = found
        self.copied += last - first
        if self.copied > MAX_COPIED:
            raise self.fail(here, f"aliases stand for more than {MAX_COPIED} values", "Write shorter lists.")
        top = self.order[first]
        self._put(path, Place(key or here, here), here)
        for one in self.order[first + 1 : last]:
            self._put((*path, *one[len(top) :]), self.places[one], here)
        return copy.deepcopy(value)

    def _put(self, path: KeyPath, place: Place, here: Position) -> None:
        if len(path) > MAX_DEPTH:
            raise self.fail(here, f"this is nested more than {MAX_DEPTH} deep", None)
        self.places[path] = place
        self.order.append(path)


def _start(event: Event) -> Position:
    return event.start_mark.line, event.start_mark.column


def _reason(error: MarkedYAMLError) -> str:
    problem = str(error.problem or error).replace("'\\x00'", "the end")
    return f"{problem} ({error.context})" if error.context else problem


def _scalar(text: str) -> str | int | float | bool | None:
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text) and len(text) < 100:
        return int(text, 0) if text[:2] in ("0o", "0x") else int(text)
    if _FLOAT.fullmatch(text):
        return float(text)
    return float(text.replace(".", "")) if _NOT_FINITE.fullmatch(text) else text
