"""The figures on a board, told from the design itself."""

from __future__ import annotations

import numpy as np

from inverse.boards.body import normals
from inverse.boards.furniture import length_words
from inverse.boards.views import Subject
from inverse.fabricate.units import METRES
from inverse.origami import geometry
from inverse.origami.footprint import FLAT_STATES, measured
from inverse.origami.pattern import CFL, FL


def figures(subject: Subject) -> list[tuple[str, str]]:
    """Names and values, in the order in which a board lists them."""
    design, unit = subject.design, subject.design.unit
    pattern = design.pattern
    found = measured(design, FLAT_STATES)
    size = np.ptp(design.vertices_coords @ _own_axes(subject).T, axis=0)
    area = float(np.linalg.norm(normals(subject.body.polygons), axis=1).sum()) / 2
    edges = geometry.edge_lengths(pattern, design.vertices_coords)
    lines = [int(pattern.edges_type[line[0]]) for line in pattern.lines_edges]
    rows = [
        ("Size", _sizes(size.tolist(), unit)),
        ("Panels", f"{len(pattern.faces_vertices)}, {_area(area, unit)} in all"),
        ("Edges", f"{length_words(float(edges.min()), unit)} to {length_words(float(edges.max()), unit)}"),
        ("Lines", _lines(lines.count(FL), lines.count(CFL))),
        ("Flat as developed", _sizes(found["developed"]["extents"], unit)),
        ("Packed", _sizes(found["flat-folded"]["extents"], unit)),
        ("Deployed to packed", f"{found['deployed_to_packed']['flat-folded']['area']:.3g} times the area"),
    ]
    if subject.free is not None:
        low, high = subject.free
        rows.append(("Free to fold", f"from {low:.0f}° to {high:.0f}° of 0° to 180°"))
    count = len(subject.supports)
    if count:
        rows.append(("Held", f"at {count} {'vertex' if count == 1 else 'vertices'}"))
    return rows + list(subject.verdicts)


def _sizes(lengths: list[float], unit: str) -> str:
    words = " \u00d7 ".join(length_words(one, unit).split()[0] for one in lengths)
    return words if unit == "unit" else f"{words} {unit}"


def _area(area: float, unit: str) -> str:
    """In square metres, but for what is tiny or has no length."""
    if unit in METRES and area * METRES[unit] ** 2 >= 0.01:
        area, unit = area * METRES[unit] ** 2, "m"
    digits = max(0, 2 - int(np.floor(np.log10(area))))
    return f"{area:.{digits}f}" if unit == "unit" else f"{area:.{digits}f} {unit}²"


def _lines(folds: int, complementary: int) -> str:
    if not complementary:
        return f"{folds} foldlines"
    return f"{folds} foldlines, {complementary} complementary ones"


def _own_axes(subject: Subject) -> np.ndarray:
    c, s = np.cos(subject.turn), np.sin(subject.turn)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
