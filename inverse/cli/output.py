"""What commands have in common: exit codes, where files go, and what is said of them and of a motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from inverse import interrupts
from inverse.errors import InputError
from inverse.files.atomic import write_together

if TYPE_CHECKING:
    from inverse.certify import Certificate

DONE, NOT_DONE, WRONG_INPUT, INTERRUPTED = 0, 1, 2, interrupts.EXIT_CODE

MOST_LINES = 8  # files that are told one by one
# What `inverse export` and `inverse fold` make of a design beside it, where no other name is asked for.
_MADE = ("cut_pattern.*", "surface.*", "panels.*", "sheet_*.dxf", "cut_list.csv", "motion.*", "state_*.fold")


def folder_for(design: Path, given: Path | None) -> Path:
    """The folder for files made from a design: the given one, or that of the design.

    Raises:
        InputError: it cannot be written to.
    """
    from inverse.results.folder import output_folder

    return output_folder(design.stem, design.parent if given is None else given)


def file_for(design: Path, given: Path) -> Path:
    """The one file to write.

    Raises:
        InputError: it is the design itself or another file of its folder that `inverse solve` wrote, or the folder
            cannot be written to.
    """
    from inverse.results.folder import NAMES

    if given.exists() and design.exists() and given.samefile(design):
        raise InputError(f"{design} would be written over", hint="Choose another -o.")
    if given.name in NAMES and given.exists() and (given.parent / "report.json").exists():
        raise InputError(
            f"{given} is a result of inverse solve or repair, and would be written over",
            hint=f"Choose another name, such as -o {given.with_stem(f'exported_{given.stem}')}.",
        )
    return folder_for(design, given.parent) / given.name


def is_file_name(given: Path | None) -> bool:
    """Whether -o names a file rather than a folder."""
    return given is not None and given.suffix != "" and not given.is_dir()


def told(paths: Sequence[Path]) -> list[str]:
    """Lines that say which files were written: many files of one folder and kind are one line.

    Args:
        paths: the files, in their order.
    """
    if len(paths) <= MOST_LINES:
        return [f"wrote     {path}" for path in paths]
    groups: dict[tuple[Path, str], list[Path]] = {}
    for path in paths:
        groups.setdefault((path.parent, path.suffix), []).append(path)
    lines = []
    for (folder, _), some in groups.items():
        if len(some) == 1:
            lines.append(f"wrote     {some[0]}")
        else:
            lines.append(f"wrote     {len(some)} files to {folder}: {some[0].name} ... {some[-1].name}")
    return lines


def made_before(folder: Path) -> str | None:
    """A sentence about files in an output folder that were made of the design that is replaced; None without any.

    Args:
        folder: an output folder, there or not.
    """
    names = sorted({path.name for pattern in _MADE for path in folder.glob(pattern)})
    if not names or not (folder / "design.fold").exists():
        return None
    several = f"{names[0]} ... {names[-1]}, {len(names)} files," if len(names) > 3 else " and ".join(names)
    are = "are" if len(names) > 1 else "is"
    return f"{several} in {folder} {are} of the design before: make {'them' if len(names) > 1 else 'it'} anew"


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


def motion(certificate: Certificate) -> list[str]:
    """How far a design folds before facets cross, and which ones do then."""
    if certificate.free_range is None:
        return []
    low, high = certificate.free_range
    found = [f"free of crossings from t = {low:g} to {high:g} degrees (0 developed, 90 the design, 180 flat-folded)"]
    return found + [crossing.sentence for crossing in certificate.crossings]
