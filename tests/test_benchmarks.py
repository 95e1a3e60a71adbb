"""The benchmarks run: small, to keep them alive; what they measure is for machines that are left alone."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.mark.slow
def test_footprint() -> None:
    command = [sys.executable, "-m", "benchmarks.footprint", "--size", "8", "12", "--only", "area"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    _, free, bounded = done.stdout.splitlines()
    before, after = (float(row.split()[-4]) for row in (free, bounded))
    assert after == pytest.approx(0.7 * before, rel=2e-3)


@pytest.mark.slow
def test_speed(tmp_path: Path) -> None:
    out = tmp_path / "speed.json"
    command = [sys.executable, "-m", "benchmarks.speed", "--sizes", "6", "8", "--out", str(out)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    rows = json.loads(out.read_text())["rows"]
    assert [row["facets"] for row in rows] == [36, 64]
    for row in rows:
        assert row["certified"]
        assert row["converged"]
        assert 0 < row["build_s"] < row["total_s"]
        assert row["peak_bytes"] > 2**20
        references = row["references"]
        assert references["default_ipopt"]["ended"] == "Solve_Succeeded"
        assert references["paper"]["rms"] <= 5e-4
        assert all(references[f"moved_{name}"]["certified"] for name in ("sideways", "taller", "bump"))
        assert references["floor_superlu"]["seconds"] >= references["floor_fastest"]["seconds"] > 0


def run(*arguments: str) -> str:
    done = subprocess.run(
        [sys.executable, "-m", *arguments], cwd=ROOT, capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("method", ["ipopt", "nlopt"])
def test_robustness(method: str, tmp_path: Path) -> None:
    out = tmp_path / "robustness.json"
    told = run("benchmarks.robustness", "--method", method, "--first", "1", "--count", "3", "--out", str(out))
    assert "3 of 3 succeed (100.0%); 0 claims refused" in told
    assert [row["number"] for row in json.loads(out.read_text())["rows"]] == [1, 2, 3]


@pytest.mark.slow
def test_panels() -> None:
    header, *rows = run("benchmarks.panels", "--sizes", "4").splitlines()
    assert len(rows) == 2
    column = header.split().index("overlap")
    assert [row.split()[column + 1] for row in rows] == ["0", "0"]


@pytest.mark.slow
def test_refine(tmp_path: Path) -> None:
    out = tmp_path / "refine.json"
    run("benchmarks.refine", "--sizes", "8", "--out", str(out))
    document = json.loads(out.read_text())
    assert document["steps"][0]["residual"] < 1e-12
    assert all(row["certified"] and row["remaining"] < 1e-9 for row in document["drags"])


@pytest.mark.slow
def test_commands(tmp_path: Path) -> None:
    out = tmp_path / "commands.json"
    small = ("--runs", "1", "--facets", "6", "--only", "tube-bare", "check", "fold")
    told = run("benchmarks.commands", *small, "--out", str(out))
    rows = {row["command"]: row for row in json.loads(out.read_text())["rows"]}
    assert set(rows) == {"tube-bare", "check", "fold"}
    assert all(row["seconds"] > row["load"] / 2 > 0 and row["MiB"] > 20 for row in rows.values())
    assert {"build", "solve", "certify", "brief"} <= set(rows["tube-bare"]["phases"])
    assert "at most 0.5 s" in told


@pytest.mark.slow
def test_motion(tmp_path: Path) -> None:
    out = tmp_path / "motion.json"
    run("benchmarks.motion", "--sizes", "4", "--frames", "3", "--formats", "glb", "html", "--out", str(out))
    rows = json.loads(out.read_text())["rows"]
    assert [row["format"] for row in rows] == ["glb", "html"]
    assert all(row["seconds"] > 0 and row["bytes"] > 1000 for row in rows)


@pytest.mark.slow
def test_verdicts(tmp_path: Path) -> None:
    out = tmp_path / "verdicts.json"
    header, row = run(
        "benchmarks.verdicts", "--sizes", "4", "--only-domes", "--repeats", "2", "--out", str(out)
    ).splitlines()
    assert header.split()[1:] == ["formulate", "certify", "brief", "fit", "footprint"]
    assert row.startswith("dome 4 x 4")
    times = json.loads(out.read_text())["rows"]["dome 4 x 4"]
    assert all(0 < times["least_ms"][part] <= times["median_ms"][part] for part in header.split()[1:])


@pytest.mark.slow
def test_live(tmp_path: Path) -> None:
    out = tmp_path / "live.json"
    run("benchmarks.live", "--cases", "2", "--moves", "2", "--path", "6", "--size", "8", "--out", str(out))
    found = json.loads(out.read_text())
    assert found["path"]["certified"] == 6
    assert found["path"]["apart, of the diagonal"] < 1e-6
    assert found["path"]["worse by"] < 1e-6
    assert 0 < found["sweep"]["from the neighbour"] < found["sweep"]["cold"]
    assert found["moves, tube 8 x 12"]["light, median"] > 0
