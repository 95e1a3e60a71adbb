"""YAML 1.2 text as plain data, with the place of every value."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
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

KeyPath = tuple[str | int, ...]
Position = tuple[int, int]  # line and column, counted from 0
Fail = Callable[[Position, str, str | None], InputError]

MAX_DEPTH = 50
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
        InputError: no valid YAML 1.2, a key given twice, an alias, a tag, a second document, or nested
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
                data = _build(next(events), events, (), None, fail, places)
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


def _build(
    event: Event,
    events: Iterator[Event],
    path: KeyPath,
    key: Position | None,
    fail: Fail,
    places: dict[KeyPath, Place],
) -> Any:
    """The value that starts with an event; reads its other events."""
    here = _start(event)
    places[path] = Place(key or here, here)
    if isinstance(event, AliasEvent):
        raise fail(here, f"the alias *{event.anchor} is not allowed", "Write the value out.")
    if (tag := getattr(event, "tag", None)) is not None:
        raise fail(here, f"the tag {tag} is not allowed", "Leave the tag out.")
    if len(path) > MAX_DEPTH:
        raise fail(here, f"this is nested more than {MAX_DEPTH} deep", None)
    if isinstance(event, ScalarEvent):
        return _scalar(event.value) if event.implicit[0] else event.value
    if not isinstance(event, MappingStartEvent):
        items: list[Any] = []
        while not isinstance(event := next(events), SequenceEndEvent):
            items.append(_build(event, events, (*path, len(items)), None, fail, places))
        return items
    data: dict[str, Any] = {}
    while not isinstance(event := next(events), MappingEndEvent):
        here = _start(event)
        if not isinstance(event, ScalarEvent) or event.tag is not None:
            raise fail(here, "a key must be a word", None)
        name = str(event.value)
        if name in data:
            first = places[(*path, name)].key or here
            raise fail(here, f'"{name}" is given twice, first in line {first[0] + 1}', None)
        data[name] = _build(next(events), events, (*path, name), here, fail, places)
    return data


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
