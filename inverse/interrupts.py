"""Ctrl-C and SIGTERM, heard where it is safe.

What a signal handler raises comes out wherever Python happens to be: in a call of CasADi, which makes a SystemError or
a NotImplementedError of it; in a finalizer, where it is printed and forgotten. So the first signal only sets a flag
while such work goes on, and the flag is asked at places in between.
"""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

SIGNALS = (signal.SIGINT, signal.SIGTERM)
EXIT_CODE = 3

_announcements: list[str] = []  # what is said at the first signal, innermost last


@contextmanager
def held(stop: threading.Event, ended: threading.Event | None = None) -> Iterator[None]:
    """Let the first signal set ``stop`` and do nothing else; a second one raises KeyboardInterrupt.

    Args:
        stop: to be asked where the work can end.
        ended: set at the second signal, for whoever catches what was made of it.

    Raises:
        KeyboardInterrupt: at the second signal, whatever was made of it on its way out.
    """

    def hear() -> bool:
        first = not stop.is_set()
        stop.set()
        if first and _announcements:
            # Not print: the handler may have come amid one.
            start = "\r\033[K" if os.isatty(2) else ""
            with contextlib.suppress(OSError):
                os.write(2, f"{start}{_announcements[-1]}\n".encode())
        elif not first and ended is not None:
            ended.set()
        return not first

    with _heard(hear):
        yield


@contextmanager
def announced(words: str) -> Iterator[None]:
    """Say something on stderr at once when a first signal comes that is held.

    Args:
        words: what is done now, as the work may go on for some seconds.
    """
    _announcements.append(words)
    try:
        yield
    finally:
        _announcements.pop()


@contextmanager
def raised() -> Iterator[None]:
    """Let every signal raise KeyboardInterrupt, and no other error come out after one."""
    with _heard(lambda: True):
        yield


def told() -> int:
    """Say on stderr that the user ended the program; the exit code for that."""
    print("interrupted; no file was left half-written", file=sys.stderr)
    return EXIT_CODE


def ignore() -> None:
    """Hear no more signals: the program is ending, and its exit code is settled."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


@contextmanager
def _heard(ends: Callable[[], bool]) -> Iterator[None]:
    """Ask at every signal whether it ends the work; in the main thread, which signals belong to.

    Handlers are put back afterwards.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    ended = False

    def handle(_signal: int, _frame: object) -> None:
        nonlocal ended
        if ends():
            ended = True
            raise KeyboardInterrupt

    before = {number: signal.getsignal(number) for number in SIGNALS}
    try:
        for number in SIGNALS:
            signal.signal(number, handle)
        yield
    except Exception as error:
        if ended:
            raise KeyboardInterrupt from error
        raise
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
