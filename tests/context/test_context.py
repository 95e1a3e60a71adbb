import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from inverse.context import Building, Context, eaves, facing_eaves, read_city_json, triangulated
from inverse.context.triangles import triangulate
from inverse.errors import InputError

EXCERPT = Path(__file__).parents[2] / "targets" / "vienna_excerpt.city.jsonl"
ORIGIN = [1275.0, 340849.0, 30.0]
WEST = "UUID_LOD2_011530-cf0ab883-2798-437c-b530"
EAST = "UUID_LOD2_011502-469b227e-b1ee-4cea-a625"


@pytest.fixture(scope="module")
def vienna() -> Context:
    return read_city_json(EXCERPT, ORIGIN)


def distances_to_edges(points: np.ndarray, building: Building, kind: str) -> np.ndarray:
    """Distance of every point (N, 3) from the nearest edge of the building's surfaces of a kind."""
    best = np.full(len(points), np.inf)
    for surface in building.of_kind(kind):
        for ring in surface.rings:
            for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
                along = np.clip((points - a) @ (b - a) / max((b - a) @ (b - a), 1e-12), 0.0, 1.0)
                best = np.minimum(best, np.linalg.norm(points - a - along[:, None] * (b - a), axis=1))
    return best


def test_the_excerpt_is_small_and_names_its_source() -> None:
    assert EXCERPT.stat().st_size < 150_000
    header = json.loads(EXCERPT.read_text().split("\n")[0])
    assert header["version"] == "1.1"
    assert "Stadt Wien - data.wien.gv.at" in header["metadata"]["title"]


def test_buildings_come_in_metres_around_the_origin(vienna: Context) -> None:
    assert len(vienna.buildings) == 8
    assert {surface.kind for b in vienna.buildings for surface in b.surfaces} == {
        "RoofSurface",
        "WallSurface",
        "GroundSurface",
    }
    points = np.concatenate([b.points for b in vienna.buildings])
    extent = json.loads(EXCERPT.read_text().split("\n")[0])["metadata"]["geographicalExtent"]
    np.testing.assert_allclose(points.min(axis=0) + ORIGIN, extent[:3], atol=1e-9)
    np.testing.assert_allclose(points.max(axis=0) + ORIGIN, extent[3:], atol=1e-9)
    assert np.max(np.abs(points[:, :2])) < 70.0
    # The lowest ground is the neighbour's in the east, at 30.465 m in the file.
    assert vienna.ground == pytest.approx(0.465, abs=1e-9)


def test_areas_agree_with_the_attributes_of_the_file(vienna: Context) -> None:
    """The city wrote the area of every surface beside it; ours come from the triangles."""
    written: dict[str, list[float]] = {}
    for line in EXCERPT.read_text().splitlines()[1:]:
        feature = json.loads(line)
        written[feature["id"]] = [
            float(feature_surface["Flaeche"])
            for thing in feature["CityObjects"].values()
            for geometry in thing.get("geometry", [])
            if "semantics" in geometry
            for feature_surface in geometry["semantics"]["surfaces"]
        ]
    vertices, triangles, owner = triangulated(vienna)
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    for index, building in enumerate(vienna.buildings):
        assert areas[owner == index].sum() == pytest.approx(sum(written[building.name]), rel=1e-3)


def test_the_default_origin_is_the_middle_at_ground_level_in_whole_metres(vienna: Context) -> None:
    context = read_city_json(EXCERPT)
    np.testing.assert_array_equal(context.origin, np.round(context.origin))
    points = np.concatenate([b.points for b in context.buildings])
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    assert np.all(np.abs(middle[:2]) <= 0.5)
    assert abs(context.ground) <= 0.5
    shift = context.origin - vienna.origin
    np.testing.assert_allclose(context.buildings[3].points + shift, vienna.buildings[3].points, atol=1e-9)


@pytest.mark.parametrize(("name", "towards"), [(WEST, (1.0, 0.0)), (EAST, (-3.0, 0.5))])
def test_eaves_are_corners_of_a_roof_and_of_a_wall(vienna: Context, name: str, towards: tuple[float, float]) -> None:
    building = vienna.building(name)
    found = eaves(building, towards)
    assert found
    lengths = [np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in found]
    assert lengths == sorted(lengths, reverse=True)
    for line in found:
        for kind in ("RoofSurface", "WallSurface"):
            corners = np.concatenate([ring for surface in building.of_kind(kind) for ring in surface.rings])
            gaps = np.linalg.norm(corners[None] - line[:, None], axis=2).min(axis=1)
            np.testing.assert_allclose(gaps, 0.0, atol=1e-12)
        chord = line[-1] - line[0]
        assert np.array([chord[1], -chord[0]]) @ towards > 0.0  # the outside is on the right


def test_the_two_eaves_of_the_vault(vienna: Context) -> None:
    west, east = facing_eaves(vienna, WEST, EAST)
    # The numbers that targets/vault.yaml and targets/README.md state, to the millimetre.
    expected_west = [[-7.732, -10.610, 20.579], [-4.236, 12.547, 20.640]]
    expected_east = [[3.410, -12.308, 18.937], [6.970, 10.840, 18.937]]
    np.testing.assert_allclose(west, expected_west, atol=6e-4)
    np.testing.assert_allclose(east, expected_east, atol=6e-4)
    spans = np.linalg.norm((east - west)[:, :2], axis=1)
    np.testing.assert_allclose(spans, [11.271, 11.336], atol=2e-3)
    for line, name in ((west, WEST), (east, EAST)):
        samples = line[0] + np.linspace(0.0, 1.0, 25)[:, None] * (line[-1] - line[0])
        for kind in ("RoofSurface", "WallSurface"):
            assert distances_to_edges(samples, vienna.building(name), kind).max() < 2e-3


@pytest.mark.parametrize(("name", "ground", "pitch"), [(WEST, 3.134, 39.7), (EAST, 0.590, 35.8)])
def test_ground_and_roof_pitch_of_the_two_houses(vienna: Context, name: str, ground: float, pitch: float) -> None:
    house = vienna.building(name)
    feet = np.concatenate([surface.rings[0] for surface in house.of_kind("GroundSurface")])
    assert feet[:, 2].min() == pytest.approx(ground, abs=1e-9)
    eave = eaves(house, (1.0, 0.0) if name == WEST else (-1.0, 0.0))[0]
    rings = [surface.rings[0] for surface in house.of_kind("RoofSurface")]
    (roof,) = [r for r in rings if all(np.linalg.norm(r - end, axis=1).min() < 1e-9 for end in eave[[0, -1]])]
    normal = np.linalg.svd(roof - roof.mean(axis=0))[2][2]
    assert np.degrees(np.arccos(abs(normal[2]))) == pytest.approx(pitch, abs=0.05)


def test_the_trimmed_ends_lie_square_across_the_gap(vienna: Context) -> None:
    west, east = facing_eaves(vienna, WEST, EAST)
    chords = [(line[-1] - line[0])[:2] / np.linalg.norm((line[-1] - line[0])[:2]) for line in (west, east)]
    along = (chords[0] + chords[1]) / np.linalg.norm(chords[0] + chords[1])
    np.testing.assert_allclose((west - east)[:, :2] @ along, 0.0, atol=1e-9)
    swapped = facing_eaves(vienna, EAST, WEST)
    np.testing.assert_allclose(swapped[0], east[::-1], atol=1e-9)
    np.testing.assert_allclose(swapped[1], west[::-1], atol=1e-9)


def test_no_building_stands_under_the_vault(vienna: Context) -> None:
    """No surface of the file, at any height, lies in the plan between the two eaves."""
    west, east = facing_eaves(vienna, WEST, EAST)
    along, across = np.meshgrid(np.linspace(0.0, 1.0, 41), np.linspace(0.002, 0.998, 21), indexing="ij")
    left = west[0] + along[..., None] * (west[1] - west[0])
    right = east[0] + along[..., None] * (east[1] - east[0])
    points = (left + across[..., None] * (right - left)).reshape(-1, 3)[:, :2]
    vertices, triangles, _ = triangulated(vienna)
    corners = vertices[triangles][..., :2]
    sides = np.roll(corners, -1, axis=1) - corners
    steps = points[:, None, None] - corners[None]
    turns = sides[None, ..., 0] * steps[..., 1] - sides[None, ..., 1] * steps[..., 0]
    covered = np.all(turns > 0.0, axis=2) | np.all(turns < 0.0, axis=2)
    assert not covered.any()


def test_zero_tolerance_keeps_every_vertex_and_a_wide_one_only_the_ends(vienna: Context) -> None:
    house = vienna.building(WEST)
    every, merged = eaves(house, (1.0, 0.0), 0.0)[0], eaves(house, (1.0, 0.0), 0.02)[0]
    assert len(every) == 6
    assert len(merged) == 2
    np.testing.assert_array_equal(merged, every[[0, -1]])


def test_triangles_of_a_square_with_two_holes() -> None:
    square = np.array([[0, 0, 1], [10, 0, 1], [10, 10, 1], [0, 10, 1]], dtype=float)
    hole = np.array([[1, 1, 1], [3, 1, 1], [3, 3, 1], [1, 3, 1]], dtype=float)
    rings = [square, hole, hole[::-1] + np.array([5.0, 4.0, 0.0])]
    points = np.concatenate(rings)
    triangles = triangulate(rings)
    a, b, c = points[triangles].transpose(1, 0, 2)
    normals = 0.5 * np.cross(b - a, c - a)
    assert np.all(normals[:, 2] > 0.0)
    assert normals[:, 2].sum() == pytest.approx(100.0 - 2 * 4.0)
    assert len(triangles) == 12 + 2 * 2 - 2


def house(**changes: Any) -> dict[str, Any]:
    """A CityJSON file of one gabled house, 4 m by 6 m, eaves at 3 m along y, ridge at 5 m."""
    corners = [[0, 0], [4000, 0], [4000, 6000], [0, 6000]]
    vertices = [[x, y, z] for z in (0, 3000) for x, y in corners] + [[2000, 0, 5000], [2000, 6000, 5000]]
    kinds = ["GroundSurface", "WallSurface", "RoofSurface"]
    geometry = {
        "type": "Solid",
        "lod": "2.2",
        "boundaries": [
            [
                [[0, 3, 2, 1]],
                [[1, 2, 6, 5]],
                [[3, 0, 4, 7]],
                [[0, 1, 5, 8, 4]],
                [[2, 3, 7, 9, 6]],
                [[4, 8, 9, 7]],
                [[5, 6, 9, 8]],
            ]
        ],
        "semantics": {"surfaces": [{"type": k} for k in kinds], "values": [[0, 1, 1, 1, 1, 2, 2]]},
    }
    rough = {"type": "Solid", "lod": "1", "boundaries": [[[[0, 3, 2, 1]], [[4, 5, 6, 7]]]]}
    return {
        "type": "CityJSON",
        "version": "2.0",
        "transform": {"scale": [0.001, 0.001, 0.001], "translate": [500000.0, 5000000.0, 100.0]},
        "CityObjects": {
            "house": {"type": "Building", "children": ["house-1"]},
            "house-1": {"type": "BuildingPart", "parents": ["house"], "geometry": [geometry, rough]},
            "oak": {"type": "SolitaryVegetationObject"},
        },
        "vertices": vertices,
    } | changes


def written(folder: Path, content: dict[str, Any] | str, indent: int | None = None) -> Path:
    path = folder / "city.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content, indent=indent))
    return path


@pytest.mark.parametrize("indent", [None, 2])
def test_a_single_city_json_file_is_read_too(tmp_path: Path, indent: int | None) -> None:
    context = read_city_json(written(tmp_path, house(), indent))
    np.testing.assert_array_equal(context.origin, [500002.0, 5000003.0, 100.0])
    assert context.ground == 0.0
    (building,) = context.buildings
    assert building.name == "house"
    assert [s.kind for s in building.surfaces] == ["GroundSurface"] + 4 * ["WallSurface"] + 2 * ["RoofSurface"]
    (eave,) = eaves(building, (1.0, 0.0))
    np.testing.assert_allclose(eave, [[2.0, -3.0, 3.0], [2.0, 3.0, 3.0]], atol=1e-9)
    # The gable has sloping roof edges only.
    assert eaves(building, (0.0, 1.0)) == []


def test_an_upper_edge_of_a_roof_is_no_eave(tmp_path: Path) -> None:
    """A pent roof: wall under its ridge as under its eave."""
    pent = house()
    geometry = pent["CityObjects"]["house-1"]["geometry"][0]
    top = [[0, 0, 3000], [4000, 0, 5000], [4000, 6000, 5000], [0, 6000, 3000]]
    pent["vertices"] = [*pent["vertices"][:4], *top]
    geometry["boundaries"] = [
        [[[0, 3, 2, 1]], [[1, 2, 6, 5]], [[3, 0, 4, 7]], [[0, 1, 5, 4]], [[2, 3, 7, 6]], [[4, 5, 6, 7]]]
    ]
    geometry["semantics"]["values"] = [[0, 1, 1, 1, 1, 2]]
    (building,) = read_city_json(written(tmp_path, pent)).buildings
    assert eaves(building, (1.0, 0.0)) == []
    assert len(eaves(building, (-1.0, 0.0))) == 1


def test_houses_side_by_side_have_no_facing_eaves(vienna: Context) -> None:
    with pytest.raises(InputError, match="face each other"):
        facing_eaves(vienna, WEST, WEST)


def test_an_unknown_name_brings_a_suggestion(vienna: Context) -> None:
    with pytest.raises(InputError, match=f"did you mean {EAST}"):
        vienna.building(EAST[:-1] + "6")


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such file"):
        read_city_json(tmp_path / "nowhere.city.jsonl")
    with pytest.raises(InputError, match="this is a folder"):
        read_city_json(tmp_path)


def test_a_broken_line_is_named_by_its_number(tmp_path: Path) -> None:
    lines = EXCERPT.read_text().splitlines()
    lines[2] = lines[2][:400]
    with pytest.raises(InputError, match=r"^city\.json:3:\d+: this is not JSON"):
        read_city_json(written(tmp_path, "\n".join(lines)))


def test_a_file_without_buildings_is_refused(tmp_path: Path) -> None:
    header = EXCERPT.read_text().splitlines()[0]
    with pytest.raises(InputError, match="no building"):
        read_city_json(written(tmp_path, header))
    with pytest.raises(InputError, match="no building"):
        read_city_json(written(tmp_path, house(CityObjects={"oak": {"type": "PlantCover"}})))


def broken_ring(city: dict[str, Any]) -> None:
    city["CityObjects"]["house-1"]["geometry"][0]["boundaries"][0][0] = [[0, 3, 99]]


def too_few_semantics(city: dict[str, Any]) -> None:
    city["CityObjects"]["house-1"]["geometry"][0]["semantics"]["values"] = [[0]]


def lost_part(city: dict[str, Any]) -> None:
    del city["CityObjects"]["house-1"]


def endless_vertex(city: dict[str, Any]) -> None:
    city["vertices"][3] = [0, float("nan"), 0]


def degrees(city: dict[str, Any]) -> None:
    city["transform"]["scale"] = [1e-8, 1e-8, 1e-3]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda city: city.update(version="1.0"), "version '1.0'"),
        (lambda city: city.update(type="CityJSONFeature"), '"type": "CityJSON"'),
        (lambda city: city.pop("transform"), "transform"),
        (lambda city: city.update(transform={"scale": [1, 1]}), "transform.scale must be three numbers"),
        (lambda city: city.pop("vertices"), "vertices"),
        (broken_ring, "vertex numbers from 0 to 9"),
        (too_few_semantics, "not laid out"),
        (lost_part, "house-1"),
        (endless_vertex, "finite"),
        (degrees, "degrees"),
    ],
)
def test_faults_are_refused_in_words(tmp_path: Path, change: Callable[[dict[str, Any]], object], says: str) -> None:
    city = house()
    change(city)
    with pytest.raises(InputError, match=says):
        read_city_json(written(tmp_path, city))


@pytest.mark.parametrize("text", ["", "[1, 2]", "null", "{", '{"type": "CityJSON"}\n{}', "[" * 100_000])
def test_what_is_not_city_json_is_refused(tmp_path: Path, text: str) -> None:
    with pytest.raises(InputError):
        read_city_json(written(tmp_path, text))


@pytest.mark.parametrize(
    ("beginning", "name"),
    [
        (b"ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_SCHEMA(('IFC4'));\n", "an IFC file"),
        (b"ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\n", "a STEP file"),
        (b"  0\r\nSECTION\r\n  2\r\nHEADER\r\n", "a DXF file"),
        (b"999\nmade by hand\n0\nSECTION\n", "a DXF file"),
        (b"AC1027\0\0\0\xff", "a DWG file"),
        (b"# Blender\nmtllib a.mtl\no House\nv 0.0 1 -2\n", "an OBJ file"),
        (b"solid house\nfacet normal 0 0 1\n", "an STL file"),
        (b"ply\nformat ascii 1.0\n", "a PLY file"),
        (b"OFF\n3 1 0\n", "an OFF file"),
        (b"glTF\2\0\0\0\xff", "a GLB file"),
        (b"PK\3\4\xff", "a ZIP archive"),
        (b"3D Geometry File Format \xff", "a 3DM file"),
        (b'<?xml version="1.0"?>\n<core:CityModel xmlns="x">', "a CityGML file"),
        (b"<?xml version='1.0'?>\n<kml>", "an XML file"),
        (b'{"type": "FeatureCollection", "features": []}', "a GeoJSON file"),
        (b'{"asset": {"version": "2.0"}}', "a glTF file"),
    ],
)
def test_other_formats_are_named(tmp_path: Path, beginning: bytes, name: str) -> None:
    path = tmp_path / "site"
    path.write_bytes(beginning)
    with pytest.raises(
        InputError, match=f"^site: this is {name}: buildings are read from CityJSON, version 1.1 or 2.0"
    ):
        read_city_json(path)


def test_bytes_that_are_not_text_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "city.json"
    path.write_bytes(b"\xff\xfe\x00{")
    with pytest.raises(InputError, match=r"city\.json:1:1: the byte 0xff is not valid UTF-8"):
        read_city_json(path)


@pytest.mark.parametrize("origin", [[1.0, 2.0], "here", [0.0, 0.0, float("inf")]])
def test_an_origin_must_be_a_point(origin: Any) -> None:
    with pytest.raises(InputError, match="origin must be three numbers"):
        read_city_json(EXCERPT, origin)


def test_eaves_need_a_direction(vienna: Context) -> None:
    with pytest.raises(InputError, match="direction in plan"):
        eaves(vienna.building(EAST), (0.0, 0.0))
