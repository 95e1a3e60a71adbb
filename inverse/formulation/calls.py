"""Targets and patterns that a specification has made by a registered function."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from inverse.extending.makers import Maker
from inverse.extending.registry import Registry
from inverse.formulation.within import within
from inverse.spec import Loaded

T = TypeVar("T")


def called(
    loaded: Loaded,
    block: str,
    key: str,
    makers: Registry[Maker[T]],
    parameters: Mapping[str, Any],
    *given: Any,
) -> T:
    """What a function makes whose name stands in a block of the specification, under a key.

    Args:
        loaded: the specification.
        block: target or pattern.
        key: in it, behind which the name stands.
        makers: where the name is looked up.
        parameters: of the function, from the block.
        given: arguments by position.

    Raises:
        InputError: with the place in the specification.
    """
    name = getattr(getattr(loaded.specification, block), key)
    maker = within(loaded, (block, key), lambda: makers.find(name))
    wrong = maker.wrong(parameters)
    if wrong is not None:
        parameter, message = wrong
        place = (block, key) if parameter is None else (block, parameter)
        raise loaded.source.error(place, message, at_key=parameter is not None)
    return within(loaded, (block, key), lambda: maker.make(*given, **parameters))
