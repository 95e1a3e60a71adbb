"""`--pictures` and the key `pictures`: what is drawn, and that nothing is started for what is not."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import pytest
from designs import miura

import inverse
from inverse.cli import commands
from inverse.pictures import rendering
from inverse.results.folder import PICTURED, WRITTEN

DOME = """\
name: dome
pattern: {size: [4, 4], u_lines: CFL}
target: {height: "sqrt(4 - x^2 - y^2)", domain: [[-1, 1], [-1, 1]]}
require: {coverage: 0, beyond: 1}
"""
DRAWN = {"none": set(), "svg": {"crease_pattern.svg", "layers.svg"}, "all": set(PICTURED)}


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("dome.yaml").write_text(DOME)


@pytest.fixture
def nothing_started(monkeypatch: pytest.MonkeyPatch) -> None:
    def start(_: object) -> NoReturn:
        raise AssertionError("nothing is to be rendered")

    monkeypatch.setattr(rendering.Renderer, "_start", start)


def names(folder: str) -> set[str]:
    return {path.name for path in Path(folder).iterdir()}


@pytest.mark.usefixtures("nothing_started")
@pytest.mark.parametrize("wanted", ["none", "svg"])
def test_what_is_not_wanted_is_not_drawn_and_does_not_stay(wanted: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert commands.run(["solve", "dome.yaml", "--pictures", "none"]) == 0
    for name in PICTURED:
        Path("out/dome", name).write_text("of the run before")
    assert commands.run(["solve", "dome.yaml", "--pictures", wanted]) == 0
    assert names("out/dome") == {*WRITTEN, *DRAWN[wanted]}
    for name in DRAWN[wanted]:
        assert Path("out/dome", name).read_text().startswith("<?xml")
    assert "pictures" not in capsys.readouterr().err


@pytest.mark.usefixtures("nothing_started")
def test_the_key_and_the_option_that_outdoes_it() -> None:
    Path("dome.yaml").write_text(DOME + "pictures: svg\n")
    assert commands.run(["solve", "dome.yaml"]) == 0
    assert names("out/dome") == {*WRITTEN, *DRAWN["svg"]}
    assert json.loads(Path("out/dome/report.json").read_text())["specification"]["pictures"] == "svg"
    assert commands.run(["solve", "dome.yaml", "--pictures", "none"]) == 0
    assert names("out/dome") == set(WRITTEN)
    assert commands.run(["solve", "dome.yaml", "--set", "pictures=none"]) == 0
    assert names("out/dome") == set(WRITTEN)
    result = inverse.solve("dome.yaml")
    result.save("saved")
    assert names("saved") == {*WRITTEN, *DRAWN["svg"]}
    result.save("saved", pictures="none")
    assert names("saved") == set(WRITTEN)


@pytest.mark.usefixtures("nothing_started")
def test_a_repair(tmp_path: Path) -> None:
    inverse.write(miura(3, 3), tmp_path / "sheet.fold")
    for wanted in ("svg", "none"):
        assert commands.run(["repair", "sheet.fold", "--pictures", wanted]) == 0
        assert names("out/sheet") == {*WRITTEN, *DRAWN[wanted]} - {"layers.svg"}


def test_all_pictures(lacking: Callable[[str], NoReturn]) -> None:
    if (reason := rendering.can_render()) is not None:
        lacking(reason)
    assert commands.run(["solve", "dome.yaml"]) == 0
    assert names("out/dome") == {*WRITTEN, *PICTURED}
    first = {name: Path("out/dome", name).read_bytes() for name in PICTURED}
    assert commands.run(["solve", "dome.yaml"]) == 0
    assert {name: Path("out/dome", name).read_bytes() for name in PICTURED} == first


@pytest.mark.usefixtures("nothing_started")
def test_wrong_words_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert commands.run(["solve", "dome.yaml", "--pictures", "some"]) == 2
    assert '"none", "svg", "all"' in capsys.readouterr().err
    Path("dome.yaml").write_text(DOME + "pictures: sgv\n")
    assert commands.run(["solve", "dome.yaml"]) == 2
    said = capsys.readouterr().err
    assert "dome.yaml:5:11" in said
    assert "none, svg" in said
    assert not Path("out").exists()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_leaves_no_process(number: signal.Signals) -> None:
    Path("dome.yaml").write_text(DOME.replace("[4, 4]", "[20, 20]"))
    code = (
        "import sys\n"
        "from inverse.pictures.rendering import Renderer\n"
        "start = Renderer._start\n"
        "def told(self):\n"
        "    start(self)\n"
        "    print(self._worker.pid, flush=True)\n"
        "Renderer._start = told\n"
        "from inverse.__main__ import main\n"
        "sys.argv = ['inverse', 'solve', 'dome.yaml']\n"
        "main()\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as program:
        assert program.stdout is not None
        process = int(program.stdout.readline())
        time.sleep(0.3)
        program.send_signal(number)
        program.stdout.read()
        assert program.wait() == 3
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)
