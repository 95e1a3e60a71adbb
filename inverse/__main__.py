"""The command line as a program: ``python -m inverse`` and the script ``inverse``."""

import os
import sys
import threading

from inverse import interrupts

# Read by the BLAS and OpenMP that numpy, scipy and casadi bring along, when they are loaded. How many threads share
# the work changes in which order they add, and so the last digits of a design.
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


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
            code = commands.run(sys.argv[1:])
    except KeyboardInterrupt:
        code = interrupts.told()
    finally:
        interrupts.ignore()
    sys.exit(code)


if __name__ == "__main__":
    main()
