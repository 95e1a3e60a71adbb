"""Every colour of the pictures, as #rrggbb; the four fold colours are those of the paper's Figure 4."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from inverse._types import FloatArray
from inverse.origami.pattern import CFL, FL, B, Pattern

Shades = tuple[str, str]  # the darkest and the brightest

# Names of the edge kinds, in the order in which the legend lists them and the crease pattern draws them.
EDGE_COLOURS = {
    "mountain": "#d81e2c",
    "valley": "#17358f",
    "complementary mountain": "#f48fb1",
    "complementary valley": "#6cb6e8",
    "border": "#000000",
}

PAPER = "#fbf9f4"  # sheets of the crease pattern
INK = "#2b2b2b"  # text
FACET_EDGE = "#40342b"  # edges of a facet in the 3D pictures
LAYER_EDGE = "#8a7767"  # the same where many layers lie over each other

# Facets from darkest to brightest, as the light falls on them; the two sides of the surface differ.
WARM: Shades = ("#b0744a", "#fdf3de")
COOL: Shades = ("#41566a", "#b9c9d6")
TARGET = ("#2f7fb5", "#8fc7ea")
TARGET_OPACITY = 0.3
WALL = ("#a9a9a6", "#efefec")
ROOF = ("#a98272", "#e8cdbf")
PERSON = ("#3c4a55", "#8d9ba6")
CONTEXT_EDGE = "#8d8d89"
GROUND = ("#ffffff", "#f0f0ec")  # at the rim and in the middle
SHADOW = "#dcdcd8"


def rgb(colour: str) -> NDArray[np.uint8]:
    """(3,) uint8 of a #rrggbb colour."""
    return np.frombuffer(bytes.fromhex(colour[1:]), np.uint8)


def blend(colours: Shades, share: FloatArray) -> NDArray[np.uint8]:
    """Colours, (N, 3) uint8, between the first (``share`` = 0) and the second (1) of a pair."""
    low, high = rgb(colours[0]).astype(np.float64), rgb(colours[1]).astype(np.float64)
    return np.rint(low + np.clip(share, 0, 1)[:, None] * (high - low)).astype(np.uint8)


def edge_kinds(pattern: Pattern, fold_angles: FloatArray) -> NDArray[np.int64]:
    """Index into ``EDGE_COLOURS`` of every edge, (E,), from its signed fold angle (valley positive)."""
    valley = (fold_angles > 0).astype(np.int64)
    kinds = {FL: valley, CFL: valley + 2, B: np.full_like(valley, 4)}
    return np.select([pattern.edges_type == t for t in kinds], list(kinds.values()))
