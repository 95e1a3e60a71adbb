"""Vertices and polygons of Wavefront OBJ files, faults with their line."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from inverse.errors import InputError
from inverse.files.meshes.polygons import MAX_BYTES, Polygons, check_corners, check_counts, check_sides, checked
from inverse.files.reading import read_bytes


def read_obj(path: Path) -> Polygons:
    """Read an OBJ file; groups, normals, texture coordinates, lines and materials are passed over.

    Args:
        path: the file. Names and comments in it may be of any encoding.

    Raises:
        InputError: missing or unreadable file, a line that is no vertex or facet, no facets.
    """
    text = read_bytes(path, MAX_BYTES).decode("utf-8-sig", errors="replace")
    vertices: list[list[float]] = []
    facets: list[list[int]] = []
    lines: list[int] = []
    n_corners = 0
    for number, line in enumerate(text.split("\n"), 1):
        words = line.split("#", 1)[0].split()
        if words[:1] == ["v"]:
            vertices.append(_vertex(words[1:], line, f"{path}:{number}"))
        elif words[:1] == ["f"]:
            facets.append(_facet(words[1:], len(vertices), line, f"{path}:{number}"))
            lines.append(number)
            n_corners += len(facets[-1])
            check_corners(n_corners, str(path))
        check_counts(len(vertices), len(facets), str(path))
    if not facets:
        raise InputError("the file has no facets (lines `f ...`)", where=str(path))
    for facet, number in zip(facets, lines, strict=True):
        if max(facet) >= len(vertices):
            raise InputError(
                f"the facet names vertex {max(facet) + 1}, but the file has {len(vertices)}, numbered from 1",
                where=f"{path}:{number}",
            )
    sizes = np.array([len(facet) for facet in facets], np.int64)
    corners = np.array([k for facet in facets for k in facet], np.int64)
    return checked(np.array(vertices, np.float64).reshape(-1, 3), sizes, corners, path)


def _vertex(words: list[str], line: str, where: str) -> list[float]:
    try:
        point = [float(word) for word in words[:3]]
    except ValueError:
        point = []
    if len(point) != 3 or not all(map(math.isfinite, point)):
        raise InputError(f"{line.strip()[:60]!r} is no vertex: three finite numbers are needed", where=where)
    return point


def _facet(words: list[str], n_vertices: int, line: str, where: str) -> list[int]:
    """Indices from 0; negative ones in the file count back from the last vertex so far."""
    if len(words) > 2:
        check_sides(len(words), where)
    try:
        given = [int(word.split("/", 1)[0]) for word in words]
    except ValueError:
        given = []
    if len(given) < 3:
        raise InputError(f"{line.strip()[:60]!r} is no facet: three or more vertex numbers are needed", where=where)
    facet = [k - 1 if k > 0 else n_vertices + k for k in given]
    if 0 in given or min(facet) < 0:
        bad = next(k for k, v in zip(given, facet, strict=True) if k == 0 or v < 0)
        raise InputError(f"the facet names vertex {bad}, but numbers start at 1 (or -1, counted back from the last)",
                         where=where)  # fmt: skip
    return facet
