"""The folder with the results of a run: whenever it is looked at, the files in it are those of one run.

New files are made in a hidden folder inside the output folder. Once all are there and whole, that folder is renamed,
which decides that they count. Then the files of the run before are moved away, and only then the new ones are moved
up, so that at no moment files of two runs lie side by side. Who is killed in between, in less than a millisecond,
leaves files missing but none lost: they wait in the hidden folder, and the next run, or the next command that reads a
design there, finishes the move.

To exchange the whole folder by one rename would leave no such moment, but would carry off what its owner put into it,
and cannot be done to a mount point, in a folder that may not be written, or under a shell that stands in it. The
hidden folder is inside for the same reason: there it is on the same file system, and may be written.

While a run lasts it holds a lock on the folder, which ends with the process, however that ends.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import shutil
from pathlib import Path
from typing import Self

from inverse.errors import InputError
from inverse.words import printable

WRITTEN = ("design.fold", "certificate.json", "report.json")
PICTURED = ("design.png", "states.png", "crease_pattern.svg", "layers.svg")
NAMES = WRITTEN + PICTURED

# The hidden folder by what is left to do: to fill it, to move the files of the run before away, to move its own up.
FILLING, REPLACING, PLACING = ".inverse-filling-", ".inverse-replacing", ".inverse-placing"
REPLACED = ".inverse-replaced"  # where the files of the run before go; a rename is quicker than a removal


def files(folder: Path) -> list[Path]:
    """The files of a result that are there; pictures may be missing."""
    return [folder / name for name in NAMES if (folder / name).exists()]


def output_folder(name: str, given: Path | None) -> Path:
    """The folder to write to, ``out/<name>`` if none is given; it is made when something is written.

    Raises:
        InputError: the folder cannot be made or written to.
    """
    folder = given or Path("out") / name
    existing = folder.absolute()
    while not existing.exists() and existing != existing.parent:
        existing = existing.parent
    if not existing.is_dir():
        raise InputError(f"{existing} is a file, so no results can be written to {folder}", hint="Choose another -o.")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise InputError(f"{existing} may not be written to", where=str(folder), hint="Choose another -o.")
    return folder


class Results:
    """An output folder, held by this run from ``with`` to the end of it.

    Args:
        folder: made if missing, and removed again if nothing is put into it.

    Attributes:
        folder: the same.

    Raises:
        InputError: on entering, if another run holds the folder, or it cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._new = folder / f"{FILLING}{os.getpid()}"
        self._made: list[Path] = []  # deepest first
        self._lock = -1

    def __enter__(self) -> Self:
        try:
            self._lock = self._locked()
            for name in NAMES:
                if (self.folder / name).is_dir():
                    raise InputError(f"{self.folder / name} is a folder, and a file of that name is to be written")
            _finish(self.folder)
            self._new.mkdir()
        except OSError as error:
            self.__exit__()
            raise unwritable(self.folder, error) from None
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        if self._lock >= 0:
            with contextlib.suppress(OSError):  # what is left is whole, and the next run finishes
                _finish(self.folder)
        for folder in self._made:
            try:
                folder.rmdir()
            except OSError:
                break  # it is used
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1

    def filling(self) -> Path:
        """The hidden folder, to be filled with new files under their final names."""
        self._new.mkdir(parents=True, exist_ok=True)  # somebody may have cleared up meanwhile
        return self._new

    def replace(self) -> None:
        """Put the new files where those of earlier runs are, which go."""
        self._new.rename(self.folder / REPLACING)
        _finish(self.folder)

    def add(self) -> None:
        """Put the new files beside those of this run."""
        self._new.rename(self.folder / PLACING)
        _finish(self.folder)

    def _locked(self) -> int:
        """The open folder with this run's lock on it."""
        while True:
            self._made += [one for one in (self.folder, *self.folder.parents) if not one.exists()]
            self.folder.mkdir(parents=True, exist_ok=True)
            if (handle := _lock(self.folder)) is not None:
                return handle


def settle(folder: Path) -> None:
    """Finish what a killed run left undone in a folder that is going to be read, where there is such a thing."""
    if not any((folder / name).is_dir() for name in (REPLACING, PLACING)):
        return
    try:
        if (handle := _lock(folder)) is not None:
            try:
                _finish(folder)
            finally:
                os.close(handle)
    except (InputError, OSError):
        pass  # a run is at it, or it may only be read


def other_design(folder: Path, name: str) -> str | None:
    """The name of the design whose results are in a folder, where it is another one; None if there is none.

    Args:
        folder: an output folder, there or not.
        name: of the design that is to be written there.
    """
    for file, key in (("report.json", "name"), ("design.fold", "file_title")):
        try:
            found = json.loads((folder / file).read_text(encoding="utf-8"))[key]
        except (OSError, ValueError, TypeError, KeyError):
            continue
        return str(found) if found != name else None
    return None


def check_same_design(folder: Path, name: str) -> None:
    """Refuse an output folder in which another design would be replaced.

    Args:
        folder: an output folder, there or not.
        name: of the design that is to be written there.

    Raises:
        InputError: it holds the results of a design with another name.
    """
    if (other := other_design(folder, name)) is not None:
        raise InputError(
            f"the folder holds another design, {printable(other)!r}, which {printable(name)!r} would replace",
            where=str(folder), hint="Choose another -o, or remove what is there.",
        )  # fmt: skip


def unwritable(folder: Path, error: OSError) -> InputError:
    """What is said where results cannot be written."""
    return InputError(f"the results cannot be written: {error}", where=str(folder), hint="Choose another -o.")


def _lock(folder: Path) -> int | None:
    """The folder, opened and locked; None if it was removed meanwhile by a run that put nothing into it.

    Raises:
        InputError: another run holds it.
    """
    try:
        handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    except FileNotFoundError:
        return None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        process = "".join(f", process {path.name.removeprefix(FILLING)}," for path in folder.glob(f"{FILLING}*"))
        raise InputError(
            f"another run{process} is writing to {folder}", hint="Wait until it has ended, or choose another -o."
        ) from None
    except OSError:
        pass  # a file system without locks
    try:
        there = os.path.samestat(os.fstat(handle), os.stat(folder))
    except FileNotFoundError:
        there = False
    if not there:
        os.close(handle)
        return None
    return handle


def _finish(folder: Path) -> None:
    """Do what is left to do; whoever calls this holds the folder."""
    replacing, placing = folder / REPLACING, folder / PLACING
    if replacing.is_dir():
        replaced = folder / REPLACED
        replaced.mkdir(exist_ok=True)
        for name in reversed(NAMES):  # pictures first: without them a folder is whole for as long as possible
            if (folder / name).exists():
                (folder / name).replace(replaced / name)
        replacing.rename(placing)
    if placing.is_dir():
        for path in sorted(placing.iterdir()):
            path.replace(folder / path.name)
        placing.rmdir()
    for rest in (*folder.glob(f"{FILLING}*"), *folder.glob(REPLACED)):
        shutil.rmtree(rest)
