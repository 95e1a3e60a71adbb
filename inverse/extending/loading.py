"""Code of users that registers terms, targets, patterns and measures: a file, or packages that say so.

A package says so by an entry point of the group ``inverse.terms`` that names its module. It is imported when a
specification names something unknown, so that what is merely installed changes no design.
"""

from __future__ import annotations

import runpy
from functools import cache
from pathlib import Path

from inverse.errors import InputError

GROUP = "inverse.terms"


def load_file(path: Path) -> None:
    """Run a Python file, which registers what it likes.

    Raises:
        InputError: there is no such file, it is no Python, or it raised something; that is the cause.
    """
    if not path.is_file():
        raise InputError("there is no such file", where=str(path), hint="--with takes a Python file.")
    try:
        runpy.run_path(str(path))
    except InputError as error:
        raise InputError(error.message, where=str(path), hint=error.hint) from error
    except SyntaxError as error:
        where = f"{error.filename or path}:{error.lineno or 1}:{error.offset or 1}"
        raise InputError(f"this is no valid Python: {error.msg}", where=where) from error
    except (Exception, SystemExit) as error:
        raise InputError(f"running it raised {told(error)}", where=f"{path}{_line(error, path)}") from error


@cache
def load_installed() -> None:
    """Import the modules that installed packages name in the entry point group, once.

    Raises:
        InputError: one of them cannot be imported; what it raised is the cause.
    """
    from importlib.metadata import entry_points

    for point in entry_points(group=GROUP):
        try:
            point.load()
        except Exception as error:
            package = point.dist.name if point.dist else "an installed package"
            raise InputError(
                f"the entry point {point.name} = {point.value} of {package} raised {told(error)}",
                hint=f"It is of the group {GROUP}: mend or remove the package.",
            ) from error


def told(error: BaseException) -> str:
    """An exception on one line, shortened."""
    text = " ".join(f"{type(error).__name__}: {error}".split()).rstrip(": ")
    return text if len(text) <= 300 else f"{text[:297]}..."


def _line(error: BaseException, path: Path) -> str:
    """``:12``, the last line of the file that an exception came through."""
    line, step = "", error.__traceback__
    while step is not None:
        if step.tb_frame.f_code.co_filename == str(path):
            line = f":{step.tb_lineno}"
        step = step.tb_next
    return line
