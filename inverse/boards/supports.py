"""What a report beside a design tells: where it is held, how far it folds freely, and the verdicts on it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.origami import geometry
from inverse.origami.pattern import Design

NEAR = 1e-6  # of the diagonal: vertices of an anchored side that are nearer to its place are held
_VERDICTS = {"certified": "Foldable", "converged": "Optimal", "as_asked": "As asked"}


def read_json(path: Path) -> dict[str, Any]:
    """The object in a JSON file of ours, or an empty one where there is none that can be read."""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def verdicts(report: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    """Names and words of the verdicts that a report tells."""
    return tuple(
        (words, "yes" if report[key] else "no") for key, words in _VERDICTS.items() if isinstance(report.get(key), bool)
    )


def free_range(certificate: Mapping[str, Any]) -> tuple[float, float] | None:
    """Folding amounts in degrees between which facets do not meet, if a certificate tells them."""
    found = certificate.get("free_range")
    if isinstance(found, list) and len(found) == 2 and all(isinstance(one, int | float) for one in found):
        return float(found[0]), float(found[1])
    return None


def supports(design: Design, report: Mapping[str, Any]) -> tuple[int, ...]:
    """Vertices that are held: those of anchored sides, or named, which do lie where the anchor says.

    Args:
        design: the design.
        report: what its report tells; its specification is looked at.
    """
    try:
        anchors = report["specification"]["constraints"]["anchors"] or []
        found: set[int] = set()
        for anchor in anchors:
            vertices = _vertices(design, anchor)
            away = _distance(design.vertices_coords[vertices], anchor["to"])
            found |= set(vertices[away <= NEAR * geometry.diagonal(design.vertices_coords)].tolist())
    except (KeyError, TypeError, ValueError, IndexError):
        return ()  # the report of something else, or of another version
    return tuple(sorted(found))


def _vertices(design: Design, anchor: Mapping[str, Any]) -> IntArray:
    if anchor.get("vertices") is not None:
        return np.array(anchor["vertices"], np.int64)
    pattern = design.pattern
    if pattern.grid is None:
        return np.zeros(0, np.int64)
    table = np.arange(pattern.n_vertices).reshape(-1, pattern.grid[1] + 1)
    sides = {"u0": table[0], "u1": table[-1], "v0": table[:, 0], "v1": table[:, -1]}
    sides["ends"] = np.concatenate([sides["v0"], sides["v1"]])
    return np.asarray(sides[anchor["side"]])


def _distance(points: FloatArray, to: Mapping[str, Any]) -> FloatArray:
    """How far points (N, 3) are from the place of an anchor, (N,)."""
    if to.get("point") is not None:
        return np.asarray(np.linalg.norm(points - np.array(to["point"]), axis=1))
    if to.get("plane") is not None:
        normal = geometry.unit(np.array(to["plane"]["normal"], np.float64))
        return np.asarray(np.abs((points - np.array(to["plane"]["point"])) @ normal))
    if to.get("circle") is not None:
        circle = to["circle"]
        normal = geometry.unit(np.array(circle["normal"], np.float64))
        off = points - np.array(circle["center"])
        level = off @ normal
        return np.asarray(np.hypot(level, np.linalg.norm(off - np.outer(level, normal), axis=1) - circle["radius"]))
    corners = np.array(to.get("polyline") or [*to["polygon"], to["polygon"][0]], np.float64)
    a, b = corners[:-1], corners[1:]
    along = np.einsum("nsk,sk->ns", points[:, None] - a, b - a) / np.einsum("sk,sk->s", b - a, b - a)
    feet = a + np.clip(along, 0, 1)[..., None] * (b - a)
    return np.asarray(np.linalg.norm(points[:, None] - feet, axis=2).min(axis=1))
