"""What is drawn on pieces to cut: words that have room, flaps that lie over nothing, layers in their places."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import shapely
from designs import assert_close, eggbox, holed, hybrid, miura, perturbed, polygonal, relabelled, tube

from inverse.errors import InputError
from inverse.fabricate.cut.crease_plan import crease_plan, layers_plan, seams
from inverse.fabricate.cut.flaps import flaps_along
from inverse.fabricate.cut.fold import crease_fold
from inverse.fabricate.cut.labels import words_of
from inverse.fabricate.cut.pieces import Piece, pieces_of, to_scale
from inverse.fabricate.cut.plan import FOLDS, Line, Plan, Text
from inverse.origami import folding, geometry, seeds
from inverse.origami.pattern import CFL, B, Design, FloatArray
from inverse.pictures.colours import EDGE_COLOURS, edge_kinds
from inverse.pictures.sheets import lay_out

SCALE = 0.03
SHARP = np.radians(25)


def single_facets(degrees: float = 60.0) -> Design:
    """Every facet is a piece of its own, some of them small, with up to four words."""
    lengths = [1, 0.6, 1, 1.4]
    return seeds.grid((4, 4), "CFL", "CFL", sector_angle=np.radians(degrees), lengths_u=lengths, lengths_v=lengths)


DESIGNS: dict[str, Callable[[], Design]] = {
    "single facets": single_facets,
    "sharp single facets": lambda: single_facets(25.0),
    "eggbox": eggbox,
    "polygonal eggbox": lambda: polygonal(eggbox),
    "short seams": lambda: seeds.grid((5, 5), "CFL", "FL", lengths_u=[4] * 5, lengths_v=[0.2] * 5),
    "narrow pieces": lambda: seeds.grid((5, 5), "CFL", "FL", lengths_u=[0.2] * 5, lengths_v=[4] * 5),
    "sharp eggbox": lambda: eggbox(6, 6, sector_angle=SHARP),
    "sharp tube": lambda: tube(8, 6, sector_angle=SHARP),
    "plus": lambda: seeds.tube(seeds.NAMED_SECTIONS["plus"], 4),
    "hybrid": hybrid,
    "tube of uneven rows": lambda: tube(4, 6, lengths=[1, 0.2, 1, 0.3, 2, 1], sector_angle=SHARP),
}


@pytest.fixture(scope="module", params=DESIGNS)
def design(request: pytest.FixtureRequest) -> Design:
    return DESIGNS[request.param]()


def facets_of(plan: Plan) -> list[shapely.Polygon]:
    lines = [shapely.LineString(line.ends) for line in plan.lines if line.layer != "flap"]
    return list(shapely.get_parts(shapely.polygonize(lines)))


def rectangle(text: Text) -> shapely.Polygon:
    """What digits of Helvetica cover: each is 0.78 of its height wide."""
    x = 0.39 * len(text.words) * text.height * np.array([np.cos(text.angle), np.sin(text.angle)])
    y = 0.5 * text.height * np.array([-np.sin(text.angle), np.cos(text.angle)])
    return shapely.Polygon([text.place - x - y, text.place + x - y, text.place + x + y, text.place - x + y])


def trapezoids(plan: Plan) -> list[FloatArray]:
    """Corners (4, 2) of all flaps; the foldline is between the last and the first."""
    drawn = [line.ends for line in plan.lines if line.layer == "flap"]
    return [np.array([*a, *c]) for a, c in zip(drawn[::3], drawn[2::3], strict=True)]


# ---- words


@pytest.mark.parametrize("scale", [0.002, SCALE, 1.0])
def test_words_lie_in_their_facet_apart_and_nearest_to_their_edge(design: Design, scale: float) -> None:
    plan = crease_plan(design, scale=scale)
    facets = facets_of(plan)
    assert len(facets) == len(design.pattern.faces_vertices)
    numbers = {words_of(number): edge for edge, number in seams(design, pieces_of(design, scale)).items()}
    assert Counter(text.words for text in plan.texts) == Counter(list(numbers) * 2)
    words = np.array([rectangle(text) for text in plan.texts])
    one, other = shapely.STRtree(words).query(words, predicate="intersects")
    assert (one == other).all()
    for text, covered in zip(plan.texts, words, strict=True):
        (facet,) = [facet for facet in facets if facet.contains(covered)]
        place = shapely.Point(text.place)
        sides = [line for line in plan.lines if facet.boundary.distance(shapely.Point(line.ends.mean(axis=0))) < 1e-9]
        nearest = min(sides, key=lambda line: shapely.LineString(line.ends).distance(place))
        assert nearest.edge == numbers[text.words]
        along = nearest.ends[1] - nearest.ends[0]
        assert abs(np.cross([*along, 0], [np.cos(text.angle), np.sin(text.angle), 0])[2]) < 1e-9 * np.linalg.norm(along)
        assert -np.pi / 2 < text.angle <= np.pi / 2 + 1e-8
        room = shapely.maximum_inscribed_circle(facet).length
        assert 0.2 * min(room, np.linalg.norm(along)) < text.height or text.height > 2.0
        assert text.height <= 4.0


def test_numbers_rise_along_every_seam() -> None:
    design = eggbox(5, 6)
    numbers = seams(design, pieces_of(design, 1.0))
    edges = {frozenset(pair): edge for edge, pair in enumerate(design.pattern.edges_vertices.tolist())}
    cut = 0
    for line in design.pattern.lines:
        own = [edges[frozenset(pair)] for pair in pairwise(line)]
        if design.pattern.edges_type[own[0]] == CFL:
            found = [numbers[edge] for edge in own]
            assert found == list(range(found[0], found[0] + len(found)))
            cut += len(found)
    assert sorted(numbers.values()) == list(range(1, cut + 1))


def test_no_number_is_another_one_upside_down() -> None:
    upside_down = {"0": "0", "6": "9", "8": "8", "9": "6", ".": "."}
    words = {words_of(number) for number in range(1, 2000)}
    assert {word.rstrip(".") for word in words} == {str(number) for number in range(1, 2000)}
    for word in words:
        turned = "".join(upside_down.get(letter, "?") for letter in reversed(word))
        assert turned == word or turned not in words
    assert words_of(6) == "6."
    assert sum(word.endswith(".") for word in words) == 2 + (9 - 3) + (36 - 6)  # of one, two and three digits


# ---- flaps


@pytest.mark.parametrize("depth", [3.0, 500.0])
def test_every_seam_has_a_flap_that_lies_over_nothing(design: Design, depth: float) -> None:
    plan = crease_plan(design, scale=SCALE, flaps=depth)
    flaps, facets = trapezoids(plan), facets_of(plan)
    polygons = [*map(shapely.Polygon, flaps), *facets]
    area = sum(polygon.area for polygon in polygons)
    assert shapely.union_all(polygons).area == pytest.approx(area, rel=1e-9)
    assert len(flaps) == len(seams(design, pieces_of(design, SCALE)))
    for corners in flaps:
        b, outer_b, outer_a, a = corners
        length = np.linalg.norm(b - a)
        along = (b - a) / length
        offsets = (corners - a) @ np.array([[along[0], along[1]], [along[1], -along[0]]]).T
        assert offsets[1, 1] == pytest.approx(offsets[2, 1])
        assert 0 < offsets[1, 1] <= depth * (1 + 1e-9)
        assert np.linalg.norm(outer_b - outer_a) > 0.3 * length
        # Tapered by 45 degrees or less, so that it never reaches beyond its foldline.
        slopes = offsets[1, 1] / np.array([offsets[2, 0], length - offsets[1, 0]])
        assert (slopes > 0).all()
        assert (slopes <= 1 + 1e-9).all()


@pytest.mark.parametrize("depth", [0.05, 0.15, 0.25, 0.5])
@pytest.mark.parametrize("seed", range(12))
def test_flaps_in_a_hole_keep_from_facets_and_from_each_other(seed: int, depth: float) -> None:
    """The middle facet of a plane grid is cut out of it, 1 x 0.2; flaps stand in the hole or at the facet."""
    x, y = np.meshgrid([0.0, 1, 2, 3], [0.0, 1, 1.2, 2.2], indexing="ij")
    flat = Design(seeds.grid_pattern((3, 3)), np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1))
    design, _, facet = relabelled(flat, seed)
    pattern, middle = design.pattern, int(facet[4])

    def piece(faces: tuple[int, ...], shift: float) -> Piece:
        vertices = {v for f in faces for v in pattern.faces_vertices[f]}
        return Piece(faces, {v: design.vertices_coords[v, :2] + [shift, 0] for v in vertices})

    pieces = [piece(tuple(f for f in range(9) if f != middle), 0.0), piece((middle,), 10.0)]
    edges = [edge for edge, pair in enumerate(pattern.edges_faces.tolist()) if middle in pair]
    flaps = flaps_along(pattern, pieces, edges, depth)
    assert [flap.edge for flap in flaps] == edges
    polygons = [shapely.Polygon(flap.outline) for flap in flaps]
    for one in pieces:
        polygons += [shapely.Polygon(one.polygon(pattern.faces_vertices[f])) for f in one.faces]
    area = sum(polygon.area for polygon in polygons)
    assert shapely.union_all(polygons).area == pytest.approx(area, rel=1e-9)
    for flap in flaps:
        drawn = flap.outline[[3, 0]]
        of = pieces[flap.piece].polygon(tuple(pattern.edges_vertices[flap.edge].tolist()))
        assert sorted(drawn.tolist()) == sorted(of.tolist())
        length = np.linalg.norm(drawn[1] - drawn[0])
        # At the facet there is always room for a flap tapered by 45 degrees.
        high = 2 * shapely.Polygon(flap.outline).area / (length + np.linalg.norm(flap.outline[2] - flap.outline[1]))
        assert high >= min(depth, length / 3) * (1 - 1e-9)


@pytest.mark.parametrize(("scale", "depth"), [(0.1, 8.0), (0.1, 0.5), (1.0, 6.0), (10.0, 2.0)])
def test_flaps_where_there_is_room_are_as_asked(scale: float, depth: float) -> None:
    design = hybrid()
    flaps = trapezoids(crease_plan(design, scale=scale, flaps=depth))
    assert len(flaps) == len(seams(design, pieces_of(design, scale)))
    for corners in flaps:
        b, outer_b, outer_a, a = corners
        assert np.linalg.norm(outer_a - a) == pytest.approx(depth * np.sqrt(2))
        assert np.linalg.norm(outer_b - b) == pytest.approx(depth * np.sqrt(2))
        assert np.linalg.norm(outer_b - outer_a) == pytest.approx(np.linalg.norm(b - a) - 2 * depth)


def test_a_seam_is_folded_at_its_flap_and_cut_on_the_other_side(design: Design) -> None:
    pattern = design.pattern
    kinds = edge_kinds(pattern, geometry.fold_angles(pattern, design.vertices_coords))
    plan = crease_plan(design, scale=SCALE, flaps=3.0)
    at_flap = {tuple(sorted(map(tuple, np.round(corners[[0, 3]], 6).tolist()))) for corners in trapezoids(plan)}
    layers: dict[int, list[str]] = {}
    for line in plan.lines:
        if line.edge < 0:
            assert line.layer == "flap"
            continue
        layers.setdefault(line.edge, []).append(line.layer)
        ends = tuple(sorted(map(tuple, np.round(line.ends, 6).tolist())))
        is_seam = pattern.edges_type[line.edge] == CFL
        assert (ends in at_flap) == (is_seam and line.layer != "cut")
    for edge, found in layers.items():
        kind = list(EDGE_COLOURS)[kinds[edge]]
        if pattern.edges_type[edge] == CFL:
            assert sorted(found) == sorted(["cut", kind])
        else:
            assert found == ["cut" if kind == "border" else kind]
    assert sorted(layers) == list(range(len(pattern.edges_type)))


# ---- layers


@pytest.mark.parametrize("make", [lambda: tube(6, 4), lambda: tube(8, 4), hybrid, eggbox, holed])
def test_layers_are_congruent_to_the_developed_state(make: Callable[[], Design]) -> None:
    design = make()
    pattern = design.pattern
    plan = layers_plan(design, scale=0.1, apart=False)
    kinds = edge_kinds(pattern, geometry.fold_angles(pattern, design.vertices_coords))
    words = ["cut" if name == "border" else name for name in EDGE_COLOURS]
    assert Counter(line.edge for line in plan.lines) == Counter(
        {edge: 1 + (kind == CFL) for edge, kind in enumerate(pattern.edges_type.tolist())}
    )
    assert all(line.layer == words[kinds[line.edge]] for line in plan.lines)
    assert {line.layer for line in plan.lines} <= {"cut", *FOLDS}
    flat = 100 * folding.flat_state(design, 0.0)[:, :2]  # metres to millimetres of 1 : 10
    place = {}
    for line in plan.lines:
        for vertex, point in zip(pattern.edges_vertices[line.edge].tolist(), line.ends, strict=True):
            assert_close(place.setdefault(vertex, point), point, 1e-9)
    drawn = np.array([place[v] for v in range(pattern.n_vertices)])
    apart = [np.linalg.norm(points[:, None] - points, axis=2) for points in (flat, drawn)]
    assert_close(apart[0], apart[1], 1e-9 * apart[0].max())
    assert (drawn >= 9.999).all()
    assert (drawn <= np.array(plan.size) - 9.999).all()
    assert (pattern.edges_type == B).sum() == sum(line.layer == "cut" for line in plan.lines)


def test_layers_apart_are_the_same_layers_moved() -> None:
    design = tube(8, 4)
    over, apart = (layers_plan(design, scale=0.1, apart=apart) for apart in (False, True))
    assert not over.texts
    steps = [b.ends - a.ends for a, b in zip(over.lines, apart.lines, strict=True)]
    assert_close([step[0] - step[1] for step in steps], 0.0, 1e-9)
    assert_close([step[:, 1] for step in steps], 0.0, 1e-9)
    shifts = Counter(round(step[0, 0] / (over.size[0] - 10.0), 6) for step in steps)
    assert set(shifts) == set(range(len(apart.texts)))


# ---- refusals


@pytest.mark.parametrize("draw", [crease_plan, layers_plan, crease_fold])
def test_what_cannot_be_developed_is_refused(draw: Callable[[Design], object]) -> None:
    draw(perturbed(miura(), 1e-9))
    for size in (1e-4, 0.02):
        with pytest.raises(InputError, match=r"the developed state tears: facet \d+ is off by"):
            draw(perturbed(miura(), size))


def test_a_sheet_whose_angles_are_wrong_is_refused() -> None:
    design = miura(1, 1)
    (sheet,) = lay_out(design)
    to_scale(design, [sheet], 1.0)
    a, b, c, d = sheet.place_of(np.array(design.pattern.faces_vertices[0]))
    turn = np.array([[np.cos(1e-4), -np.sin(1e-4)], [np.sin(1e-4), np.cos(1e-4)]])
    sheared = dict(zip(design.pattern.faces_vertices[0], [a, b, b + turn @ (d - a), a + turn @ (d - a)], strict=True))
    assert_close(c - b, d - a, 1e-12)  # a parallelogram: all edges keep their lengths
    with pytest.raises(InputError, match="the developed state tears"):
        to_scale(design, [replace(sheet, points=np.array([sheared[v] for v in sheet.vertices.tolist()]))], 1.0)


@pytest.mark.parametrize("draw", [crease_plan, layers_plan, crease_fold])
@pytest.mark.parametrize(
    ("scale", "words"),
    [
        *((scale, "it must be greater than 0") for scale in (0.0, -1.0, np.nan, np.inf)),
        *((scale, "mm long: 0.001 to 1e.09 mm can be drawn") for scale in (1e-320, 1e-300, 1e-7, 1e7, 1e300, 1e308)),
    ],
)
def test_scales_that_cannot_be_are_refused(draw: Callable[..., object], scale: float, words: str) -> None:
    with pytest.raises(InputError, match=words):
        draw(miura(), scale=scale)


@pytest.mark.parametrize("edge", [1.1e-3, 0.9e9])
def test_pieces_at_the_least_and_the_largest_scale_are_true(edge: float) -> None:
    for design in (tube(6, 10), hybrid()):
        of = geometry.edge_lengths(design.pattern, design.vertices_coords)
        scale = edge / (1000 * of.mean())
        plan = crease_plan(design, scale=scale, flaps=0.2 * edge)
        lengths = [np.linalg.norm(line.ends[1] - line.ends[0]) for line in plan.lines if line.edge >= 0]
        edges = [line.edge for line in plan.lines if line.edge >= 0]
        np.testing.assert_allclose(lengths, 1000 * scale * of[edges], rtol=1e-9)
        assert len(trapezoids(plan)) == len(seams(design, pieces_of(design, scale)))


def test_depths_that_cannot_be_are_refused() -> None:
    for depth in (-1.0, np.nan, np.inf):
        with pytest.raises(InputError, match="or more is needed"):
            crease_plan(eggbox(), flaps=depth)


def test_lengths_follow_the_unit_and_the_scale() -> None:
    def lengths(lines: tuple[Line, ...]) -> FloatArray:
        return np.array([np.linalg.norm(line.ends[1] - line.ends[0]) for line in lines])

    for unit, mm in (("m", 1000.0), ("cm", 10.0), ("in", 25.4), ("unit", 1.0)):
        design = hybrid(unit=unit)
        plan = crease_plan(design, scale=0.25)
        of = geometry.edge_lengths(design.pattern, design.vertices_coords)[[line.edge for line in plan.lines]]
        np.testing.assert_allclose(lengths(plan.lines), 0.25 * mm * of, rtol=1e-9)
