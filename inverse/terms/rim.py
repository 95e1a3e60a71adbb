"""Where facets on the rim belong when a seed is spread over its target."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.origami import geometry
from inverse.origami.pattern import B, Design, Pattern
from inverse.surfaces import Target

BESIDE = 1e-3  # of the plan's smaller side: what lies farther beside it is outside


def rim_places(
    seed: Design, target: Target, facets: IntArray, outward: float = 0.0, *, trimmed: bool = False
) -> FloatArray:
    """Where the centroids of facets on the rim come to lie when the seed is spread over the target.

    In plan a steep end of a target is short, so that a place in plan says little about where on it a facet is to
    be. The rows of quads that begin at the rim are therefore laid along the target, and the first facet of a row gets
    the share of its length that it has in the seed. Other facets keep their place in plan.

    The rows of a grid that is trimmed to the target's outline end within a facet of it, and are laid from outline to
    outline.

    Args:
        seed: the placed seed.
        target: the target.
        facets: (N,) int, facets on the rim.
        outward: length by which the first facet of a row lies nearer to the rim than so.
        trimmed: whether the seed is such a trimmed grid.

    Returns:
        (N, 3) places on the target.
    """
    pattern = seed.pattern
    centroids = geometry.facet_centroids(pattern, seed.vertices_coords)
    rows = [row for row in _rows(pattern) if len(row) > 1]
    lines, shares, beside = [], [], []
    for row in rows:
        first, second, before, last = centroids[[row[0], row[1], row[-2], row[-1]]]
        half = (second - first) / 2
        start, end = first - half, last + (last - before) / 2
        along = end - start
        share = half @ along / (along @ along)
        beside.append(half - share * along)  # corrugations put centroids beside the straight line
        shares.append(share)
        lines.append(start + _along(len(row), trimmed=trimmed)[:, None] * along)
    places, count = np.zeros_like(centroids), np.zeros(len(centroids))
    for row, line, share, off in zip(rows, _laid(target, lines, trimmed=trimmed), shares, beside, strict=True):
        if len(line) < 2:
            continue
        length = np.r_[0.0, np.linalg.norm(np.diff(line, axis=0), axis=1).cumsum()]
        places[row[0]] += [np.interp(share * length[-1] - outward, length, line[:, k]) for k in range(3)] + off
        count[row[0]] += 1
    in_plan = np.flatnonzero(count == 0)
    places[in_plan] = target.over_plan(centroids[in_plan])
    return np.asarray((places / np.maximum(count, 1)[:, None])[facets])


def _along(count: int, *, trimmed: bool) -> FloatArray:
    """Shares of the length of a row of facets at which it is laid on the target, of a trimmed grid beyond its ends."""
    if not trimmed:
        return np.linspace(0, 1, 8 * count + 1)
    return np.linspace(-1 / count, 1 + 1 / count, 32 * (count + 2) + 1)


def _laid(target: Target, lines: list[FloatArray], *, trimmed: bool) -> list[FloatArray]:
    """Lines (N, 3) laid on the target; of a trimmed grid without what lies beside its plan."""
    if not lines:
        return []
    ends = np.cumsum([len(line) for line in lines])[:-1]
    whole = np.concatenate(lines)
    over = target.over_plan(whole)
    if not trimmed:
        return np.split(over, ends)
    frame = target.frame
    beside = np.linalg.norm((over - whole) @ frame.axes[:2].T, axis=1)
    inside = beside < BESIDE * min(frame.extent)
    return [line[own] for line, own in zip(np.split(over, ends), np.split(inside, ends), strict=True)]


@lru_cache(maxsize=2)
def _rows(pattern: Pattern) -> list[list[int]]:
    """Facets met on walking inwards from every boundary edge, across opposite edges of quads."""
    rows = []
    for edge in np.flatnonzero(pattern.edges_type == B).tolist():
        facet = int(pattern.edges_faces[edge, 0])
        row: list[int] = []
        while facet >= 0 and len(pattern.faces_vertices[facet]) == 4:
            row.append(facet)
            others = set(pattern.faces_vertices[facet]) - set(pattern.edges_vertices[edge].tolist())
            edge = pattern.edge_between[frozenset(others)]
            left, right = pattern.edges_faces[edge].tolist()
            facet = right if facet == left else left
        if row:
            rows.append(row)
    return rows
