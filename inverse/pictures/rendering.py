"""Renders scenes with VTK in a process of its own, which gets ready while something else is done here."""

from __future__ import annotations

import contextlib
import functools
import importlib.util
import json
import os
import pickle
import select
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Self

from inverse.files.atomic import write_atomically
from inverse.pictures.camera import VIEW_ANGLE
from inverse.pictures.scene import Scene

_WORKER = Path(__file__).with_name("worker.py")
_TIMEOUT, _TIMEOUT_EACH = 120, 20  # seconds to start, and for every picture
_PULSE = 0.2  # seconds after which progress is told again
# Read by VTK when it opens a window; None leaves the choice to VTK (or to the user, who may have set it).
_WINDOW = "VTK_DEFAULT_OPENGL_WINDOW"
_WINDOWS = (None, "vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow")
# Read by Mesa's software renderer, which by itself may leave all cores but one idle. It changes no pixel.
_THREADS = {"LP_NUM_THREADS": str(os.cpu_count() or 1)}


class Renderer:
    """A process that renders scenes, from ``with`` to the end of it.

    It starts at once and opens a window by itself; nobody waits for that before a picture is wanted. A VTK that finds
    no OpenGL dies of it, and the next kind of window is tried in another process. What is begun is rendered in its
    order, while something else can be done here.
    """

    _works = 0  # which of the windows is tried first: the one that worked before in this program

    def __init__(self) -> None:
        self._worker: subprocess.Popen[bytes] | None = None
        self._window = type(self)._works
        self._ready = False
        self._reason: str | None = None
        self._jobs: list[bytes] = []  # what the worker was told and has not finished
        self._due: list[Path] = []
        self._heard = b""

    def __enter__(self) -> Self:
        self._folder = tempfile.TemporaryDirectory(prefix="inverse-")
        self._said = Path(self._folder.name) / "said"
        self._reason = lacking()
        if self._reason is None:
            self._start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end()
        self._folder.cleanup()

    def missing(self) -> str | None:
        """None if scenes can be rendered here, else a sentence that says what is missing; waits until that is known."""
        if self._reason is None and not self._ready:
            end = time.monotonic() + _TIMEOUT
            try:
                while self._answer(end, lambda: None) != "ready":
                    self._kill()
                    self._window += 1
                    if self._window == len(_WINDOWS):
                        self._reason = (
                            "No 3D pictures: VTK finds no OpenGL to render with off screen. On Debian or Ubuntu, "
                            "`apt install libegl1 libgl1-mesa-dri` or `apt install libosmesa6` provides one."
                        )
                        return self._reason
                    self._start()
                    end = time.monotonic() + _TIMEOUT
            except BaseException:
                self._end()
                raise
            self._ready, type(self)._works = True, self._window
        return self._reason

    def begin(self, scenes: Iterable[Scene], name: str = "{:05d}.png", folder: Path | None = None) -> None:
        """Have scenes rendered; this does not wait for it.

        Args:
            scenes: one scene per picture. Arrays that several of them show are handed over once.
            name: of the PNG files, with a place for their numbers.
            folder: for the PNG files; by default one that is removed with the process.
        """
        if self._reason is not None:
            return
        if self._worker is None:
            self._start()
        into = Path(self._folder.name) if folder is None else folder
        handle, source = tempfile.mkstemp(dir=self._folder.name)
        with os.fdopen(handle, "wb") as file:
            pickler = pickle.Pickler(file)  # one, so that it writes an array once that scenes share
            for number, scene in enumerate(scenes):
                self._due.append(into / name.format(number))
                pickler.dump(_plain(scene) | {"picture": str(self._due[-1])})
        self._jobs.append(json.dumps(source).encode() + b"\n")
        self._tell(self._jobs[-1])

    def finish(self, progress: Callable[[int], None] | None = None) -> list[Path]:
        """Wait for all that was begun.

        Args:
            progress: told now and then how many pictures are there; what it raises ends the rendering.

        Returns:
            The PNG files in the order of the scenes.

        Raises:
            RuntimeError: they cannot be rendered here, or the process was killed or took too long.
        """
        if (reason := self.missing()) is not None:
            raise RuntimeError(reason)
        tell = progress or (lambda _: None)
        seconds = _TIMEOUT + _TIMEOUT_EACH * len(self._due)
        end = time.monotonic() + seconds
        try:
            for done in range(len(self._due)):
                if self._answer(end, lambda done=done: tell(done)) is None:  # type: ignore[misc]
                    late = time.monotonic() > end
                    why = f"VTK took more than {seconds} seconds" if late else self._last_words()
                    raise RuntimeError(f"the pictures could not be rendered: {why}")
                tell(done + 1)
        except BaseException:
            self._end()
            raise
        pictures, self._due, self._jobs = self._due, [], []
        return pictures

    def _start(self) -> None:
        window = _WINDOWS[self._window]
        environment = _THREADS | dict(os.environ) | ({} if window is None else {_WINDOW: window})
        with self._said.open("wb") as said:
            self._worker = subprocess.Popen(
                [sys.executable, "-P", str(_WORKER)], env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                stderr=said, bufsize=0, start_new_session=True,  # Ctrl-C is ours to hear
            )  # fmt: skip
        for job in self._jobs:
            self._tell(job)

    def _end(self) -> None:
        """Kill the process, whatever it is at, and forget what was begun."""
        self._kill()
        self._jobs, self._due = [], []

    def _kill(self) -> None:
        if self._worker is not None:
            self._worker.kill()
            self._worker.wait()
            for pipe in (self._worker.stdin, self._worker.stdout):
                if pipe is not None:
                    pipe.close()
        self._worker, self._ready, self._heard = None, False, b""

    def _tell(self, job: bytes) -> None:
        if self._worker is not None and self._worker.stdin is not None:
            with contextlib.suppress(BrokenPipeError):  # it is dead, which is told when an answer is awaited
                self._worker.stdin.write(job)

    def _answer(self, end: float, wait: Callable[[], None]) -> str | None:
        """The next line of the worker; None if it is dead, or the time is over."""
        assert self._worker is not None
        assert self._worker.stdout is not None
        while b"\n" not in self._heard:
            if time.monotonic() > end:
                return None
            if select.select([self._worker.stdout], [], [], _PULSE)[0]:
                part = os.read(self._worker.stdout.fileno(), 4096)
                if not part:
                    return None
                self._heard += part
            wait()
        line, _, self._heard = self._heard.partition(b"\n")
        return line.decode()

    def _last_words(self) -> str:
        """What the dead worker said last."""
        assert self._worker is not None
        code = self._worker.wait()
        # A crashing VTK kills its process by a signal; what it prints is of interest only then.
        words = self._said.read_text(errors="replace").strip().splitlines()
        return words[-1] if words else f"VTK ended with exit code {code}"


@functools.cache
def can_render() -> str | None:
    """Whether 3D pictures can be rendered here: None, or a sentence that says what is missing.

    The answer is found once per program, by opening a window in another one.
    """
    with Renderer() as renderer:
        return renderer.missing()


def render(scene: Scene, path: Path, renderer: Renderer | None = None) -> None:
    """Write a scene as PNG, whole or not at all.

    Args:
        scene: what is shown.
        path: the PNG file to write.
        renderer: the process to be used; by default one for this picture alone.

    Raises:
        RuntimeError: it cannot be rendered here; :func:`can_render` tells beforehand.
    """
    with contextlib.ExitStack() as stack:
        running = renderer or stack.enter_context(Renderer())
        running.begin([scene])
        write_atomically(path, running.finish()[0].read_bytes())


def lacking() -> str | None:
    """A sentence about a Python package that rendering needs and that is not installed; None if all are."""
    for package in ("pyvista", "PIL"):
        if importlib.util.find_spec(package) is None:
            return f"No 3D pictures: the Python package {package} is not installed."
    return None


def _plain(scene: Scene) -> dict[str, object]:
    """A scene as the worker takes it, who knows nothing of the package."""
    plain: dict[str, object] = vars(scene) | {"camera": vars(scene.camera), "view_angle": VIEW_ANGLE}
    for items in ("facets", "lines", "captions"):
        plain[items] = [vars(item) for item in getattr(scene, items)]
    return plain
