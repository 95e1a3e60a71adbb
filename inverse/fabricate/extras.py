"""Libraries of the extra ``fabricate``."""

from __future__ import annotations

import importlib
from typing import Any

from inverse.errors import InputError


def needed(library: str) -> Any:
    """A library of the extra ``fabricate``, loaded when used.

    Raises:
        InputError: it is not installed.
    """
    try:
        return importlib.import_module(library)
    except ImportError as error:
        raise InputError(
            f"the Python package {library} is not installed: {error}",
            hint='`pip install "inverse[fabricate]"` installs what files for building are written with.',
        ) from error
