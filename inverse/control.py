"""What ends a solve from outside: the user, the clock, or whoever is told the iterations."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from inverse.attempt import Progress

Watch = Callable[[str, Progress], None]


@dataclass(eq=False)
class Control:
    """Ends a solve at its next iteration, and remembers why.

    Attributes:
        deadline: on the monotonic clock, in seconds.
        watch: told every iteration, or None.
        stop: set to end at the next iteration.
        failure: what the watch raised, if it did.
    """

    deadline: float
    watch: Watch | None = None
    stop: threading.Event = field(default_factory=threading.Event)
    failure: Exception | None = None

    @property
    def stopped(self) -> bool:
        """Whether the user, the clock or a broken watch ended the solve."""
        return self.stop.is_set() or self.failure is not None or self.timed_out

    @property
    def timed_out(self) -> bool:
        """Whether the time is up."""
        return time.monotonic() >= self.deadline

    def tell(self, phase: str, progress: Progress) -> bool:
        """Tell the watch; what it raises ends the solve and is kept.

        Returns:
            Whether to go on.
        """
        if self.watch is not None and not self.stopped:
            try:
                self.watch(phase, progress)
            except KeyboardInterrupt:
                self.stop.set()
            except Exception as error:
                self.failure = error
        return not self.stopped

    @contextmanager
    def interruptible(self) -> Iterator[None]:
        """Let Ctrl-C end the run at its next iteration instead of in the middle of one."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        previous = signal.signal(signal.SIGINT, lambda _signal, _frame: self.stop.set())
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, previous)
