"""Reads buildings from CityJSON 1.1 or 2.0: a text sequence (.city.jsonl) or a single file (.city.json)."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from inverse._types import FloatArray
from inverse.context.building import Building, Context, Surface
from inverse.context.city_objects import FARTHEST, MalformedError, buildings_of
from inverse.context.formats import BEGINNING, other_format
from inverse.errors import InputError
from inverse.files.reading import json_object, read_bytes, read_text

VERSIONS = ("1.1", "2.0")
MAX_BYTES = 100_000_000


def read_city_json(path: Path, origin: Sequence[float] | FloatArray | None = None) -> Context:
    """Reads the buildings of a CityJSON file in local coordinates.

    Of every object the most detailed geometry is taken; among equals the one that tells roofs from walls.
    Parts belong to the building they are parts of. City objects that are not buildings are left out.

    Args:
        path: a CityJSONSeq or CityJSON file, version 1.1 or 2.0, in a metric reference system.
        origin: (3,) point to subtract, in the file's reference system. By default the centre of the
            buildings' bounding box at the lowest ground surface, rounded to whole metres.

    Returns:
        The buildings, in metres from the origin.

    Raises:
        InputError: the file is missing, is not CityJSON of these versions, or holds no building.
    """
    path = Path(path)
    _check_format(path)
    text = read_text(path, MAX_BYTES)
    start = None if origin is None else _point(origin, "origin")
    where, header, features = _documents(text, path.name)
    scale, translate = _transform(header, where)
    buildings: list[Building] = []
    for place, feature in [(where, header), *features]:
        try:
            buildings += buildings_of(feature, scale)
        except MalformedError as error:
            raise InputError(str(error), where=place) from None
        except (KeyError, TypeError, ValueError, IndexError, AttributeError, OverflowError) as error:
            what = f"{type(error).__name__}: {error}"
            raise InputError(f"not laid out as CityJSON asks ({what})", where=place) from None
    if not buildings:
        raise InputError("no building with a surface geometry was found", where=path.name)
    return _placed(buildings, translate, start, path.name)


def _check_format(path: Path) -> None:
    """Refuse a file of another format by its name: what a JSON reader says of it helps nobody."""
    other = other_format(read_bytes(path, MAX_BYTES)[:BEGINNING])
    if other is not None:
        raise InputError(
            f"this is {other}: buildings are read from CityJSON, version {' or '.join(VERSIONS)}", where=path.name,
            hint="Give them as .city.json or .city.jsonl, or leave the context out.",
        )  # fmt: skip


def _placed(buildings: list[Building], translate: FloatArray, origin: FloatArray | None, name: str) -> Context:
    """Moves the buildings from the file's own offset to the origin; the big numbers meet only each other."""
    points = np.concatenate([b.points for b in buildings])
    if np.max(np.ptp(points[:, :2], axis=0)) < 1.0:
        hint = "are these degrees? The reference system must be in metres"
        raise InputError("all buildings together are less than 1 m wide", where=name, hint=hint)
    grounds = [ring for b in buildings for surface in b.of_kind("GroundSurface") for ring in surface.rings]
    lowest = float(np.min((np.concatenate(grounds) if grounds else points)[:, 2]))
    if origin is None:
        middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
        origin = np.round(translate + np.array([middle[0], middle[1], lowest]))
    move = translate - origin
    moved = [
        Building(b.name, tuple(Surface(s.kind, tuple(ring + move for ring in s.rings)) for s in b.surfaces))
        for b in buildings
    ]
    return Context(tuple(moved), origin, lowest + float(move[2]))


def _documents(text: str, name: str) -> tuple[str, dict[str, Any], list[tuple[str, dict[str, Any]]]]:
    """The place and content of the CityJSON object, and of the features that follow it."""
    lines = [(number, line) for number, line in enumerate(text.split("\n"), start=1) if line.strip()]
    if not lines:
        raise InputError("the file is empty", where=name)
    if re.match(r"\s*\{.*\}\s*$", lines[0][1]) is None:  # one object over many lines: a single CityJSON file
        lines = [(1, text)]
    parsed = [(f"{name}:{number}", json_object(line, name, number)) for number, line in lines]
    where, header = parsed[0]
    if header.get("type") != "CityJSON":
        raise InputError(f'the first object must have "type": "CityJSON", not {header.get("type")!r}', where=where)
    if header.get("version") not in VERSIONS:
        allowed = " or ".join(VERSIONS)
        raise InputError(f"CityJSON version {header.get('version')!r} cannot be read, only {allowed}", where=where)
    for place, feature in parsed[1:]:
        if feature.get("type") != "CityJSONFeature":
            raise InputError(f'expected "type": "CityJSONFeature", not {feature.get("type")!r}', where=place)
    return where, header, parsed[1:]


def _point(values: Any, name: str, where: str | None = None) -> FloatArray:
    try:
        point = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        point = np.zeros(0)
    if point.shape != (3,) or not np.all(np.abs(point) < FARTHEST):
        raise InputError(f"{name} must be three numbers, not {values!r}", where=where)
    return point


def _transform(header: dict[str, Any], where: str) -> tuple[FloatArray, FloatArray]:
    transform = header.get("transform")
    if not isinstance(transform, dict):
        raise InputError('"transform" with "scale" and "translate" is missing', where=where)
    scale, translate = (_point(transform.get(key), f"transform.{key}", where) for key in ("scale", "translate"))
    return scale, translate
