"""`inverse fold` as a user meets it."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import designs
import numpy as np
import pytest

import inverse
from inverse.cli import commands
from inverse.fabricate.film import film
from inverse.pictures import rendering


@pytest.fixture
def design(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("mine").mkdir()
    inverse.write(designs.hybrid(), "mine/sheet.fold")
    inverse.write(designs.perturbed(designs.miura(), 1e-3), "torn.fold")
    return Path("mine/sheet.fold")


def everything(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("--at -1", ["-1 degrees", "0 (developed) to 180"]),
        ("--at 180.5", ["180.5 degrees"]),
        ("--at 30 --at nan", ["nan"]),
        ("--at 30 --at 60 -o one.fold", ["2 states", "folder"]),
        ("--at 30 -o one.glb", [".fold"]),
        ("--at 30 -o mine/sheet.fold", ["written over"]),
        ("--at 30 --frames 5", ["--frames", "--at"]),
        ("--at 30 --frames 0", ["--frames", "--at"]),
        ("--frames 1", ["1 frames", "from 2 to 5000"]),
        ("--frames 0", ["0 frames"]),
        ("--frames 2.5", ["2.5 is no whole number"]),
        ("--to avi", ["'avi'", "mp4, gif, glb, html"]),
        ("--to gfi", ["Did you mean gif?"]),
        ("-o film.mov", ["'mov'", "mp4, gif, glb, html"]),
        ("-o film.mp4 --to gif", ["film.mp4", "gif"]),
        ("-o film.fold", ["--at"]),
        ("--range 20 181", ["181"]),
        ("--range 60 60", ["none"]),
        ("--to gif --size 641 480", ["641 x 480", "even"]),
        ("-o mine/sheet.fold/out", ["sheet.fold is a file"]),
        ("--target missing.obj", ["missing.obj"]),
        ("--context missing.json", ["missing.json"]),
        ("--to glb --thickness 0.02", ["glb cannot show thick panels", "mp4 and gif"]),
        ("--to gif --delta 20", ["--thickness"]),
        ("--to gif --thickness 0.02 --range 0 180", ["the panels fold from", "asked are 0 to 180"]),
        ("--to gif --thickness 9", ["largest thickness that works"]),
        ("--at 30 --thickness 0.02", ["--thickness", "--at"]),
        ("torn.fold", ["come apart", "inverse check"]),
        ("nothing.fold", ["nothing.fold"]),
        ("nothing.fold -o torn.fold --at 3", ["nothing.fold"]),
    ],
)
def test_wrong_input_is_refused_and_nothing_written(
    arguments: str, words: list[str], design: Path, capsys: pytest.CaptureFixture[str]
):
    before = everything(Path())
    given = arguments.split()
    code = commands.run(
        ["fold", *([] if given[0].endswith("n.fold") or given[0] == "nothing.fold" else [str(design)]), *given]
    )
    said = capsys.readouterr()
    assert code == 2
    assert all(word in said.err + said.out for word in words), said.err
    assert everything(Path()) == before


def test_states_are_written_to_a_folder(design: Path, capsys: pytest.CaptureFixture[str]):
    assert commands.run(["fold", str(design), "--at", "0", "--at", "45.5", "--at", "180", "--at", "0"]) == 0
    names = ["state_0.fold", "state_45.5.fold", "state_180.fold"]
    assert capsys.readouterr().out.splitlines() == [f"wrote     mine/{name}" for name in names]
    assert sorted(path.name for path in Path("mine").iterdir()) == sorted([*names, "sheet.fold"])
    assert inverse.check("mine/state_45.5.fold").certified


def test_one_state_is_written_to_the_file_asked_for(design: Path):
    assert commands.run(["fold", str(design), "--at", "120", "-o", "new/here.fold"]) == 0
    expected = inverse.fold(designs.hybrid(), np.radians([120.0])).vertices_coords[0]
    found = inverse.read("new/here.fold").vertices_coords
    np.testing.assert_allclose(designs.best_motion(found, expected), expected, rtol=0, atol=1e-12)


def test_page_is_written_where_nothing_is_said(design: Path, capsys: pytest.CaptureFixture[str]):
    assert commands.run(["fold", str(design), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"files": ["mine/motion.html"]}
    assert Path("mine/motion.html").read_text().startswith("<!DOCTYPE html>")


def test_formats_are_told_by_name_or_by_ending(design: Path):
    assert commands.run(["fold", str(design), "--frames", "3", "--to", "glb", "--to", "html", "-o", "there"]) == 0
    assert sorted(path.name for path in Path("there").iterdir()) == ["motion.glb", "motion.html"]
    assert commands.run(["fold", str(design), "--frames", "3", "-o", "Film.GLB"]) == 0
    assert Path("Film.GLB").read_bytes()[:4] == b"glTF"


def test_interrupted_drawing_leaves_nothing(
    design: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    before = everything(Path())

    def stop(_, progress):
        progress(1)
        raise KeyboardInterrupt

    monkeypatch.setattr(rendering, "lacking", lambda: None)
    monkeypatch.setattr(film.Renderer, "_start", lambda _: None)
    monkeypatch.setattr(film.Renderer, "missing", lambda _: None)
    monkeypatch.setattr(film.Renderer, "finish", stop)
    assert commands.run(["fold", str(design), "--to", "mp4", "--to", "glb", "--frames", "3"]) == 3
    assert everything(Path()) == before


def test_the_command_line_starts_light():
    code = (
        "import sys, inverse.cli.commands; print([name for name in ('casadi', 'numpy', 'vtk') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_thick_panels_are_filmed_over_their_range(design: Path):
    from PIL import Image

    words = ["--to", "gif", "--frames", "3", "--size", "96", "64", "-o", "thick.gif"]
    assert commands.run(["fold", str(design), *words, "--thickness", "0.01"]) == 0
    assert commands.run(["fold", str(design), *words[:-1], "thin.gif"]) == 0
    with Image.open("thick.gif") as thick, Image.open("thin.gif") as thin:
        assert (thick.n_frames, thick.size) == (3, (96, 64))
        assert np.abs(np.asarray(thick.convert("L"), float) - np.asarray(thin.convert("L"), float)).max() > 30
