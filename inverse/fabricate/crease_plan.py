"""Crease patterns to be cut: pieces side by side, with labels where they are joined and flaps to glue them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from inverse import geometry
from inverse.errors import InputError
from inverse.fabricate.extras import needed
from inverse.fabricate.pieces import Piece, pieces_of
from inverse.fabricate.plan import Line, Plan, Text
from inverse.fabricate.units import millimetres
from inverse.pattern import Design, FloatArray
from inverse.pictures.colours import EDGE_COLOURS, edge_kinds
from inverse.pictures.sheets import stacked

MARGIN = 10.0  # mm around and between pieces
LARGEST_LETTERS = 4.0  # mm
SMALLEST_FLAP = 0.05  # of the depth asked for: less is left out
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
        InputError: a scale or depth that cannot be; shapely is missing.
    """
    if not (np.isfinite(flaps) and flaps >= 0):
        raise InputError(f"flaps are {flaps:g} mm deep: 0 (none) or more is needed")
    pieces = pieces_of(design, scale)
    kinds = _edge_kinds(design)
    numbers = seams(design, pieces)
    drawn = [_drawn(design, pieces, k, kinds, numbers, flaps) for k in range(len(pieces))]
    return _in_shelves(design.name, drawn)


def layers_plan(design: Design, *, scale: float = 1.0) -> Plan:
    """Every layer of the developed state where it lies in it, one beside the other, the lowest first (Figure 9).

    Args:
        design: the design.
        scale: of the model, 1 for full size.

    Raises:
        InputError: the scale is not positive.
    """
    if not (np.isfinite(scale) and scale > 0):
        raise InputError(f"the scale is {scale:g}: it must be greater than 0", hint="0.1 makes a model of 1 : 10.")
    factor = scale * millimetres(design.unit)
    layers = stacked(design)
    low = factor * np.min([layer.points.min(axis=0) for layer in layers], axis=0)
    width, height = factor * np.max([layer.points.max(axis=0) for layer in layers], axis=0) - low
    kinds = _edge_kinds(design)
    lines, texts = [], []
    for k, layer in enumerate(layers):
        shift = np.array([MARGIN + k * (width + MARGIN), MARGIN + LARGEST_LETTERS]) - low
        inside = set(layer.faces.tolist())
        for edge in layer.edges.tolist():
            ends = factor * layer.place_of(design.pattern.edges_vertices[edge]) + shift
            folded = {f for f in design.pattern.edges_faces[edge].tolist() if f >= 0} <= inside
            lines.append(Line(kinds[edge] if folded else "cut", ends, edge))
        place = low + shift + [width / 2, -LARGEST_LETTERS / 2 - 1]
        texts.append(Text("label", place, 0.0, LARGEST_LETTERS * 0.8, f"layer {k + 1} of {len(layers)}"))
    size = (MARGIN + len(layers) * (width + MARGIN), height + 2 * MARGIN + LARGEST_LETTERS)
    return Plan(design.name, (float(size[0]), float(size[1])), tuple(lines), tuple(texts))


def seams(design: Design, pieces: list[Piece]) -> dict[int, int]:
    """Numbers from 1 on of all edges between pieces, by their numbers in the design."""
    piece_of = {f: k for k, piece in enumerate(pieces) for f in piece.faces}
    cut = [
        edge
        for edge in design.pattern.interior_edges.tolist()
        if len({piece_of[f] for f in design.pattern.edges_faces[edge].tolist()}) == 2
    ]
    return {edge: number for number, edge in enumerate(cut, 1)}


def _edge_kinds(design: Design) -> list[str]:
    """Layer of every edge."""
    rho = geometry.fold_angles(design.pattern, design.vertices_coords)
    words = [_KINDS[k] for k in edge_kinds(design.pattern, rho).tolist()]
    return ["cut" if word == "border" else word for word in words]


def _drawn(
    design: Design, pieces: list[Piece], k: int, kinds: list[str], numbers: dict[int, int], flaps: float
) -> _Drawn:
    shapely = needed("shapely")
    pattern, piece = design.pattern, pieces[k]
    covered: Any = shapely.union_all([shapely.Polygon(piece.polygon(pattern.faces_vertices[f])) for f in piece.faces])
    lines: list[Line] = []
    texts: list[Text] = []
    inside = set(piece.faces)
    own = [e for e, pair in enumerate(pattern.edges_faces.tolist()) if not inside.isdisjoint(pair)]
    for edge in own:
        ends = piece.polygon(tuple(pattern.edges_vertices[edge].tolist()))
        left, right = pattern.edges_faces[edge].tolist()
        facet, other = (left, right) if left in inside else (right, left)
        if edge not in numbers:
            lines.append(Line(kinds[edge], ends, edge))
            continue
        middle = piece.polygon(pattern.faces_vertices[facet]).mean(axis=0)
        texts.append(_label(ends, middle, str(numbers[edge])))
        flap = None
        if flaps > 0 and facet == min(facet, other):  # one side of a seam has the flap
            flap = _flap(ends, middle, flaps, covered, shapely)
        if flap is None:
            lines.append(Line("cut", ends, edge))
            continue
        covered = covered.union(shapely.Polygon(flap))
        lines.append(Line(kinds[edge], ends, edge))
        lines += [Line("flap", np.array(pair)) for pair in pairwise(flap)]
    return _Drawn(lines, texts)


def _label(ends: FloatArray, middle: FloatArray, words: str) -> Text:
    """A number along an edge within a facet, to be read from below or from the right."""
    along = ends[1] - ends[0]
    length = float(np.linalg.norm(along))
    along = along / length
    inwards = np.array([-along[1], along[0]])
    depth = float((middle - ends[0]) @ inwards)
    inwards, depth = inwards * np.sign(depth), abs(depth)
    height = min(LARGEST_LETTERS, 0.5 * depth, 0.5 * length / max(len(words), 2))
    if along[0] < -1e-9 or (abs(along[0]) <= 1e-9 and along[1] < 0):
        along = -along
    # Towards the facet's middle, so that it stays inside at acute corners.
    at = ends.mean(axis=0)
    place = at + (middle - at) * (height / depth)
    return Text("label", place, float(np.arctan2(along[1], along[0])), height, words)


def _flap(ends: FloatArray, middle: FloatArray, depth: float, covered: Any, shapely: Any) -> FloatArray | None:
    """Corners (4, 2) of a flap with sides at 45 degrees, as deep as there is room; None where there is none."""
    along = ends[1] - ends[0]
    length = float(np.linalg.norm(along))
    along = along / length
    outwards = np.array([along[1], -along[0]])
    outwards = -outwards if (middle - ends[0]) @ outwards > 0 else outwards
    deep = min(depth, 0.4 * length)
    while deep > SMALLEST_FLAP * depth:
        slope = deep * (along + outwards), deep * (outwards - along)
        corners = np.array([ends[0], ends[0] + slope[0], ends[1] + slope[1], ends[1]])
        if covered.intersection(shapely.Polygon(corners)).area <= 1e-9 * deep * length:
            return corners
        deep *= 0.7
    return None


def _in_shelves(title: str, drawn: list[_Drawn]) -> Plan:
    """Pieces side by side in rows about as wide as all are high."""
    points = [np.concatenate([line.ends for line in one.lines]) for one in drawn]
    low = [cloud.min(axis=0) for cloud in points]
    sizes = np.array([np.ptp(cloud, axis=0) for cloud in points]) + MARGIN
    limit = max(sizes[:, 0].max(), 1.4 * np.sqrt(sizes.prod(axis=1).sum()))
    lines: list[Line] = []
    texts: list[Text] = []
    x, y, row, widest = 0.0, 0.0, 0.0, 0.0
    for one, corner, size in zip(drawn, low, sizes, strict=True):
        if x > 0 and x + size[0] > limit:
            x, y, row = 0.0, y + row, 0.0
        shift = np.array([x, y]) + MARGIN - corner
        lines += [replace(line, ends=line.ends + shift) for line in one.lines]
        texts += [replace(text, place=text.place + shift) for text in one.texts]
        x, row = x + float(size[0]), max(row, float(size[1]))
        widest = max(widest, x)
    return Plan(title, (widest + MARGIN, y + row + MARGIN), tuple(lines), tuple(texts))
