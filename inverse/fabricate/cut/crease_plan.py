"""Crease patterns to be cut: pieces side by side, with labels where they are joined and flaps to glue them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from inverse._types import FloatArray
from inverse.errors import InputError
from inverse.fabricate.cut.flaps import Flap, flaps_along
from inverse.fabricate.cut.labels import LARGEST, labels_along, words_of
from inverse.fabricate.cut.pieces import Piece, edges_of, pieces_of, to_scale
from inverse.fabricate.cut.plan import Line, Plan, Text
from inverse.fabricate.units import scale_in_words
from inverse.origami import geometry
from inverse.origami.pattern import Design
from inverse.pictures.colours import EDGE_COLOURS, edge_kinds
from inverse.pictures.sheets import stacked

MARGIN = 10.0  # mm around and between pieces
_KINDS = list(EDGE_COLOURS)  # the words of edge_kinds


@dataclass(frozen=True, eq=False)
class _Drawn:
    """Lines and texts of a piece at its own place."""

    lines: list[Line]
    texts: list[Text]


def crease_plan(design: Design, *, scale: float = 1.0, flaps: float = 0.0) -> Plan:
    """The pieces of the developed state, true to scale, none over another.

    Border and seams are cut. The two sides of a seam bear the same number, one for each edge.

    Args:
        design: the design.
        scale: of the model, 1 for full size.
        flaps: depth in mm of a flap along one side of each edge of a seam, where there is room; 0 for none. Such an
            edge is folded, and the flap is glued to the facet on the other side.

    Raises:
        InputError: a scale or depth that cannot be; the design cannot be developed; shapely is missing.
    """
    if not (np.isfinite(flaps) and flaps >= 0):
        raise InputError(f"flaps are {flaps:g} mm deep: 0 (none) or more is needed")
    pieces = pieces_of(design, scale)
    kinds = _edge_kinds(design)
    numbers = seams(design, pieces)
    glued = flaps_along(design.pattern, pieces, list(numbers), flaps) if flaps > 0 else []
    own = edges_of(design.pattern, pieces)
    return _in_shelves(
        design.name,
        scale_in_words(scale, design.unit),
        [
            _drawn(design, piece, own[k], kinds, numbers, [flap for flap in glued if flap.piece == k])
            for k, piece in enumerate(pieces)
        ],
    )


def layers_plan(design: Design, *, scale: float = 1.0, apart: bool = True) -> Plan:
    """Every layer of the developed state where it lies in it, the lowest first (Figure 9).

    All foldlines are drawn as what they are, complementary ones in both layers that they join; only the border is cut.

    Args:
        design: the design.
        scale: of the model, 1 for full size.
        apart: one layer beside the other, each named; otherwise one over the other.

    Raises:
        InputError: a scale that cannot be; the design cannot be developed.
    """
    layers = to_scale(design, stacked(design), scale)
    points = np.concatenate([layer.points for layer in layers])
    low, (width, height) = points.min(axis=0), np.ptp(points, axis=0)
    kinds = _edge_kinds(design)
    lines, texts = [], []
    for k, layer in enumerate(layers):
        shift = np.array([MARGIN + k * apart * (width + MARGIN), MARGIN + LARGEST]) - low
        for edge in layer.edges.tolist():
            ends = layer.place_of(design.pattern.edges_vertices[edge]) + shift
            lines.append(Line(kinds[edge], ends, edge, k * apart))
        if apart:
            place = low + shift + [width / 2, -LARGEST / 2 - 1]
            texts.append(Text("label", place, 0.0, LARGEST * 0.8, f"layer {k + 1} of {len(layers)}", k))
    size = (MARGIN + (len(layers) if apart else 1) * (width + MARGIN), height + 2 * MARGIN + LARGEST)
    words = scale_in_words(scale, design.unit)
    return Plan(design.name, (float(size[0]), float(size[1])), tuple(lines), tuple(texts), words)


def seams(design: Design, pieces: list[Piece]) -> dict[int, int]:
    """Numbers from 1 on of all edges between pieces, rising along every line, by their numbers in the design."""
    pattern = design.pattern
    piece_of = {f: k for k, piece in enumerate(pieces) for f in piece.faces}
    along = [edge for edges in pattern.lines_edges for edge in edges]
    cut = [edge for edge in along if len({piece_of[f] for f in pattern.edges_faces[edge].tolist()}) == 2]
    return {edge: number for number, edge in enumerate(cut, 1)}


def _edge_kinds(design: Design) -> list[str]:
    """Layer of every edge."""
    rho = geometry.fold_angles(design.pattern, design.vertices_coords)
    words = [_KINDS[k] for k in edge_kinds(design.pattern, rho).tolist()]
    return ["cut" if word == "border" else word for word in words]


def _drawn(
    design: Design, piece: Piece, own: list[int], kinds: list[str], numbers: dict[int, int], flaps: list[Flap]
) -> _Drawn:
    """A piece with its own edges and flaps."""
    pattern = design.pattern
    folded = {flap.edge for flap in flaps}
    lines: list[Line] = []
    sides: dict[int, list[tuple[FloatArray, str]]] = {f: [] for f in piece.faces}
    for edge in own:
        ends = piece.polygon(tuple(pattern.edges_vertices[edge].tolist()))
        is_cut = edge in numbers and edge not in folded
        lines.append(Line("cut" if is_cut else kinds[edge], ends, edge))
        if edge in numbers:
            left, right = pattern.edges_faces[edge].tolist()
            facet, side = (left, ends) if left in sides else (right, ends[::-1])
            sides[facet].append((side, words_of(numbers[edge])))
    lines += [Line("flap", np.array(pair)) for flap in flaps for pair in pairwise(flap.outline)]
    written = (labels_along(piece.polygon(pattern.faces_vertices[f]), own) for f, own in sides.items() if own)
    return _Drawn(lines, [text for texts in written for text in texts])


def _in_shelves(title: str, scale: str, drawn: list[_Drawn]) -> Plan:
    """Pieces side by side in rows about as wide as all are high."""
    points = [np.concatenate([line.ends for line in one.lines]) for one in drawn]
    low = [cloud.min(axis=0) for cloud in points]
    sizes = np.array([np.ptp(cloud, axis=0) for cloud in points]) + MARGIN
    limit = max(sizes[:, 0].max(), 1.4 * np.sqrt(sizes.prod(axis=1).sum()))
    lines: list[Line] = []
    texts: list[Text] = []
    x, y, row, widest = 0.0, 0.0, 0.0, 0.0
    for k, (one, corner, size) in enumerate(zip(drawn, low, sizes, strict=True)):
        if x > 0 and x + size[0] > limit:
            x, y, row = 0.0, y + row, 0.0
        shift = np.array([x, y]) + MARGIN - corner
        lines += [replace(line, ends=line.ends + shift, piece=k) for line in one.lines]
        texts += [replace(text, place=text.place + shift, piece=k) for text in one.texts]
        x, row = x + float(size[0]), max(row, float(size[1]))
        widest = max(widest, x)
    return Plan(title, (widest + MARGIN, y + row + MARGIN), tuple(lines), tuple(texts), scale)
