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
        piece: number of the piece, or of the layer beside others, that it belongs to.
    """

    layer: str
    ends: FloatArray
    edge: int = -1
    piece: int = 0


@dataclass(frozen=True, eq=False)
class Text:
    """A word on a layer.

    Attributes:
        layer: name of the layer.
        place: (2,) middle of the word in mm.
        angle: of its baseline, radians counter-clockwise from x.
        height: of its capitals in mm.
        words: what is written.
        piece: as of a line.
    """

    layer: str
    place: FloatArray
    angle: float
    height: float
    words: str
    piece: int = 0


@dataclass(frozen=True, eq=False)
class Plan:
    """A drawing: y upwards, all of it within the rectangle from (0, 0) to ``size``.

    Attributes:
        title: name of the design.
        size: (width, height) in mm.
        lines: all lines.
        texts: all words.
        scale: of the model in words, such as "1:50, 1 m = 20 mm".
    """

    title: str
    size: tuple[float, float]
    lines: tuple[Line, ...]
    texts: tuple[Text, ...] = field(default=())
    scale: str = ""


# Layers and their colours as #rrggbb: the four kinds of foldlines as in pictures; border and seams are cut; flaps are
# cut too, and their foldlines folded; labels are engraved or left out.
FOLDS = ("mountain", "valley", "complementary mountain", "complementary valley")
LAYERS: dict[str, str] = {
    "cut": EDGE_COLOURS["border"],
    **{kind: EDGE_COLOURS[kind] for kind in FOLDS},
    "flap": "#8a8a8a",
    "label": "#5c5c5c",
}
