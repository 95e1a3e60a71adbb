"""Field types of specifications, with refusals that say what is allowed."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator
from pydantic_core import PydanticCustomError

from inverse.limits import FARTHEST, SMALLEST
from inverse.words import did_you_mean


def shown(value: Any) -> str:
    """A value as it would be written in YAML, shortened."""
    if isinstance(value, Mapping):
        return "a mapping with " + (f"the keys {', '.join(map(str, value))}" if value else "no keys")
    try:
        text = json.dumps(value, ensure_ascii=False)
    except (TypeError, ValueError, RecursionError):
        text = f"a {type(value).__name__}"
    return text if len(text) <= 60 else f"{text[:57]}..."


def refusal(
    message: str, hint: str | None = None, *, key: str | None = None, at_key: bool = False
) -> PydanticCustomError:
    """What a validator raises for a message of its own.

    Args:
        message: the sentence shown.
        hint: what to do about it.
        key: what to point at below the validated value.
        at_key: point at that key instead of what stands behind it.
    """
    context = {"message": message, "hint": hint, "key": key, "at_key": at_key}
    return PydanticCustomError("refusal", "{message}", context)


def word(what: str, meanings: Mapping[str | int, str]) -> BeforeValidator:
    """For a field that takes one of a few words: says which, and which could have been meant.

    Args:
        what: what the words are.
        meanings: what each word means, nothing if it speaks for itself.
    """

    def check(value: Any) -> Any:
        if type(value) in (str, int) and value in meanings:
            return value
        names = [f"{name} ({meaning})" if meaning else str(name) for name, meaning in meanings.items()]
        suggestion = did_you_mean(value, map(str, meanings)) if isinstance(value, str) else ""
        raise refusal(f"{shown(value)} is no {what}: allowed are {', '.join(names)}.{suggestion}")

    return BeforeValidator(check)


def row(*entries: str) -> BeforeValidator:
    """For a field that takes a list of a fixed length: says which entries it has."""

    def check(value: Any) -> Any:
        if isinstance(value, list | tuple) and len(value) == len(entries):
            return value
        raise refusal(f"{shown(value)} should be a list of {len(entries)}: [{', '.join(entries)}]")

    return BeforeValidator(check)


def exactly_one(value: Any, what: str, names: tuple[str, ...], others: tuple[str, ...] = ()) -> dict[str, Any]:
    """A mapping in which exactly one of some keys is given; those with nothing behind them are left out.

    Args:
        value: should be the mapping.
        what: its name in messages.
        names: the keys of which one must be given.
        others: the other keys allowed, for the suggestions.
    """
    listed = ", ".join(names)
    if not isinstance(value, Mapping):
        raise refusal(f"{what} should be a mapping with exactly one of {listed}; given {shown(value)}")
    given = [key for key, item in value.items() if key in names and item is not None]
    if len(given) > 1:
        message = f"{what} needs exactly one of {listed}; given {' and '.join(given)}"
        raise refusal(message, key=given[1], at_key=True)
    if not given:
        for key in value:
            if key not in (*names, *others):
                raise refusal(no_key(str(key), what, (*names, *others)), key=str(key), at_key=True)
        raise refusal(f"{what} needs exactly one of {listed}; given none of them")
    return {key: item for key, item in value.items() if key not in names or item is not None}


def no_key(key: str, what: str, allowed: tuple[str, ...]) -> str:
    """The message for an unknown key."""
    return f'"{key}" is no key of {what}: allowed are {", ".join(allowed)}.{did_you_mean(key, allowed)}'


class Model(BaseModel):
    """Base of all parts of a specification: no unknown keys, not to be changed.

    Attributes:
        one_of: keys of which exactly one must be given, if there are any.
        what: what the part is called in messages about them.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)
    one_of: ClassVar[tuple[str, ...]] = ()
    what: ClassVar[str] = ""

    @model_validator(mode="before")
    @classmethod
    def _check_one_of(cls, value: Any) -> Any:
        if not cls.one_of or isinstance(value, BaseModel):
            return value
        others = tuple(name for name in cls.model_fields if name not in cls.one_of)
        return exactly_one(value, cls.what, cls.one_of, others)


def _numbers(values: tuple[float, ...]) -> str:
    return f"[{', '.join(f'{value:g}' for value in values)}]"


def _increasing(limits: tuple[float, float]) -> tuple[float, float]:
    if not limits[0] < limits[1]:
        raise refusal(f"{_numbers(limits)} should be [low, high] with low below high")
    return limits


def _nonzero(vector: tuple[float, float, float]) -> tuple[float, float, float]:
    if math.hypot(*vector) < 1e-12:
        raise refusal(f"the normal {_numbers(vector)} has no length, so it has no direction")
    return vector


def _moving(line: tuple[tuple[float, float, float], ...]) -> tuple[tuple[float, float, float], ...]:
    for k, (a, b) in enumerate(itertools.pairwise(line)):
        if a == b:
            raise refusal(f"points {k} and {k + 1} of this polyline (counted from 0) are the same: {_numbers(a)}")
    return line


def _closed(line: tuple[tuple[float, float, float], ...]) -> tuple[tuple[float, float, float], ...]:
    if line[0] == line[-1]:
        raise refusal(f"the polygon closes by itself: leave out its last point {_numbers(line[-1])}")
    return _moving(line)


def _not_tiny(value: float) -> float:
    if value < SMALLEST:
        raise refusal(f"{value:g} is too small: it must be at least {SMALLEST:g}")
    return value


Number = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-FARTHEST, le=FARTHEST)]
Positive = Annotated[Number, Field(gt=0), AfterValidator(_not_tiny)]
Integer = Annotated[int, Field(strict=True, ge=-1_000_000_000, le=1_000_000_000)]
Switch = Annotated[bool, Field(strict=True)]
FileName = Annotated[str, Field(min_length=1)]
Point = Annotated[tuple[Number, Number, Number], row("x", "y", "z")]
Normal = Annotated[Point, AfterValidator(_nonzero)]
Polyline = Annotated[tuple[Point, ...], Field(min_length=2), AfterValidator(_moving)]
Polygon = Annotated[tuple[Point, ...], Field(min_length=3), AfterValidator(_closed)]
Increasing = AfterValidator(_increasing)
Interval = Annotated[tuple[Number, Number], row("low", "high"), Increasing]


class Plane(Model):
    """A plane."""

    point: Point = Field(description="a point of the plane, [x, y, z]")
    normal: Normal = Field(description="the plane's normal [x, y, z], of any length but zero")


class Circle(Model):
    """A circle in space."""

    center: Point = Field(description="the circle's centre, [x, y, z]")
    normal: Normal = Field(description="normal [x, y, z] of the circle's plane, of any length but zero")
    radius: Positive = Field(description="the circle's radius")
