"""Starts for fine grids: the same task with half the lines each way is solved first, and its design spread out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from inverse._types import FloatArray
from inverse.origami.pattern import Design
from inverse.spec import GridPattern, Loaded

FINE = 1024  # facets up to which a grid is solved from its seed: a coarser one would save nothing


def coarsened(loaded: Loaded) -> Loaded | None:
    """The same task with half the facets along u and v.

    Returns:
        The task, or None where there is none that is like it: for small grids, odd numbers of facets, strips of
        different lengths, lines of different types, where vertices are held by anchors, and where packed states count:
        how far their ends drift from each other adds up over all facets, so that a spread design starts far off.
    """
    specification = loaded.specification
    pattern = specification.pattern
    if not isinstance(pattern, GridPattern) or specification.constraints.anchors or specification.packs:
        return None
    (m, n), words, lengths = pattern.size, (pattern.u_lines, pattern.v_lines), (pattern.lengths_u, pattern.lengths_v)
    alike = all(_alike(row) for row in (*words, *lengths))
    if m * n <= FINE or m % 2 or n % 2 or min(m, n) < 16 or not alike:
        return None
    u_lines, v_lines = (word if isinstance(word, str) else word[0] for word in words)
    coarse = pattern.model_copy(
        update={
            "size": (m // 2, n // 2), "u_lines": u_lines, "v_lines": v_lines, "lengths_u": None, "lengths_v": None
        }
    )  # fmt: skip
    return replace(loaded, specification=specification.model_copy(update={"pattern": coarse}))


def spread(coarse_seed: Design, coarse_points: FloatArray, seed: Design) -> FloatArray:
    """Vertices of a fine grid moved from their seed as those of a coarse one moved from theirs.

    A corrugation repeats every two lines, so a vertex moves like those of its own parity along u and v. What these
    have in common is the movement of the sheet and stays; by how much they differ is a matter of the facets' size,
    and shrinks with it.

    Args:
        coarse_seed: placed seed of the coarse grid.
        coarse_points: (V, 3) its vertices in the solved design.
        seed: placed seed of the fine grid.

    Returns:
        (V', 3) vertices of the fine grid, in the seeds' unit.
    """
    assert coarse_seed.pattern.grid is not None  # coarsened() gave it
    assert seed.pattern.grid is not None
    m, n = coarse_seed.pattern.grid
    moved = (coarse_points - coarse_seed.vertices_coords).reshape(m + 1, n + 1, 3)
    fine_m, fine_n = seed.pattern.grid
    u, v = np.linspace(0, 1, m + 1), np.linspace(0, 1, n + 1)
    fine_u, fine_v = np.linspace(0, 1, fine_m + 1), np.linspace(0, 1, fine_n + 1)

    def everywhere(a: int, b: int, k: int) -> FloatArray:
        from scipy.interpolate import RectBivariateSpline

        # The box makes it go on beyond the outermost vertices of a parity instead of staying constant there.
        spline = RectBivariateSpline(u[a::2], v[b::2], moved[a::2, b::2, k], bbox=[0, 1, 0, 1])
        return np.asarray(spline(fine_u, fine_v))

    by_parity = np.array([[np.stack([everywhere(a, b, k) for k in range(3)], -1) for b in (0, 1)] for a in (0, 1)])
    sheet = by_parity.mean(axis=(0, 1))
    i, j = np.meshgrid(np.arange(fine_m + 1) % 2, np.arange(fine_n + 1) % 2, indexing="ij")
    own = by_parity[i, j, np.arange(fine_m + 1)[:, None], np.arange(fine_n + 1)]
    finer = np.sqrt(m * n / (fine_m * fine_n))
    return np.asarray(seed.vertices_coords + (sheet + finer * (own - sheet)).reshape(-1, 3))


def _alike(row: str | Sequence[str] | Sequence[float] | None) -> bool:
    return row is None or isinstance(row, str) or len(set(row)) == 1
