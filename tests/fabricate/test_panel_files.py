"""Files of panels and surfaces for other programs, read back by programs of others."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from itertools import combinations
from pathlib import Path
from typing import Any

import designs
import ezdxf
import numpy as np
import pytest
import pyvista
import rhino3dm
import shapely
import trimesh

from inverse.errors import InputError
from inverse.fabricate import extras, meshes
from inverse.fabricate.panels.cutting import dxf
from inverse.fabricate.panels.panels import panels
from inverse.fabricate.panels.thickness import Thickness
from inverse.fabricate.picture import panels_scene
from inverse.fabricate.rhino import threedm
from inverse.origami import folding, geometry
from inverse.origami.pattern import Design

T = np.radians(120)
THICK = Thickness(0.02)
WITH_SHEET = Thickness(0.02, hinge=0.003)
CASES: dict[str, Callable[[], Design]] = {
    "two squares": lambda: designs.miura(1, 2),
    "miura": designs.miura,
    "eggbox": designs.eggbox,
    "tube": designs.tube,
    "polygonal": designs.polygonal,
}
FORMATS = (meshes.obj, meshes.ply, meshes.stl, meshes.glb, meshes.threemf, threedm)


def test_the_example_of_the_documentation_runs():
    text = (Path(__file__).parents[2] / "docs" / "panels.md").read_text(encoding="utf-8")
    exec(text.split("```python\n")[1].split("```")[0], {})


def content(files: dict[str, bytes], name: str) -> bytes:
    assert list(files) == [name]
    return files[name]


def surface_at(design: Design, t: float) -> np.ndarray:
    return folding.fold(design, np.array([t])).vertices_coords[0]


@pytest.mark.parametrize("write", [one for one in FORMATS if one is not threedm])  # it names objects at random
def test_the_same_design_gives_the_same_file(write: Callable[..., dict[str, bytes]]):
    first, second = (write(designs.miura(), t=T, thickness=WITH_SHEET) for _ in range(2))
    assert first == second


@pytest.mark.parametrize("thickness", [THICK, WITH_SHEET])
@pytest.mark.parametrize("name", CASES)
def test_stl_of_panels_is_watertight_and_holds_their_volume(name: str, thickness: Thickness):
    design = CASES[name]()
    data = content(meshes.stl(design, t=T, thickness=thickness), "panels.stl")
    mesh = trimesh.load(io.BytesIO(data), file_type="stl")
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    thick = panels(design, thickness)
    assert mesh.volume == pytest.approx(thick.volumes.sum(), rel=1e-5)
    bodies = trimesh.graph.connected_component_labels(mesh.face_adjacency, node_count=len(mesh.faces))
    assert bodies.max() + 1 == thick.volumes.size


def test_stl_is_watertight_at_the_limits_where_walls_lie_on_each_other():
    design = designs.eggbox()
    reach = panels(design, THICK).range
    for t in (reach.low, reach.high):
        data = content(meshes.stl(design, t=t, thickness=THICK), "panels.stl")
        assert trimesh.load(io.BytesIO(data), file_type="stl").is_watertight


@pytest.mark.parametrize(("unit", "factor"), [("m", 1000.0), ("mm", 1.0), ("in", 25.4), ("unit", 1.0)])
def test_3mf_names_watertight_bodies_in_millimetres(unit: str, factor: float):
    base = designs.tube()
    design = Design(base.pattern, base.vertices_coords, unit)
    thick = panels(design, WITH_SHEET)
    scene = trimesh.load(
        io.BytesIO(content(meshes.threemf(design, t=T, thickness=WITH_SHEET), "panels.3mf")), file_type="3mf"
    )
    assert scene.units == "millimeter"
    expected = {f"{name} {layer}": v for name, row in zip(thick.names, thick.volumes, strict=True)
                for layer, v in zip(("upper", "lower", "hinge"), row.tolist(), strict=True)}  # fmt: skip
    assert set(scene.geometry) == set(expected)
    for name, mesh in scene.geometry.items():
        assert mesh.is_watertight
        assert mesh.volume == pytest.approx(factor**3 * expected[name], rel=1e-9)


@pytest.mark.node
@pytest.mark.parametrize("thickness", [None, THICK, WITH_SHEET])
@pytest.mark.parametrize("name", CASES)
def test_glb_is_clean(name: str, thickness: Thickness | None, gltf_issues: Callable[[bytes], list[str]]):
    (data,) = meshes.glb(CASES[name](), t=T, thickness=thickness).values()
    assert gltf_issues(data) == []
    broken = data.replace(b'"VEC3"', b'"VEC2"')
    assert gltf_issues(broken)


def test_glb_names_panels_in_metres_with_y_up():
    base = designs.miura()
    design = Design(base.pattern, base.vertices_coords, "cm")
    scene = trimesh.load(io.BytesIO(content(meshes.glb(design, t=T, thickness=THICK), "panels.glb")), file_type="glb")
    assert {"00 upper", "15 lower"} <= set(scene.graph.nodes_geometry)
    box = np.concatenate([part.reshape(-1, 3) for part in panels(design, THICK).bodies_at(np.array([T]))[0]])
    x, y, z = 0.01 * np.stack([box.min(axis=0), box.max(axis=0)], axis=1)
    designs.assert_close(scene.bounds.T, [x, z, -y[::-1]], 1e-7)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("form", [meshes.obj, meshes.ply])
def test_obj_and_ply_keep_polygons(name: str, form: Callable[..., dict[str, bytes]], tmp_path: Path):
    design = CASES[name]()
    ((file, data),) = form(design, t=T).items()
    (tmp_path / file).write_bytes(data)
    mesh = pyvista.read(tmp_path / file)
    assert [tuple(face) for face in mesh.irregular_faces] == list(design.pattern.faces_vertices)
    designs.assert_close(mesh.points, surface_at(design, T), 1e-6)
    ((file, data),) = form(design, t=T, thickness=THICK).items()
    (tmp_path / file).write_bytes(data)
    solid = pyvista.read(tmp_path / file)
    thick = panels(design, THICK)
    assert solid.n_points == sum(2 * len(outline) for pair in thick.outlines for outline in pair)
    assert solid.triangulate().volume == pytest.approx(thick.volumes.sum(), rel=1e-4)


def test_obj_and_ply_hold_every_digit():
    design = designs.tube()
    expected = surface_at(design, T)
    text = meshes.obj(design, t=T)["surface.obj"].decode().splitlines()
    assert [list(map(float, line.split()[1:])) for line in text if line.startswith("v ")] == expected.tolist()
    text = meshes.ply(design, t=T)["surface.ply"].decode().split("end_header\n")[1].splitlines()
    assert [list(map(float, line.split())) for line in text[: len(expected)]] == expected.tolist()


@pytest.mark.parametrize("name", CASES)
def test_3dm_of_panels_holds_solids_on_layers(name: str):
    design = CASES[name]()
    file = rhino3dm.File3dm.FromByteArray(content(threedm(design, t=T, thickness=WITH_SHEET), "panels.3dm"))
    thick = panels(design, WITH_SHEET)
    assert file.Settings.ModelUnitSystem == rhino3dm.UnitSystem.Meters
    assert [layer.Name for layer in file.Layers] == ["upper", "lower", "hinge"]
    bodies = thick.bodies_at(np.array([T]))[0]
    assert len(file.Objects) == bodies.shape[0] * bodies.shape[1]
    for k, item in enumerate(file.Objects):
        facet, layer = divmod(k, 3)
        assert item.Attributes.Name == f"{thick.names[facet]} {file.Layers[item.Attributes.LayerIndex].Name}"
        assert item.Geometry.IsSolid
        found = np.array([[v.Location.X, v.Location.Y, v.Location.Z] for v in item.Geometry.Vertices])
        corners = bodies[facet, layer].reshape(-1, 3)
        apart = np.linalg.norm(found[:, None] - corners, axis=2)
        assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < 1e-9


def test_3dm_of_a_surface_keeps_quads_and_has_a_layer_for_every_kind_of_fold():
    design = designs.eggbox()
    file = rhino3dm.File3dm.FromByteArray(content(threedm(design, t=T), "surface.3dm"))
    lines: dict[str, int] = {}
    for item in file.Objects:
        layer = file.Layers[item.Attributes.LayerIndex].Name
        if layer == "facets":
            assert item.Geometry.Faces.Count == len(design.pattern.faces_vertices)
            assert item.Geometry.Faces.QuadCount == len(design.pattern.faces_vertices)
        else:
            lines[layer] = lines.get(layer, 0) + 1
    angles = geometry.fold_angles(design.pattern, design.vertices_coords)
    kinds = {"border": (0, 0), "valley": (1, 1), "mountain": (1, -1)}
    kinds |= {"complementary valley": (2, 1), "complementary mountain": (2, -1)}
    expected = {
        name: int(((design.pattern.edges_type == kind) & (np.sign(angles) == sign)).sum())
        for name, (kind, sign) in kinds.items()
    }
    assert lines == {name: count for name, count in expected.items() if count}


@pytest.mark.parametrize("name", CASES)
def test_sheets_hold_every_layer_once_apart_and_as_large_as_it_is(name: str):
    design = CASES[name]()
    thick, sheet = panels(design, THICK), (4.0, 2.0)
    files = dxf(design, thickness=THICK, sheet=sheet, density=500.0)
    rows = list(csv.DictReader(io.StringIO(files.pop("cut_list.csv").decode())))
    assert [row["name"] for row in rows] == [f"{n} {layer}" for n in thick.names for layer in ("upper", "lower")]
    areas = dict(zip((row["name"] for row in rows), thick.areas.ravel().tolist(), strict=True))
    found = {}
    for file, data in files.items():
        document = ezdxf.read(io.StringIO(data.decode()))
        assert document.units == 6
        audit = document.audit()
        assert not audit.errors
        assert not audit.fixes
        space = document.modelspace()
        outlines = [shapely.Polygon(line.get_points("xy")) for line in space.query('LWPOLYLINE[layer=="cut"]')]
        texts = space.query('TEXT[layer=="engrave"]')
        assert len(texts) == len(outlines)
        for text, outline in zip(texts, outlines, strict=True):
            assert outline.contains(shapely.Point(*text.get_placement()[1].vec2))
            assert outline.area == pytest.approx(areas[text.dxf.text], rel=1e-9)
            assert outline.exterior.is_ccw
            assert shapely.box(0, 0, *sheet).buffer(-0.99 * THICK.thickness).contains(outline)
            found[text.dxf.text] = file, outline
        for one, other in combinations(outlines, 2):
            assert one.distance(other) > 0.5 * THICK.thickness
    assert set(found) == set(areas)
    for row in rows:
        outline = shapely.Polygon([[float(x) for x in pair.split()] for pair in row["outline [m]"].split(";")])
        area = float(row["area [m^2]"])
        assert outline.area == pytest.approx(area, rel=1e-6)
        assert area == pytest.approx(areas[row["name"]], rel=1e-8)
        assert float(row["mass [kg]"]) == pytest.approx(500 * area * THICK.thickness, rel=1e-5)
        assert row["sheet"] == found[row["name"]][0]
        assert outline.length == pytest.approx(found[row["name"]][1].length, rel=1e-6)


def test_lower_layers_are_drawn_from_below():
    # Seen from outside when built, a lower layer is the mirror image of what is seen from the top side.
    design = designs.miura()
    files = dxf(design, thickness=THICK, sheet=(4.0, 2.0))
    rows = {row["name"]: row for row in csv.DictReader(io.StringIO(files["cut_list.csv"].decode()))}
    thick = panels(design, THICK)
    for name, own in zip(thick.names, thick.outlines, strict=True):
        for layer, mirror, outline in (("upper", 1.0, own[0]), ("lower", -1.0, own[1])):
            told = np.array(
                [[float(x) for x in pair.split()] for pair in rows[f"{name} {layer}"]["outline [m]"].split(";")]
            )
            drawn, expected = shapely.Polygon(told), shapely.Polygon(outline * [mirror, 1.0])
            assert drawn.symmetric_difference(expected).area < 1e-8
        assert rows[f"{name} upper"]["mass [kg]"] == ""


@pytest.mark.parametrize(("options", "words"), [
    ({"sheet": (1.0, 0.5)}, r"panel \d\d (upper|lower) does not fit on a sheet of 1 x 0.5 m.*: it measures [\d.]+ x "),
    ({"sheet": (0.0, 1.0)}, "the sheet is 0 x 1: both must be greater than 0"),
    ({"sheet": (2.0, float("nan"))}, "both must be greater than 0"),
    ({"sheet": (4.0, 2.0), "density": 0.0}, "the density is 0: it must be greater than 0"),
])  # fmt: skip
def test_sheets_and_densities_that_cannot_be_are_refused(options: dict[str, Any], words: str):
    with pytest.raises(InputError, match=words):
        dxf(designs.miura(), thickness=THICK, **options)


def test_a_sheet_as_large_as_it_must_be_works_and_turned_too():
    design = strip_of_one(3.0, 1.0)
    for sheet in ((3.04, 1.04), (1.04, 3.04)):
        assert len(dxf(design, thickness=THICK, sheet=sheet)) == 3  # upper and lower, each on a sheet, and the list
    for sheet in ((3.03, 1.04), (1.03, 3.04)):
        with pytest.raises(InputError, match="panel 0 upper does not fit"):
            dxf(design, thickness=THICK, sheet=sheet)


def strip_of_one(width: float, height: float) -> Design:
    points = np.array([[0, 0, 0], [width, 0, 0], [width, height, 0], [0, height, 0]], float)
    parent = designs.miura(1, 1)
    face = [parent.pattern.faces_vertices[0]]
    return designs.network(Design(parent.pattern, points[np.argsort(face[0])]), face)


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("degrees", [2.0, 178.0])
def test_states_that_delta_does_not_leave_are_refused(form: Callable[..., dict[str, bytes]], degrees: float):
    with pytest.raises(InputError, match=f"do not fold to t = {degrees:g} degrees: delta leaves 8.4577 to 174.07"):
        form(designs.eggbox(), t=np.radians(degrees), thickness=THICK)
    assert form(designs.eggbox(), t=np.radians(degrees))


def test_a_missing_library_names_the_extra(monkeypatch: pytest.MonkeyPatch):
    def missing(name: str) -> None:
        raise ImportError(f"No module named {name!r}")

    monkeypatch.setattr(extras.importlib, "import_module", missing)
    for run in (
        lambda: threedm(designs.miura()),
        lambda: meshes.threemf(designs.miura()),
        lambda: dxf(designs.miura(), thickness=THICK, sheet=(4.0, 2.0)),
    ):
        with pytest.raises(InputError, match=r'pip install "inverse\[fabricate\]"'):
            run()


@pytest.mark.parametrize("name", ["miura", "tube"])
def test_every_state_stands_in_its_place_of_the_picture(name: str):
    scene = panels_scene(panels(CASES[name](), THICK), 3, 2)
    bodies = scene.facets[1::2]
    assert len(bodies) == len(scene.captions) == 6
    position, focus = np.array(scene.camera.position), np.array(scene.camera.focus)
    towards = (position - focus) / np.linalg.norm(position - focus)
    right = np.cross([0, 0, 1], towards) / np.linalg.norm(np.cross([0, 0, 1], towards))
    axes = np.stack([right, np.cross(towards, right)])
    boxes = []
    for body, caption in zip(bodies, scene.captions, strict=True):
        pixels = (body.points - focus) @ axes.T / scene.camera.pixel + np.array(scene.size) / 2
        boxes.append((pixels.min(axis=0), pixels.max(axis=0)))
        assert (pixels > 0).all()
        assert (pixels < scene.size).all()
        assert caption.y > 0
        assert caption.y + caption.size < pixels[:, 1].min()
        assert pixels[:, 0].min() < caption.x < pixels[:, 0].max()
        assert body.points[:, 2].min() == pytest.approx(0, abs=1e-9)
    for one, other in combinations(boxes, 2):
        assert ((one[1] < other[0]) | (other[1] < one[0])).any()
