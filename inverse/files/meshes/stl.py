"""Triangles of STL files, binary or ASCII."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from inverse.errors import InputError
from inverse.files.meshes.polygons import MAX_BYTES, Polygons, check_counts, checked
from inverse.files.reading import read_bytes

_HEADER = 84  # bytes before the first triangle
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_LOOP = re.compile(rb"outer\s+loop\s+" + rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)\s+" * 3 + rb"endloop", re.IGNORECASE)


def read_stl(path: Path) -> Polygons:
    """Read an STL file; every triangle has vertices of its own.

    Args:
        path: the file.

    Raises:
        InputError: unreadable file, or another number of triangles than it says.
    """
    content, where = read_bytes(path, MAX_BYTES), str(path)
    count = int.from_bytes(content[80:_HEADER], "little") if len(content) >= _HEADER else -1
    if len(content) == _HEADER + count * _TRIANGLE.itemsize:
        check_counts(0, count, where)
        corners = np.frombuffer(content, _TRIANGLE, count, _HEADER)["corners"].astype(np.float64)
    elif content.lstrip()[:5].lower() == b"solid":
        corners = _ascii(content, where)
    else:
        raise InputError(
            f"this is no whole STL file: it does not start with `solid`, and with {max(count, 0)} triangles it would "
            f"have {_HEADER + max(count, 0) * _TRIANGLE.itemsize} bytes, but has {len(content)}",
            where=where, hint="The file is damaged: export the mesh anew.",
        )  # fmt: skip
    vertices = np.ascontiguousarray(corners.reshape(-1, 3))
    return checked(vertices, np.full(len(corners), 3), np.arange(len(vertices)), path)


def _ascii(content: bytes, where: str) -> np.ndarray:
    """Corners (T, 3, 3)."""
    announced = len(re.findall(rb"facet\s+normal", content, re.IGNORECASE))
    check_counts(0, announced, where)
    words = [word for loop in _LOOP.findall(content) for word in loop]
    try:
        corners = np.array([float(word) for word in words], np.float64).reshape(-1, 3, 3)
    except ValueError as error:
        raise InputError(f"a vertex is no three numbers: {error}", where=where) from None
    if len(corners) != announced or b"endsolid" not in content.lower():
        raise InputError(
            f"the file starts {announced} triangles, but {len(corners)} are whole" if len(corners) != announced else
            "the file ends before its `endsolid`",
            where=where, hint="The file is damaged: export the mesh anew.",
        )  # fmt: skip
    return corners
