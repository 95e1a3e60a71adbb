"""Meshes of any state for other programs: OBJ, PLY, STL, GLB and 3MF, of the ideal surface or of thick panels."""

from __future__ import annotations

import io
import re
import uuid
import zipfile
from collections.abc import Sequence
from typing import Any

import numpy as np

from inverse._types import FloatArray
from inverse.fabricate.extras import needed
from inverse.fabricate.panels.panels import panels
from inverse.fabricate.panels.thickness import Thickness
from inverse.fabricate.parts import Part, panel_parts, surface_part
from inverse.fabricate.units import metres, millimetres
from inverse.origami.pattern import Design
from inverse.pictures import colours

DESIGN_STATE = np.pi / 2
COLOURS = {
    "facets": colours.WARM[1],
    "upper": colours.WARM[1],
    "lower": colours.COOL[1],
    "hinge": colours.SHADOW,
}
_UUID = re.compile(rb"[0-9a-f]{8}(?:-[0-9a-f]{4}){3}-[0-9a-f]{12}")
_Y_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])  # glTF has y upwards


def parts_of(design: Design, t: float, thickness: Thickness | None) -> list[Part]:
    """The ideal surface at ``t`` radians, or the panels if a thickness is given."""
    return [surface_part(design, t)] if thickness is None else panel_parts(panels(design, thickness), t)


def obj(design: Design, *, t: float = DESIGN_STATE, thickness: Thickness | None = None) -> dict[str, bytes]:
    """Wavefront OBJ: polygons stay polygons, every part an object; in the design's unit.

    Args:
        design: the mesh.
        t: folding amount in radians.
        thickness: of the panels; None for the ideal surface.

    Returns:
        The content of one file by its name.

    Raises:
        InputError: the design cannot be made that thick, or does not fold to ``t`` then.
    """
    lines = [f"# {_one_line(design.name)}, unit: {design.unit}"]
    count = 1
    for part in parts_of(design, t, thickness):
        lines.append(f"o {_one_line(part.name).replace(' ', '_')}")
        lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in part.points.tolist()]
        lines += ["f " + " ".join(str(count + k) for k in polygon) for polygon in part.polygons]
        count += len(part.points)
    return {_name("obj", thickness): ("\n".join(lines) + "\n").encode()}


def ply(design: Design, *, t: float = DESIGN_STATE, thickness: Thickness | None = None) -> dict[str, bytes]:
    """PLY as text: polygons stay polygons, each with the number of its part; in the design's unit.

    Arguments, result and errors are those of :func:`obj`.
    """
    parts = parts_of(design, t, thickness)
    starts = np.cumsum([0, *(len(part.points) for part in parts)]).tolist()
    rows = [
        f"{len(polygon)} {' '.join(str(start + k) for k in polygon)} {number}"
        for number, (part, start) in enumerate(zip(parts, starts, strict=False))
        for polygon in part.polygons
    ]
    lines = [
        *("ply", "format ascii 1.0", f"comment {_one_line(design.name)}, unit: {design.unit}"),
        *(f"comment part {number}: {_one_line(part.name)}" for number, part in enumerate(parts)),
        *(f"element vertex {starts[-1]}", *(f"property double {axis}" for axis in "xyz")),
        *(f"element face {len(rows)}", "property list uchar int vertex_indices", "property int part", "end_header"),
        *(f"{x!r} {y!r} {z!r}" for part in parts for x, y, z in part.points.tolist()),
    ]
    return {_name("ply", thickness): ("\n".join([*lines, *rows]) + "\n").encode()}


def stl(design: Design, *, t: float = DESIGN_STATE, thickness: Thickness | None = None) -> dict[str, bytes]:
    """Binary STL in the design's unit; of panels a closed surface for every layer.

    Programs weld vertices at one place. Bodies that touch in an edge would become one body with four facets at it, so
    that each body's edges are cut in two at a place of its own: no two bodies have an edge in common.

    Arguments, result and errors are those of :func:`obj`.
    """
    import trimesh

    parts = parts_of(design, t, thickness)
    if thickness is None:
        corners = parts[0].points[parts[0].triangles]
    else:
        # All are below one half, so that no edge that is cut from its other end agrees with one of these.
        shares = np.linspace(0.25, 0.45, len(parts))
        corners = np.concatenate([_with_cut_edges(part, share) for part, share in zip(parts, shares, strict=True)])
    single = corners.astype(np.float32)
    collapsed = (single == np.roll(single, 1, axis=1)).all(axis=2).any(axis=1)
    soup = single[~collapsed].astype(np.float64)
    mesh = trimesh.Trimesh(soup.reshape(-1, 3), np.arange(3 * len(soup)).reshape(-1, 3), process=False)
    return {_name("stl", thickness): bytes(mesh.export(file_type="stl"))}


def glb(design: Design, *, t: float = DESIGN_STATE, thickness: Thickness | None = None) -> dict[str, bytes]:
    """Binary glTF in metres, y upwards; every part a node that bears its name.

    Arguments, result and errors are those of :func:`obj`.
    """
    scene = _scene(parts_of(design, t, thickness), metres(design.unit), shaded=True)
    scene.apply_transform(_Y_UP)
    return {_name("glb", thickness): bytes(scene.export(file_type="glb"))}


def threemf(design: Design, *, t: float = DESIGN_STATE, thickness: Thickness | None = None) -> dict[str, bytes]:
    """3MF in millimetres, every part an object that bears its name.

    Arguments, result and errors are those of :func:`obj`; and lxml may be missing.
    """
    needed("lxml")
    needed("networkx")
    scene = _scene(parts_of(design, t, thickness), millimetres(design.unit), shaded=False)
    return {_name("3mf", thickness): _with_fixed_ids(bytes(scene.export(file_type="3mf")))}


def _with_fixed_ids(package: bytes) -> bytes:
    """A 3MF package whose ids count up and whose entries have no date: the same design gives the same file."""
    ids: dict[bytes, bytes] = {}

    def fixed(found: re.Match[bytes]) -> bytes:
        return ids.setdefault(found[0], str(uuid.uuid5(uuid.NAMESPACE_URL, f"part {len(ids)}")).encode())

    written = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(package)) as given, zipfile.ZipFile(written, "w", zipfile.ZIP_DEFLATED) as own:
        for name in given.namelist():
            own.writestr(zipfile.ZipInfo(name), _UUID.sub(fixed, given.read(name)), zipfile.ZIP_DEFLATED)
    return written.getvalue()


def _name(ending: str, thickness: Thickness | None) -> str:
    return f"{'surface' if thickness is None else 'panels'}.{ending}"


def _one_line(name: str) -> str:
    return " ".join(name.split())


def _with_cut_edges(part: Part, share: float) -> FloatArray:
    """Triangles (T, 3, 3) around a point in every polygon, its edges cut in two at this share of their length."""
    found = []
    for polygon in part.polygons:
        corners = part.points[list(polygon)]
        ahead = np.roll(corners, -1, axis=0)
        # Both polygons at an edge must cut it at the same place: count from the smaller number.
        forward = (np.array(polygon) < np.roll(polygon, -1))[:, None]
        cut = np.where(forward, corners + share * (ahead - corners), ahead + share * (corners - ahead))
        rim = np.stack([corners, cut], axis=1).reshape(-1, 3)
        # That point is also its own: layers that lie on each other may have the same corners.
        middle = np.broadcast_to((1 - share) * corners.mean(axis=0) + share * corners[0], rim.shape)
        found.append(np.stack([middle, rim, np.roll(rim, -1, axis=0)], axis=1))
    return np.concatenate(found)


def _scene(parts: Sequence[Part], scale: float, *, shaded: bool) -> Any:
    """A trimesh scene; ``shaded`` gives every triangle corners and a normal of its own, and parts their colours."""
    import trimesh

    materials = {
        layer: trimesh.visual.material.PBRMaterial(
            name=layer,
            baseColorFactor=[*colours.rgb(colour).tolist(), 255],
            metallicFactor=0.0,
            roughnessFactor=0.9,
            doubleSided=layer == "facets",
        )
        for layer, colour in COLOURS.items()
    }
    scene = trimesh.Scene()
    for part in parts:
        points, triangles = scale * part.points, part.triangles
        if shaded:
            points, triangles = points[triangles].reshape(-1, 3), np.arange(triangles.size).reshape(-1, 3)
        mesh = trimesh.Trimesh(points, triangles, process=False)
        if shaded:
            mesh.vertex_normals = np.repeat(mesh.face_normals, 3, axis=0)
            mesh.visual = trimesh.visual.TextureVisuals(material=materials[part.layer])
        scene.add_geometry(mesh, node_name=part.name, geom_name=part.name)
    return scene
