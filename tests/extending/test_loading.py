"""Code of users on the command line: files after --with, and installed packages."""

from __future__ import annotations

import importlib
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import inverse
from inverse import InputError
from inverse.cli import commands
from inverse.extending import loading
from inverse.formulation.formulate import formulate
from inverse.policy import measures

pytestmark = pytest.mark.usefixtures("registered")
ROOT = Path(__file__).parents[1]
TERMS = """\
import casadi, inverse

LEVEL = 0.1

@inverse.objective("low", per="vertex", unit="length")
def low(points, seed):
    return casadi.fmax(0, points[0, 2] - LEVEL)

@inverse.measure("highest", unit="m")
def highest(design):
    return design.vertices_coords[:, 2].max()
"""


def run(*arguments: object) -> int:
    return commands.run([str(argument) for argument in arguments])


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    path = tmp_path / "dome.yaml"
    path.write_text(
        "name: dome\npattern: {size: [4, 4]}\nobjectives: {low: 0.01}\nrequire: {beyond: 1}\n"
        'target: {height: "0.45 - 0.3*(x^2 + y^2)", domain: [[-0.6, 0.6], [-0.6, 0.6]]}\n'
    )
    return path


def test_the_command_line_takes_terms(spec: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "terms.py").write_text(TERMS)
    (tmp_path / "more.py").write_text('import inverse\n@inverse.measure("one")\ndef one(design):\n    return 1\n')
    out = tmp_path / "out"
    code = run("solve", spec, "--with", tmp_path / "terms.py", "--with", tmp_path / "more.py", "-o", out)
    assert code == 0, capsys.readouterr().err
    report = json.loads((out / "report.json").read_text())
    assert report["measures"]["one"] == 1
    assert report["measures"]["highest"] == max(
        p[2] for p in json.loads((out / "design.fold").read_text())["vertices_coords"]
    )
    assert report["objective"]["low"] > 0


FILES = {
    "print(": r"terms\.py:1:\d+: this is no valid Python: ",
    "\n1 / 0": r"terms\.py:2: running it raised ZeroDivisionError: division by zero",
    "import nowhere_to_be_found": r"terms\.py:1: running it raised ModuleNotFoundError: No module named",
    "raise SystemExit(3)": r"terms\.py:1: running it raised SystemExit: 3",
    "import inverse\ninverse.section('plus', [])": r"terms\.py: section plus: the section has 0 steps",
    "import inverse\ninverse.measure('a b')(print)": r"terms\.py: 'a b' cannot name a measure",
}


@pytest.mark.parametrize("text", FILES)
def test_faults_of_a_file_are_sentences(
    text: str, spec: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "terms.py"
    path.write_text(text)
    with pytest.raises(InputError, match=FILES[text]) as caught:
        loading.load_file(path)
    assert caught.value.__cause__ is not None
    assert run("solve", spec, "--with", path, "-o", tmp_path / "out") == 2
    told = capsys.readouterr().err
    assert told.startswith("error: ")
    assert "Traceback" not in told
    assert not (tmp_path / "out").exists()


def test_a_file_that_is_not_there(spec: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("solve", spec, "--with", tmp_path / "none.py") == 2
    assert "none.py: there is no such file" in capsys.readouterr().err
    assert run("solve", spec, "--with", tmp_path) == 2


def test_without_the_file_the_name_is_unknown(spec: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run("solve", spec) == 2
    assert "dome.yaml:3:14: 'low' is no objective" in capsys.readouterr().err


def test_the_help_says_that_code_is_run() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "inverse", "solve", "--help"], capture_output=True, text=True, cwd=ROOT
    )
    assert "RUN" in done.stdout


# ---- installed packages


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Path]:
    """A package with an entry point, found by the machinery that finds any."""
    folder = tmp_path / "packages"
    (folder / "mine-1.0.dist-info").mkdir(parents=True)
    (folder / "mine-1.0.dist-info" / "METADATA").write_text("Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n")
    (folder / "mine-1.0.dist-info" / "entry_points.txt").write_text("[inverse.terms]\nmine = mine_terms\n")
    monkeypatch.syspath_prepend(str(folder))
    importlib.invalidate_caches()
    loading.load_installed.cache_clear()
    yield folder / "mine_terms.py"
    sys.modules.pop("mine_terms", None)
    loading.load_installed.cache_clear()


def test_installed_packages_are_imported_for_what_is_unknown(installed: Path, spec: Path) -> None:
    installed.write_text(TERMS)
    formulate(inverse.load(spec, ["objectives={fit: 1}"]))
    assert "mine_terms" not in sys.modules
    made = formulate(inverse.load(spec))
    assert "low" in [o.name for o in made.objectives]
    assert "highest" in measures.own(made.goal.model.seed)


def test_a_broken_package_is_named(installed: Path, spec: Path) -> None:
    installed.write_text("import nowhere_to_be_found")
    with pytest.raises(
        InputError, match="the entry point mine = mine_terms of mine raised ModuleNotFoundError"
    ) as caught:
        formulate(inverse.load(spec))
    assert isinstance(caught.value.__cause__, ModuleNotFoundError)


# ---- measures


def test_measures_are_told_and_their_faults_too() -> None:
    inverse.measure("area", unit="m^2")(lambda design: 2)
    seed = inverse.seeds.grid((2, 2))
    assert measures.own(seed) == {"area": 2.0}
    assert measures.MEASURES["area"].unit == "m^2"
    faults: list[tuple[Any, str]] = [
        (lambda design: 1 / 0, "measure broken raised ZeroDivisionError: division by zero"),
        (lambda design: "1", "measure broken returns a str: a number is wanted"),
        (lambda design: None, "measure broken returns a NoneType: a number is wanted"),
        (lambda design: True, "measure broken returns a bool: a number is wanted"),
    ]
    for function, message in faults:
        inverse.measure("broken")(function)
        with pytest.raises(InputError, match=message):
            measures.own(seed)
        failures: list[str] = []
        found = measures.own(seed, failures)
        assert found["area"] == 2
        assert found["broken"] != found["broken"]
        assert failures == [message]
        measures.MEASURES.remove("broken")
    with pytest.raises(InputError, match="measure broken is no function"):
        inverse.measure("broken")(3)  # type: ignore[type-var]


def test_a_measure_that_fails_at_the_end_keeps_the_design(spec: Path) -> None:
    calls: list[int] = []

    @inverse.measure("fickle")
    def fickle(design: inverse.Design) -> float:
        calls.append(0)
        return 1.0 / (2 - len(calls))

    result = inverse.solve(inverse.load(spec, ["objectives={fit: 1}"]))
    assert result.report["measures"] == {"fickle": None}
    assert result.report["failed_measures"] == ["measure fickle raised ZeroDivisionError: float division by zero"]
    assert json.dumps(result.report, allow_nan=False)
    calls[:] = [0]
    with pytest.raises(InputError, match="fickle raised"):
        inverse.solve(inverse.load(spec, ["objectives={fit: 1}"]))
