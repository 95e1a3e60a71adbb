"""Whether a network is a grid of m x n quads, however its vertices are numbered."""

from __future__ import annotations

import numpy as np

from inverse._types import IntArray
from inverse.errors import InputError
from inverse.origami.pattern import Pattern
from inverse.repair.foreign import Pair, pair_of
from inverse.repair.line_types import words_of


def grid_of(pattern: Pattern) -> IntArray | None:
    """Vertices of a grid, (m + 1, n + 1) int, or None if the network is none.

    Where the file numbers them u-major as design files do, u and v are those of the numbering. Otherwise (0, 0) is
    the corner with the lowest number, and u runs so that the facets turn from u to v.
    """
    degree = np.bincount(pattern.edges_vertices.ravel())
    corners = np.flatnonzero(degree == 2)
    if len(corners) != 4 or pattern.n_holes or any(len(face) != 4 for face in pattern.faces_vertices):
        return None
    right: dict[tuple[int, int], tuple[int, ...]] = {}
    for face in pattern.faces_vertices:
        for k in range(4):
            right[face[k], face[(k + 1) % 4]] = face[k:] + face[:k]
    corner = int(corners[0])
    # A facet from here on is (p, q, r, s): p -> q along u, p -> s along v.
    first = next(face for (a, _), face in right.items() if a == corner)
    columns: list[list[int]] = []
    foot: tuple[int, ...] | None = first
    while foot is not None and len(columns) <= len(pattern.faces_vertices):
        column, face = [foot[0]], foot
        ahead: tuple[int, ...] | None = foot
        outer = [foot[1]]
        while ahead is not None:
            face = ahead
            column.append(face[3])
            outer.append(face[2])
            ahead = right.get((face[3], face[2]))
        columns.append(column)
        beyond = right.get((foot[2], foot[1]))
        foot = None if beyond is None else beyond[1:] + beyond[:1]
    columns.append(outer)
    if len({len(column) for column in columns}) > 1:
        return None
    grid = np.array(columns, np.int64)
    quads = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=-1).reshape(-1, 4)
    if set(map(frozenset, quads.tolist())) != set(map(frozenset, pattern.faces_vertices)):
        return None
    return grid.T if np.array_equal(grid.T.ravel(), np.arange(grid.size)) else grid


def numbered_size(pattern: Pattern) -> tuple[int, int] | None:
    """(m, n) if vertices and facets are numbered as the file format asks of a grid."""
    grid = grid_of(pattern)
    if grid is None or not np.array_equal(grid.ravel(), np.arange(grid.size)):
        return None
    m, n = grid.shape[0] - 1, grid.shape[1] - 1
    for f, face in enumerate(pattern.faces_vertices):
        i, j = divmod(f, n)
        if set(face) != set(grid[i : i + 2, j : j + 2].ravel().tolist()):
            return None
    return m, n


def types_of_words(pattern: Pattern, u_lines: str, v_lines: str) -> IntArray:
    """Types (E,) of a grid's edges from words for its lines.

    Args:
        pattern: the network.
        u_lines: FL or CFL for all interior lines that are crossed by walking along u, or a word for each,
            separated by commas.
        v_lines: the same along v.

    Raises:
        InputError: the network is no grid, or the words do not fit.
    """
    grid = grid_of(pattern)
    if grid is None:
        raise InputError("the pattern is no grid of quads, so that it has no lines along u and v",
                         hint="Give the types in the file (bdffpq:edges_type), or let them be deduced.")  # fmt: skip
    m, n = grid.shape[0] - 1, grid.shape[1] - 1
    u = words_of(u_lines.split(","), m - 1, "--u-lines")
    v = words_of(v_lines.split(","), n - 1, "--v-lines")
    kinds: dict[Pair, int] = {}
    for i, kind in enumerate(u, 1):
        kinds |= {pair_of(a, b): kind for a, b in zip(grid[i, :-1].tolist(), grid[i, 1:].tolist(), strict=True)}
    for j, kind in enumerate(v, 1):
        kinds |= {pair_of(a, b): kind for a, b in zip(grid[:-1, j].tolist(), grid[1:, j].tolist(), strict=True)}
    return np.array([kinds.get(pair_of(a, b), 0) for a, b in pattern.edges_vertices.tolist()], np.int64)
