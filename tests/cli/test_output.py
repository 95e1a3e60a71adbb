"""What commands print and write, where a user looks for it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import designs
import pytest

import inverse
from inverse.cli import commands
from inverse.cli.output import told
from inverse.pictures import rendering

DOME = """\
name: dome
pattern: {size: [4, 4], u_lines: CFL}
target: {height: "sqrt(4 - x^2 - y^2)", domain: [[-1, 1], [-1, 1]]}
"""


@pytest.fixture
def results(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a solve, without 3D pictures."""
    monkeypatch.setattr(rendering, "lacking", lambda: "no pictures here")
    monkeypatch.chdir(tmp_path)
    Path("dome.yaml").write_text(DOME)
    assert commands.run(["solve", "dome.yaml"]) == 0
    return Path("out/dome")


def test_exports_leave_what_solve_wrote(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = {path: path.read_bytes() for path in results.iterdir()}
    for words in (["--to", "svg"], ["--to", "svg", "--layers", "apart"], ["--to", "fold"], ["--to", "obj"]):
        assert commands.run(["export", str(results / "design.fold"), *words]) == 0
    assert {path: path.read_bytes() for path in before} == before
    assert {path.name for path in results.iterdir()} - {path.name for path in before} == {
        "cut_pattern.svg", "cut_pattern.fold", "surface.obj",
    }  # fmt: skip
    capsys.readouterr()
    for name in ("crease_pattern.svg", "layers.svg"):
        given = ["export", str(results / "design.fold"), "-o", str(results / name)]
        assert commands.run(given) == 2
        said = capsys.readouterr().err
        assert f"{results / name} is a result of inverse solve" in said
        advice = said.split(" such as -o ")[1].strip().rstrip(".")
        assert commands.run([*given[:-1], advice]) == 0
    assert {path: path.read_bytes() for path in before} == before


def test_an_export_is_named_as_one_likes_elsewhere(results: Path) -> None:
    assert commands.run(["export", str(results / "design.fold"), "-o", "crease_pattern.svg"]) == 0
    assert commands.run(["export", str(results / "design.fold"), "-o", "crease_pattern.svg"]) == 0


def test_solve_tells_the_range_without_crossings(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert commands.run(["solve", "dome.yaml"]) == 0
    printed = capsys.readouterr().out
    assert "motion    free of crossings from t = 0 to 180 degrees" in printed


def test_the_first_crossing_is_told(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A tube runs into itself before it is flat."""
    inverse.write(designs.tube(6, 4), tmp_path / "tube.fold")
    certificate = inverse.check(tmp_path / "tube.fold")
    assert commands.run(["check", str(tmp_path / "tube.fold")]) == 0
    printed = capsys.readouterr().out
    for crossing in certificate.crossings:
        assert crossing.sentence in printed


def test_long_lists_of_files_are_one_line() -> None:
    sheets = [Path(f"out/sheet_{k:03}.dxf") for k in range(1, 105)]
    assert told([*sheets, Path("out/cut_list.csv")]) == [
        "wrote     104 files to out: sheet_001.dxf ... sheet_104.dxf",
        "wrote     out/cut_list.csv",
    ]
    assert told(sheets[:3]) == [f"wrote     out/sheet_00{k}.dxf" for k in (1, 2, 3)]


@pytest.mark.parametrize("arguments", [["schema"], ["schema", "report"], ["check", "sheet.fold"], ["--help"]])
@pytest.mark.parametrize("which", ["stdout", "stderr"])
def test_a_reader_who_is_gone_gets_no_traceback(arguments: list[str], which: str, tmp_path: Path) -> None:
    inverse.write(designs.eggbox(4, 4), tmp_path / "sheet.fold")
    read, write = os.pipe()
    os.close(read)
    other = subprocess.PIPE
    streams = {"stdout": write, "stderr": other} if which == "stdout" else {"stdout": other, "stderr": write}
    done = subprocess.run(
        [sys.executable, "-m", "inverse", *arguments], cwd=tmp_path, **streams, timeout=60, check=False
    )
    os.close(write)
    assert done.returncode in ((0, 1, 141) if "--help" in arguments else (0, 141))  # help is printed by a library
    assert done.stderr in (None, b"")


def test_the_verdict_outlives_the_reader(tmp_path: Path) -> None:
    """What is printed is lost, not how it went."""
    (tmp_path / "wrong.fold").write_text("{")
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run([sys.executable, "-m", "inverse", "check", "wrong.fold"], cwd=tmp_path, stdout=write,
                          stderr=subprocess.PIPE, timeout=60, check=False)  # fmt: skip
    os.close(write)
    assert done.returncode == 2


def test_files_of_the_design_before_are_told(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (results / "notes.txt").write_text("mine")
    capsys.readouterr()
    assert commands.run(["solve", "dome.yaml"]) == 0
    assert "of the design before" not in capsys.readouterr().err
    for words in (["export", "--to", "svg"], ["fold", "--to", "html"]):
        assert commands.run([words[0], str(results / "design.fold"), *words[1:]]) == 0
    capsys.readouterr()
    assert commands.run(["solve", "dome.yaml"]) == 0
    assert f"cut_pattern.svg and motion.html in {results} are of the design before" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["fold", "a.fold", "--at", "45", "100"], ["no argument or option takes 100", "`inverse fold --help`"]),
        (["solve", "a.yaml", "--ste", "a=1"], ["Unknown option", "Did you mean --set?"]),
        (["export", "a.fold", "--to", "pdf", "--scale", "1:x"], ["1:x is no scale, such as 1:50 or 0.02"]),
    ],
)
def test_misuse_is_told_in_plain_lines(
    arguments: list[str], words: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert commands.run(arguments) == 2
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    for word in words:
        assert word in said


def test_help_says_where_files_go(capsys: pytest.CaptureFixture[str]) -> None:
    """And no option shows a default that nobody would write."""
    for command in ("solve", "repair"):
        assert commands.run([command, "--help"]) == 0
        words = " ".join(capsys.readouterr().out.replace("│", " ").split())
        assert "by default out/NAME" in words
    for command in ("solve", "check", "repair", "fold", "export"):
        assert commands.run([command, "--help"]) == 0
        printed = capsys.readouterr().out
        assert "default: ()" not in printed
        assert "--empty" not in printed
