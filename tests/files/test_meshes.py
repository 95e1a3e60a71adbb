"""Mesh files of every format: whole ones keep polygons and digits, damaged and dishonest ones bring a sentence."""

from __future__ import annotations

import base64
import json
import os
import random
import struct
import time
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista
import trimesh

from inverse.errors import InputError
from inverse.files.meshes import FORMATS, Polygons, read_mesh_file
from inverse.files.meshes.polygons import MAX_FACETS, MAX_SIDES
from inverse.surfaces.mesh import read_mesh

POINTS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0.5], [0, 1, 0]], float)
NODE: dict[str, Any] = {"mesh": 0}


def gltf(
    indices: list[int] | None = None, nodes: list[dict[str, Any]] | None = None, **accessor: Any
) -> dict[str, Any]:
    """A glTF document of two triangles, with its buffer within."""
    indices = [0, 1, 2, 0, 2, 3] if indices is None else indices
    content = POINTS.astype("<f4").tobytes() + np.array(indices, "<u2").tobytes()
    return {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": len(content), "uri": "data:;base64," + base64.b64encode(content).decode()}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": len(content) - 48},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", **accessor},
            {"bufferView": 1, "componentType": 5123, "count": len(indices), "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [NODE] if nodes is None else nodes,
        "scenes": [{"nodes": [0]}],
    }


def glb(document: dict[str, Any], binary: bytes = b"") -> bytes:
    text = json.dumps(document).encode()
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary if binary else b""
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def ply(facets: str = "4 0 1 2 3\n", count: int | None = None, form: str = "ascii", kind: str = "int") -> bytes:
    n = facets.count("\n") if count is None else count
    header = f"ply\nformat {form} 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
    header += f"element face {n}\nproperty list uchar {kind} vertex_indices\nend_header\n"
    return (header + "".join(f"{x} {y} {z}\n" for x, y, z in POINTS) + facets).encode()


def binary_ply(facets: list[list[int]], order: str = "<", count: int | None = None) -> bytes:
    form = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    header = ply("", len(facets) if count is None else count, form).split(b"end_header\n")[0] + b"end_header\n"
    body = POINTS.astype(f"{order}f8").tobytes()
    return header + body + b"".join(struct.pack(f"{order}B{len(f)}i", len(f), *f) for f in facets)


def off(facets: str, n_vertices: int = 4, n_facets: int = 1) -> bytes:
    rows = "".join(f"{x} {y} {z}\n" for x, y, z in POINTS)
    return f"OFF\n# a comment\n{n_vertices} {n_facets} 0\n{rows}{facets}\n".encode()


def stl(n: int = 2, announced: int | None = None) -> bytes:
    triangle = struct.pack("<12fH", 0, 0, 1, *POINTS[:3].ravel(), 0)
    return b"\0" * 80 + struct.pack("<I", n if announced is None else announced) + n * triangle


def written(folder: Path, name: str, content: bytes) -> Path:
    path = folder / name
    path.write_bytes(content)
    return path


def facets_of(mesh: Polygons) -> list[list[int]]:
    return [facet.tolist() for facet in np.split(mesh.corners, np.cumsum(mesh.sizes)[:-1])]


# ---- whole files


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.ply", ply("4 0 1 2 3\n3 0 1 2\n")),
        ("a.ply", ply("4 0 1 2 3\n3 0 1 2\n").replace(b"\n", b"\r\n")),
        ("a.ply", binary_ply([[0, 1, 2, 3], [0, 1, 2]])),
        ("a.ply", binary_ply([[0, 1, 2, 3], [0, 1, 2]], ">")),
        ("a.off", off("4 0 1 2 3 255 0 0\n3 0 1 2", n_facets=2)),
        ("a.obj", b"".join(b"v %f %f %f\n" % tuple(p) for p in POINTS) + b"f 1 2 3 4\nf 1 2 3\n"),
    ],
)
def test_polygons_are_kept(name: str, content: bytes, tmp_path: Path) -> None:
    mesh = read_mesh_file(written(tmp_path, name, content))
    assert facets_of(mesh) == [[0, 1, 2, 3], [0, 1, 2]]
    assert mesh.vertices.tolist() == POINTS.tolist()


def test_a_ply_file_keeps_every_digit(tmp_path: Path) -> None:
    """National coordinates in millimetres: in single precision they would be a metre off."""
    vertices = POINTS + np.array([5_412_345_678.123, 0.0, 1 / 3])
    text = ply().decode().replace("0.0 0.0 0.0\n", " ".join(map(repr, vertices[0].tolist())) + "\n")
    assert read_mesh_file(written(tmp_path, "a.ply", text.encode())).vertices[0].tolist() == vertices[0].tolist()


@pytest.mark.parametrize("ending", ["ply", "stl", "glb", "off", "obj"])
def test_the_same_triangles_as_a_library_reads(ending: str, tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(2)
    ball.export(tmp_path / f"ball.{ending}")
    mesh = read_mesh_file(tmp_path / f"ball.{ending}")
    theirs = trimesh.load(tmp_path / f"ball.{ending}", process=False, force="mesh")
    assert (mesh.sizes == 3).all()
    assert mesh.vertices[mesh.corners].tolist() == theirs.vertices[theirs.faces].reshape(-1, 3).tolist()


def test_ascii_and_binary_files_of_vtk(tmp_path: Path) -> None:
    plane = pyvista.Plane(i_resolution=3, j_resolution=2)
    for ending in ("ply", "stl"):
        for binary in (True, False):
            plane.save(tmp_path / f"a.{ending}", binary=binary)
            mesh = read_mesh_file(tmp_path / f"a.{ending}")
            assert len(mesh.sizes) == (6 if ending == "ply" else 12)
            assert np.ptp(mesh.vertices, axis=0).tolist() == [1, 1, 0]


def test_nodes_turn_scale_and_move_and_strips_and_fans_are_triangles(tmp_path: Path) -> None:
    half = float(np.sqrt(0.5))
    node = {"mesh": 0, "translation": [0, 0, 5], "rotation": [0, 0, half, half], "scale": [2, 1, 1]}
    nodes = [{"children": [1], "matrix": [*np.eye(4)[:3].ravel(), 1, 0, 0, 1]}, node]
    mesh = read_mesh_file(written(tmp_path, "a.gltf", json.dumps(gltf(nodes=nodes)).encode()))
    x, y, z = POINTS.T
    np.testing.assert_allclose(mesh.vertices, np.stack([1 - y, 2 * x, z + 5], axis=1), atol=1e-14)
    for mode, faces in ((5, [[0, 1, 2], [2, 1, 3]]), (6, [[0, 1, 2], [0, 2, 3]])):
        document = gltf([0, 1, 2, 3])
        document["meshes"][0]["primitives"][0]["mode"] = mode
        assert facets_of(read_mesh_file(written(tmp_path, "a.gltf", json.dumps(document).encode()))) == faces


# ---- damaged and dishonest ones

TREE = [{"children": [k + 1] * 2, "mesh": 0} for k in range(60)] + [NODE]  # two to the sixtieth copies
FACETS = b"element face %d\nproperty list uchar int vertex_indices\nend_header\n"
REFUSED = {
    "index too large, ascii": ("a.ply", ply("4 0 1 2 4\n"), "facet 1 names vertex 4, but the 4 vertices"),
    "index below 0, ascii": ("a.ply", ply("3 0 1 2\n4 0 1 2 -1\n"), "facet 2 names vertex -1"),
    "no whole index": ("a.ply", ply("3 0 1 1.5\n"), "names vertex 1.5: whole numbers"),
    "index too large": ("a.ply", binary_ply([[0, 1, 2], [0, 1, 10**9]]), "facet 2 names vertex 1000000000"),
    "index below 0": ("a.ply", binary_ply([[0, 1, 2, 3], [0, 1, -1]]), "facet 2 names vertex -1"),
    "cut off": ("a.ply", binary_ply([[0, 1, 2]] * 3)[:-3], "ends before all that its header announces"),
    "cut off in words": ("a.ply", ply("4 0 1 2\n"), "ends before all"),
    "count too large": ("a.ply", binary_ply([[0, 1, 2]], count=150_000), "ends before all"),
    "count absurd": ("a.ply", binary_ply([[0, 1, 2]], count=10**11), f"100000000000 facets: up to {MAX_FACETS}"),
    "sides below 0": ("a.ply", ply("-4 0 1 2\n"), "a facet has -4 sides"),
    "words": ("a.ply", ply("4 0 1 two 3\n"), "is no number"),
    "no header end": ("a.ply", ply().replace(b"end_header", b"end_heater"), "header"),
    "header line": ("a.ply", ply().replace(b"property double z", b"properly double z"), "is no line of a PLY header"),
    "no kind": ("a.ply", ply(kind="integer"), "is no line of a PLY header"),
    "no z": ("a.ply", ply().replace(b"double z", b"double w"), "no coordinates x, y and z"),
    "no rows of nothing": ("a.ply", b"ply\nformat ascii 1.0\nelement a 99999999999\nend_header\n", "no properties"),
    "infinite": ("a.ply", ply().replace(b"1.0 1.0 0.5", b"1.0 inf 0.5"), "must be finite"),
    "far": ("a.ply", ply().replace(b"1.0 1.0 0.5", b"1.0 1e300 0.5"), r"up to 1e\+12 are allowed"),
    "two sides": ("a.off", off("2 0 1"), "a.off:8: a facet has 2 sides"),
    "off index": ("a.off", off("3 0 1 -1"), "names vertex -1"),
    "off huge index": ("a.off", off(f"3 0 1 {10**30}"), "is no facet"),
    "off short": ("a.off", off("3 0 1"), "is no facet"),
    "off counts": ("a.off", off("3 0 1 2", n_facets=9), "announces 4 vertices and 9 facets"),
    "off count absurd": ("a.off", off("3 0 1 2", n_facets=10**15), "facets: up to"),
    "off word": ("a.off", off("3 0 1 2").replace(b"1.0 0.0 0.0", b"1.0 zero 0.0"), "a.off:5: .* is no vertex"),
    "stl count": ("a.stl", stl(2, 3), "would have 234 bytes, but has 184"),
    "stl count absurd": ("a.stl", stl(2, 2**32 - 1), "no whole STL file"),
    "stl cut off": ("a.stl", b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n", "0 are whole"),
    "glb index": ("a.glb", glb(gltf([0, 1, 4])), "names vertex 4, but the 4 vertices"),
    "glb counts": ("a.glb", glb(gltf(count=10**9)), "need 12000000000 bytes, but 48 are there"),
    "glb zeros": ("a.glb", glb(gltf(bufferView=None, count=10**9)), "not laid out|there are|sparse"),
    "glb sparse": ("a.glb", glb(gltf(sparse={}, count=10**9)), "sparse"),
    "glb buffer": ("a.glb", glb({**gltf(), "buffers": [{"byteLength": 10**10}]}, b"0000"), "announces 10000000000"),
    "glb cut off": ("a.glb", glb(gltf())[:-5], "do not add up"),
    "glb copies": ("a.glb", glb(gltf(nodes=TREE)), "must form a tree"),
    "glb circle": ("a.glb", glb(gltf(nodes=[{"children": [0]}])), "must form a tree"),
    "glb instances": ("a.glb", glb({**gltf([0, 1, 2] * 20_000, [NODE] * 40), "scenes": [{"nodes": [*range(40)]}]}),
                      "facets: up to"),
    "glb node": ("a.glb", glb(gltf(nodes=[{"mesh": -1}])), "number -1 of meshes is not there"),
    "glb far": ("a.glb", glb(gltf(nodes=[{"mesh": 0, "scale": [1e300, 1, 1]}])), "coordinates up to"),
    "glb nan": ("a.glb", glb(gltf(nodes=[{"mesh": 0, "scale": [1e308, 1e308, 1]}] )), "coordinates up to|finite"),
    "glb packed": ("a.glb", glb({**gltf(), "extensionsRequired": ["KHR_draco_mesh_compression"]}), "KHR_draco"),
    "gltf elsewhere": ("a.gltf", json.dumps({**gltf(), "buffers": [{"byteLength": 72, "uri": "b.bin"}]}).encode(),
                       "b.bin: there is no such file"),
    "obj corners": ("a.obj", b"v 0 0 0\n" + (b"f" + b" 1" * 900 + b"\n") * 1000, "more than 800000 sides together"),
    "obj vertices": ("a.obj", b"v 0 0 0\n" * 600_002, "600001 vertices: up to 600000 are read"),
    "obj sides": ("a.obj", b"v 0 0 0\nf" + b" 1" * 9_000_000, f"has 9000000 sides: 3 to {MAX_SIDES}"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_a_sentence_at_once(case: str, tmp_path: Path) -> None:
    name, content, match = REFUSED[case]
    path = written(tmp_path, name, content)
    start = time.monotonic()
    with pytest.raises(InputError, match=match) as caught:
        read_mesh(path)
    assert time.monotonic() - start < 10
    assert str(tmp_path) in str(caught.value)


@pytest.mark.parametrize(
    "case", ["count too large", "count absurd", "glb counts", "glb zeros", "glb buffer", "glb copies"]
)
def test_no_memory_is_taken_for_what_is_only_said(case: str, tmp_path: Path) -> None:
    name, content, _ = REFUSED[case]
    path = written(tmp_path, name, content)
    tracemalloc.start()
    try:
        with pytest.raises(InputError):
            read_mesh(path)
        assert tracemalloc.get_traced_memory()[1] < 20_000_000
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("ending", FORMATS)
def test_pipes_and_devices_are_refused_at_once(ending: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / f"pipe{ending}")
    (tmp_path / f"zero{ending}").symlink_to("/dev/zero")
    for name in ("pipe", "zero"):
        with pytest.raises(InputError, match="a device, pipe or socket, not a file"):
            read_mesh(tmp_path / f"{name}{ending}")


def test_bytes_changed_anywhere(tmp_path: Path) -> None:
    """Whatever is damaged, a mesh of numbers that are there or a sentence."""
    trimesh.creation.box().export(tmp_path / "a.glb")
    bases = {
        "a.ply": [ply("4 0 1 2 3\n3 0 1 2\n"), binary_ply([[0, 1, 2, 3], [0, 1, 2]]), binary_ply([[0, 1, 2]] * 2, ">")],
        "a.off": [off("4 0 1 2 3")],
        "a.stl": [stl()],
        "a.obj": [b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"],
        "a.gltf": [json.dumps(gltf()).encode()],
        "a.glb": [glb(gltf()), (tmp_path / "a.glb").read_bytes()],
    }
    rng = random.Random(1)
    read = 0
    for name, contents in bases.items():
        for base in contents:
            for _ in range(50):
                changed = bytearray(base)
                for _ in range(rng.randint(1, 4)):
                    changed[rng.randrange(len(changed))] = rng.choice(
                        [0, 255, rng.randrange(256), *b"0123456789-e. \n"]
                    )
                if rng.random() < 0.1:
                    del changed[rng.randrange(len(changed)) :]
                path = written(tmp_path, name, bytes(changed))
                try:
                    vertices, triangles = read_mesh(path).triangles()
                except InputError as error:
                    assert str(tmp_path) in str(error)  # noqa: PT017
                else:
                    assert np.isfinite(vertices).all()
                    assert 0 <= triangles.min() <= triangles.max() < len(vertices)
                    read += 1
    assert read > 30
