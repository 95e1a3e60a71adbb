"""`inverse export` as a user meets it."""

from __future__ import annotations

import csv
import json
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import designs
import numpy as np
import pytest
import trimesh

import inverse
from inverse.cli import commands
from inverse.fabricate import formats
from inverse.fabricate.formats import Settings
from inverse.origami import folding


@pytest.fixture
def design(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("mine").mkdir()
    inverse.write(designs.tube(6, 4), "mine/tube.fold")
    return Path("mine/tube.fold")


def everything(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("", ["no format", "--to"]),
        ("--to stpl", ["'stpl'", "Did you mean stl?"]),
        ("--to step --thickness 0.02", ["'step'", "thick panels", "obj, ply, stl, glb, 3mf, 3dm, dxf"]),
        ("--to obj --density 700", ["obj", "--density", "--at"]),
        ("--to stl --delta 20", ["stl", "--delta"]),
        ("--to obj --at 190", ["190 degrees", "0 (developed) to 180"]),
        ("--to stl --thickness 3", ["3", "facet", "largest thickness that works"]),
        ("--to stl --thickness -0.1", ["-0.1", "greater than 0"]),
        ("--to stl --thickness 0.02 --delta 180", ["180 degrees", "between 0 and 180"]),
        ("--to stl --thickness 0.02 --hinge -1", ["-1", "hinge"]),
        ("--to stl --thickness 0.02 --delta-of 0-29=20", ["no foldline between vertices 0 and 29"]),
        ("--to stl --thickness 0.02 --delta-of x", ["x is no foldline", "12-19=20"]),
        ("--to stl --thickness 0.02 --at 180", ["180"]),
        ("--to dxf --thickness 0.02", ["--sheet"]),
        ("--to dxf --thickness 0.02 --sheet 0.1 0.1", ["0.1"]),
        ("--to dxf --thickness 0.02 --sheet 9 9 --density 0", ["density"]),
        ("--to dxf --thickness 0.02 --sheet 9 9 -o one.dxf", ["files cannot be one file", "folder"]),
        ("--to svg --dash 3", ["both --dash and --gap"]),
        ("--to svg --dash 1e-6 --gap 1e-6", ["cuts: at most 500000", "longer ones"]),
        ("--to svg --scale 1e-300", ["1e-300", "0.001 to 1e+09 mm", "1 : 10"]),
        ("--to fold --scale 1e300", ["1e+300", "0.001 to 1e+09 mm"]),
        ("--to svg --dash 3 --gap -1", ["gaps are -1 mm", "more than 0"]),
        ("--to dxf --scale 0", ["scale is 0", "1 : 10"]),
        ("--to svg --flaps -2", ["flaps are -2 mm"]),
        ("--to svg --layers apart --flaps 3", ["--layers or --flaps"]),
        ("--to svg --layers beside", ["beside", "apart", "stacked"]),
        ("--to svg --paper A4", ["--paper", "--dash"]),
        ("--to pdf --paper A9", ["'A9' is no paper", "A0, A1", "Did you mean"]),
        ("--to pdf --scale 50", ["pages of A4", "at most 500", "smaller scale"]),
        ("--to svg --thickness 0.02", ["'svg' is no format of thick panels", "Without --thickness"]),
        ("--to fold --at 30", ["--at", "--scale"]),
        ("--to fold -o mine/tube.fold", ["written over"]),
        ("--to ply -o one.obj", ["one.obj", "ply"]),
        ("-o mine/tube.fold/out --to obj", ["tube.fold is a file"]),
    ],
)
def test_wrong_input_is_refused_and_nothing_written(
    arguments: str, words: list[str], design: Path, capsys: pytest.CaptureFixture[str]
):
    before = everything(Path())
    assert commands.run(["export", str(design), *arguments.split()]) == commands.WRONG_INPUT
    said = capsys.readouterr().err
    flowing = " ".join(said.replace("│", " ").split())
    assert all(word in flowing for word in words), said
    assert "Traceback" not in said
    assert everything(Path()) == before


def test_a_folder_that_is_none_is_refused_with_nothing_written(design: Path, capsys: pytest.CaptureFixture[str]):
    assert commands.run(["export", str(design), "--to", "obj", "-o", "/proc/none"]) == commands.WRONG_INPUT
    assert "/proc" in capsys.readouterr().err


@pytest.mark.parametrize("name", formats.PATTERNS)
def test_crease_patterns_go_beside_the_design(name: str, design: Path, capsys: pytest.CaptureFixture[str]):
    words = [] if name == "fold" else ["--dash", "4", "--gap", "2", "--flaps", "5"]
    assert commands.run(["export", str(design), "--to", name, "--scale", "0.05", *words]) == 0
    path = Path(f"mine/cut_pattern.{name}")
    first = path.read_bytes()
    assert str(path) in capsys.readouterr().out
    assert commands.run(["export", str(design), "--to", name, "--scale", "0.05", *words]) == 0
    assert path.read_bytes() == first


def test_layers_are_drawn_on_demand(design: Path):
    for word in ("apart", "stacked"):
        assert commands.run(["export", str(design), "-o", f"{word}.svg", "--layers", word, "--scale", "0.05"]) == 0
    assert "layer 1 of 2" in Path("apart.svg").read_text()
    assert "layer 1 of 2" not in Path("stacked.svg").read_text()


@pytest.mark.parametrize("name", [*formats.PATTERNS, *formats.SURFACES])
def test_any_title_is_written(name: str, design: Path):
    document = json.loads(design.read_text()) | {"file_title": "<a>\u0007\ud800\r\nb \u6771"}
    design.write_text(json.dumps(document))
    words = ["--scale", "0.05"] if name in formats.PATTERNS else []
    assert commands.run(["export", str(design), "--to", name, "-o", "out", *words]) == 0
    (path,) = Path("out").iterdir()
    if name == "svg":
        title = ElementTree.parse(path).findtext("{http://www.w3.org/2000/svg}title")
        assert title == "<a>    b \u6771"


@pytest.mark.parametrize("name", formats.SURFACES)
def test_surfaces_go_beside_the_design(name: str, design: Path, capsys: pytest.CaptureFixture[str]):
    assert commands.run(["export", str(design), "--to", name]) == 0
    path = Path(f"mine/surface.{name}")
    assert path.stat().st_size > 0
    assert str(path) in capsys.readouterr().out


def test_a_state_is_written_to_the_file_asked_for(design: Path):
    assert commands.run(["export", str(design), "-o", "out/half.obj", "--at", "45"]) == 0
    mesh = trimesh.load("out/half.obj", process=False)
    state = folding.fold(inverse.read(design), np.array([np.pi / 4])).vertices_coords[0]
    sizes = np.sort(np.linalg.norm(state[:, None] - state[None], axis=2).ravel())
    points = np.unique(np.round(np.asarray(mesh.vertices), 9), axis=0)
    own = np.sort(np.linalg.norm(points[:, None] - points[None], axis=2).ravel())
    assert own == pytest.approx(sizes, abs=1e-6)


def test_panels_are_told_with_their_range_and_contacts(design: Path, capsys: pytest.CaptureFixture[str]):
    assert commands.run(["export", str(design), "--to", "stl", "--thickness", "0.02", "--json"]) == 0
    said = capsys.readouterr()
    told = json.loads(said.out)
    assert told["files"] == ["mine/panels.stl"]
    assert told["notes"][0].startswith("panels fold from t = ")
    assert any("no panels penetrate each other" in note for note in told["notes"])
    assert "first contact" in said.err
    assert trimesh.load("mine/panels.stl").is_watertight


def test_sheets_and_their_list_are_written_together(design: Path):
    words = ["--to", "dxf", "--thickness", "0.02", "--sheet", "4", "4", "--density", "700", "-o", "cut"]
    assert commands.run(["export", str(design), *words]) == 0
    with Path("cut/cut_list.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 48
    assert {Path("cut", row["sheet"]) for row in rows} == set(Path("cut").glob("*.dxf"))


def test_a_foldline_may_have_a_delta_of_its_own(design: Path):
    mesh = inverse.read(design)
    line = next(line for line in mesh.pattern.lines if line[0] != line[-1])
    a, b = line[1:3]
    thickness = formats.thickness_of(mesh, Settings(thickness=0.02, deltas_degrees=((a, b, 25.0),)))
    assert thickness is not None
    deltas = np.degrees(thickness.deltas(mesh.pattern))
    on_line = {frozenset(pair) for pair in pairwise(line)}
    for (u, v), delta in zip(mesh.pattern.edges_vertices.tolist(), deltas, strict=True):
        assert delta == pytest.approx(25 if frozenset((u, v)) in on_line else 10)
