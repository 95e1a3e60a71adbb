"""Documents of design files for the tests of the certificate."""

from __future__ import annotations

import copy
import json
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from inverse import certify
from inverse.certify.measures import fold_halves
from inverse.certify.mesh import build_mesh
from inverse.certify.motion import Motion
from inverse.certify.structure import examine
from inverse.files import fold_file
from inverse.files.fold_format import FoldFrame, read_frame
from inverse.origami import seeds
from inverse.origami.pattern import Design

FOUR_GON = [(1, 1, 1), (1, -1, 1), (-1, -1, 1), (-1, 1, 1)]
SIX_GON = [(1, 1, 2), (1, -1, 1), (-1, -1, 1), (1, -1, 1), (-1, -1, 1), (-1, 1, 2)]
HYBRID = ["FL", "FL", "FL", "CFL", "CFL", "FL", "FL", "FL"]

SEEDS: dict[str, Design] = {
    "miura": seeds.grid((4, 5)),
    "miura, complementary": seeds.grid((4, 5), "CFL", "CFL"),
    "eggbox": seeds.grid((4, 5), "CFL", "FL"),
    "eggbox, turned": seeds.grid((4, 5), "FL", "CFL"),
    "hybrid": seeds.grid((6, 9), "FL", HYBRID),
    "unequal": seeds.grid(
        (4, 5), "CFL", "FL", lengths_u=[1, 2, 1.5, 0.3], lengths_v=[1, 2, 0.7, 3, 1], sector_angle=1.2
    ),
    "4-gon tube": seeds.tube(FOUR_GON, 5),
    "6-gon tube": seeds.tube(SIX_GON, 4, lengths=[1, 0.5, 2, 0.7]),
    "one hinge": seeds.grid((2, 1)),
}  # fmt: skip


def document(name: str) -> dict[str, Any]:
    """A fresh document of a seed."""
    return copy.deepcopy(fold_file.document(SEEDS[name]))


def verdict(doc: dict[str, Any], folder: Path) -> certify.Certificate:
    """The certificate of a document, by way of a file."""
    path = folder / "design.fold"
    path.write_text(json.dumps(doc))
    return certify.check(path)


def frame_of(doc: dict[str, Any]) -> FoldFrame:
    """A document as it is read from a file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "design.fold"
        path.write_text(json.dumps(doc))
        return read_frame(path)


def motion_of(doc: dict[str, Any]) -> Motion:
    """The motion of a document whose facets and types are in order."""
    structure = examine(frame_of(doc))
    assert structure.mesh is not None
    assert structure.halves is not None
    return Motion(structure.mesh, structure.points, structure.types, *structure.halves)


def failures(certificate: certify.Certificate) -> set[str]:
    return {name for name, item in certificate.checks.items() if not item.passed}


def edge_index(doc: dict[str, Any], a: int, b: int) -> int:
    return next(k for k, pair in enumerate(doc["edges_vertices"]) if set(pair) == {a, b})


def without_facets(doc: dict[str, Any], removed: set[int], holes: list[list[int]]) -> dict[str, Any]:
    """A document with holes where facets that share no vertices were; ``holes``: the claim to make."""
    doc = copy.deepcopy(doc)
    rim = {frozenset((face[k - 1], face[k])) for f in removed for face in [doc["faces_vertices"][f]] for k in range(4)}
    for k, pair in enumerate(doc["edges_vertices"]):
        if frozenset(pair) in rim:
            doc["edges_assignment"][k] = doc["bdffpq:edges_type"][k] = "B"
            doc["edges_foldAngle"][k] = 0.0
            for frame in doc["file_frames"]:
                frame["edges_foldAngle"][k] = 0.0
    doc["faces_vertices"] = [face for f, face in enumerate(doc["faces_vertices"]) if f not in removed]
    doc["bdffpq:topology"] = "cylinder" if len(removed) == 1 else f"holes:{len(removed)}"
    doc["bdffpq:holes"] = holes
    del doc["bdffpq:grid"]
    return doc


def relabelled(doc: dict[str, Any], rng: np.random.Generator) -> dict[str, Any]:
    """The same design with vertices, facets and edges renumbered, facets and edges starting elsewhere."""
    doc = copy.deepcopy(doc)
    new = rng.permutation(len(doc["vertices_coords"]))
    old = np.argsort(new)
    edge_order = rng.permutation(len(doc["edges_vertices"]))
    face_order = rng.permutation(len(doc["faces_vertices"]))
    for frame in [doc, *doc["file_frames"]]:
        frame["vertices_coords"] = [frame["vertices_coords"][v] for v in old]
        frame["edges_foldAngle"] = [frame["edges_foldAngle"][e] for e in edge_order]
    doc["edges_vertices"] = [[int(new[v]) for v in doc["edges_vertices"][e]] for e in edge_order]
    for key in ("edges_assignment", "bdffpq:edges_type"):
        doc[key] = [doc[key][e] for e in edge_order]
    faces = [[int(new[v]) for v in doc["faces_vertices"][f]] for f in face_order]
    shifts = rng.integers(0, 3, len(faces))
    doc["faces_vertices"] = [face[k:] + face[:k] for face, k in zip(faces, shifts, strict=True)]
    place = np.argsort(face_order)
    doc["bdffpq:holes"] = [[int(place[f]) for f in strip] for strip in doc["bdffpq:holes"]]
    doc.pop("bdffpq:grid", None)
    return doc


def moved(doc: dict[str, Any], rotation: np.ndarray, shift: np.ndarray, scale: float) -> dict[str, Any]:
    """The same design turned, shifted and scaled."""
    doc = copy.deepcopy(doc)
    doc["vertices_coords"] = (scale * (np.array(doc["vertices_coords"]) @ rotation.T + shift)).tolist()
    for frame in doc["file_frames"]:
        frame["vertices_coords"] = (scale * np.array(frame["vertices_coords"])).tolist()
    return doc


def _conditions(design: Design, x: np.ndarray) -> np.ndarray:
    """Residuals of the vertex conditions (6), (7) as cosines and of planarity as volumes."""
    pattern, points = design.pattern, x.reshape(-1, 3)
    spokes = points[pattern.ring_vertices] - points[pattern.interior_vertices][:, None]
    spokes /= np.linalg.norm(spokes, axis=2, keepdims=True)
    cosines = np.einsum("ikd,ikd->ik", spokes, np.roll(spokes, -1, axis=1))
    opposite = np.where(pattern.is_miura_vertex, 1, -1)[:, None] * cosines[:, 2:]
    quads = points[np.array(pattern.faces_vertices)]
    volumes = np.linalg.det(quads[:, 1:] - quads[:, :1])
    return np.concatenate([(cosines[:, :2] + opposite).ravel(), volumes])


def generic(design: Design, amount: float, seed: int = 1) -> Design:
    """A design without symmetry: all conditions of a disk hold, those of loops around holes do not.

    The given one moved in a random direction, then brought back by Newton steps of least norm.
    """
    x = design.vertices_coords.ravel()
    x = x + amount * np.random.default_rng(seed).normal(size=x.size)
    step = 1e-6
    for _ in range(30):
        residual = _conditions(design, x)
        if np.abs(residual).max() < 1e-15:
            break
        columns = [
            (_conditions(design, x + step * e) - _conditions(design, x - step * e)) / (2 * step) for e in np.eye(x.size)
        ]
        x = x - np.linalg.lstsq(np.stack(columns, axis=1), residual, rcond=1e-7)[0]
    return design.moved_to(x.reshape(-1, 3))


def raw(points: np.ndarray, faces: list[list[int]], types: dict[tuple[int, ...], str]) -> dict[str, Any]:
    """A document of a small mesh without claims; ``types`` of the interior edges."""
    mesh, _ = build_mesh(faces, len(points))
    rho = np.degrees(2 * np.arctan2(*fold_halves(mesh, points)))
    kind = [types.get(tuple(sorted(e)), "B") for e in mesh.edges.tolist()]
    return {
        "vertices_coords": points.tolist(),
        "edges_vertices": mesh.edges.tolist(),
        "edges_assignment": ["B" if k == "B" else "V" if r > 0 else "M" for k, r in zip(kind, rho, strict=True)],
        "edges_foldAngle": rho.tolist(),
        "faces_vertices": [list(face) for face in faces],
        "bdffpq:edges_type": kind,
    }


def strip(rho: float, count: int) -> dict[str, Any]:
    """Unit squares in a row, the folds between them all of ``rho`` radians, typed FL."""
    return hinged([rho] * (count - 1), [1.0] * count)


def hinged(folds: Sequence[float] | np.ndarray, widths: Sequence[float]) -> dict[str, Any]:
    """Rectangles in a row, 1 high and of these widths, with these folds in radians between them, typed FL."""
    count = len(widths)
    headings = np.concatenate([[0.0], np.cumsum(folds)])
    steps = np.array(widths)[:, None] * np.stack([np.cos(headings), np.sin(headings), 0 * headings], axis=1)
    bottom = np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])
    top = count + 1
    points = np.vstack([bottom, bottom + np.array([0, 0, 1])])
    faces = [[k, k + 1, top + k + 1, top + k] for k in range(count)]
    return raw(points, faces, {(k, top + k): "FL" for k in range(1, count)})


def spherical(
    sectors: Sequence[float] | np.ndarray, kinds: Sequence[str], reach: Sequence[float] = (1, 1, 1, 1)
) -> dict[str, Any]:
    """Four quads around vertex 0 with these sector angles, the k-th between edges k and k + 1 of these types.

    The edges end at unit distance in vertices 1 to 4; ``reach`` scales the outermost vertices, 5 to 8.
    """
    a, b, c, d = sectors
    diagonal = 1.4  # between the first and the third edge: two spherical triangles

    def apex(near: float, far: float, side: int) -> list[float]:
        cosine = (np.cos(far) - np.cos(near) * np.cos(diagonal)) / (np.sin(near) * np.sin(diagonal))
        return [np.sin(near) * cosine, np.sin(near) * side * np.sqrt(1 - cosine**2), np.cos(near)]

    ends = np.array([[0, 0, 1], apex(a, b, 1), [np.sin(diagonal), 0, np.cos(diagonal)], apex(d, c, -1)])
    corners = np.array(reach)[:, None] * (ends + np.roll(ends, -1, axis=0))
    faces = [[0, 1 + k, 5 + k, 1 + (k + 1) % 4] for k in range(4)]
    return raw(np.vstack([np.zeros(3), ends, corners]), faces, {(0, 1 + k): kinds[k] for k in range(4)})


def four_facets(crossed: bool, sides: int) -> tuple[np.ndarray, list[list[int]]]:
    """Triangles or quads around a vertex whose opposite sector angles are equal; two of them may cross.

    With edges FL and CFL in turn, equations (6) and (7) and the motion hold for the parallelogram on the sphere that
    the edges' directions form, and for the one with a corner mirrored in its diagonal, which crosses itself.
    """
    diagonal, near, far = 0.9, 0.7, 1.2

    def corner(from_first: float, from_third: float, side: int) -> list[float]:
        x = (np.cos(from_third) - np.cos(from_first) * np.cos(diagonal)) / np.sin(diagonal)
        return [x, side * float(np.sqrt(np.sin(from_first) ** 2 - x**2)), np.cos(from_first)]

    third = [np.sin(diagonal), 0, np.cos(diagonal)]
    ends = np.array([[0, 0, 1], corner(near, far, 1), third, corner(far, near, 1 if crossed else -1)])
    if sides == 3:
        return np.vstack([np.zeros(3), ends]), [[0, 1 + k, 1 + (k + 1) % 4] for k in range(4)]
    faces = [[0, 1 + k, 5 + k, 1 + (k + 1) % 4] for k in range(4)]
    return np.vstack([np.zeros(3), ends, ends + np.roll(ends, -1, axis=0)]), faces


def opened_tube(section, n_rows, amount):
    """A tube that closes in the design state and satisfies every condition but that of its loop."""
    return generic(seeds.tube(section, n_rows), amount)
