"""Closest points of target meshes against brute force, and target files of every format."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import pyvista
import trimesh
from designs import assert_close, rotation

from inverse.errors import InputError
from inverse.surfaces.mesh import MeshTarget, read_mesh

SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]


def bumpy(n: int = 6) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and quads of a wavy square."""
    x, y = (k.ravel() / n for k in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
    i, j = (k.ravel() for k in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    first = i * (n + 1) + j
    quads = np.stack([first, first + n + 1, first + n + 2, first + 1], axis=1)
    return np.c_[x, y, 0.2 * np.sin(5 * x) * np.cos(4 * y)], quads


def halves(quads: np.ndarray) -> np.ndarray:
    return np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])


def brute_force(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distances (N,) from all triangles: planes where the foot is inside, else their sides; and the feet."""
    best, feet = np.full(len(points), np.inf), np.empty_like(points)

    def offer(found: np.ndarray, valid: np.ndarray) -> None:
        distance = np.where(valid, np.linalg.norm(points - found, axis=1), np.inf)
        better = distance < best
        best[better], feet[better] = distance[better], found[better]

    for a, b, c in vertices[triangles]:
        normal = np.cross(b - a, c - a)
        u, v = np.linalg.lstsq(np.c_[b - a, c - a], (points - a).T, rcond=None)[0]
        offer(a + u[:, None] * (b - a) + v[:, None] * (c - a), (u >= 0) & (v >= 0) & (u + v <= 1))
        assert normal.any()
        for p, q in ((a, b), (b, c), (c, a)):
            w = np.clip((points - p) @ (q - p) / ((q - p) @ (q - p)), 0, 1)
            offer(p + w[:, None] * (q - p), np.full(len(points), True))
    return best, feet


def test_closest_points_by_brute_force() -> None:
    vertices, quads = bumpy()
    triangles = halves(quads)
    vertices = vertices @ rotation(4) + [3.0, 1, -2]
    points = vertices.mean(axis=0) + np.random.default_rng(0).uniform(-1, 1, (400, 3))
    distances, feet = brute_force(points, vertices, triangles)
    target = MeshTarget(vertices, triangles)
    assert_close(target.distances(points), distances, 1e-13)
    assert_close(target.closest(points).feet, feet, 1e-7)


def test_weights_inside_on_the_border_and_at_corners() -> None:
    turn = rotation(5)
    target = MeshTarget(np.array(SQUARE, float) @ turn, np.array([[0, 1, 2], [0, 2, 3]]))
    points = np.array([[0.3, 0.6, 0.2], [0.5, 0.5, 1], [0.5, -1, 0.3], [1.5, 0.4, -2], [2, 2, 1], [-1, 1.1, 0.1]])
    kinds = [[0, 0, 1], [0, 0, 1], [0, 1, 1], [1, 0, 1], [1, 1, 1], [1, 1, 1]]
    closest = target.closest(points @ turn)
    assert_close(closest.feet @ turn.T, np.clip(points, [0, 0, 0], [1, 1, 0]), 1e-14)
    assert_close(turn @ closest.weights @ turn.T, np.array([np.diag(kind) for kind in kinds]), 1e-13)


def test_weights_give_distances_of_first_order() -> None:
    """Wherever the foot is not on a kink: the linear distance has an error of second order."""
    vertices, quads = bumpy(3)
    target = MeshTarget(vertices, halves(quads))
    rng = np.random.default_rng(1)
    points = rng.uniform([-0.5, -0.5, -0.5], [1.5, 1.5, 0.7], (600, 3))
    closest = target.closest(points)
    away = points - closest.feet
    smooth = (
        np.abs(np.linalg.norm(np.einsum("nij,nj->ni", closest.weights, away), axis=1) - target.distances(points)) < 1e-9
    )
    assert smooth.sum() > 300
    step = rng.standard_normal((600, 3))
    errors = []
    for h in (1e-4, 5e-5):
        moved = np.einsum("nij,nj->ni", closest.weights, away + h * step)
        errors.append(np.abs(np.linalg.norm(moved, axis=1) - target.distances(points + h * step)))
    second_order = (errors[1] < 0.27 * errors[0] + 1e-13)[smooth]
    assert second_order.mean() > 0.97  # a foot may pass from one facet to the next within the step
    outside = np.trace(closest.weights, axis1=1, axis2=2)[smooth]
    assert {1, 2, 3} == set(np.round(outside))


def test_repeated_vertices_are_merged() -> None:
    """Border edges are those of the surface, not of every facet of a triangle soup."""
    vertices, quads = bumpy(3)
    soup = vertices[halves(quads)].reshape(-1, 3)
    whole, loose = MeshTarget(vertices, halves(quads)), MeshTarget(soup, np.arange(len(soup)).reshape(-1, 3))
    points = np.random.default_rng(2).uniform(-0.3, 1.3, (200, 3))
    assert len(loose.triangles()[0]) == len(vertices)
    assert_close(loose.closest(points).feet, whole.closest(points).feet, 1e-12)
    border = (np.abs(np.trace(loose.closest(points).weights, axis1=1, axis2=2) - 1) > 1e-9).mean()
    assert 0.3 < border < 0.9


def test_the_plan_is_the_smallest_rectangle() -> None:
    turn = np.radians(27.5)
    flat = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    vertices, quads = bumpy()
    frame = MeshTarget((vertices * [4, 2, 0.01]) @ flat.T + [1, 2, 3], halves(quads)).frame
    assert_close(frame.axes @ frame.axes.T, np.eye(3), 1e-12)
    assert np.linalg.det(frame.axes) == pytest.approx(1)
    assert sorted(frame.extent) == pytest.approx([2, 4], rel=1e-3)
    assert frame.axes[2, 2] > 0.999
    assert_close(frame.origin[:2], flat[:2, :2] @ [2, 1] + [1, 2], 1e-2)
    along = frame.axes[int(np.argmax(frame.extent))]
    assert abs(along @ flat[:, 0]) == pytest.approx(1, abs=1e-4)


# ---- files


@pytest.mark.parametrize("ending", ["obj", "ply", "stl", "glb", "off", "STL"])
def test_triangles_from_files(ending: str, tmp_path: Path) -> None:
    vertices, quads = bumpy()
    path = tmp_path / f"target.{ending}"
    trimesh.Trimesh(vertices, halves(quads), process=False).export(path, file_type=ending.lower())
    target = read_mesh(path)
    points = np.random.default_rng(3).uniform(-0.5, 1.5, (100, 3))
    exact = MeshTarget(vertices, halves(quads)).distances(points)
    assert_close(target.distances(points), exact, 1e-6)  # several formats hold single precision
    assert len(target.triangles()[1]) == 72
    assert target.samples()[1].sum() == pytest.approx(MeshTarget(vertices, halves(quads)).samples()[1].sum(), rel=1e-6)


@pytest.mark.parametrize("binary", [True, False])
@pytest.mark.parametrize("ending", ["ply", "obj"])
def test_polygons_are_cut_around_their_centroids(ending: str, binary: bool, tmp_path: Path) -> None:
    vertices, quads = bumpy(4)
    surface = pyvista.PolyData.from_regular_faces(vertices, quads)
    surface.save(tmp_path / f"target.{ending}", **({"binary": binary} if ending == "ply" else {}))
    target = read_mesh(tmp_path / f"target.{ending}")
    assert len(target.triangles()[1]) == 4 * len(quads)
    assert_close(target.distances(vertices[quads].mean(axis=1)), 0, 1e-6)
    assert_close(target.distances(vertices), 0, 1e-6)


def test_obj_files_keep_every_digit_and_know_their_forms(tmp_path: Path) -> None:
    """Relative numbers, textures and normals, comments, other statements, polygons."""
    text = "# a target\no part\nv 0 0 0.1234567890123456 # here\nv 1 0 0\nv 1 1 0 1.0\n"
    text += "vt 0 0\nvn 0 0 1\nv 0 1 0\n"
    for faces in (
        "f 1//1 2//1 3//1\nf 1 3 4\n",
        "f -4 -3 -2\nf 1/1/1 3/1/1 4/1/1\n",
        "s off\nf 1 2 3\nf -4 -2 -1\n",
    ):
        (tmp_path / "target.obj").write_text(text + faces)
        vertices, triangles = read_mesh(tmp_path / "target.obj").triangles()
        assert len(triangles) == 2
        assert 0.1234567890123456 in vertices[:, 2]


def test_a_scene_is_one_target(tmp_path: Path) -> None:
    """Parts of a GLB stand where their nodes put them."""
    scene = trimesh.Scene()
    for k in range(2):
        move = trimesh.transformations.translation_matrix([3 * k, 0, 1])
        scene.add_geometry(trimesh.Trimesh(SQUARE, [[0, 1, 2], [0, 2, 3]]), transform=move)
    scene.export(tmp_path / "scene.glb")
    target = read_mesh(tmp_path / "scene.glb")
    assert_close(target.distances(np.array([[0.5, 0.5, 1], [3.5, 0.5, 1.5], [2, 0.5, 1]])), [0, 0.5, 1], 1e-6)


OBJ = "".join(f"v {x} {y} {z}\n" for x, y, z in SQUARE)


@pytest.mark.parametrize(
    ("name", "content", "match"),
    [
        ("a.obj", "", "file is empty"),
        ("a.obj", OBJ, "no facets"),
        ("a.obj", "# nothing\n", "no facets"),
        ("a.obj", OBJ + "f 1 2\n", r"a\.obj:5: 'f 1 2' is no facet"),
        ("a.obj", OBJ + "f 1 2 x\n", r"a\.obj:5: 'f 1 2 x' is no facet"),
        ("a.obj", OBJ + "f 0 1 2\n", r"a\.obj:5: the facet names vertex 0, but numbers start at 1"),
        ("a.obj", OBJ + "f 1 2 9\n", r"a\.obj:5: the facet names vertex 9, but the file has 4"),
        ("a.obj", OBJ + "f -1 -2 -9\n", r"a\.obj:5: the facet names vertex -9"),
        ("a.obj", "v 0 0\n" + OBJ, r"a\.obj:1: 'v 0 0' is no vertex"),
        ("a.obj", "v 0 0 nan\n" + OBJ, r"a\.obj:1: .* is no vertex"),
        ("a.obj", "v 0 0 1e999\n" + OBJ, r"a\.obj:1: .* is no vertex"),
        ("a.obj", "v 1 1 1\n" * 3 + "f 1 2 3\n", "has no size"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "has no area"),
        ("a.obj", b"\xff\xfe\x00\x00", "no facets"),
        ("a.stl", "", "file is empty"),
        ("a.stl", "solid a\nendsolid a\n", "no facets"),
        ("a.stl", b"\0" * 84, "no facets"),
        ("a.ply", "ply\nformat ascii 1.0\nend_header\n", "no facets"),
        ("a.ply", "nonsense", "no PLY file"),
        ("a.off", "OFF\n0 0 0\n", "no facets"),
        ("a.glb", "nonsense", "no binary glTF"),
        ("a.gltf", "{}", "no facets"),
        ("a.3dm", "x", r"\.3dm is no mesh format: allowed are \.obj, \.ply"),
        ("a", "x", "a file without an ending is no mesh format"),
    ],
)  # fmt: skip
def test_files_that_are_refused(name: str, content: str | bytes, match: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(InputError, match=match) as caught:
        read_mesh(path)
    assert caught.value.where is not None
    assert caught.value.where.startswith(str(path)) or path.name == "a"


def test_numbers_that_are_not_finite_in_other_formats(tmp_path: Path) -> None:
    vertices, quads = bumpy(2)
    vertices[4, 2] = np.nan
    pyvista.PolyData.from_regular_faces(vertices, quads).save(tmp_path / "a.ply")
    with pytest.raises(InputError, match=r"vertex 4 is at .*: it must be finite"):
        read_mesh(tmp_path / "a.ply")


def test_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such file"):
        read_mesh(tmp_path / "missing.obj")
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(InputError, match="this is a folder"):
        read_mesh(tmp_path / "folder.obj")
