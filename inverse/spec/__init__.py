"""What a user asks, with its place in the file."""

from __future__ import annotations

from inverse.spec.specification import *  # noqa: F403
from inverse.spec.specification import __all__ as __all__
