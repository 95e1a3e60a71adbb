"""Where the files of `inverse fold` and `inverse export` go."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from inverse.errors import InputError
from inverse.files.atomic import write_together


def folder_for(design: Path, given: Path | None) -> Path:
    """The folder for files made from a design: the given one, or that of the design.

    Raises:
        InputError: it cannot be written to.
    """
    from inverse.results.saving import output_folder

    return output_folder(design.stem, design.parent if given is None else given)


def file_for(design: Path, given: Path) -> Path:
    """The one file to write.

    Raises:
        InputError: it is the design itself, or its folder cannot be written to.
    """
    if given.exists() and design.exists() and given.samefile(design):
        raise InputError(f"{design} would be written over", hint="Choose another -o.")
    return folder_for(design, given.parent) / given.name


def is_file_name(given: Path | None) -> bool:
    """Whether -o names a file rather than a folder."""
    return given is not None and given.suffix != "" and not given.is_dir()


def write_all(files: Mapping[Path, str | bytes]) -> None:
    """Write all files, each whole, or none of them.

    Raises:
        InputError: one cannot be written.
    """
    try:
        for path in files:
            path.parent.mkdir(parents=True, exist_ok=True)
        write_together(files)
    except OSError as error:
        names = ", ".join(str(path) for path in files)
        raise InputError(f"{names} cannot be written: {error}", hint="Choose another -o.") from None
