"""The process that renders: what it draws, what it is when something fails, and that it ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import designs
import numpy as np
import pytest

from inverse import pictures
from inverse.pictures import rendering
from inverse.pictures.camera import Camera
from inverse.pictures.rendering import Renderer
from inverse.pictures.scene import Caption, Facets, Lines, Scene

FRONT = Camera((0, -9, 0), (0, 0, 0), 0.0, 0.1)


@pytest.fixture
def gl(lacking: Callable[[str], NoReturn]) -> None:
    if (reason := rendering.can_render()) is not None:
        lacking(reason)


def worker(text: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another program in the place of the worker."""
    (folder / "worker.py").write_text(text)
    monkeypatch.setattr(rendering, "_WORKER", folder / "worker.py")


def alive(process: int) -> bool:
    """Whether a process is running."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return "Z" not in Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]


def pixels(path: Path) -> np.ndarray:
    from PIL import Image

    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB"), float)


def triangle(size: tuple[int, int]) -> Scene:
    """A facet with an edge along one of its sides and a caption."""
    points = np.array([[-1.0, 0.0, -1.1], [1.0, 0.2, -0.7], [0.3, 0.0, 1.3]])
    scene = Scene(size, FRONT)
    scene.facets.append(Facets(points, np.array([3, 0, 1, 2]), np.array([[200, 90, 10]], np.uint8)))
    scene.lines.append(Lines(points, np.array([[0, 1], [1, 2]]), np.zeros((2, 3), np.uint8), 2.0))
    scene.captions.append(Caption("seen", size[0] / 2, 20, 24))
    return scene


@pytest.mark.usefixtures("gl")
def test_one_process_draws_what_several_do_byte_for_byte(tmp_path: Path) -> None:
    scenes = [triangle((160, 1200)), triangle((320, 64)), triangle((160, 1200))]
    with Renderer() as renderer:
        renderer.begin(scenes, folder=tmp_path)
        together = renderer.finish()
    for k, scene in enumerate(scenes):
        rendering.render(scene, tmp_path / "alone.png")
        assert (tmp_path / "alone.png").read_bytes() == together[k].read_bytes()


@pytest.mark.usefixtures("gl")
@pytest.mark.parametrize("scale", [0.0, 1.7])
def test_bands_have_no_seams(scale: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = triangle((160, 1200))
    scene = Scene(scene.size, Camera((0, -9, 0), (0, 0, 0), scale, 0.1), scene.facets, scene.lines, scene.captions)
    rendering.render(scene, tmp_path / "bands.png")
    text = rendering._WORKER.read_text()
    assert "\nBAND = 512 " in text
    worker(text.replace("\nBAND = 512 ", "\nBAND = 1200 "), tmp_path, monkeypatch)
    rendering.render(scene, tmp_path / "whole.png")
    off = np.abs(pixels(tmp_path / "bands.png") - pixels(tmp_path / "whole.png"))
    assert off.mean() < 0.01
    assert (off.max(axis=2) > 100).mean() < 1e-4  # samples that lie on an edge, within rounding


@pytest.mark.usefixtures("gl")
@pytest.mark.parametrize("width", [0.5, 1.3, 2.0])
@pytest.mark.parametrize("turn", [0.0, 0.02, 0.7])
def test_lines_are_as_wide_as_they_are_asked_to_be(width: float, turn: float, tmp_path: Path) -> None:
    """Ink times length, however they lie to the pixels."""
    half = np.array([np.cos(turn), 0.0, np.sin(turn)])
    lines = Lines(np.array([-half, half]), np.array([[0, 1]]), np.zeros((1, 3), np.uint8), width)
    scene = Scene((256, 256), FRONT, [], [lines])
    rendering.render(scene, tmp_path / "line.png")
    length = 2 * 256 / (2 * 9 * np.tan(np.radians(12.0)))
    ink = (1 - pixels(tmp_path / "line.png") / 255)[..., 0].sum()
    assert ink == pytest.approx(width * length, rel=0.05)


@pytest.mark.usefixtures("gl")
def test_a_line_that_begins_behind_the_viewer_is_seen_where_it_is_in_front(tmp_path: Path) -> None:
    points = np.array([[0.5, -19.0, 0.0], [0.5, 9.0, 0.0], [-3.0, -12.0, -3.0], [3.0, -12.0, 3.0]])
    lines = Lines(points, np.array([[0, 1], [2, 3]]), np.zeros((2, 3), np.uint8), 8.0)
    ground = Facets(points[[0, 1, 2]] + [0.0, 4.0, -3.0], np.array([3, 0, 1, 2]), np.full((1, 3), 250, np.uint8))
    rendering.render(Scene((128, 128), FRONT, [ground], [lines]), tmp_path / "line.png")
    dark = pixels(tmp_path / "line.png")[..., 0] < 120
    assert (dark[:, 80:].sum(axis=0) == 8).all()  # to the right of the middle, as wide as anywhere
    assert not dark[:, :60].any()  # nothing is mirrored


@pytest.mark.usefixtures("gl")
def test_edges_have_shades(tmp_path: Path) -> None:
    """A border that is nearly level has as many of them as there are renderings."""
    points = np.array([[-5.0, 0.0, 0.0], [5.0, 0.0, 0.15], [5.0, 0.0, -9.0], [-5.0, 0.0, -9.0]])
    facets = Facets(points, np.array([4, 0, 1, 2, 3]), np.zeros((1, 3), np.uint8))
    rendering.render(Scene((256, 256), FRONT, [facets]), tmp_path / "edge.png")
    assert len(np.unique(pixels(tmp_path / "edge.png")[..., 0])) >= 9


def test_the_next_window_is_tried_where_one_kills_its_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    worker(
        "import json, os, pickle, signal, sys\n"
        "if os.environ.get('VTK_DEFAULT_OPENGL_WINDOW') != 'vtkEGLRenderWindow':\n"
        "    os.kill(os.getpid(), signal.SIGSEGV)\n"
        "print('ready', flush=True)\n"
        "for line in sys.stdin:\n"
        "    scene = pickle.load(open(json.loads(line), 'rb'))\n"
        "    open(scene['picture'], 'w').write('drawn')\n"
        "    print(scene['picture'], flush=True)\n",
        tmp_path, monkeypatch,
    )  # fmt: skip
    monkeypatch.delenv("VTK_DEFAULT_OPENGL_WINDOW", raising=False)
    monkeypatch.setattr(Renderer, "_works", 0)
    with Renderer() as renderer:
        renderer.begin([triangle((64, 64))])  # before it is known which works
        assert renderer.finish()[0].read_text() == "drawn"
    assert rendering._WINDOWS[Renderer._works] == "vtkEGLRenderWindow"


def test_a_worker_that_hangs_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    worker("import time\nprint('ready', flush=True)\ntime.sleep(600)\n", tmp_path, monkeypatch)
    monkeypatch.setattr(rendering, "_TIMEOUT", 1)
    monkeypatch.setattr(rendering, "_TIMEOUT_EACH", 0)
    with Renderer() as renderer:
        assert renderer.missing() is None
        assert renderer._worker is not None
        process = renderer._worker.pid
        renderer.begin([triangle((64, 64))])
        with pytest.raises(RuntimeError, match="VTK took more than 1 seconds"):
            renderer.finish()
        assert not alive(process)


def test_a_worker_that_hangs_before_it_is_ready(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    worker("import time\ntime.sleep(600)\n", tmp_path, monkeypatch)
    monkeypatch.setattr(rendering, "_TIMEOUT", 0.3)
    with Renderer() as renderer:
        reason = renderer.missing()
    assert reason is not None
    assert reason.startswith("No 3D pictures: VTK finds no OpenGL")


def test_what_a_dying_worker_says_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    worker("print('ready', flush=True)\ninput()\nraise ValueError('a reason')\n", tmp_path, monkeypatch)
    with Renderer() as renderer:
        renderer.begin([triangle((64, 64))])
        with pytest.raises(RuntimeError, match="could not be rendered: ValueError: a reason"):
            renderer.finish()


def test_the_process_ends_with_its_renderer(tmp_path: Path) -> None:
    with Renderer() as renderer:
        assert renderer._worker is not None
        process, folder = renderer._worker.pid, Path(renderer._folder.name)
        assert alive(process)
        assert folder.is_dir()
    assert not alive(process)
    assert not folder.exists()


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_the_process_ends_when_its_program_is_killed(number: signal.Signals) -> None:
    code = (
        "import time\n"
        "from inverse.pictures.rendering import Renderer\n"
        "with Renderer() as renderer:\n"
        "    renderer.missing()\n"
        "    print(renderer._worker.pid if renderer._worker else 0, flush=True)\n"
        "    time.sleep(600)\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE) as program:
        assert program.stdout is not None
        process = int(program.stdout.readline())
        program.send_signal(number)
    end = time.monotonic() + 30
    while process and alive(process) and time.monotonic() < end:
        time.sleep(0.05)
    assert not process or not alive(process)


def test_what_progress_raises_ends_the_rendering(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    worker("import time\nprint('ready', flush=True)\ntime.sleep(600)\n", tmp_path, monkeypatch)

    def stop(_: int) -> None:
        raise KeyboardInterrupt

    with Renderer() as renderer:
        renderer.begin([triangle((64, 64))])
        assert renderer._worker is not None
        process = renderer._worker.pid
        with pytest.raises(KeyboardInterrupt):
            renderer.finish(stop)
        assert not alive(process)


@pytest.mark.usefixtures("gl")
def test_the_same_design_gives_the_same_pictures(tmp_path: Path) -> None:
    design = designs.miura(4, 4)
    for name in ("a", "b"):
        pictures.design_picture(design, tmp_path / f"{name}.png", caption="foldable: yes")
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
