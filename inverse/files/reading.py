"""Files that somebody gives, read with care."""

from __future__ import annotations

import json
import stat
from pathlib import Path
from typing import Any

from inverse.errors import InputError
from inverse.words import did_you_mean


def read_bytes(path: Path, most: int) -> bytes:
    """The content of a file that somebody gives.

    Only regular files are read: a pipe or a device may never answer, or never end.

    Args:
        path: the file.
        most: largest size allowed, in bytes.

    Raises:
        InputError: there is no such file, it is none or empty, is too large or cannot be read; the message names it.
    """
    where = str(path)
    try:
        known = path.stat()
        kind, size = known.st_mode, known.st_size
        if not stat.S_ISREG(kind):
            what = "a folder" if stat.S_ISDIR(kind) else "a device, pipe or socket"
            raise InputError(f"this is {what}, not a file", where=where)
        if size > most:
            message = f"the file is larger than {most // 10**6} MB, the most that is read of its kind"
            raise InputError(message, where=where)
        with path.open("rb") as file:
            content = file.read(size + 1)
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(f"there is no such file.{_sibling(path)}", where=where) from None
    except InputError:
        raise
    except (OSError, ValueError) as error:  # a name with a null byte is a ValueError
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"the file cannot be read: {reason}", where=where) from None
    if len(content) != size:
        raise InputError("the file changed while it was read", where=where, hint="Try again.")
    if not content:
        raise InputError("the file is empty", where=where)
    return content


def read_text(path: Path, most: int) -> str:
    """The content of a UTF-8 text file that somebody gives; a byte order mark is left out.

    Args:
        path: the file.
        most: largest size allowed, in bytes.

    Raises:
        InputError: as :func:`read_bytes`, or with line and column a byte that is not UTF-8.
    """
    content = read_bytes(path, most)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = content[: error.start].removeprefix(b"\xef\xbb\xbf")
        line = before.count(b"\n") + 1
        column = len(before.rsplit(b"\n", 1)[-1].decode("utf-8", "replace")) + 1
        message = f"the byte 0x{content[error.start]:02x} is not valid UTF-8"
        raise InputError(message, where=f"{path}:{line}:{column}", hint="Save the file as UTF-8.") from None


def json_object(text: str, name: str, line: int | None = None) -> dict[str, Any]:
    """The object in a JSON text that somebody gives.

    Args:
        text: the text.
        name: the file's name, for messages.
        line: number of its first line in the file, where that holds other objects too.

    Raises:
        InputError: no JSON, with line and column; a key given twice in one object; no object.
    """
    where = name if line is None else f"{name}:{line}"
    try:
        document = json.loads(text, object_pairs_hook=_once)
    except json.JSONDecodeError as error:
        place = f"{name}:{(line or 1) + error.lineno - 1}:{error.colno}"
        raise InputError(f"this is not JSON: {error.msg}", where=place) from None
    except InputError as error:
        raise InputError(error.message, where=where, hint=error.hint) from None
    except ValueError as error:  # a number with thousands of digits
        raise InputError(f"this is not JSON that can be read: {error}", where=where) from None
    except RecursionError:
        raise InputError("the JSON is nested too deeply", where=where) from None
    if not isinstance(document, dict):
        raise InputError("the file must hold a JSON object in braces", where=where)
    return document


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    found = dict(pairs)
    if len(found) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for k, key in enumerate(keys) if key in keys[:k])
        raise InputError(f"the key {twice[:60]!r} is given twice in one object", hint="Leave one of them out.")
    return found


def _sibling(path: Path) -> str:
    """A suggestion from the same folder, among files of the same kind."""
    try:
        return did_you_mean(path.name, [p.name for p in path.parent.iterdir() if p.suffix[:3] == path.suffix[:3]])
    except (OSError, ValueError):
        return ""
