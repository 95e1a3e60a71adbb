"""What a file says about itself beyond its design state, held against what was derived from that."""

from __future__ import annotations

from typing import Any

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.certify.loops import cut_open
from inverse.certify.measures import CFL, FL
from inverse.certify.mesh import Mesh
from inverse.certify.structure import Structure
from inverse.files.fold_format import FoldFrame

ANGLE_TOLERANCE = 1e-6  # degrees
LENGTH_TOLERANCE = 1e-7  # of the diagonal: flat states are cut from, not folded from
# A frame that replaces one of these describes another mesh.
INHERITED = ("edges_vertices", "faces_vertices", "edges_assignment", "bdffpq:edges_type")


def faults(structure: Structure, frame: FoldFrame) -> list[str]:
    """What is wrong with the claims of a file, as far as they can be held against anything."""
    mesh = structure.mesh
    if mesh is None:
        return []
    found = _topology_faults(mesh, frame.document)
    if structure.halves is not None:
        sine, cosine = structure.halves
        found += _fold_faults(structure, mesh, frame, np.degrees(2 * np.arctan2(sine, cosine)))
        found += _flat_state_faults(structure, mesh, frame)
    return found


def _topology_faults(mesh: Mesh, document: dict[str, Any]) -> list[str]:
    """The claims ``bdffpq:topology``, ``bdffpq:holes`` and ``bdffpq:grid``, where the file makes them."""
    faults = []
    topology = document.get("bdffpq:topology", mesh.topology)
    if topology != mesh.topology:
        faults.append(f"bdffpq:topology is {_short(topology)}, but the facets form a {mesh.topology}")
    if "bdffpq:holes" in document:
        faults += _hole_faults(mesh, document["bdffpq:holes"])
    if "bdffpq:grid" in document:
        faults += _grid_faults(mesh, document["bdffpq:grid"])
    return faults


def _fold_faults(structure: Structure, mesh: Mesh, frame: FoldFrame, rho: FloatArray) -> list[str]:
    """Mountains, valleys and fold angles of the file against the fold angles ``rho`` (E,), in degrees."""
    faults = []
    for e, k in enumerate(structure.file_edge.tolist()):
        if k < 0:
            continue
        word, angle = frame.edges_assignment[k], float(frame.edges_fold_angle[k])
        # Where the sheet is flat the sign says nothing.
        is_folded = ANGLE_TOLERANCE < abs(rho[e]) < 180 - ANGLE_TOLERANCE
        true_word, name = ("V", "valley") if rho[e] > 0 else ("M", "mountain")
        if word != "B" and is_folded and word != true_word:
            faults.append(f"{mesh.name(e)} is assigned {word}, but it is a {name}")
        if abs(angle - rho[e]) > ANGLE_TOLERANCE:
            faults.append(f"{mesh.name(e)} has a fold angle of {angle:.9g} degrees, but is folded by {rho[e]:.9g}")
    return faults


def _flat_state_faults(structure: Structure, mesh: Mesh, frame: FoldFrame) -> list[str]:
    """The frames titled ``developed`` and ``flat-folded``: congruent facets, each on its proper side."""
    frames = frame.document.get("file_frames", [])
    if not isinstance(frames, list):
        return ["file_frames is no list"]
    faults = []
    for k, item in enumerate(frames):
        title = item.get("frame_title") if isinstance(item, dict) else None
        if not isinstance(item, dict):
            faults.append(f"file_frames[{k}] is no frame")
        elif title == "developed":
            faults += _flat_frame_faults(structure, mesh, frame, item, title, CFL)
        elif title == "flat-folded":
            faults += _flat_frame_faults(structure, mesh, frame, item, title, FL)
    return faults


def _flat_frame_faults(
    structure: Structure, mesh: Mesh, frame: FoldFrame, item: dict[str, Any], title: str, folded: int
) -> list[str]:
    for key in INHERITED:
        if key in item and item[key] != frame.document.get(key):
            return [f"the {title} frame has its own {key}"]
    faults = []
    if "edges_foldAngle" in item:
        faults += _flat_angle_faults(structure, mesh, frame, item["edges_foldAngle"], title, folded)
    signs = structure.signs[0 if folded == CFL else 1]
    rows = _numbers(item.get("vertices_coords"), len(structure.points))
    if rows is None:
        faults.append(f"the {title} frame needs coordinates of every vertex")
    elif signs is not None:
        # In the unit in which the design's diagonal is 1. An absurd frame may overflow: it is no match then.
        with np.errstate(all="ignore"):
            faults += _layout_faults(mesh, structure.points, rows / structure.unit, signs, title)
    return faults


def _layout_faults(mesh: Mesh, points: FloatArray, flat: FloatArray, signs: IntArray, title: str) -> list[str]:
    """Facets congruent to those of the design state and turned over as the signs say fix a flat state."""
    if not np.ptp(flat[:, 2]) <= LENGTH_TOLERANCE:
        return [f"the {title} frame is not flat"]
    first, second = _pairs(mesh)
    wanted = np.linalg.norm(points[first] - points[second], axis=1)
    difference = np.abs(np.linalg.norm(flat[first] - flat[second], axis=1) - wanted)
    if not (difference <= LENGTH_TOLERANCE).all():
        k = int(np.where(np.isnan(difference), np.inf, difference).argmax())
        return [
            f"the {title} frame changes the distance of vertices {first[k]} and {second[k]} of a facet"
            f" by {difference[k]:.3g} of the diagonal"
        ]
    x, y = (flat - flat[mesh.tail[0]])[:, :2].T
    swept = x[mesh.tail] * y[mesh.head] - x[mesh.head] * y[mesh.tail]
    side = np.sign(np.add.reduceat(swept, mesh.starts)) * signs
    wrong = np.flatnonzero(side != side[0])
    return [f"the {title} frame has facet {wrong[0]} wrong side up"] if len(wrong) else []


def _flat_angle_faults(
    structure: Structure, mesh: Mesh, frame: FoldFrame, angles: object, title: str, folded: int
) -> list[str]:
    rows = [[x] for x in angles] if isinstance(angles, list) else None
    given = _numbers(rows, len(frame.edges_vertices))
    if given is None:
        return [f"the {title} frame needs a fold angle for each edge"]
    for e, k in enumerate(structure.file_edge.tolist()):
        full = {"V": 180.0, "M": -180.0, "B": 0.0}[frame.edges_assignment[k]] if k >= 0 else 0.0
        wanted = full if structure.types[e] == folded else 0.0
        if k >= 0 and abs(given[k, 0] - wanted) > ANGLE_TOLERANCE:
            return [f"the {title} frame folds {mesh.name(e)} by {given[k, 0]:.9g} degrees: it must be {wanted:g}"]
    return []


def _numbers(rows: object, count: int) -> FloatArray | None:
    """Rows of 1 to 3 finite numbers as (count, 3), filled up with zeros; None if they are something else."""
    if not isinstance(rows, list) or len(rows) != count:
        return None
    if not all(isinstance(row, list) and len(row) == len(rows[0]) and 1 <= len(row) <= 3 for row in rows):
        return None
    if not all(isinstance(x, int | float) and not isinstance(x, bool) for row in rows for x in row):
        return None
    try:
        given = np.array(rows, np.float64)
    except OverflowError:
        return None
    if not np.isfinite(given).all():
        return None
    return np.hstack([given, np.zeros((count, 3 - given.shape[1]))])


def _pairs(mesh: Mesh) -> tuple[IntArray, IntArray]:
    """All pairs of vertices of a facet: their distances fix its shape."""
    pairs = {(a, b) if a < b else (b, a) for facet in mesh.facets for a in facet for b in facet if a != b}
    first, second = np.array(sorted(pairs), np.int64).T
    return first, second


def _hole_faults(mesh: Mesh, claim: object) -> list[str]:
    """A strip per hole: closed, of facets with common edges, and together once around every hole."""
    if mesh.n_holes is None:
        return []
    if not isinstance(claim, list) or len(claim) != mesh.n_holes:
        count = len(claim) if isinstance(claim, list) else "no list of"
        return [f"bdffpq:holes has {count} strips, but the surface has {mesh.n_holes} holes"]
    if not claim:
        return []
    crossed = {}
    for e, (a, b) in zip(mesh.inner.tolist(), mesh.sides[mesh.inner].tolist(), strict=True):
        crossed[a, b], crossed[b, a] = (e, 1), (e, -1)
    windings = cut_open(mesh).windings
    rows = []
    for hole, strip in enumerate(claim):
        if not isinstance(strip, list) or not strip or not all(type(f) is int for f in strip):
            return [f"bdffpq:holes[{hole}] is no list of facets"]
        steps = [crossed.get(pair) for pair in zip(strip, strip[1:] + strip[:1], strict=True)]
        if None in steps:
            broken = strip[steps.index(None)]
            return [f"bdffpq:holes[{hole}] is no closed strip: facet {broken} shares no edge with the next one"]
        rows.append(sum(sign * windings[e] for e, sign in (step for step in steps if step is not None)))
    determinant = np.linalg.det(np.array(rows, np.float64))
    if not abs(abs(determinant) - 1) < 0.5:
        return ["the strips of bdffpq:holes do not go once around every hole"]
    return []


def _grid_faults(mesh: Mesh, claim: object) -> list[str]:
    """Facets numbered i n + j with vertices i (n + 1) + j; a cylinder closes in i."""
    if not isinstance(claim, list) or len(claim) != 2 or not all(type(x) is int and x > 0 for x in claim):
        return [f"bdffpq:grid is {_short(claim)}: two numbers of facets are needed"]
    m, n = claim
    if m * n != len(mesh.facets):
        return [f"bdffpq:grid is {m} x {n}, but there are {len(mesh.facets)} facets"]
    around = m if mesh.n_holes == 1 else m + 1
    for f, facet in enumerate(mesh.facets):
        i, j = divmod(f, n)
        here, there = i * (n + 1) + j, (i + 1) % around * (n + 1) + j
        if set(facet) != {here, here + 1, there, there + 1}:
            return [f"facet {f} is not facet ({i}, {j}) of the {m} x {n} grid that bdffpq:grid claims"]
    return []


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 40 else text[:37] + "..."
