"""Progress on stderr."""

from __future__ import annotations

import sys
import time
from typing import Self


class ProgressLine:
    """Shows progress on stderr: one line that changes on a terminal, else a line every few seconds."""

    def __init__(self, every_s: float = 5.0) -> None:
        self._terminal = sys.stderr.isatty()
        self._every = 0.1 if self._terminal else every_s
        self._last = time.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._terminal:
            print("\r\033[K", end="", file=sys.stderr, flush=True)

    def show(self, line: str) -> None:
        """Show a line, unless another one was shown just before."""
        now = time.monotonic()
        if now - self._last < self._every:
            return
        self._last = now
        print(
            f"\r\033[K{line}" if self._terminal else line,
            end="" if self._terminal else "\n",
            file=sys.stderr,
            flush=True,
        )
