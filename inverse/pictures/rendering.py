"""Renders scenes with VTK in a process of its own, and finds out beforehand whether that works here."""

from __future__ import annotations

import functools
import importlib.util
import os
import pickle
import subprocess
import sys
import tempfile
from dataclasses import asdict
from pathlib import Path

import numpy as np

from inverse.files import write_atomically
from inverse.pictures.camera import VIEW_ANGLE, Camera
from inverse.pictures.scene import Facets, Scene

_WORKER = Path(__file__).with_name("worker.py")
_TIMEOUT = 120  # seconds
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
    window, reason = _probe()
    if reason is not None:
        raise RuntimeError(reason)
    picture = _run(scene, window)
    if isinstance(picture, str):
        raise RuntimeError(f"the picture {path} could not be rendered: {picture}")
    write_atomically(path, picture)


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
        if isinstance(_run(scene, window), bytes):
            return window, None
    return None, (
        "No 3D pictures: VTK finds no OpenGL to render with off screen. "
        "On Debian or Ubuntu, `apt install libegl1 libgl1-mesa-dri` or `apt install libosmesa6` provides one."
    )


def _run(scene: Scene, window: str | None) -> bytes | str:
    """The PNG, or what the worker said last."""
    environment = dict(os.environ) | ({} if window is None else {_WINDOW: window})
    with tempfile.TemporaryDirectory() as folder:
        source, destination = Path(folder, "scene"), Path(folder, "picture.png")
        source.write_bytes(pickle.dumps(asdict(scene) | {"view_angle": VIEW_ANGLE}))
        command = [sys.executable, "-P", str(_WORKER), str(source), str(destination)]
        try:
            # A crashing VTK kills its process by a signal; what it prints is of interest only then.
            done = subprocess.run(command, env=environment, capture_output=True, timeout=_TIMEOUT, check=False)
        except subprocess.TimeoutExpired:
            return f"VTK took more than {_TIMEOUT} seconds"
        if done.returncode == 0 and destination.exists():
            return destination.read_bytes()
        words = done.stderr.decode(errors="replace").strip().splitlines()
        return words[-1] if words else f"VTK ended with exit code {done.returncode}"
