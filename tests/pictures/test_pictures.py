from __future__ import annotations

import io
import sys
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NoReturn

import designs
import numpy as np
import pytest
from scipy.spatial import cKDTree

from inverse import pictures
from inverse.origami import folding, geometry
from inverse.origami.pattern import CFL, Design
from inverse.pictures import rendering
from inverse.pictures.colours import EDGE_COLOURS, edge_kinds, rgb
from inverse.pictures.design_state import design_scene
from inverse.pictures.sheets import lay_out, stacked
from inverse.pictures.states import states_scene

SVG = "{http://www.w3.org/2000/svg}"
FOLD_COLOURS = {
    "mountain": ("red", lambda r, g, b: r > 180 and g < 80 and b < 80),
    "valley": ("dark blue", lambda r, g, b: b > 100 and r < 80 and g < 80),
    "complementary mountain": ("pink", lambda r, g, b: r > 220 and 100 < g < b),
    "complementary valley": ("light blue", lambda r, g, b: b > 200 and r < g < b and g > 150),
    "border": ("black", lambda r, g, b: r == g == b == 0),
}
ALL = [
    *designs.ALL.values(),
    lambda: designs.miura(1, 1),
    lambda: designs.eggbox(16, 16),
    lambda: designs.seeds.grid((4, 5), "CFL", "CFL"),
]


def drawn(design: Design, tmp_path: Path) -> ET.Element:
    path = tmp_path / "pattern.svg"
    pictures.crease_pattern_picture(design, path)
    return ET.parse(path).getroot()


def group(svg: ET.Element, name: str) -> ET.Element:
    found = [g for g in svg.iter(f"{SVG}g") if g.get("id") == name.replace(" ", "-")]
    assert len(found) == 1
    return found[0]


def segments(svg: ET.Element, name: str) -> np.ndarray:
    lines = [[float(line.get(k)) for k in ("x1", "y1", "x2", "y2")] for line in group(svg, name)]
    return np.array(lines).reshape(-1, 2, 2)


def length(lines: np.ndarray) -> float:
    return float(np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum())


@pytest.mark.parametrize("make", ALL)
def test_every_kind_of_edge_is_drawn_true_to_scale(make: Callable[[], Design], tmp_path: Path):
    design = make()
    svg = drawn(design, tmp_path)
    kinds = edge_kinds(design.pattern, geometry.fold_angles(design.pattern, design.vertices_coords))
    lengths = geometry.edge_lengths(design.pattern, design.vertices_coords)
    for kind, name in enumerate(EDGE_COLOURS):
        sides = 2 if name.startswith("complementary") else 1  # a seam is drawn on both of its sheets
        expected = sides * lengths[kinds == kind].sum()
        assert length(segments(svg, name)) == pytest.approx(expected, rel=1e-5), name


def test_miura_has_no_complementary_lines_and_mountains_are_negative(tmp_path: Path):
    design = designs.miura()
    svg = drawn(design, tmp_path)
    angles = geometry.fold_angles(design.pattern, design.vertices_coords)
    assert len(segments(svg, "mountain")) == (angles < 0).sum()
    assert len(segments(svg, "valley")) == (angles > 0).sum()
    assert not len(segments(svg, "complementary mountain"))
    assert not len(segments(svg, "complementary valley"))


@pytest.mark.parametrize("name", EDGE_COLOURS)
def test_lines_have_the_papers_colours_and_a_legend(name: str, tmp_path: Path):
    svg = drawn(designs.eggbox(), tmp_path)
    word, is_it = FOLD_COLOURS[name]
    assert is_it(*rgb(group(svg, name).get("stroke")).tolist()), word
    legend = group(svg, "legend")
    assert [t.text for t in legend.iter(f"{SVG}text")] == list(FOLD_COLOURS)
    samples = [line.get("stroke") for line in legend.iter(f"{SVG}line")]
    assert samples[list(FOLD_COLOURS).index(name)] == group(svg, name).get("stroke")


def test_scale_bar_is_as_long_as_it_says(tmp_path: Path):
    svg = drawn(designs.miura(16, 16), tmp_path)
    scale = float(group(svg, "crease-pattern").get("transform").split("scale(")[1].split()[0])
    bar = group(svg, "scale-bar")
    left, right = (float(x) for x in bar[0].get("d")[1:].replace("H", " ").replace("V", " ").split()[::3][:2])
    number, unit = bar.find(f"{SVG}text").text.split()
    assert unit == "m"
    assert (right - left) / scale == pytest.approx(float(number), rel=1e-3)


@pytest.mark.parametrize(("make", "count"), [
    (designs.miura, 1),
    (lambda: designs.eggbox(16, 16), 16),
    (designs.hybrid, 3),
    (designs.tube, 2),
    (lambda: designs.seeds.grid((4, 5), "CFL", "CFL"), 20),
    (designs.GENERAL["polygonal_eggbox"], 4),
])  # fmt: skip
def test_sheets_lie_apart_and_top_side_up(make: Callable[[], Design], count: int):
    design = make()
    sheets = lay_out(design)
    assert len(sheets) == count
    assert sorted(f for s in sheets for f in s.faces) == list(range(len(design.pattern.faces_vertices)))
    boxes = np.array([[s.points.min(axis=0), s.points.max(axis=0)] for s in sheets])
    for k, (low, high) in enumerate(boxes):
        others = np.delete(boxes, k, axis=0)
        assert ((others[:, 0] > high) | (others[:, 1] < low)).any(axis=1).all()
    for sheet in sheets:
        for face in sheet.faces:
            x, y = sheet.place_of(np.array(design.pattern.faces_vertices[face])).T
            assert (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() > 0


def test_strips_of_an_eggbox_lie_in_a_row_next_to_their_neighbours():
    strips = lay_out(designs.eggbox(6, 8))
    middles = np.array([s.points.mean(axis=0) for s in strips])
    assert (np.abs(np.diff(np.sign(np.diff(middles[:, 0])))) == 0).all()
    designs.assert_close(middles[:, 1], middles[0, 1], 0.3)


def test_equal_numbers_mark_both_sides_of_a_seam(tmp_path: Path):
    design = designs.eggbox()
    labels = [t.text for t in group(drawn(design, tmp_path), "seams").iter(f"{SVG}text")]
    seams = int((design.pattern.edges_type == CFL).sum())
    assert sorted(labels) == sorted([str(k + 1) for k in range(seams)] * 2)


def test_same_design_gives_the_same_bytes(tmp_path: Path):
    for name in ("a.svg", "b.svg"):
        pictures.crease_pattern_picture(designs.hybrid(), tmp_path / name)
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


@pytest.mark.parametrize("make", [designs.tube, designs.hybrid, designs.miura, lambda: designs.tube(8, 5)])
def test_layers_lie_where_they_are_in_the_developed_state(make: Callable[[], Design]):
    """All together they are the developed state, turned and moved, and every facet is there once."""
    design = make()
    flat, sheets = folding.flat_state(design, 0.0), stacked(design)
    assert sorted(f for s in sheets for f in s.faces) == list(range(len(design.pattern.faces_vertices)))
    vertices = np.concatenate([s.vertices for s in sheets])
    points = np.concatenate([s.points for s in sheets])
    designs.assert_close(designs.best_motion(points, flat[vertices, :2]), flat[vertices, :2], 1e-9)
    assert np.ptp(points[:, 0]) >= np.ptp(points[:, 1])


@pytest.mark.parametrize("k", [4, 6, 8])
def test_the_uppermost_layer_is_drawn_last(k: int, tmp_path: Path):
    """Where two layers have vertices near each other, the later one lies higher shortly before the state is flat."""
    design = designs.tube(k, 5)
    pictures.layers_picture(design, tmp_path / "layers.svg")
    svg = ET.parse(tmp_path / "layers.svg").getroot()
    near, sheets = folding.flat_state(design, 0.02), stacked(design)
    compared = 0
    for n, upper in enumerate(sheets):
        kinds = [g for g in group(svg, f"layer-{n + 1}") if not g.get("id", "").endswith("sheets")]
        assert sum(len(g) for g in kinds) == len(upper.edges)
        for lower in sheets[:n]:
            tree = cKDTree(near[lower.vertices, :2])
            gaps, beside = tree.query(near[upper.vertices, :2])
            pairs = gaps < 0.3
            rise = near[upper.vertices, 2][pairs] - near[lower.vertices[beside], 2][pairs]
            compared += int(pairs.sum())
            assert rise.sum() >= -1e-9
    assert compared > 0


def seen(scene, points: np.ndarray) -> np.ndarray:
    """Pixels (N, 2) of points, from the middle of the picture."""
    position, focus = np.array(scene.camera.position), np.array(scene.camera.focus)
    towards = (position - focus) / np.linalg.norm(position - focus)
    right = np.cross([0, 0, 1], towards)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(towards, right)])
    distance = (position - points) @ towards
    shrink = 1 if scene.camera.parallel_scale else np.linalg.norm(position - focus) / distance[:, None]
    return (points - focus) @ axes.T * shrink / scene.camera.pixel


@pytest.mark.parametrize("make", [*designs.ALL.values(), lambda: designs.tube(4, 30), lambda: designs.miura(1, 1)])
def test_design_and_states_fill_their_pictures_without_leaving_them(make: Callable[[], Design]):
    design = make()
    for scene in (design_scene(design, None, None), states_scene(design)):
        points = np.concatenate([facets.points for facets in scene.facets if len(facets.colours)])
        pixels = seen(scene, points if not scene.captions else np.concatenate([f.points for f in scene.facets[1::2]]))
        share = np.abs(pixels).max(axis=0) / (np.array(scene.size) / 2)
        assert share.max() < 1
        assert share.max() > 0.5
        assert not any(n % 16 for n in scene.size)


@pytest.mark.parametrize("make", designs.ALL.values())
def test_flat_states_are_thin_and_keep_their_lengths(make: Callable[[], Design]):
    design = make()
    scene = states_scene(design)
    assert [caption.text for caption in scene.captions] == [
        "developed (t = 0°)", "design (t = 90°)", "flat-folded (t = 180°)"
    ]  # fmt: skip
    expected = geometry.edge_lengths(design.pattern, design.vertices_coords)
    for facets in scene.facets[1::4]:
        assert np.ptp(facets.points[:, 2]) <= 0.03 * geometry.diagonal(facets.points)
        level = np.c_[facets.points[:, :2], np.zeros(len(facets.points))]
        designs.assert_close(geometry.edge_lengths(design.pattern, level), expected, 1e-9)
    captions = np.array([[c.x, 0.28 * c.size * len(c.text)] for c in scene.captions])
    assert (captions[1:, 0] - captions[1:, 1] > captions[:-1, 0] + captions[:-1, 1]).all()


def wall(x: float, height: float) -> tuple[np.ndarray, np.ndarray]:
    points = np.array(
        [[x, -9, -6], [x, 9, -6], [x, 9, height], [x, -9, height], [x + 3, -9, height], [x + 3, 9, height]]
    )
    return points.astype(float), np.array([[0, 1, 2], [0, 2, 3], [3, 2, 5], [3, 5, 4]])


@pytest.mark.parametrize("side", [-6.0, 10.0])
def test_buildings_do_not_hide_the_design(side: float):
    design = designs.miura(6, 6)
    scene = design_scene(design, None, wall(side, 12.0))
    eye = np.array(scene.camera.position)
    middle = design.vertices_coords.mean(axis=0)
    at = (side - middle[0]) / (eye[0] - middle[0])  # where the line of sight meets the wall's plane
    assert not 0 < at < 1 or abs((middle + at * (eye - middle))[1]) > 9 or (middle + at * (eye - middle))[2] > 12


@pytest.fixture
def gl(lacking: Callable[[str], NoReturn]) -> None:
    reason = pictures.can_render()
    if reason is not None:
        lacking(reason)


@pytest.mark.usefixtures("gl")
def test_rendered_pictures_show_something(tmp_path: Path):
    from PIL import Image

    design = designs.miura(6, 6)
    box = design.vertices_coords[:4] + np.array([0, 0, 4])
    closed = (box, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]))  # without a rim
    pictures.design_picture(design, tmp_path / "d.png", target=closed, context=wall(-6.0, 3.0))
    pictures.states_picture(design, tmp_path / "s.png")
    for name in ("d.png", "s.png"):
        with Image.open(io.BytesIO((tmp_path / name).read_bytes())) as picture:
            pixels = np.asarray(picture.convert("RGB"), float)
        height, width, _ = pixels.shape
        assert width >= 1600
        assert not width % 16
        assert not height % 16
        coloured = (pixels < 250).any(axis=2).mean()
        assert 0.05 < coloured < 0.98, name
        assert pixels.std() > 15, name
        assert len(np.unique(pixels[::4, ::4] @ [65536, 256, 1])) > 20, name


@pytest.mark.usefixtures("gl")
def test_a_target_is_translucent(tmp_path: Path):
    from PIL import Image

    from inverse.pictures.camera import Camera
    from inverse.pictures.scene import Facets, Scene

    square = np.array([[-1.0, 0, -1], [1, 0, -1], [1, 0, 1], [-1, 0, 1]])
    cells = np.array([4, 0, 1, 2, 3])
    facets = [Facets(square + np.array([0, k, 0]), cells, np.array([c], np.uint8), o) for k, c, o in
              ((0, (200, 0, 0), 1.0), (-1, (0, 0, 200), 0.3))]  # fmt: skip
    rendering.render(Scene((64, 64), Camera((0, -9, 0), (0, 0, 0), 0.0, 0.1), facets), tmp_path / "t.png")
    with Image.open(tmp_path / "t.png") as picture:
        assert np.abs(np.array(picture.convert("RGB").getpixel((32, 32))) - [140, 0, 60]).max() <= 2


@pytest.fixture
def asked_anew() -> Iterator[None]:
    rendering.can_render.cache_clear()
    yield
    rendering.can_render.cache_clear()


@pytest.mark.usefixtures("asked_anew")
@pytest.mark.parametrize(
    "code", ["import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", "raise ImportError('libX')"]
)
def test_without_gl_there_is_a_sentence_and_no_file(code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    worker = tmp_path / "worker.py"
    worker.write_text(code)
    monkeypatch.setattr(rendering, "_WORKER", worker)
    reason = pictures.can_render()
    assert reason is not None
    assert reason.startswith("No 3D pictures: ")
    assert reason.endswith(".")
    with pytest.raises(RuntimeError, match="No 3D pictures"):
        pictures.states_picture(designs.miura(), tmp_path / "s.png")
    assert not (tmp_path / "s.png").exists()


def test_vtk_stays_out_of_this_process():
    import subprocess

    code = (
        "import sys, inverse.pictures; sys.exit(any(m in sys.modules for m in ('vtk', 'vtkmodules', 'pyvista', 'PIL')))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
