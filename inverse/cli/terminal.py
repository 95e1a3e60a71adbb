"""Progress on stderr."""

from __future__ import annotations

import contextlib
import shutil
import sys
import threading
import time
from typing import Self

TERMINAL_S, LOG_S = 0.1, 5.0  # least time between two lines that show something new
PULSE_S, LOG_PULSE_S = 1.0, 10.0  # the same where nothing new is told: how long it has taken so far


class ProgressLine:
    """Shows progress on stderr from ``with`` to its end: one line that changes on a terminal, else a line now and then.

    While nothing new is told, the last line is shown again with the time since it was told first, so that nobody waits
    before a silent terminal.

    Args:
        every_s: least time between two lines, and ...
        pulse_s: ... least time until a line is shown again; in seconds, by what stderr is if not given.
    """

    def __init__(self, every_s: float | None = None, pulse_s: float | None = None) -> None:
        self._terminal = sys.stderr is not None and sys.stderr.isatty()
        self._every = every_s if every_s is not None else TERMINAL_S if self._terminal else LOG_S
        self._pulse = pulse_s if pulse_s is not None else PULSE_S if self._terminal else LOG_PULSE_S
        self._last = self._told = time.monotonic()
        self._line = ""
        self._phase, self._began = "", self._told
        self._lock = threading.Lock()
        self._over = threading.Event()

    def __enter__(self) -> Self:
        threading.Thread(target=self._keep_showing, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        with self._lock:
            if self._terminal:
                self._write("\r\033[K")

    def phase(self, words: str) -> None:
        """Say what is going on now, at once on a terminal.

        Args:
            words: such as "drawing design.png".
        """
        self._line, self._told = words, time.monotonic()
        if self._terminal:
            self._show()

    def show(self, line: str) -> None:
        """Show a line, unless another one was shown just before."""
        self._line, self._told = line, time.monotonic()
        if self._told - self._last >= self._every:
            self._show()

    def share(self, words: str, done: int, of: int) -> None:
        """Show how much of a work is done, and how much longer it takes if it goes on like this.

        Args:
            words: what is done, such as "drawing frames"; the same in all calls of one work.
            done: parts that are done.
            of: parts in all; 0 where that is not known.
        """
        if not of:
            self.show(words)
            return
        now = time.monotonic()
        if words != self._phase:
            self._phase, self._began = words, now
        spent = now - self._began
        left = f", {_seconds(spent / done * (of - done))} left" if 0 < done < of and spent > 1 else ""
        self.show(f"{words}: {done} of {of}, {100 * done // of} %{left}")

    def _keep_showing(self) -> None:
        while not self._over.wait(self._pulse / 4):
            if self._line and time.monotonic() - self._last >= self._pulse:
                self._show()

    def _show(self) -> None:
        with self._lock:
            if self._over.is_set():
                return
            self._last = time.monotonic()
            waited = self._last - self._told
            line = f"{self._line} ({_seconds(waited)})" if waited >= 1 else self._line
            if self._terminal:  # what is wrapped cannot be taken back
                self._write("\r\033[K" + line[: shutil.get_terminal_size().columns - 1])
            else:
                self._write(f"{line}\n")

    @staticmethod
    def _write(text: str) -> None:
        with contextlib.suppress(OSError, ValueError):  # nobody looks any more; the work goes on
            print(text, end="", file=sys.stderr, flush=True)


def _seconds(seconds: float) -> str:
    """A time for people: 12 s, 3 min 20 s, 2 h 5 min."""
    whole = round(seconds)
    if whole < 100:
        return f"{whole} s"
    minutes, rest = divmod(whole, 60)
    if minutes < 100:
        return f"{minutes} min {rest} s"
    return f"{minutes // 60} h {minutes % 60} min"
