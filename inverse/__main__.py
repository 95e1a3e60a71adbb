"""The command line as a program: ``python -m inverse`` and the script ``inverse``."""

import os
import sys
import threading
from collections.abc import Callable

from inverse import interrupts

# Read by the BLAS and OpenMP that numpy, scipy and casadi bring along, when they are loaded. How many threads share
# the work changes in which order they add, and so the last digits of a design.
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
READER_GONE = 141  # exit code of a command whose output nobody reads to its end: as shells tell it of other programs


def main() -> None:
    """Run the command line and exit with its code."""
    os.environ.update(dict.fromkeys(THREADS, "1"))
    stop = threading.Event()
    try:
        with interrupts.raised():
            with interrupts.held(stop):  # what a handler raises amid imports is printed by whatever it meets
                from inverse.cli import commands
            if stop.is_set():
                raise KeyboardInterrupt
            code = _unless_closed(commands.run)
    except KeyboardInterrupt:
        code = interrupts.told()
    finally:
        interrupts.ignore()
    sys.exit(code)


def _unless_closed(run: Callable[[list[str]], int]) -> int:
    """The exit code of the command line, also where nobody reads what it prints any more, as after ``| head -1``."""
    code = READER_GONE
    try:
        code = run(sys.argv[1:])
        if sys.stdout is not None:
            sys.stdout.flush()  # Python would do it at its very end, where nothing can answer
    except BrokenPipeError:
        _drop_unread()
    return code


def _drop_unread() -> None:
    """Let go what was printed for a reader who is gone."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (sys.stdout, sys.stderr):
        try:
            if stream is not None:
                stream.flush()
        except BrokenPipeError:
            os.dup2(nowhere, stream.fileno())


if __name__ == "__main__":
    main()
