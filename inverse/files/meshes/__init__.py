"""Meshes from files that somebody gives: read by code of our own, which checks what a file says before it believes it.

The readers of large libraries end the process on a damaged file, ask for as much memory as a header claims, or take a
wrong number for another vertex.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from inverse.errors import InputError
from inverse.files.meshes.gltf import read_glb, read_gltf
from inverse.files.meshes.obj import read_obj
from inverse.files.meshes.off import read_off
from inverse.files.meshes.ply import read_ply
from inverse.files.meshes.polygons import Polygons
from inverse.files.meshes.stl import read_stl

__all__ = ["FORMATS", "Polygons", "read_mesh_file", "read_obj"]

_READERS: dict[str, Callable[[Path], Polygons]] = {
    ".obj": read_obj,
    ".ply": read_ply,
    ".stl": read_stl,
    ".glb": read_glb,
    ".gltf": read_gltf,
    ".off": read_off,
}
FORMATS = tuple(_READERS)


def read_mesh_file(path: Path) -> Polygons:
    """Vertices and polygons of a mesh file; of a scene those of all its parts, where they stand.

    Args:
        path: an OBJ, PLY, STL, GLB, glTF or OFF file.

    Raises:
        InputError: an unknown format, a file that cannot be read, is damaged or too large, or a mesh without facets.
    """
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        given = path.suffix or "a file without an ending"
        raise InputError(f"{given} is no mesh format: allowed are {', '.join(FORMATS)}", where=str(path))
    return reader(path)
