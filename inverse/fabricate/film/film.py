"""Animations as pictures: MP4 and GIF, all frames drawn by one process."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from inverse.errors import InputError
from inverse.fabricate.film.stage import Stage
from inverse.fabricate.panels.panels import Panels
from inverse.fabricate.picture import bodies, placed
from inverse.origami import geometry
from inverse.pictures import colours, drawing
from inverse.pictures.rendering import Renderer
from inverse.pictures.scene import Caption, Scene, cells_of

RATE = 25  # frames a second; GIF counts in hundredths
SIZES = (64, 4096)  # of a side in pixels
_TEXT = 26  # pixels of 720
_COLOURS = 256


def check_film(size: tuple[int, int], formats: Sequence[str]) -> None:
    """Refuse early what would fail after minutes of drawing.

    Raises:
        InputError: a size that H.264 does not know, or a missing library.
    """
    low, high = SIZES
    if any(side % 2 or not low <= side <= high for side in size):
        raise InputError(
            f"frames of {size[0]} x {size[1]} pixels: both sides must be even and from {low} to {high}",
            hint="1280 720 and 1920 1080 are usual.",
        )
    if "mp4" in formats:
        _ffmpeg()


def film(
    stage: Stage,
    size: tuple[int, int],
    formats: Sequence[str],
    progress: Callable[[int, int], None],
    panels: Panels | None = None,
) -> dict[str, bytes]:
    """Draw all frames once and make films of them.

    Args:
        stage: what is shown.
        size: width and height in pixels, even.
        formats: "mp4", "gif" or both.
        progress: told how many frames of how many are drawn.
        panels: thick panels to be drawn instead of the ideal surface; all states lie in their range.

    Returns:
        The content of a file for each format.

    Raises:
        InputError: they cannot be drawn here.
    """
    count = len(stage.t)
    with tempfile.TemporaryDirectory() as name, Renderer() as renderer:
        folder = Path(name)
        renderer.begin(_scenes(stage, size, panels), folder=folder)
        if (missing := renderer.missing()) is not None:
            raise InputError(missing, hint="glb and html can be written without 3D pictures.")
        try:
            pictures = renderer.finish(lambda done: progress(done, count))
        except RuntimeError as error:
            raise InputError(str(error)) from None
        makers = {"mp4": _mp4, "gif": _gif}
        return {one: makers[one](pictures, size, folder) for one in formats}


def _scenes(stage: Stage, size: tuple[int, int], panels: Panels | None) -> Iterator[Scene]:
    """One scene per frame; all of them share the camera and what does not move."""
    pattern, view = stage.design.pattern, stage.view
    context, target = stage.surroundings.context, stage.surroundings.target
    camera = stage.camera(size)
    text = round(_TEXT * size[1] / 720)
    extent, cells = geometry.diagonal(stage.points), cells_of(pattern.faces_vertices)
    sides = drawing.sides_of(pattern, stage.design.vertices_coords, view)
    still = Scene(size, camera)
    if context is not None:
        walls, corners = drawing.buildings(*context, view)
        reach = max(geometry.diagonal(context[0][:, :2]), extent)
        lower = stage.ground - 1e-3 * extent
        still.facets.append(drawing.ground(stage.points.mean(axis=0), 1.6 * reach, lower - 1e-3 * extent))
        still.facets.append(drawing.shadow(walls.points, walls.cells, len(context[1]), view, lower))
        still.facets.append(walls)
        still.lines.append(corners)
    if stage.figure is not None:
        body = drawing.solid(*stage.figure, view, colours.PERSON)
        still.facets.append(drawing.shadow(body.points, body.cells, len(body.colours), view, stage.ground))
        still.facets.append(body)
    glass = drawing.target(*target, view) if target is not None else None
    eye = np.array(camera.position)
    for t, points, faint in zip(stage.t, stage.frames.vertices_coords, stage.faint, strict=True):
        if panels is None:
            facets, edges = drawing.structure(pattern, points, view, eye, camera.pixel, sides, faint=faint)
        else:
            facets, edges = bodies(placed(panels, float(t), points)[0], np.zeros(3), view, camera.pixel)
        fallen = drawing.shadow(points, cells, len(pattern.faces_vertices), view, stage.ground)
        scene = Scene(size, camera, [*still.facets, fallen, facets], [*still.lines, edges])
        if glass is not None:
            scene.facets.append(glass[0])
            scene.lines.append(glass[1])
        scene.captions.append(Caption(f"t = {np.degrees(t):.0f}°", size[0] / 2, 0.8 * text, text))
        yield scene


def _mp4(pictures: list[Path], size: tuple[int, int], folder: Path) -> bytes:
    from PIL import Image

    path = folder / "film.mp4"
    writer = _ffmpeg().write_frames(
        str(path),
        size,
        fps=RATE,
        quality=None,
        macro_block_size=2,
        output_params=["-crf", "18", "-preset", "fast", "-movflags", "+faststart"],
    )
    writer.send(None)
    try:
        for picture in pictures:
            with Image.open(picture) as image:
                writer.send(image.convert("RGB").tobytes())
    finally:
        writer.close()
    return path.read_bytes()


def _gif(pictures: list[Path], size: tuple[int, int], folder: Path) -> bytes:
    from PIL import Image

    def opened(picture: Path) -> Image.Image:
        with Image.open(picture) as image:
            return image.convert("RGB")

    # One palette for all frames, from a few of them side by side: colours that stay do not flicker.
    some = [opened(picture) for picture in pictures[:: max(1, len(pictures) // 8)]]
    sheet = Image.new("RGB", (size[0], size[1] * len(some)))
    for row, image in enumerate(some):
        sheet.paste(image, (0, row * size[1]))
    palette = sheet.quantize(_COLOURS)
    shades = np.array(palette.getpalette()).reshape(-1, 3)
    shades[shades.min(axis=1) > 247] = 255  # the page, which was averaged with what is nearly white
    palette.putpalette(shades.ravel().tolist())
    frames = (opened(picture).quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures)
    path = folder / "film.gif"
    first = next(frames)
    first.save(path, save_all=True, append_images=frames, duration=1000 // RATE, loop=0)
    return path.read_bytes()


def _ffmpeg() -> Any:
    try:
        import imageio_ffmpeg
    except ImportError:
        raise InputError(
            "MP4 needs the Python package imageio-ffmpeg", hint='pip install "inverse[fabricate]"'
        ) from None
    return imageio_ffmpeg
