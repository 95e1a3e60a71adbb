"""`inverse draw` as a user meets it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import designs
import numpy as np
import pytest

import inverse
from inverse.cli import commands
from inverse.results.folder import NAMES


@pytest.fixture
def design(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("mine").mkdir()
    inverse.write(replace(designs.tube(6, 4), unit="m", name="tube"), "mine/design.fold")
    return Path("mine/design.fold")


def everything(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def run(line: str) -> int:
    return commands.run(["draw", *line.split()])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("--what plam", ["'plam' is no view", "Did you mean plan?"]),
        ("--what plan,", ["'' is no view"]),
        ("--paper A9", ["'A9' is no paper", "A0, A1, A2, A3, A4"]),
        ("--what plan --scale 50", ["'50' is no scale", "1:50"]),
        ("--what plan --scale 1:1", ["at 1:1 the drawing is", "no room on A3", "--scale 1:"]),
        ("--what board --scale 1:1", ["at 1:1 the board has no room on A1", "--scale 1:"]),
        ("--to dxf", ["'dxf' is no format of drawings", "pdf, svg, png"]),
        ("--at 1", ["a section at 1 cuts nothing", "--at 0.5"]),
        ("--states 40", ["40 states", "2 to 12"]),
        ("--states 2.5", ["2.5 is no whole number"]),
        ("--size 30000", ["30000 pixels", "--size"]),
        ("--style drawn", ["drawn", "shadow"]),
        ("-o mine/design.fold", ["'fold' is no format of drawings"]),
        ("-o plan.jpg", ["'jpg' is no format of drawings"]),
        ("-o both.pdf --what plan,front", ["2 views cannot be one file"]),
        ("-o plan.pdf --what plan --to svg", ["plan.pdf is no file of format svg"]),
        ("--context no.yaml", ["no.yaml", "no such file"]),
        ("--target no.obj", ["no.obj", "no such file"]),
    ],
)
def test_what_cannot_be_drawn_is_refused_with_words(
    design: Path, capsys: pytest.CaptureFixture[str], arguments: str, words: list[str]
):
    before = everything(Path())
    assert run(f"{design} {arguments}") == commands.WRONG_INPUT
    said = " ".join("".join(capsys.readouterr().err.split("│")).split())
    for one in words:
        assert one in said
    assert everything(Path()) == before


def test_files_go_beside_the_design_and_are_told_in_one_line(design: Path, capsys: pytest.CaptureFixture[str]):
    assert run(f"{design} --what plan,section --size 300") == 0
    told = capsys.readouterr().out.splitlines()
    assert told == ["wrote     mine/drawings/{plan,section}.{pdf,svg,png}"]
    names = sorted(path.name for path in Path("mine/drawings").iterdir())
    assert names == ["plan.pdf", "plan.png", "plan.svg", "section.pdf", "section.png", "section.svg"]
    assert run(f"{design} --what plan --to svg -o elsewhere") == 0
    assert capsys.readouterr().out == "wrote     elsewhere/plan.svg\n"
    assert Path("elsewhere/plan.svg").read_bytes() == Path("mine/drawings/plan.svg").read_bytes()


def test_a_file_is_named_after_its_view(design: Path, capsys: pytest.CaptureFixture[str]):
    assert run(f"{design} -o front.svg --json") == 0
    assert json.loads(capsys.readouterr().out) == {"files": ["front.svg"]}
    assert "Front elevation" in Path("front.svg").read_text()
    assert run(f"{design} -o mine.svg") == 0
    assert "Board" in Path("mine.svg").read_text()


def test_nothing_that_solve_wrote_is_written_over(design: Path, capsys: pytest.CaptureFixture[str]):
    for name in set(NAMES) - {"design.fold"}:
        (Path("mine") / name).write_text("{}")
    before = everything(Path("mine"))
    assert run(f"{design} -o mine/design.png --what plan") == commands.WRONG_INPUT
    assert "would be written over" in capsys.readouterr().err
    assert run(f"{design} -o mine/crease_pattern.svg --what plan") == commands.WRONG_INPUT
    assert run(f"{design} -o mine --what all --size 200") == 0
    after = everything(Path("mine"))
    assert {path: after[path] for path in before} == before


def test_a_unit_without_length_has_no_scale_but_a_drawing(design: Path, capsys: pytest.CaptureFixture[str]):
    inverse.write(replace(designs.miura(), unit="unit"), "plain.fold")
    assert run("plain.fold --what plan --scale 1:10") == commands.WRONG_INPUT
    assert "the design's unit is 'unit', which has no length" in capsys.readouterr().err
    assert run("plain.fold -o plan.svg") == 0
    assert "1 unit = " in Path("plan.svg").read_text()


def test_what_a_report_tells_is_drawn(design: Path):
    made = designs.tube(6, 4).vertices_coords
    anchors = [{"vertices": [0], "to": {"point": made[0].tolist()}}]
    report = {"certified": True, "converged": False, "specification": {"constraints": {"anchors": anchors}}}
    Path("mine/report.json").write_text(json.dumps(report))
    Path("mine/certificate.json").write_text(json.dumps({"free_range": [0.0, 120.0]}))
    assert run(f"{design} -o board.svg") == 0
    words = Path("board.svg").read_text()
    for one in ("at 1 vertex", "from 0° to 120°", "Foldable", "packed (flat-folded), facets would meet"):
        assert one in words, one


def test_context_and_target_of_a_specification(design: Path):
    vault = Path(__file__).parents[2] / "targets" / "vault.yaml"
    sheet = replace(designs.miura(6, 8), unit="m")
    inverse.write(sheet.moved_to(sheet.vertices_coords + np.array([0.0, 0.0, 18.0])), "sheet.fold")
    assert run(f"sheet.fold --context {vault} --target {vault} --what plan,right --to svg") == 0
    assert "stroke-dasharray" in Path("drawings/plan.svg").read_text()


def test_a_motion_that_is_none_is_refused_and_a_plan_is_drawn(design: Path, capsys: pytest.CaptureFixture[str]):
    sheet = designs.eggbox(4, 4)
    off = sheet.moved_to(sheet.vertices_coords + 0.01 * np.random.default_rng(0).standard_normal((25, 3)))
    inverse.write(off, "off.fold")
    assert run("off.fold --what motion") == commands.WRONG_INPUT
    assert "does not fold rigidly" in capsys.readouterr().err
    assert run("off.fold --what plan --to svg") == 0
