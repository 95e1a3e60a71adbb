"""What ends a solve from outside: the user, the clock, or whoever is told the iterations."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, field

from inverse import interrupts
from inverse.solvers.run import Progress

Watch = Callable[[str, Progress], None]


@dataclass(eq=False)
class Control:
    """Ends a solve at its next iteration, and remembers why.

    Attributes:
        deadline: on the monotonic clock, in seconds.
        watch: told every iteration, or None.
        stop: set to end at the next iteration.
        ended: set where the user would not even wait for the best design.
        failure: what the watch raised, if it did.
    """

    deadline: float
    watch: Watch | None = None
    stop: threading.Event = field(default_factory=threading.Event)
    ended: threading.Event = field(default_factory=threading.Event)
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

    def phase(self, words: str) -> None:
        """Tell the watch what is going on besides iterations, if it has a method of that name."""
        told = getattr(self.watch, "phase", None)
        if told is not None and not self.stopped:
            told(words)

    def interruptible(self) -> AbstractContextManager[None]:
        """Let Ctrl-C and SIGTERM end the run at its next iteration instead of in the middle of one."""
        return interrupts.held(self.stop, self.ended)

    def check(self) -> None:
        """End here if asked to, where nothing has been found yet.

        Raises:
            KeyboardInterrupt: after Ctrl-C or SIGTERM.
        """
        if self.stop.is_set():
            raise KeyboardInterrupt
