"""Triangles of glTF 2.0 scenes, text (.gltf) or binary (.glb), where their nodes put them."""

from __future__ import annotations

import base64
import struct
import urllib.parse
from pathlib import Path
from typing import Any

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.files.meshes.polygons import MAX_BYTES, Polygons, check_counts, checked
from inverse.files.reading import json_object, read_bytes, read_text

_COMPONENTS = {5120: "i1", 5121: "u1", 5122: "i2", 5123: "u2", 5125: "u4", 5126: "f4"}
_WIDTHS = {"SCALAR": 1, "VEC3": 3}
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_KNOWN = ("KHR_mesh_quantization", "KHR_materials_", "KHR_texture_", "KHR_lights_")
_DAMAGED = "The file is damaged: export the mesh anew."


class _MalformedError(Exception):
    """A fault, told without the file's name."""


def read_glb(path: Path) -> Polygons:
    """Read a binary glTF file.

    Args:
        path: the file.

    Raises:
        InputError: unreadable file, or not laid out as glTF 2.0 asks.
    """
    content, where = read_bytes(path, MAX_BYTES), str(path)
    magic, version, length = struct.unpack_from("<4sII", content.ljust(12, b"\0"))
    if magic != b"glTF" or version != 2:
        raise InputError("this is no binary glTF 2.0 file", where=where)
    chunks: dict[bytes, bytes] = {}
    at = 12
    while at + 8 <= len(content):
        size, kind = struct.unpack_from("<I4s", content, at)
        chunks.setdefault(kind, content[at + 8 : at + 8 + size])
        at += 8 + size
    if length != len(content) or at != len(content) or b"JSON" not in chunks:
        raise InputError(f"its parts do not add up to the {len(content)} bytes of the file", where=where, hint=_DAMAGED)
    try:
        text = chunks[b"JSON"].decode("utf-8")
    except UnicodeDecodeError:
        raise InputError("its JSON is not valid UTF-8", where=where, hint=_DAMAGED) from None
    return _read(json_object(text, where), chunks.get(b"BIN\0"), path)


def read_gltf(path: Path) -> Polygons:
    """Read a glTF file in JSON, with its buffers within or beside it.

    Args:
        path: the file.

    Raises:
        InputError: unreadable file, or not laid out as glTF 2.0 asks.
    """
    return _read(json_object(read_text(path, MAX_BYTES), str(path)), None, path)


def _read(document: dict[str, Any], binary: bytes | None, path: Path) -> Polygons:
    where = str(path)
    try:
        unknown = [str(e) for e in document.get("extensionsRequired", []) if not str(e).startswith(_KNOWN)]
        if unknown:
            raise InputError(f"the file needs the extension {unknown[0][:60]}, which is not read here", where=where,
                             hint="Export the mesh without compression.")  # fmt: skip
        buffers = [
            _buffer(buffer, binary if k == 0 else None, path) for k, buffer in enumerate(document.get("buffers", []))
        ]
        points, triangles = _placed(document, buffers, where)
    except _MalformedError as error:
        raise InputError(str(error), where=where, hint=_DAMAGED) from None
    except InputError:
        raise
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, OverflowError) as error:
        what = f"{type(error).__name__}: {str(error)[:100]}"
        raise InputError(f"not laid out as glTF asks ({what})", where=where, hint=_DAMAGED) from None
    return checked(points, np.full(len(triangles), 3), triangles.ravel(), path)


def _buffer(buffer: dict[str, Any], binary: bytes | None, path: Path) -> bytes:
    uri = buffer.get("uri")
    if uri is None:
        content = binary or b""
    elif uri.startswith("data:"):
        content = base64.b64decode(uri.partition(",")[2], validate=True)
    elif "://" in uri:
        raise _MalformedError("a buffer is an address on the web: it must be a file beside this one, or within it")
    else:
        content = read_bytes(path.parent / urllib.parse.unquote(uri), MAX_BYTES)
    length = buffer["byteLength"]
    if not 0 <= length <= len(content):
        raise _MalformedError(f"a buffer announces {length} bytes, but has {len(content)}")
    return content[:length]


def _placed(document: dict[str, Any], buffers: list[bytes], where: str) -> tuple[FloatArray, IntArray]:
    """Vertices (V, 3) and triangles (T, 3) of all meshes where the scene puts them."""
    meshes: dict[int, list[tuple[FloatArray, IntArray]]] = {}
    points: list[FloatArray] = []
    triangles: list[IntArray] = []
    n_points = n_triangles = 0
    for place, k in _nodes(document):
        if k not in meshes:
            mesh = _item(document, "meshes", k)
            found = [_primitive(document, buffers, primitive) for primitive in mesh["primitives"]]
            meshes[k] = [part for part in found if part is not None]
        for own, faces in meshes[k]:
            check_counts(n_points + len(own), n_triangles + len(faces), where)
            with np.errstate(all="ignore"):  # what is not finite is refused with the rest
                points.append(own @ place[:3, :3].T + place[:3, 3])
            triangles.append(faces + n_points)
            n_points, n_triangles = n_points + len(own), n_triangles + len(faces)
    if not points:
        return np.zeros((0, 3)), np.zeros((0, 3), np.int64)
    return np.concatenate(points), np.concatenate(triangles)


def _nodes(document: dict[str, Any]) -> list[tuple[FloatArray, int]]:
    """The meshes of the scene by their numbers, with their places (4, 4)."""
    nodes = document.get("nodes", [])
    if "scenes" in document:
        roots = _item(document, "scenes", document.get("scene", 0)).get("nodes", [])
    else:
        roots = sorted(set(range(len(nodes))) - {child for node in nodes for child in node.get("children", [])})
    waiting = [(np.eye(4), k) for k in reversed(roots)]
    seen: set[int] = set()
    found = []
    while waiting:
        above, k = waiting.pop()
        node = _item(document, "nodes", k)
        if k in seen:
            raise _MalformedError(f"node {k} hangs in two places of the scene: the nodes must form a tree")
        seen.add(k)
        with np.errstate(all="ignore"):
            place = above @ _transform(node)
        if "mesh" in node:
            found.append((place, node["mesh"]))
        waiting += [(place, child) for child in reversed(node.get("children", []))]
    return found


def _transform(node: dict[str, Any]) -> FloatArray:
    from scipy.spatial.transform import Rotation

    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    place = np.eye(4)
    turn = Rotation.from_quat(np.array(node.get("rotation", (0.0, 0.0, 0.0, 1.0)), np.float64)).as_matrix()
    place[:3, :3] = turn * np.array(node.get("scale", (1.0, 1.0, 1.0)), np.float64).reshape(3)
    place[:3, 3] = np.array(node.get("translation", (0.0, 0.0, 0.0)), np.float64)
    return place


def _primitive(
    document: dict[str, Any], buffers: list[bytes], primitive: dict[str, Any]
) -> tuple[FloatArray, IntArray] | None:
    """Vertices and triangles of one part, None for points and lines."""
    mode = primitive.get("mode", _TRIANGLES)
    if mode not in (_TRIANGLES, _STRIP, _FAN):
        return None
    points = _accessor(document, buffers, primitive["attributes"]["POSITION"], "VEC3").astype(np.float64)
    corners: IntArray = np.arange(len(points))
    if "indices" in primitive:
        corners = _accessor(document, buffers, primitive["indices"], "SCALAR").ravel().astype(np.int64)
    if len(corners) and not 0 <= corners.min() <= corners.max() < len(points):
        raise _MalformedError(f"a facet names vertex {corners.max()}, but the {len(points)} vertices of its part have "
                              "numbers from 0")  # fmt: skip
    if mode == _TRIANGLES:
        if len(corners) % 3:
            raise _MalformedError(f"{len(corners)} corners make no whole number of triangles")
        return points, corners.reshape(-1, 3)
    if mode == _FAN:
        return points, np.stack([np.full(max(len(corners) - 2, 0), corners[0]), corners[1:-1], corners[2:]], axis=1)
    strip = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    strip[1::2] = strip[1::2, [1, 0, 2]]  # every second one turns the other way
    return points, strip


def _accessor(document: dict[str, Any], buffers: list[bytes], number: Any, form: str) -> np.ndarray:
    """A table of numbers (count, width)."""
    accessor = _item(document, "accessors", number)
    if "sparse" in accessor or "bufferView" not in accessor:
        raise _MalformedError("its numbers are stored sparsely, which is not read here")
    if accessor["type"] != form:
        raise _MalformedError(f"numbers of type {accessor['type']} stand where {form} is needed")
    view = _item(document, "bufferViews", accessor["bufferView"])
    first, length = view.get("byteOffset", 0), view["byteLength"]
    buffer = buffers[_index(view["buffer"], len(buffers), "buffer")]
    kind = np.dtype(f"<{_COMPONENTS[accessor['componentType']]}")
    width, count, offset = _WIDTHS[form], accessor["count"], accessor.get("byteOffset", 0)
    stride = view.get("byteStride", width * kind.itemsize)
    needed = offset + stride * (count - 1) + width * kind.itemsize if count else 0
    if min(first, length, count, offset) < 0 or stride < width * kind.itemsize or first + length > len(buffer):
        raise _MalformedError("a part of a buffer is not within it")
    if needed > length:
        raise _MalformedError(f"{count} entries of {form} need {needed} bytes, but {length} are there")
    table: np.ndarray = np.ndarray((count, width), kind, buffer, first + offset, (stride, kind.itemsize))
    if accessor.get("normalized") is True and kind.kind != "f":
        return np.maximum(table / np.iinfo(kind).max, -1.0)
    return table


def _item(document: dict[str, Any], key: str, number: Any) -> dict[str, Any]:
    found: dict[str, Any] = document[key][_index(number, len(document[key]), key)]
    return found


def _index(number: Any, count: int, key: str) -> int:
    if type(number) is not int or not 0 <= number < count:
        raise _MalformedError(f"number {str(number)[:20]} of {key} is not there: there are {count}")
    return number
