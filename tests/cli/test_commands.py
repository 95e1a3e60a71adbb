"""The command line as a user meets it: exit codes, places, hints, and nothing written on wrong input."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import inverse
from inverse.cli import commands
from inverse.origami import seeds
from inverse.pictures import rendering

DOME = """\
name: dome
pattern:
  kind: grid
  size: [6, 6]
target:
  height: "sqrt(4 - x^2 - y^2)"
  domain: [[-1, 1], [-1, 1]]
"""
MESH = DOME[: DOME.index("target")] + "target: {mesh: hill.obj}\n"
ANCHORED = DOME + "constraints:\n  anchors:\n    - "


@pytest.fixture(autouse=True)
def without_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drawing has tests of its own."""
    monkeypatch.setattr(rendering, "lacking", lambda: "no pictures here")


def run(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    code = commands.run(arguments)
    printed = capsys.readouterr()
    return code, printed.out, printed.err


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        (DOME.replace("kind", "knid"), "3:3", ["knid", "Did you mean kind?"]),
        (DOME.replace("  size", "  u_lines: LF\n  size"), "4:12", ["LF", "FL", "CFL", "Did you mean FL?"]),
        (DOME.replace("  size", "  v_lines: [FL, CFL]\n  size"), "4:3", ["2 words", "5 interior v lines"]),
        (DOME.replace("[6, 6]", "[0, 6]"), "4:10", ["0", "at least 1"]),
        (DOME.replace("  size", "  sector_angle: 90\n  size"), "4:17", ["90", "less than 90"]),
        (DOME.replace("sqrt(", "__import__("), "6:11", ["__import__", "sqrt"]),
        (DOME.replace("sqrt(4", "sqrt(1.5"), "6:11", ["no value"]),
        (MESH, "5:16", ["hill.obj"]),
        (ANCHORED + "{side: w0, to: {point: [0, 0, 0]}}\n", "10:14", ["w0", "u0"]),
        (ANCHORED + "{side: ends, to: {point: [0, 0, 0]}}\n", "10:14", ["names no boundary"]),
        (ANCHORED + "{vertices: [99], to: {point: [0, 0, 0]}}\n", "10:18", ["vertex 99", "0 to 48"]),
        (ANCHORED + "{side: u0, to: {point: [0, 0, 0]}}\n", "10:22", ["7 vertices", "coincide"]),
        (
            ANCHORED + "{side: u0, to: {polyline: [[-9, 0, 0], [9, 0, 0]]}}\n"
            "    - {side: u1, to: {polyline: [[-9, 1, 0], [9, 1, 0]]}}\n"
            "    - {vertices: [8, 9, 10, 11, 12, 15, 16, 17, 18, 19, 22, 23], to: {polyline: [[0, 0, 0], [1, 0, 0]]}}\n"
            "    - {vertices: [24, 25, 26, 29, 30], to: {polyline: [[0, 0, 0], [1, 0, 0]]}}\n",
            "13:7", ["takes 10 freedoms", "61", "9 are left"],
        ),
        (
            ANCHORED + "{side: u0, to: {polyline: [[-9, 0, 0], [9, 0, 0]]}}\n"
            "    - {side: v0, to: {polyline: [[0, -9, 0], [0, 9, 0]]}}\n",
            "10:7", ["on one straight line", "every: 2"],
        ),
        (DOME + "objectives: {fairnes: 1}\n", "8:14", ["fairnes", "fairness"]),
    ],
)  # fmt: skip
def test_wrong_input_is_located_and_explained(
    text: str, place: str, words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    specification = tmp_path / "dome.yaml"
    specification.write_text(text)
    code, out, error = run(["solve", str(specification), "-o", str(tmp_path / "out")], capsys)
    assert code == 2
    assert out == ""
    assert f"{specification}:{place}:" in error
    for word in words:
        assert word in error
    assert text.splitlines()[int(place.split(":")[0]) - 1].strip() in error  # the line itself
    assert "Traceback" not in error
    assert sorted(p.name for p in tmp_path.iterdir()) == ["dome.yaml"]  # nothing was written


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", ["empty"]),
        ("v 0 0 0\nv 1 0 0\n", ["no facets"]),
        ("v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n", ["hill.obj:3:"]),
        ("v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n", ["no size"]),
        ("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", ["no area"]),
    ],
)
def test_target_meshes_that_are_none(
    content: str, words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "hill.obj").write_text(content)
    (tmp_path / "dome.yaml").write_text(MESH)
    code, _, error = run(["solve", str(tmp_path / "dome.yaml"), "-o", str(tmp_path / "out")], capsys)
    assert code == 2
    assert "dome.yaml:5:" in error
    for word in [*words, "hill.obj"]:
        assert word in error
    assert not (tmp_path / "out").exists()


def test_solving_writes_what_the_contract_promises(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "dome.yaml").write_text(DOME)
    out = tmp_path / "out"
    code, printed, error = run(["solve", str(tmp_path / "dome.yaml"), "-o", str(out), "--json"], capsys)
    assert code == 0
    assert "no pictures here" in error
    summary = json.loads(printed)
    assert summary["certified"]
    assert summary["converged"]
    assert sorted(p.name for p in out.iterdir()) == [
        "certificate.json", "crease_pattern.svg", "design.fold", "report.json",
    ]  # fmt: skip
    certificate = json.loads((out / "certificate.json").read_text())
    assert list(certificate["checks"]) == [
        "structure", "planarity", "developability", "flat_foldability",
        "fold_angle", "motion_gap", "loop_closure", "crossing_design",
    ]  # fmt: skip
    assert all(set(check) == {"value", "limit", "unit", "worst", "pass"} for check in certificate["checks"].values())
    assert certificate["free_range"] == [0, 180]
    report = json.loads((out / "report.json").read_text())
    assert report["converged"] is True
    assert set(report["fit"]) >= {"points", "rms", "max", "rms_relative", "max_relative", "start_rms"}
    assert report["fit"]["rms"] < 0.1 * report["fit"]["start_rms"]
    assert 0.9 <= report["coverage"]["covered"] <= 1
    assert report["as_asked"] is all(one["met"] for one in report["asked"])
    assert report["as_asked"] is True
    assert report["specification"]["pattern"]["size"] == [6, 6]
    methods = [a["method"] for a in report["attempts"]]
    assert methods == ["ipopt, linearized constraints", "ipopt, static pivots, without idle bounds"]
    design = json.loads((out / "design.fold").read_text())
    assert [frame["frame_title"] for frame in design["file_frames"]] == ["developed", "flat-folded"]

    code, printed, _ = run(["check", str(out / "design.fold"), "--json"], capsys)
    assert code == 0
    assert json.loads(printed) == certificate


def test_overrides_change_the_design(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "dome.yaml").write_text(DOME)
    arguments = ["solve", str(tmp_path / "dome.yaml"), "-o", str(tmp_path / "out")]
    code, _, _ = run([*arguments, "--set", "pattern.size=[4, 5]", "--set", "pattern.u_lines=CFL"], capsys)
    assert code == 0
    assert inverse.read(tmp_path / "out" / "design.fold").pattern.grid == (4, 5)
    code, _, error = run([*arguments, "--set", "pattern.size=4"], capsys)
    assert code == 2
    assert "--set pattern.size=4" in error


def test_what_cannot_be_certified_is_written_and_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    # Two opposite corners nailed farther apart than folded facets can reach.
    (tmp_path / "dome.yaml").write_text(
        ANCHORED + "{vertices: [0], to: {point: [-3.5, -3.5, 0]}}\n    - {vertices: [48], to: {point: [3.5, 3.5, 0]}}\n"
        "solver: {max_iterations: 60}\n"
    )
    code, _, error = run(["solve", str(tmp_path / "dome.yaml"), "-o", str(tmp_path / "out")], capsys)
    assert code == 1
    assert "constraints.anchors." in error
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert report["converged"] is False


def test_a_spoiled_file_is_not_certified(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    seed = seeds.grid((4, 4))
    points = seed.vertices_coords.copy()
    points[12, 2] += 1e-6
    inverse.write(seed.moved_to(points), tmp_path / "bad.fold")
    code, printed, _ = run(["check", str(tmp_path / "bad.fold")], capsys)
    assert code == 1
    assert printed.splitlines()[-1].startswith("foldable  NO: not certified: ")


def test_a_term_without_a_number_is_told_and_written(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    text = DOME.replace("sqrt(4 - x^2 - y^2)", "sqrt(1 - x^2)")  # which has no slope at vertex 0
    (tmp_path / "dome.yaml").write_text(text + "fit: {points: vertices}\n")
    code = commands.run(["solve", str(tmp_path / "dome.yaml"), "-o", str(tmp_path / "out"), "--json"])
    printed, said = capfd.readouterr()
    assert code == 1

    def refuse(word: str) -> None:
        raise AssertionError(f"{word} is no JSON")

    summary = json.loads(printed, parse_constant=refuse)
    assert "fit at vertex 0" in summary["status"]
    assert said.splitlines() == ["no pictures here"]
    report = json.loads((tmp_path / "out" / "report.json").read_text(), parse_constant=refuse)
    assert report["ending"] == "not_a_number"
    assert None in report["objective"].values()
    assert inverse.check(tmp_path / "out" / "design.fold").certified == report["certified"]


@pytest.mark.parametrize(("height", "half"), [("1e200*x^2", 1), ("0", 1e-200), ("sqrt(1-x^2)", 1.001), ("x^0.5", 1)])
def test_a_target_without_numbers_is_wrong_input(
    height: str, half: float, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    domain = f"[[{-half}, {half}], [{-half}, {half}]]"
    text = DOME.replace("sqrt(4 - x^2 - y^2)", height).replace("[[-1, 1], [-1, 1]]", domain)
    (tmp_path / "dome.yaml").write_text(text)
    assert commands.run(["solve", str(tmp_path / "dome.yaml"), "-o", str(tmp_path / "out")]) == 2
    said = capfd.readouterr().err
    assert "dome.yaml:6:11: " in said
    assert len(said.splitlines()) == 4
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("arguments", [["solv"], ["solve"], ["check", "missing.fold"], ["solve", "missing.yaml"]])
def test_misuse_is_wrong_input(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    code, _, error = run(arguments, capsys)
    assert code == 2
    assert error


def test_an_output_folder_that_cannot_be(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "dome.yaml").write_text(DOME)
    (tmp_path / "file").write_text("")
    code, _, error = run(["solve", str(tmp_path / "dome.yaml"), "-o", str(tmp_path / "file" / "out")], capsys)
    assert code == 2
    assert "is a file" in error


def test_the_schema_names_every_part(capsys: pytest.CaptureFixture[str]) -> None:
    code, printed, _ = run(["schema"], capsys)
    schema: dict[str, Any] = json.loads(printed)
    assert code == 0
    assert {"name", "units", "pattern", "target", "fit", "objectives", "constraints", "solver"} <= set(
        schema["properties"]
    )


def test_threads_that_somebody_asks_for_change_no_bit(tmp_path: Path) -> None:
    (tmp_path / "dome.yaml").write_text(DOME.replace("[6, 6]", "[8, 8]"))
    code = "import sys; sys.modules['pyvista'] = None; from inverse.__main__ import main; main()"  # no pictures
    for count in ("1", "2"):
        threads = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), count)
        done = subprocess.run(
            [sys.executable, "-c", code, "solve", str(tmp_path / "dome.yaml"), "-o", str(tmp_path / count)],
            env=os.environ | threads, capture_output=True,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
    one, two = ((tmp_path / count / "design.fold").read_bytes() for count in ("1", "2"))
    assert one == two


def test_the_module_runs_as_a_program() -> None:
    done = subprocess.run([sys.executable, "-m", "inverse", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == inverse.__version__
