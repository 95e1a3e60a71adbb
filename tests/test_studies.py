"""Every file in studies/ and examples/ runs, in a folder with targets/ in it."""

from __future__ import annotations

import runpy
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import pytest
from designs import eggbox

import inverse
from inverse.pictures import rendering

ROOT = Path(__file__).parents[1]
FILES = [path for folder in ("studies", "examples") for path in ROOT.glob(f"{folder}/*.py") if path.stem != "__init__"]

ARGUMENTS = {"studies/motion_picture.py": ["design.fold"]}
DRAWN = {"studies/motion_picture.py", "studies/tube_process.py"}  # files that need pictures


def name(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@pytest.mark.slow
@pytest.mark.parametrize("path", FILES, ids=name)
def test_it_runs(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, lacking: Callable[[str], NoReturn], registered: object
) -> None:
    if name(path) in DRAWN and (reason := rendering.can_render()) is not None:
        lacking(reason)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "targets").symlink_to(ROOT / "targets")
    inverse.write(eggbox(), "design.fold")
    monkeypatch.setattr(sys, "argv", [str(path), *ARGUMENTS.get(name(path), [])])
    runpy.run_path(str(path), run_name="__main__")
