"""What a run leaves in its output folder, however it ends: files of one run, whole, and what others put there."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import inverse
from inverse import pictures
from inverse.cli import commands
from inverse.cli.output import write_all
from inverse.files import atomic
from inverse.pictures import rendering
from inverse.pictures.rendering import Renderer
from inverse.policy.attempts import Attempt
from inverse.results import saving
from inverse.results.folder import NAMES, WRITTEN, Results, settle

Run = inverse.Result
SCENES = {"design_scene": pictures.design_scene, "states_scene": pictures.states_scene}

SPECIFICATION = """\
name: {name}
pattern: {{size: {size}}}
target: {{height: "0.45 - 0.3*(x^2 + y^2)", domain: [[-1, 1], [-1, 1]]}}
require: {{coverage: 0, beyond: 1}}
"""


@pytest.fixture(scope="module")
def specifications(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Two tasks that are soon done."""
    folder = tmp_path_factory.mktemp("specifications")
    for name, size in (("one", [2, 2]), ("two", [2, 3])):
        (folder / f"{name}.yaml").write_text(SPECIFICATION.format(name=name, size=size))
    return {name: folder / f"{name}.yaml" for name in ("one", "two")}


@pytest.fixture(scope="module")
def runs(specifications: dict[str, Path]) -> dict[str, Run]:
    """Their results, of which every file is different."""
    return {name: inverse.solve(path) for name, path in specifications.items()}


@pytest.fixture(autouse=True)
def drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures that are made at once, and say only of which design they are."""

    def draw(design: inverse.Design, path: Path, **_: object) -> None:
        atomic.write_atomically(path, design.name)

    for name in ("crease_pattern_picture", "layers_picture"):
        monkeypatch.setattr(pictures, name, draw)
    for name in ("design_scene", "states_scene"):
        monkeypatch.setattr(pictures, name, lambda design, *_: design.name)
    for module in (saving, rendering):
        monkeypatch.setattr(module, "Renderer", Drawing)


class Drawing:
    """A renderer whose pictures say what was to be rendered."""

    def __enter__(self) -> Drawing:
        self.folder = tempfile.TemporaryDirectory()
        self.made: list[Path] = []
        return self

    def __exit__(self, *_: object) -> None:
        self.folder.cleanup()

    def missing(self) -> str | None:
        return None

    def begin(self, scenes: list[str], name: str) -> None:
        self.made.append(Path(self.folder.name) / name)
        self.made[-1].write_text(scenes[0])

    def finish(self) -> list[Path]:
        return self.made


def put(run: Run, folder: Path) -> saving.Written:
    with Results(folder) as into:
        return saving.write(run, into)


def owners(folder: Path, runs: dict[str, Run]) -> dict[str, str]:
    """Of which run each file is. A file that is not whole is of none."""
    found = {}
    for name in NAMES:
        if (folder / name).exists():
            text = (folder / name).read_text()
            if name == "certificate.json":
                found[name] = next(k for k, r in runs.items() if r.certificate.document() == json.loads(text))
            else:
                key = {"design.fold": "file_title", "report.json": "name"}.get(name)
                found[name] = json.loads(text)[key] if key else text
    return found


def hidden(folder: Path) -> list[str]:
    return [path.name for path in folder.iterdir() if path.name.startswith(".")]


def test_a_run_replaces_the_one_before_and_nothing_else(runs: dict[str, Run], tmp_path: Path) -> None:
    put(runs["one"], tmp_path)
    (tmp_path / "layers.svg").write_text("one")  # of a pattern with complementary lines
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "mine.txt").write_text("mine")
    (tmp_path / "model.3dm").write_text("mine")
    assert put(runs["two"], tmp_path) == saving.Written([])
    assert set(owners(tmp_path, runs).values()) == {"two"}
    assert (tmp_path / "notes" / "mine.txt").read_text() == "mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "certificate.json", "crease_pattern.svg", "design.fold", "design.png", "model.3dm", "notes", "report.json",
        "states.png",
    ]  # fmt: skip
    told = json.loads((tmp_path / "report.json").read_text())
    assert told["notes"] == []
    assert told["seconds"]["pictures"] > 0


class Killed(BaseException):
    """Stands for the end of the process: after it no file is touched any more."""


def dying(monkeypatch: pytest.MonkeyPatch, after: int) -> Callable[[], bool]:
    """Let the process die before a change of the file system; tells whether it did."""
    left = [after]

    def counted(change: Callable[..., Any]) -> Callable[..., Any]:
        def changing(*given: Any, **named: Any) -> Any:
            left[0] -= 1
            if left[0] < 0:
                raise Killed
            return change(*given, **named)

        return changing

    for name in ("rename", "replace", "mkdir", "rmdir", "unlink", "open"):
        monkeypatch.setattr(os, name, counted(getattr(os, name)))
    return lambda: left[0] < 0


def test_whoever_dies_at_any_moment_leaves_files_of_one_run(runs: dict[str, Run], tmp_path: Path) -> None:
    seen, folder = set(), tmp_path
    for moment in range(1000):
        put(runs["one"], folder)
        assert set(owners(folder, runs).values()) == {"one"}
        assert hidden(folder) == []
        with pytest.MonkeyPatch.context() as patched:
            died = dying(patched, moment)
            into = Results(folder)
            try:
                into.__enter__()
                saving.write(runs["two"], into)
            except Killed:
                pass
            is_dead = died()
        if not is_dead:
            break
        if into._lock >= 0:
            os.close(into._lock)  # the process is gone
        left = owners(folder, runs)
        assert len(set(left.values())) <= 1, (moment, left)
        settle(folder)
        settled = owners(folder, runs)
        assert len(set(settled.values())) == 1, (moment, settled)
        assert set(WRITTEN) <= set(settled), (moment, settled)
        seen.add(settled["design.fold"])
    assert moment > 20
    assert seen == {"one", "two"}
    assert set(owners(folder, runs).values()) == {"two"}


def test_commands_that_read_finish_what_a_killed_run_left(
    runs: dict[str, Run], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    put(runs["one"], tmp_path)
    (tmp_path / ".inverse-replacing").mkdir()
    inverse.write(runs["two"].design, tmp_path / ".inverse-replacing" / "design.fold")
    assert commands.run(["check", str(tmp_path / "design.fold")]) == 0
    assert owners(tmp_path, runs) == {"design.fold": "two"}
    assert hidden(tmp_path) == []


def test_a_full_disk_changes_nothing(runs: dict[str, Run], tmp_path: Path) -> None:
    put(runs["one"], tmp_path)
    before = {name: (tmp_path / name).read_bytes() for name in sorted(os.listdir(tmp_path))}
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
    try:
        with pytest.raises(inverse.InputError, match="the results cannot be written"):
            put(runs["two"], tmp_path)
        with pytest.raises(inverse.InputError, match="cannot be written"):
            write_all({tmp_path / "small": "x", tmp_path / "large": 2000 * "x"})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert {name: (tmp_path / name).read_bytes() for name in sorted(os.listdir(tmp_path))} == before


def test_a_disk_that_is_full_of_pictures(runs: dict[str, Run], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    put(runs["one"], tmp_path)
    monkeypatch.setattr(pictures, "states_scene", full)
    written = put(runs["two"], tmp_path)
    assert written.notes == ["The pictures cannot be written: [Errno 28] No space left on device"]
    assert owners(tmp_path, runs) == dict.fromkeys(WRITTEN, "two")
    assert hidden(tmp_path) == []


def test_a_picture_worker_that_is_killed(runs: dict[str, Run], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    worker = tmp_path / "worker.py"
    worker.write_text("import os\nprint('ready', flush=True)\nos.kill(os.getpid(), 9)\n")
    monkeypatch.setattr(rendering, "_WORKER", worker)
    monkeypatch.setattr(saving, "Renderer", Renderer)
    for name, scene in SCENES.items():
        monkeypatch.setattr(pictures, name, scene)
    put(runs["one"], tmp_path / "out")
    written = put(runs["two"], tmp_path / "out")
    assert written.notes == ["No 3D pictures: the pictures could not be rendered: VTK ended with exit code -9"]
    assert owners(tmp_path / "out", runs) == dict.fromkeys((*WRITTEN, "crease_pattern.svg"), "two")
    assert json.loads((tmp_path / "out" / "report.json").read_text())["notes"] == written.notes


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_pictures_that_are_interrupted(
    number: signal.Signals, runs: dict[str, Run], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = signal.getsignal(number)
    monkeypatch.setattr(pictures, "design_scene", lambda *_, **__: signal.raise_signal(number))
    put(runs["one"], tmp_path)
    written = put(runs["two"], tmp_path)
    assert written == saving.Written(["Interrupted: the results have no pictures."], interrupted=True)
    assert owners(tmp_path, runs) == dict.fromkeys(WRITTEN, "two")
    assert hidden(tmp_path) == []
    assert signal.getsignal(number) is before


def test_two_runs_into_one_folder(
    specifications: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    arguments = ["solve", str(specifications["one"]), "-o", str(out)]
    with Results(out):
        assert commands.run(arguments) == 2
        said = capsys.readouterr().err
        assert f"another run, process {os.getpid()}, is writing to {out}" in said
        assert "choose another -o" in said
    assert not out.exists()  # nothing was put into it
    assert commands.run(arguments) == 0


def test_a_folder_in_the_way_of_a_file(
    specifications: dict[str, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "out" / "design.png").mkdir(parents=True)
    assert commands.run(["solve", str(specifications["one"]), "-o", str(tmp_path / "out")]) == 2
    assert "design.png is a folder" in capsys.readouterr().err
    assert os.listdir(tmp_path / "out") == ["design.png"]


def test_an_output_folder_that_is_cleared_while_a_run_lasts(runs: dict[str, Run], tmp_path: Path) -> None:
    with Results(tmp_path / "out") as into:
        for path in (tmp_path / "out").iterdir():
            path.rmdir()
        (tmp_path / "out").rmdir()
        assert saving.write(runs["one"], into).notes == []
    assert set(owners(tmp_path / "out", runs).values()) == {"one"}


def interrupted(run: Run, *, certified: bool, iterations: int) -> Run:
    attempts = (Attempt("start", "ipopt", "User_Requested_Stop", iterations),)
    return replace(run, interrupted=True, converged=False, certified=certified, attempts=attempts)


@pytest.mark.parametrize(
    ("converged", "certified", "iterations", "keeps"),
    [(False, False, 5, True), (False, True, 0, True), (False, True, 5, False), (True, True, 5, True)],
)
def test_an_interrupted_run_does_not_replace_a_certified_design_by_less(
    converged: bool, certified: bool, iterations: int, keeps: bool, specifications: dict[str, Path],
    runs: dict[str, Run], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    """Not by one that is not certified, or the seed; nor one that converged too by one that did not."""
    out, other = tmp_path / "out", tmp_path / "out.interrupted"
    put(replace(runs["one"], converged=converged), out)
    result = interrupted(runs["two"], certified=certified, iterations=iterations)
    monkeypatch.setattr(inverse, "solve", lambda *_, **__: result)
    assert commands.run(["solve", str(specifications["two"]), "-o", str(out), "--set", "name=one"]) == 3
    assert set(owners(out, runs).values()) == {"one" if keeps else "two"}
    assert other.exists() == keeps
    if keeps:
        assert set(owners(other, runs).values()) == {"two"}
        assert f"{out} keeps its certified design; that of this run goes to {other}" in capsys.readouterr().err


@pytest.mark.parametrize("left", [NAMES, ("design.fold",), ("report.json",)])
def test_another_design_is_not_replaced(
    left: tuple[str, ...], specifications: dict[str, Path], runs: dict[str, Run], tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    """Known by its name; the same one is replaced, and what the hint says works."""
    put(runs["one"], tmp_path / "out")
    for name in set(NAMES) - set(left):
        (tmp_path / "out" / name).unlink(missing_ok=True)
    before = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    assert commands.run(["solve", str(specifications["two"]), "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert "another design, 'one', which 'two' would replace" in said
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == before
    assert commands.run(["solve", str(specifications["one"]), "-o", str(tmp_path / "out")]) == 0
    assert commands.run(["solve", str(specifications["two"]), "-o", str(tmp_path / "other")]) == 0


def test_what_is_being_drawn_is_told(runs: dict[str, Run], tmp_path: Path) -> None:
    told: list[str] = []
    with Results(tmp_path) as into:
        saving.write(runs["one"], into, phase=told.append)
    assert [words for words in told if words.startswith("drawing ")] == [
        f"drawing {name}" for name in ("states.png", "design.png", "crease_pattern.svg", "design.png and states.png")
    ]


WRITER = """\
import sys, time
from pathlib import Path
import inverse
from inverse import pictures
from inverse.files import atomic
from inverse.results import saving
from inverse.results.folder import Results
def draw(design, path, **_):
    time.sleep(0.002)
    atomic.write_atomically(path, design.name)
pictures.crease_pattern_picture = draw
runs = [inverse.solve(specification) for specification in sys.argv[2:]]
while True:
    for result in runs:
        with Results(Path(sys.argv[1])) as into:
            saving.write(result, into, pictures="svg")
        print("written", flush=True)
"""


@pytest.mark.slow
@pytest.mark.parametrize("number", range(8))
def test_a_real_kill(
    number: int, specifications: dict[str, Path], runs: dict[str, Run], tmp_path: Path
) -> None:  # fmt: skip
    out = tmp_path / "out"
    arguments = [str(out), *(str(path) for path in specifications.values())]
    with subprocess.Popen([sys.executable, "-c", WRITER, *arguments], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.readline()
        time.sleep(0.0137 * number)
        process.kill()
    assert len(set(owners(out, runs).values())) <= 1
    settle(out)
    assert set(WRITTEN) <= set(owners(out, runs))
    with Results(out):  # the lock has ended with the process
        assert len(hidden(out)) == 1
