"""Pydantic's findings as one :class:`InputError` that points into the source and says what is allowed."""

from __future__ import annotations

import re
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, Tag, ValidationError
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

from inverse.errors import InputError
from inverse.spec.fields import no_key, shown
from inverse.spec.yaml_data import KeyPath
from inverse.spec.yaml_source import Source, dotted

M = TypeVar("M", bound=BaseModel)
# Tags of union members are written <so>, to be told from the keys of the data.
_TAG = re.compile(r"<\w+>")
_MUST = {
    "int_type": "be a whole number",
    "float_type": "be a number",
    "finite_number": "be finite",
    "string_type": "be text",
    "bool_type": "be true or false",
    "tuple_type": "be a list",
    "dict_type": "be a mapping of keys to values",
    "model_type": "be a mapping of keys to values",
    "greater_than": "be greater than {gt:g}",
    "greater_than_equal": "be at least {ge:g}",
    "less_than": "be less than {lt:g}",
    "less_than_equal": "be at most {le:g}",
    "string_too_short": "not be empty",
    "string_too_long": "have at most {max_length} characters",
    "string_pattern_mismatch": "consist of the allowed characters",
    "too_short": "have at least {min_length} entries",
}


def validate(model: type[M], data: Any, source: Source) -> M:
    """A model from plain data.

    Args:
        model: what the data must fit.
        data: what :mod:`inverse.spec.yaml_source` read.
        source: where it was read.

    Raises:
        InputError: for the first fault in the order of the file, or else for the first missing key, with the
            number of faults besides.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        faults = error.errors(include_url=False)
    # Wrong entries of a list are not counted as entries: it is they that are wrong, not the list's length.
    within = {fault["loc"][:k] for fault in faults for k in range(len(fault["loc"]))}
    faults = [fault for fault in faults if fault["type"] != "too_short" or fault["loc"] not in within]
    # What is missing has no place in the file and may just be misspelt, so it comes last.
    fault = min(faults, key=lambda fault: (fault["type"] == "missing", source.rank(_path(fault))))
    raise _error(fault, len(faults) - 1, model, source)


def _path(fault: ErrorDetails) -> KeyPath:
    """The key path of a fault, without the tags that Pydantic puts into it."""
    steps, last = fault["loc"], len(fault["loc"]) - 1
    is_key = fault["type"] == "extra_forbidden"
    path = tuple(step for k, step in enumerate(steps) if not _is_tag(step) or (is_key and k == last))
    key = fault.get("ctx", {}).get("key")
    return path if key is None else (*path, key)


def _is_tag(step: str | int) -> bool:
    return isinstance(step, str) and _TAG.fullmatch(step) is not None


def _error(fault: ErrorDetails, more: int, model: type[BaseModel], source: Source) -> InputError:
    path, kind, given, context = _path(fault), fault["type"], fault.get("input"), fault.get("ctx", {})
    name, parent = dotted(path) or "this", dotted(path[:-1]) or "the top level"
    _, field = _walk(model, fault["loc"])
    label = next((step for step in reversed(path) if isinstance(step, str)), "")
    hint = f"{label}: {field.description}" if field and field.description else None
    at_key = False
    if kind == "refusal":
        message, hint, at_key = context["message"], context["hint"], context["at_key"]
    elif kind == "extra_forbidden":
        holder, _ = _walk(model, fault["loc"][:-1])
        message, hint = no_key(label, parent, tuple(holder.model_fields) if holder else ()), None
        at_key = True
    elif kind == "missing":
        message = f'the key "{label}" is missing from {parent}'
    elif kind in _MUST:
        message = f"{name} is {shown(given)}: it must {_MUST[kind].format(**context)}"
        if kind == "string_type" and isinstance(given, int | float):
            hint = "Put it in quotes."
    else:
        message = f"{name} is {shown(given)}: {fault['msg']}"
    return source.error(path, message + (f" (and {more} more)" if more else ""), hint, at_key=at_key)


def _walk(model: type[BaseModel], steps: tuple[str | int, ...]) -> tuple[type[BaseModel] | None, FieldInfo | None]:
    """The model at a place in the data, if there is one, and the last field on the way to it."""
    here: dict[str, type[BaseModel]] = {"": model}
    field: FieldInfo | None = None
    for step in steps:
        if step in here:
            here = {"": here[str(step)]}
        elif isinstance(step, str) and not _is_tag(step) and len(here) == 1:
            (only,) = here.values()
            field = only.model_fields.get(step)
            here = _models(field.annotation, "") if field else {}
    return next(iter(here.values())) if len(here) == 1 else None, field


def _models(annotation: Any, tag: str) -> dict[str, type[BaseModel]]:
    """The models that an annotation speaks of, by the tags of a union's members."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return {tag: annotation}
    arguments = get_args(annotation)
    tag = next((argument.tag for argument in arguments if isinstance(argument, Tag)), tag)
    found: dict[str, type[BaseModel]] = {}
    for argument in arguments:
        found |= _models(argument, tag)
    return found
