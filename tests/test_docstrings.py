"""Every public function says what it takes and what it gives."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import pytest

import inverse

NAMES = sorted({*inverse.__all__} - {"__version__", "seeds"})


def functions() -> list[Callable[..., Any]]:
    own = [getattr(inverse, name) for name in NAMES]
    seeds = [one for name, one in inspect.getmembers(inverse.seeds, inspect.isfunction) if not name.startswith("_")]
    here = [one for one in seeds if one.__module__ == inverse.seeds.__name__]
    return [*here, *(one for one in own if inspect.isfunction(one))]


@pytest.mark.parametrize("function", functions(), ids=lambda function: function.__name__)
def test_functions_say_what_they_take_and_give(function: Callable[..., Any]) -> None:
    text, signature = inspect.getdoc(function) or "", inspect.signature(function)
    _, _, section = text.partition("\nArgs:\n")
    assert [word for word in signature.parameters if f"    {word}: " not in section] == []
    assert ("\nReturns:\n" in text) == (signature.return_annotation != "None")
    if "raise InputError" in inspect.getsource(function):
        assert "\nRaises:\n" in text


@pytest.mark.parametrize("name", NAMES)
def test_types_tell_their_attributes(name: str) -> None:
    kind = getattr(inverse, name)
    fields = getattr(kind, "__dataclass_fields__", {})
    text = inspect.getdoc(kind) or ""
    assert text
    assert [field for field in fields if not field.startswith("_") and f"    {field}: " not in text] == []
