"""A drawing in millimetres, true to scale: what every format of crease patterns is written from."""

from __future__ import annotations

from dataclasses import dataclass, field

from inverse._types import FloatArray
from inverse.pictures.colours import EDGE_COLOURS


@dataclass(frozen=True, eq=False)
class Line:
    """A straight line on a layer.

    Attributes:
        layer: name of the layer; see :data:`LAYERS`.
        ends: (2, 2) in mm.
        edge: number of the edge in the design that it is, -1 for what is no edge.
    """

    layer: str
    ends: FloatArray
    edge: int = -1


@dataclass(frozen=True, eq=False)
class Text:
    """A word on a layer.

    Attributes:
        layer: name of the layer.
        place: (2,) middle of the word in mm.
        angle: of its baseline, radians counter-clockwise from x.
        height: of its capitals in mm.
        words: what is written.
    """

    layer: str
    place: FloatArray
    angle: float
    height: float
    words: str


@dataclass(frozen=True, eq=False)
class Plan:
    """A drawing: y upwards, all of it within the rectangle from (0, 0) to ``size``.

    Attributes:
        title: name of the design.
        size: (width, height) in mm.
        lines: all lines.
        texts: all words.
    """

    title: str
    size: tuple[float, float]
    lines: tuple[Line, ...]
    texts: tuple[Text, ...] = field(default=())


# Layers and their colours as #rrggbb: the four kinds of foldlines as in pictures; border and seams are cut; flaps are
# cut too, and their foldlines folded; labels are engraved or left out.
FOLDS = ("mountain", "valley", "complementary mountain", "complementary valley")
LAYERS: dict[str, str] = {
    "cut": EDGE_COLOURS["border"],
    **{kind: EDGE_COLOURS[kind] for kind in FOLDS},
    "flap": "#8a8a8a",
    "label": "#5c5c5c",
}
