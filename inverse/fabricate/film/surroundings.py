"""What is shown around a moving structure: its target, buildings, and a person for scale."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.fabricate.units import METRES, metres

Surface = tuple[FloatArray, IntArray]
PERSON = 1.75  # metres
_SPECIFICATIONS = (".yaml", ".yml")

# A standing person as stacks of ellipses: height of the middle, half width, half depth, and how far from the middle
# the stack stands to either side; shares of the height.
_HEAD = [(0.87, 0.03, 0.035), (0.89, 0.043, 0.053), (0.935, 0.047, 0.06), (0.975, 0.036, 0.045), (1.0, 0.004, 0.005)]
_TRUNK = [
    *[(0.46, 0.06, 0.05), (0.5, 0.098, 0.068), (0.58, 0.085, 0.06), (0.72, 0.108, 0.068), (0.8, 0.118, 0.058)],
    *[(0.83, 0.06, 0.042), (0.845, 0.031, 0.032), (0.88, 0.029, 0.031)],
]
_LEG = [(0.0, 0.03, 0.07), (0.03, 0.028, 0.06), (0.05, 0.024, 0.03), (0.28, 0.034, 0.036), (0.49, 0.05, 0.058)]
_ARM = [(0.38, 0.012, 0.02), (0.43, 0.019, 0.026), (0.48, 0.016, 0.019), (0.63, 0.022, 0.025), (0.81, 0.025, 0.03)]
_STACKS = ((_HEAD, 0.0), (_TRUNK, 0.0), (_LEG, 0.053), (_LEG, -0.053), (_ARM, 0.138), (_ARM, -0.138))
_SIDES = 14


@dataclass(frozen=True, eq=False)
class Surroundings:
    """What stands around a design, in the design's unit.

    Attributes:
        target: vertices (V, 3) and triangles (T, 3) of the target surface.
        context: the same of buildings.
        person: whether a person 1.75 m tall stands beside the design.
    """

    target: Surface | None = None
    context: Surface | None = None
    person: bool = False


def read_target(path: Path) -> Surface:
    """The target surface that a specification names, or a mesh file.

    Raises:
        InputError: the file cannot be used.
    """
    if path.suffix.lower() in _SPECIFICATIONS:
        from inverse.formulation.formulate import build_target
        from inverse.spec import load

        return build_target(load(path)).triangles()
    from inverse.surfaces.mesh import read_mesh

    return read_mesh(path).triangles()


def read_buildings(path: Path, unit: str) -> Surface:
    """The buildings that a specification names, or those of a CityJSON file, from their origin.

    Args:
        path: specification or CityJSON file.
        unit: of the lengths that are returned; not known they are metres.

    Raises:
        InputError: the file cannot be used, or the specification names no buildings.
    """
    from inverse.context import read_city_json, triangulated

    if path.suffix.lower() in _SPECIFICATIONS:
        from inverse.formulation.context import read_context
        from inverse.spec import load

        context = read_context(load(path))
        if context is None:
            raise InputError("the specification names no buildings", where=str(path), hint="Give it a block `context`.")
    else:
        context = read_city_json(path)
    vertices, triangles, _ = triangulated(context)
    return vertices / metres(unit), triangles


def check_unit(unit: str) -> None:
    """Refuse a person beside a design without a unit of length."""
    if unit not in METRES:
        known = ", ".join(METRES)
        raise InputError(
            f"the design's unit is {unit!r}, so a person beside it has no size",
            hint=f"Give the file a frame_unit ({known}), or leave the figure out.",
        )


def person(unit: str, foot: FloatArray, facing: FloatArray) -> Surface:
    """A standing person, 1.75 m tall.

    Args:
        unit: of the lengths that are returned, a key of ``units.METRES``.
        foot: (3,) point on the ground between the feet.
        facing: (3,) level unit vector.

    Returns:
        Vertices (V, 3) and triangles (T, 3), turning counter-clockwise seen from outside.
    """
    angle = 2 * np.pi * np.arange(_SIDES) / _SIDES
    points: list[FloatArray] = []
    triangles: list[IntArray] = []
    first = 0
    for stack, aside in _STACKS:
        level, wide, deep = np.array(stack).T
        x, y = aside + wide[:, None] * np.cos(angle), deep[:, None] * np.sin(angle)
        # The feet point forward.
        y = y + np.where(level < 0.05, 0.025, 0.0)[:, None] * (stack is _LEG)
        rings = np.stack([x, y, np.broadcast_to(level[:, None], x.shape)], axis=2).reshape(-1, 3)
        caps = np.stack([rings[:_SIDES].mean(axis=0), rings[-_SIDES:].mean(axis=0)])
        points += [rings, caps]
        k, j = (i.ravel() for i in np.meshgrid(np.arange(len(stack) - 1), np.arange(_SIDES), indexing="ij"))
        a, b = k * _SIDES + j, k * _SIDES + (j + 1) % _SIDES
        rim, bottom = np.arange(_SIDES), len(rings)
        after, top = (rim + 1) % _SIDES, len(rings) - _SIDES
        sides = [np.stack([a, b, b + _SIDES], axis=1), np.stack([a, b + _SIDES, a + _SIDES], axis=1)]
        ends = [
            np.stack([after, rim, np.full(_SIDES, bottom)], axis=1),
            np.stack([top + rim, top + after, np.full(_SIDES, bottom + 1)], axis=1),
        ]
        triangles += [first + np.concatenate([*sides, *ends])]
        first += len(rings) + 2
    right = np.cross(facing, [0.0, 0.0, 1.0])
    axes = np.stack([right, facing, [0.0, 0.0, 1.0]])
    scale = PERSON / metres(unit)
    return np.concatenate(points) * scale @ axes + foot, np.concatenate(triangles).astype(np.int64)
