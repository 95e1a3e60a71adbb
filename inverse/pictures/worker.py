"""Renders scenes off screen: run as a program of its own, because VTK without a usable GL kills its process.

Usage: ``python worker.py SCENES FOLDER COUNT``; SCENES holds so many dictionaries from one pickler, made by
:mod:`inverse.pictures.rendering`, and the pictures are 00000.png, 00001.png and so on in FOLDER.
Knows nothing of the package, so that it starts fast and from any folder.
"""

from __future__ import annotations

import pickle
import sys
from pathlib import Path
from typing import Any

import numpy as np

OVERSAMPLING = 2  # every pixel is the mean of this many squared


def render(scene: dict[str, Any]) -> np.ndarray:
    """The picture, (height, width, 3) uint8."""
    import pyvista
    from vtkmodules.vtkRenderingCore import vtkMapper

    # Facets step back, the more the steeper they are seen, so that the lines on them are not half hidden. VTK's own
    # steps are the same at all slopes, which lets lines behind a facet show through.
    vtkMapper.SetResolveCoincidentTopologyToPolygonOffset()
    vtkMapper.SetResolveCoincidentTopologyPolygonOffsetParameters(1.5, 0.0)
    vtkMapper.SetResolveCoincidentTopologyLineOffsetParameters(0.0, 0.0)
    width, height = scene["size"]
    plotter = pyvista.Plotter(off_screen=True, window_size=[OVERSAMPLING * width, OVERSAMPLING * height])
    plotter.set_background("white")
    for item in scene["facets"]:
        mesh = pyvista.PolyData(item["points"], faces=item["cells"])
        mesh.cell_data["colours"] = item["colours"]
        plotter.add_mesh(mesh, scalars="colours", rgb=True, lighting=False, opacity=item["opacity"])
    for item in scene["lines"]:
        ends = item["ends"]
        if len(ends) == 0:  # a closed surface has no rim
            continue
        mesh = pyvista.PolyData(item["points"], lines=np.insert(ends, 0, 2, axis=1).ravel())
        mesh.cell_data["colours"] = item["colours"]
        line_width = OVERSAMPLING * item["width"]
        plotter.add_mesh(mesh, scalars="colours", rgb=True, lighting=False, line_width=line_width)
    for item in scene["captions"]:
        text = plotter.add_text(
            item["text"],
            position=(OVERSAMPLING * item["x"], OVERSAMPLING * item["y"]),
            font_size=10,
            color="#2b2b2b",
        )
        text.prop.font_size = OVERSAMPLING * item["size"]
        text.prop.justification_horizontal = "center"
    camera = scene["camera"]
    plotter.camera_position = [camera["position"], camera["focus"], (0.0, 0.0, 1.0)]
    plotter.camera.view_angle = scene["view_angle"]
    if camera["parallel_scale"]:
        plotter.enable_parallel_projection()
        plotter.camera.parallel_scale = camera["parallel_scale"]
    plotter.reset_camera_clipping_range()
    image = plotter.screenshot(return_img=True)
    plotter.close()
    steps = range(OVERSAMPLING)
    total = sum(image[i::OVERSAMPLING, j::OVERSAMPLING].astype(np.uint16) for i in steps for j in steps)
    return np.asarray((total + OVERSAMPLING**2 // 2) // OVERSAMPLING**2, np.uint8)


def main() -> None:
    """Render the scenes in the file that the first argument names into the folder that the second one names."""
    from PIL import Image

    source, folder = Path(sys.argv[1]), Path(sys.argv[2])
    with source.open("rb") as file:
        scenes = pickle.Unpickler(file)
        for number in range(int(sys.argv[3])):
            picture = folder / f"{number:05d}.png"
            Image.fromarray(render(scenes.load())).save(picture, compress_level=4)


if __name__ == "__main__":
    main()
