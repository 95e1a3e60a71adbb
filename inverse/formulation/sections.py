"""The seed of a tube laid on the section that it is to follow: how large, and turned how far about its axis."""

from __future__ import annotations

import numpy as np

from inverse._types import FloatArray
from inverse.origami.seeds import Section
from inverse.surfaces.section import SectionTarget, on_polygons

TURNS, SIZES = 180, 25  # looked at
LEAST, MOST = 0.7, 1.4  # sizes, by mean radius


def suited(steps: Section, target: SectionTarget) -> Section:
    """Steps with the proportions of the target's section: of four sides the rectangle around it."""
    if len(steps) != 4:
        return steps
    outline = target.outlines(np.array([0.5]))[0]
    turns = np.radians(np.arange(0.0, 90.0, 0.5))
    sides = [np.ptp(outline @ np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]), axis=0) for a in turns]
    width, height = min(sides, key=np.prod)
    return tuple((n, a, float((width, height)[k % 2])) for k, (n, a, _) in enumerate(steps))


def laid(ring: FloatArray, target: SectionTarget) -> tuple[float, float]:
    """Where a ring lies best on the section half-way along the target.

    Args:
        ring: (k, 2) corners of the seed's section.
        target: the target.

    Returns:
        Twice the rms distance of the ring's sides from its middle, and its turn in radians.
    """
    outline = target.outlines(np.array([0.5]))
    sides = (ring + np.roll(ring, -1, axis=0)) / 2
    points = np.concatenate([ring, sides]) - sides.mean(axis=0)
    radius = float(np.sqrt(np.mean(np.sum((sides - sides.mean(axis=0)) ** 2, axis=1))))
    best = (np.inf, 0.0, 0.0)
    for turn in 2 * np.pi * np.arange(TURNS) / TURNS:
        c, s = np.cos(turn), np.sin(turn)
        turned = points @ np.array([[c, s], [-s, c]])
        for size in np.geomspace(LEAST, MOST, SIZES) * target.mean_radius / radius:
            own = size * turned
            foot, _ = on_polygons(own, np.broadcast_to(outline, (len(own), *outline.shape[1:])))
            # The other way round, a ring must not hide in a corner of the section.
            back = np.linalg.norm(outline[0][:, None] - own, axis=2).min(axis=1)
            misfit = float(np.mean(np.sum((own - foot) ** 2, axis=1)) + 0.25 * np.mean(back**2))
            if misfit < best[0] * (1 - 1e-9):
                best = (misfit, 2 * size * radius, turn)
    return best[1], best[2]
