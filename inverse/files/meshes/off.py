"""Vertices and polygons of OFF files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from inverse.errors import InputError
from inverse.files.meshes.polygons import MAX_BYTES, Polygons, check_counts, check_sides, checked
from inverse.files.reading import read_text

_KINDS = ("OFF", "COFF", "NOFF", "CNOFF", "STOFF")  # what stands behind the coordinates is passed over


def read_off(path: Path) -> Polygons:
    """Read an OFF file in ASCII.

    Args:
        path: the file.

    Raises:
        InputError: unreadable file, no OFF, or another number of lines than it says; with its line.
    """
    rows = [
        (number, words)
        for number, line in enumerate(read_text(path, MAX_BYTES).split("\n"), 1)
        if (words := line.split("#", 1)[0].split())
    ]
    if not rows or rows[0][1][0] not in _KINDS:
        raise InputError(f"an OFF file starts with one of the words {', '.join(_KINDS)}", where=str(path))
    if len(rows[0][1]) > 1:
        rows[0] = rows[0][0], rows[0][1][1:]
    else:
        del rows[0]
    (n_vertices, n_facets), rows = _counts(rows, path), rows[1:]
    check_counts(n_vertices, n_facets, str(path))
    if len(rows) < n_vertices + n_facets:
        raise InputError(
            f"the file announces {n_vertices} vertices and {n_facets} facets, but holds {len(rows)} lines of them",
            where=str(path), hint="The file is damaged: export the mesh anew.",
        )  # fmt: skip
    vertices = np.array([_vertex(*row, path) for row in rows[:n_vertices]], np.float64).reshape(-1, 3)
    facets = [_facet(*row, path) for row in rows[n_vertices : n_vertices + n_facets]]
    sizes = np.array([len(facet) for facet in facets], np.int64)
    return checked(vertices, sizes, np.array([k for facet in facets for k in facet], np.int64), path)


def _counts(rows: list[tuple[int, list[str]]], path: Path) -> tuple[int, int]:
    try:
        n_vertices, n_facets = (int(word) for word in rows[0][1][:2])
    except (IndexError, ValueError):
        n_vertices = n_facets = -1
    if min(n_vertices, n_facets) < 0:
        raise InputError("an OFF file tells the numbers of its vertices and facets first", where=str(path))
    return n_vertices, n_facets


def _vertex(number: int, words: list[str], path: Path) -> list[float]:
    try:
        x, y, z = (float(word) for word in words[:3])
    except ValueError:
        raise InputError(f"{' '.join(words)[:60]!r} is no vertex: three numbers are needed",
                         where=f"{path}:{number}") from None  # fmt: skip
    return [x, y, z]


def _facet(number: int, words: list[str], path: Path) -> list[int]:
    where = f"{path}:{number}"
    try:
        sides = int(words[0])
        check_sides(sides, where)
        facet = [int(word) for word in words[1 : 1 + sides]]
        if len(facet) < sides or max(map(abs, facet)) >= 2**62:
            raise ValueError
    except InputError:
        raise
    except ValueError:
        raise InputError(f"{' '.join(words)[:60]!r} is no facet: a number of sides and as many vertices are needed",
                         where=where) from None  # fmt: skip
    return facet
