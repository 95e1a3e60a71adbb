"""The building context that a specification names."""

from __future__ import annotations

from inverse.context import Context, read_city_json
from inverse.errors import InputError
from inverse.spec import Loaded


def read_context(loaded: Loaded) -> Context | None:
    """The buildings, or None where the specification names none.

    Raises:
        InputError: the file cannot be used, with the place in the specification.
    """
    keys = loaded.specification.context
    if keys is None:
        return None
    try:
        return read_city_json(loaded.folder / keys.file, keys.origin)
    except InputError as error:
        raise loaded.source.error(("context", "file"), str(error).split("\n")[0], error.hint) from None
