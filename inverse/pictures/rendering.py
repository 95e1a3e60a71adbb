"""Renders scenes with VTK in a process of its own, and finds out beforehand whether that works here."""

from __future__ import annotations

import contextlib
import functools
import importlib.util
import os
import pickle
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from inverse.files.atomic import write_atomically
from inverse.pictures.camera import VIEW_ANGLE, Camera
from inverse.pictures.scene import Facets, Scene

_WORKER = Path(__file__).with_name("worker.py")
_TIMEOUT, _TIMEOUT_EACH = 120, 20  # seconds to start, and for every picture
# Read by VTK when it opens a window; None leaves the choice to VTK (or to the user, who may have set it).
_WINDOW = "VTK_DEFAULT_OPENGL_WINDOW"
_WINDOWS = (None, "vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow")


def can_render() -> str | None:
    """Whether 3D pictures can be rendered here: None, or a sentence that says what is missing.

    The answer is found once per process, by rendering a small picture in another one.
    """
    return _probe()[1]


def render(scene: Scene, path: Path) -> None:
    """Write a scene as PNG, whole or not at all.

    Raises:
        RuntimeError: it cannot be rendered here; :func:`can_render` tells beforehand.
    """
    with tempfile.TemporaryDirectory() as folder:
        write_atomically(path, render_frames([scene], Path(folder))[0].read_bytes())


def render_frames(scenes: Iterable[Scene], folder: Path, progress: Callable[[int], None] | None = None) -> list[Path]:
    """Render many scenes in one process.

    Args:
        scenes: one scene per picture. Arrays that several of them show are handed over once.
        folder: an empty one, for the PNG files.
        progress: told now and then how many pictures are there; what it raises ends the rendering.

    Returns:
        The PNG files in the order of the scenes.

    Raises:
        RuntimeError: they cannot be rendered here; :func:`can_render` tells beforehand.
    """
    window, reason = _probe()
    if reason is not None:
        raise RuntimeError(reason)
    pictures = _run(scenes, folder, window, progress or (lambda _: None))
    if isinstance(pictures, str):
        raise RuntimeError(f"the pictures could not be rendered: {pictures}")
    return pictures


@functools.cache
def _probe() -> tuple[str | None, str | None]:
    """The render window that works, and what is wrong if none does."""
    for package in ("pyvista", "PIL"):
        if importlib.util.find_spec(package) is None:
            return None, f"No 3D pictures: the Python package {package} is not installed."
    triangle = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
    black = Facets(triangle, np.array([3, 0, 1, 2]), np.zeros((1, 3), np.uint8))
    scene = Scene((64, 64), Camera((0, -9, 9), (0, 0, 0), 0.0, 0.1), [black])
    for window in _WINDOWS:
        with tempfile.TemporaryDirectory() as folder:
            if isinstance(_run([scene], Path(folder), window, lambda _: None), list):
                return window, None
    return None, (
        "No 3D pictures: VTK finds no OpenGL to render with off screen. "
        "On Debian or Ubuntu, `apt install libegl1 libgl1-mesa-dri` or `apt install libosmesa6` provides one."
    )


def _run(
    scenes: Iterable[Scene], folder: Path, window: str | None, progress: Callable[[int], None]
) -> list[Path] | str:
    """The PNG files, or what the worker said last."""
    environment = dict(os.environ) | ({} if window is None else {_WINDOW: window})
    source, said = folder / "scenes", folder / "said"
    count = _hand_over(scenes, source)
    pictures = [folder / f"{number:05d}.png" for number in range(count)]
    command = [sys.executable, "-P", str(_WORKER), str(source), str(folder), str(count)]
    timeout = _TIMEOUT + _TIMEOUT_EACH * count
    end = time.monotonic() + timeout
    with said.open("wb") as file:
        # A crashing VTK kills its process by a signal; what it prints is of interest only then.
        worker = subprocess.Popen(command, env=environment, stdout=file, stderr=file)
        try:
            while worker.poll() is None:
                if time.monotonic() > end:
                    return f"VTK took more than {timeout} seconds"
                with contextlib.suppress(subprocess.TimeoutExpired):
                    worker.wait(timeout=0.2)
                progress(sum(picture.exists() for picture in pictures))
        finally:
            worker.kill()
            worker.wait()
    if worker.returncode == 0 and all(picture.exists() for picture in pictures):
        return pictures
    words = said.read_text(errors="replace").strip().splitlines()
    return words[-1] if words else f"VTK ended with exit code {worker.returncode}"


def _hand_over(scenes: Iterable[Scene], path: Path) -> int:
    """Write scenes for the worker and count them; one pickler, so that it writes an array once that they share."""
    count = 0
    with path.open("wb") as file:
        pickler = pickle.Pickler(file)
        for scene in scenes:
            plain = vars(scene) | {"camera": vars(scene.camera), "view_angle": VIEW_ANGLE}
            for items in ("facets", "lines", "captions"):
                plain[items] = [vars(item) for item in plain[items]]
            pickler.dump(plain)
            count += 1
    return count
