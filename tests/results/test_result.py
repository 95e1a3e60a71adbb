"""Results as plain data: pickled, saved, and gone on from."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import pytest
from designs import assert_close
from domes import DOME, PATTERNS, dome, task

import inverse
from inverse.cli import commands
from inverse.errors import InputError


def test_a_result_pickles() -> None:
    result = dome()
    again = pickle.loads(pickle.dumps(result))
    assert isinstance(again, inverse.Result)
    assert again.report == result.report
    assert again.fit == result.fit
    assert_close(again.design.vertices_coords, result.design.vertices_coords, 0)
    assert again.certificate.document() == result.certificate.document()
    assert inverse.solve(task(), start=again).certified  # a start is worth as much after a journey


def test_a_result_saves_itself_as_the_command_line_does(tmp_path: Path) -> None:
    result = dome()
    assert result.save(tmp_path / "out", pictures="none") == []
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "certificate.json", "design.fold", "report.json",
    ]  # fmt: skip
    told = json.loads((tmp_path / "out" / "report.json").read_text())
    assert {key: told[key] for key in result.report} == json.loads(json.dumps(result.report))
    assert told.keys() - result.report.keys() == {"versions", "notes"}
    assert told["fit"]["rms_relative"] == result.fit.rms_relative
    assert inverse.check(tmp_path / "out" / "design.fold").certified


def test_what_is_told_follows_from_what_is_there() -> None:
    result = dome("eggbox")
    assert result.name == "dome"
    assert result.iterations == sum(attempt.iterations for attempt in result.attempts) == result.report["iterations"]
    assert result.specification["pattern"]["size"] == [6, 7]
    assert result.report["ending"] == result.ending == "solved"
    assert set(result.seconds) >= {"formulate", "build", "solve", "polish", "certify"}
    vertices, triangles = result.target
    assert triangles.max() < len(vertices)


# ---- starts


def lower() -> inverse.spec.Loaded:
    """The dome, a little flatter."""
    return task(target=DOME | {"height": "0.44 - 0.29*(x^2 + y^2)"})


@pytest.fixture(scope="module")
def cold() -> inverse.Result:
    return inverse.solve(lower())


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("dome")
    dome().save(folder, pictures="none")
    return folder


@pytest.mark.parametrize("kind", ["result", "design", "folder", "file", "text"])
def test_a_solve_goes_on_from_an_earlier_one(kind: str, saved: Path, cold: inverse.Result) -> None:
    start = {
        "result": dome(), "design": dome().design, "folder": saved, "file": saved / "design.fold", "text": str(saved),
    }[kind]  # fmt: skip
    warm = inverse.solve(lower(), start=start)
    assert warm.certified
    assert warm.converged
    assert_close(warm.design.vertices_coords, cold.design.vertices_coords, 1e-5)
    if kind == "result":  # it has multipliers too
        assert warm.iterations < cold.iterations


def test_the_answer_as_start_stays_where_it_is(saved: Path) -> None:
    again = inverse.solve(task(), start=saved)
    assert_close(again.design.vertices_coords, dome().design.vertices_coords, 1e-6)


def test_a_start_of_another_pattern_is_refused(saved: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the start has another pattern: 36 facets, the specification 42"):
        inverse.solve(task(pattern=PATTERNS["eggbox"]), start=saved)
    with pytest.raises(InputError, match="there is no such file"):
        inverse.solve(task(), start=tmp_path / "none")


def test_the_command_line_takes_a_start(saved: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "dome.yaml").write_text(
        f"name: dome\npattern: {{size: [6, 6]}}\ntarget: {{height: '{DOME['height']}', domain: {DOME['domain']}}}\n"
    )
    out = tmp_path / "out"
    assert commands.run(["solve", str(tmp_path / "dome.yaml"), "-o", str(out), "--start", str(saved)]) == 0
    assert_close(inverse.read(out / "design.fold").vertices_coords, dome().design.vertices_coords, 1e-6)
    assert commands.run(["solve", str(tmp_path / "dome.yaml"), "-o", str(out), "--start", str(tmp_path)]) == 2
    assert "design.fold" in capsys.readouterr().err


def test_a_design_is_checked_as_its_file_would_be(tmp_path: Path) -> None:
    design = dome().design
    inverse.write(design, tmp_path / "design.fold")
    assert inverse.check(design).document() == inverse.check(tmp_path / "design.fold").document()
    spoiled = design.moved_to(design.vertices_coords + 1e-3 * np.eye(3)[np.arange(49) % 3])
    assert not inverse.check(spoiled).certified
