"""Vertices and polygons of PLY files, ASCII or binary of either byte order, in the precision of the file."""

from __future__ import annotations

import re
import struct
import warnings
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np

from inverse._types import IntArray
from inverse.errors import InputError
from inverse.files.meshes.polygons import MAX_BYTES, Polygons, check_corners, check_counts, check_sides, checked
from inverse.files.reading import read_bytes

_KINDS = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float": "f4", "double": "f8", "float32": "f4", "float64": "f8",
}  # fmt: skip
_CODES = {"i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "f4": "f", "f8": "d"}  # of `struct`
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}
_DAMAGED = "The file is damaged: export the mesh anew."
_INDICES = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class _Property:
    name: str
    kind: str
    counted_by: str | None  # kind of the number before a list, None if it is a single number


@dataclass(frozen=True)
class _Element:
    name: str
    count: int
    properties: list[_Property] = field(default_factory=list)


class _TooShortError(Exception):
    """The file ends too early."""


class _Numbers(Protocol):
    """The numbers after the header."""

    position: int

    def take(self, kind: str, count: int) -> list[float]: ...

    def table(self, kinds: list[str], count: int) -> list[np.ndarray]: ...


class _Text:
    def __init__(self, content: bytes) -> None:
        with warnings.catch_warnings():  # NumPy warns where it meets no number, and stops
            warnings.simplefilter("error")
            self._values: np.ndarray = np.fromstring(content, np.float64, sep=" ")
        self.position = 0

    def take(self, kind: str, count: int) -> list[float]:
        found: list[float] = self._block(count).tolist()
        return found

    def table(self, kinds: list[str], count: int) -> list[np.ndarray]:
        return list(self._block(len(kinds) * count).reshape(count, len(kinds)).T)

    def _block(self, count: int) -> np.ndarray:
        block = self._values[self.position : self.position + count]
        if len(block) < count:
            raise _TooShortError
        self.position += count
        return block


class _Binary:
    def __init__(self, content: bytes, order: str) -> None:
        self._content, self._order = content, order
        self.position = 0

    def take(self, kind: str, count: int) -> list[float]:
        layout = struct.Struct(f"{self._order}{count}{_CODES[kind]}")
        return list(layout.unpack_from(self._content, self._advance(layout.size)))

    def table(self, kinds: list[str], count: int) -> list[np.ndarray]:
        layout = np.dtype([(f"f{k}", self._order + kind) for k, kind in enumerate(kinds)])
        rows = np.frombuffer(self._content, layout, count, self._advance(layout.itemsize * count))
        return [rows[f"f{k}"] for k in range(len(kinds))]

    def _advance(self, size: int) -> int:
        start = self.position
        if start + size > len(self._content):
            raise _TooShortError
        self.position += size
        return start


def read_ply(path: Path) -> Polygons:
    """Read a PLY file; colours, normals and elements of other names are passed over.

    Args:
        path: the file.

    Raises:
        InputError: unreadable file, a header that is none, or less behind it than it announces.
    """
    where = str(path)
    content = read_bytes(path, MAX_BYTES)
    form, elements, body = _header(content, where)
    try:
        numbers: _Numbers = _Text(content[body:]) if form == "ascii" else _Binary(content[body:], _ORDERS[form])
    except (DeprecationWarning, ValueError):
        raise InputError("there is something between the numbers after the header that is no number", where=where,
                         hint=_DAMAGED) from None  # fmt: skip
    vertices, sizes, corners = np.zeros((0, 3)), np.zeros(0, np.int64), np.zeros(0, np.int64)
    for element in elements:
        try:
            single, lists = _columns(numbers, element, where)
        except _TooShortError:
            announced = " and ".join(f"{e.count} of {e.name}" for e in elements)
            raise InputError(f"the file ends before all that its header announces: {announced}",
                             where=where, hint=_DAMAGED) from None  # fmt: skip
        if element.name == "vertex":
            if not {"x", "y", "z"} <= single.keys():
                raise InputError("its vertices have no coordinates x, y and z", where=where)
            vertices = np.stack([single[axis].astype(np.float64) for axis in "xyz"], axis=1)
        elif element.name == "face":
            named = next((name for name in _INDICES if name in lists), None)
            if element.count and named is None:
                raise InputError(f"its facets have no list {' or '.join(_INDICES)}", where=where)
            if named is not None:
                sizes, corners = lists[named][0], _indices(lists[named][1], where)
    return checked(vertices, sizes, corners, path)


def _header(content: bytes, where: str) -> tuple[str, list[_Element], int]:
    """The format, the elements in their order, and where the numbers start."""
    found = re.match(rb"ply[ \t]*(\r\n|\n|\r)(.*?)\1end_header[ \t]*\1", content[:100_000], re.DOTALL)
    if found is None:
        raise InputError("this is no PLY file: its header from `ply` to `end_header` is missing", where=where)
    form = ""
    elements: list[_Element] = []
    for line in found[2].decode("latin-1").splitlines():
        words = line.split()
        match words:
            case ["format", "ascii" | "binary_little_endian" | "binary_big_endian" as form, _]:
                pass
            case ["element", name, count] if re.fullmatch("[0-9]{1,12}", count):
                elements.append(_Element(name, int(count)))
            case ["property", "list", counted_by, kind, name] if (
                elements and kind in _KINDS and _KINDS.get(counted_by, "f")[0] != "f"
            ):
                elements[-1].properties.append(_Property(name, _KINDS[kind], _KINDS[counted_by]))
            case ["property", kind, name] if elements and kind in _KINDS:
                elements[-1].properties.append(_Property(name, _KINDS[kind], None))
            case ["comment" | "obj_info", *_] | []:
                pass
            case _:
                raise InputError(f"{line[:60]!r} is no line of a PLY header", where=where, hint=_DAMAGED)
    if not form:
        raise InputError("its header has no line `format`", where=where, hint=_DAMAGED)
    sizes = {element.name: element.count for element in elements}
    if len(sizes) < len(elements) or any(element.count and not element.properties for element in elements):
        raise InputError("an element of its header stands twice or has no properties", where=where, hint=_DAMAGED)
    check_counts(sizes.get("vertex", 0), sizes.get("face", 0), where)
    return form, elements, found.end()


def _columns(
    numbers: _Numbers, element: _Element, where: str
) -> tuple[dict[str, np.ndarray], dict[str, tuple[IntArray, np.ndarray]]]:
    """Properties of an element: single numbers (count,), and lists as their lengths (count,) and all their entries."""
    if not any(one.counted_by for one in element.properties):
        table = numbers.table([one.kind for one in element.properties], element.count)
        return {one.name: column for one, column in zip(element.properties, table, strict=True)}, {}
    check_counts(0, element.count, where)
    start = numbers.position
    rows = [_row(numbers, element, where)] if element.count else []
    if rows and (regular := _regular(numbers, element, [len(cells) for cells in rows[0]], start)) is not None:
        return {}, regular
    cells = 0
    for _ in range(len(rows), element.count):
        rows.append(_row(numbers, element, where))
        cells += sum(len(cell) for one, cell in zip(element.properties, rows[-1], strict=True) if one.counted_by)
        check_corners(cells, where)
    return {}, {
        one.name: (
            np.array([len(row[k]) for row in rows], np.int64),
            np.array([cell for row in rows for cell in row[k]], np.float64),
        )
        for k, one in enumerate(element.properties)
    }


def _row(numbers: _Numbers, element: _Element, where: str) -> list[list[float]]:
    """One row: what stands in each property."""
    row = []
    for one in element.properties:
        count = 1.0 if one.counted_by is None else numbers.take(one.counted_by, 1)[0]
        if one.counted_by is not None and element.name == "face" and one.name in _INDICES:
            check_sides(int(count) if count == count // 1 else -1, where)
        if not 0 <= count < MAX_BYTES or count != int(count):
            raise _TooShortError
        row.append(numbers.take(one.kind, int(count)))
    return row


def _regular(
    numbers: _Numbers, element: _Element, lengths: list[int], start: int
) -> dict[str, tuple[IntArray, np.ndarray]] | None:
    """The lists of an element whose rows are all like the first one, or None with the position after that one."""
    after = numbers.position
    numbers.position = start
    kinds = [
        kind
        for one, n in zip(element.properties, lengths, strict=True)
        for kind in ([] if one.counted_by is None else [one.counted_by]) + n * [one.kind]
    ]
    try:
        table = numbers.table(kinds, element.count)
    except _TooShortError:
        numbers.position = after
        return None
    lists = {}
    at = 0
    for one, n in zip(element.properties, lengths, strict=True):
        if one.counted_by is not None:
            if (table[at] != n).any():
                numbers.position = after
                return None
            at += 1
        cells = np.stack(table[at : at + n], axis=1).ravel() if n else np.zeros(0)
        lists[one.name] = np.full(element.count, n), cells
        at += n
    return lists


def _indices(entries: np.ndarray, where: str) -> IntArray:
    numbers = entries.astype(np.float64)
    with np.errstate(invalid="ignore"):
        whole = (np.abs(numbers) < 2**53) & (numbers == np.floor(numbers))
    if not whole.all():
        raise InputError(f"a facet names vertex {numbers[np.argmin(whole)]:g}: whole numbers are needed", where=where,
                         hint=_DAMAGED)  # fmt: skip
    return numbers.astype(np.int64)
