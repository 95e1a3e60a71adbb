"""A design's motion in one picture: developed, three states between, flat-folded.

python -m studies.motion_picture DESIGN.fold [PICTURE.png]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import inverse
from inverse.fabricate.film.poses import poses
from inverse.pictures import process_picture

DEGREES = np.array([0.0, 45.0, 90.0, 135.0, 180.0])
NEARLY = 0.6  # degrees before a flat state: its layers lie in one plane there, and cannot be drawn apart


def main() -> None:
    """Draw the states side by side, at one scale."""
    path, *others = (Path(argument) for argument in sys.argv[1:])
    design = inverse.read(path)
    shown = np.clip(DEGREES, NEARLY, 180 - NEARLY)
    states = [design.moved_to(points) for points in poses(design, np.radians(shown)).vertices_coords]
    titles = ["developed", *(f"t = {amount:g}°" for amount in DEGREES[1:-1]), "flat-folded"]
    process_picture(states, titles, others[0] if others else path.with_name("motion.png"))


if __name__ == "__main__":
    main()
