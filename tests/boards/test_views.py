"""What the views show: projections, sections, supports, shadows, words."""

from __future__ import annotations

from dataclasses import replace

import designs
import numpy as np
import pytest
import shapely
from scipy.spatial import ConvexHull

from inverse.boards import supports
from inverse.boards.body import body_of, normals
from inverse.boards.drawings import check, formats_of, views_of
from inverse.boards.picture import CUT, HIDDEN, OUTLINE, POCHE, PROFILE, SHADOW, TARGET
from inverse.boards.sheet import Area, Stroke
from inverse.boards.views import VIEWS, Subject, state_words
from inverse.errors import InputError
from inverse.origami.pattern import Design
from inverse.pictures.camera import basis

TUBE = replace(designs.tube(6, 6), unit="m")
SHEET = replace(designs.miura(6, 10), unit="m")


def turned(design: Design, degrees: float) -> Design:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return design.moved_to(design.vertices_coords @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]]))


def lines_of(picture, pen) -> list[np.ndarray]:
    return [line for item in picture.items if isinstance(item, Stroke) and item.pen == pen for line in item.lines]


def areas_of(picture, fill: str) -> list[Area]:
    return [item for item in picture.items if isinstance(item, Area) and item.fill == fill]


@pytest.mark.parametrize("degrees", [0, 20, 75, 140])
def test_plan_and_elevations_follow_the_design_however_it_lies(degrees: float):
    here, there = Subject(SHEET), Subject(turned(SHEET, degrees))
    for name in ("plan", "front", "right"):
        a, b = (np.ptp(VIEWS[name].draw(one).measured, axis=0) for one in (here, there))
        np.testing.assert_allclose(a, b, rtol=1e-6)
    size = np.ptp(VIEWS["plan"].draw(there).measured, axis=0)
    assert size[0] > size[1]  # the longer side lies


@pytest.mark.parametrize(("name", "row"), [("north", [-1, 0]), ("south", [1, 0]), ("east", [0, 1]), ("west", [0, -1])])
def test_the_compass_is_that_of_the_file(name: str, row: list[int]):
    design = turned(SHEET, 20)
    points = design.vertices_coords @ np.array([[*row, 0], [0, 0, 1]]).T
    picture = VIEWS[name].draw(Subject(design))
    np.testing.assert_allclose(picture.measured, [points.min(axis=0), points.max(axis=0)], atol=1e-9)


def test_opposite_elevations_have_mirrored_outlines():
    front, back = (VIEWS[name].draw(Subject(TUBE, style="line")) for name in ("front", "back"))
    a, b = (np.concatenate(lines_of(picture, OUTLINE)) for picture in (front, back))
    np.testing.assert_allclose(np.ptp(a, axis=0), np.ptp(b, axis=0), rtol=1e-6)


def test_a_section_cuts_every_facet_across_the_plane_and_closes_around_a_tube():
    subject = Subject(TUBE, at=0.4)
    level = basis(subject.turn, 0.0)
    body = body_of(TUBE.pattern, TUBE.vertices_coords).seen(level)
    depth = float(body.points[:, 2].max() - 0.4 * np.ptp(body.points[:, 2]))
    cuts = body.cut(depth)
    straddling = [p for p in body.polygons if p[:, 2].min() < depth < p[:, 2].max()]
    assert len(cuts) == len(straddling) > 0
    behind = body.behind(depth)
    assert behind.points[:, 2].max() <= depth + 1e-12
    assert behind.edges[..., 2].max() <= depth + 1e-12
    before = body.seen(np.diag([1.0, -1.0, -1.0])).behind(-depth)

    def area(one) -> float:
        return float(np.linalg.norm(normals(one.polygons), axis=1).sum())

    assert area(behind) + area(before) == pytest.approx(area(body))


def test_a_section_along_a_tube_is_drawn_heavy_and_closed_across_it():
    upright = TUBE.moved_to(TUBE.vertices_coords[:, [2, 0, 1]])  # its axis lies along x
    picture = VIEWS["section"].draw(Subject(upright))
    cut = lines_of(picture, CUT)
    assert len(cut) == 1
    np.testing.assert_allclose(cut[0][0], cut[0][-1], atol=1e-6)


def test_where_sections_cut_follows_the_share():
    lengths = []
    for at in (0.1, 0.5, 0.9):
        _, ends, way = VIEWS["plan"].draw(Subject(SHEET, at=at)).marks[0]
        assert abs(way @ (ends[1] - ends[0])) < 1e-9
        lengths.append(float(ends[0][0]))
    assert np.ptp(np.diff(lengths)) < 1e-9
    assert lengths[0] != lengths[1]


def test_the_shadow_falls_where_the_light_goes():
    picture = VIEWS["plan"].draw(Subject(TUBE))
    shadow = shapely.union_all([shapely.Polygon(area.rings[0], area.rings[1:]) for area in areas_of(picture, SHADOW)])
    tall = np.ptp(TUBE.vertices_coords[:, 2])
    np.testing.assert_allclose(shadow.bounds[2:], picture.measured[1] + tall, rtol=0.2)
    body = shapely.union_all([shapely.Polygon(p[:, :2]).buffer(0) for p in Subject(TUBE).body.seen(
        basis(Subject(TUBE).turn - np.pi / 2, np.pi / 2)).polygons])  # fmt: skip
    assert shadow.intersection(body).area < 1e-6 * body.area
    assert not areas_of(VIEWS["plan"].draw(Subject(TUBE, style="shaded")), SHADOW)
    assert not any(isinstance(item, Area) for item in VIEWS["plan"].draw(Subject(TUBE, style="line")).items)


def test_hidden_lines_are_dashed_when_asked_for():
    assert not lines_of(VIEWS["front"].draw(Subject(TUBE)), HIDDEN)
    assert lines_of(VIEWS["front"].draw(Subject(TUBE, hidden=True)), HIDDEN)


def test_a_target_is_an_outline_over_facets_that_stay_whole():
    vertices = np.array([[-9, -9, 1], [9, -9, 1], [9, 9, 1], [-9, 9, 1.0]])
    target = vertices, np.array([[0, 1, 2], [0, 2, 3]])
    without, with_target = VIEWS["plan"].draw(Subject(SHEET)), VIEWS["plan"].draw(Subject(SHEET, target=target))
    count = [sum(isinstance(item, Area) for item in picture.items) for picture in (without, with_target)]
    assert count[0] == count[1]
    outline = np.concatenate(lines_of(with_target, TARGET))
    np.testing.assert_allclose(np.ptp(outline, axis=0), [18, 18])


def test_a_closed_target_has_no_rim_and_is_drawn():
    target = house([-9.0, -9.0, -9.0], [9.0, 9.0, 9.0])
    for name in ("plan", "axonometric", "section"):
        assert lines_of(VIEWS[name].draw(Subject(SHEET, target=target)), TARGET)


def house(low: list[float], high: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """A box as triangles."""
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    return corners, ConvexHull(corners).simplices.astype(np.int64)


def test_buildings_are_cropped_to_the_design_and_filled_where_they_are_cut():
    low, high = SHEET.vertices_coords.min(axis=0), SHEET.vertices_coords.max(axis=0)
    wall = house([low[0] - 50, low[1] - 50, low[2] - 5], [high[0] + 50, low[1], high[2] + 3])
    subject = Subject(SHEET, context=wall)
    view, name = basis(0.0, 0.0), "east"
    picture = VIEWS[name].draw(subject)
    np.testing.assert_allclose([picture.low, picture.high], subject.frame(view))
    assert np.ptp([picture.low, picture.high], axis=0)[0] < 1.6 * np.ptp(picture.measured, axis=0)[0]
    cut = shapely.union_all([shapely.Polygon(area.rings[0]) for area in areas_of(picture, POCHE)])
    frame = shapely.box(*picture.low, *picture.high)
    expected = shapely.box(low[1] - 50, low[2] - 5, low[1], high[2] + 3).intersection(frame)
    assert cut.symmetric_difference(expected).area < 1e-3 * expected.area


def test_exploded_panels_keep_their_size():
    """Every panel is there in its true size: in plan of a level sheet all edges are as long as before."""

    def lengths(name: str) -> float:
        return sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in
                   lines_of(VIEWS[name].draw(Subject(SHEET, style="line")), PROFILE))  # fmt: skip

    width = {name: np.ptp([(p := VIEWS[name].draw(Subject(SHEET, style="line"))).low, p.high], axis=0)[0]
             for name in ("exploded", "axonometric")}  # fmt: skip
    assert width["exploded"] > width["axonometric"] * 1.1
    assert lengths("exploded") > lengths("axonometric")  # every edge is drawn twice


def test_states_in_words():
    assert [state_words(t, None) for t in (0.0, 90.0, 180.0, 45.0)] == [
        "flat as developed", "deployed", "packed (flat-folded)", "45°",
    ]  # fmt: skip
    assert state_words(180.0, (0.0, 150.0)) == "packed (flat-folded), facets would meet"
    assert [words for words, _ in VIEWS["motion"].draw(Subject(SHEET, states=3)).words] == [
        "flat as developed", "deployed", "packed (flat-folded)",
    ]  # fmt: skip


def report(*anchors: dict) -> dict:
    return {"specification": {"constraints": {"anchors": list(anchors)}}}


def test_supports_are_vertices_that_lie_where_the_report_says():
    points = SHEET.vertices_coords
    side = points[:11]
    plane = {"point": side[0].tolist(), "normal": [0, 0, 1]}
    level = np.flatnonzero(np.abs(side[:, 2] - side[0, 2]) < 1e-9).tolist()
    assert supports.supports(SHEET, report({"side": "u0", "to": {"plane": plane}})) == tuple(level)
    line = [points[3].tolist(), points[7].tolist()]
    assert supports.supports(SHEET, report({"vertices": [3, 4, 7], "to": {"polyline": line}})) == (3, 7)
    point = {"vertices": [5], "to": {"point": points[5].tolist()}}
    assert supports.supports(SHEET, report(point)) == (5,)
    centre = points[2] + [0, 0, 2]
    circle = {"center": centre.tolist(), "normal": [1, 0, 0], "radius": 2}
    assert supports.supports(SHEET, report({"vertices": [2, 9], "to": {"circle": circle}})) == (2,)
    polygon = [points[0].tolist(), points[4].tolist(), points[8].tolist()]
    assert supports.supports(SHEET, report({"vertices": [8, 4], "to": {"polygon": polygon}})) == (4, 8)


@pytest.mark.parametrize(
    "wrong",
    [
        {},
        {"specification": 3},
        report({"side": "w9", "to": {}}),
        report({"vertices": [999], "to": {"point": [0, 0, 0]}}),
    ],
)
def test_a_report_of_something_else_says_nothing(wrong: dict):
    assert supports.supports(SHEET, wrong) == ()
    assert supports.verdicts(wrong) == ()
    assert supports.free_range(wrong) is None


def test_names_of_views_and_formats():
    assert views_of(["plan,front", "plan"]) == ["plan", "front"]
    assert views_of(["elevations"]) == ["front", "right", "back", "left"]
    assert set(views_of(["all"])) == {"board", *VIEWS}
    assert formats_of(["PDF,.svg"]) == ["pdf", "svg"]
    with pytest.raises(InputError, match=r"Did you mean axonometric\?"):
        views_of(["axonometry"])
    with pytest.raises(InputError, match=r"'tiff' is no format"):
        formats_of(["tiff"])


@pytest.mark.parametrize(
    ("changes", "size"),
    [({"at": 0.0}, 900), ({"at": np.nan}, 900), ({"states": 1}, 900), ({"states": 13}, 900), ({}, 100)],
)
def test_numbers_out_of_range_are_refused(changes: dict, size: int):
    with pytest.raises(InputError):
        check(replace(Subject(SHEET), **changes), size)


def test_a_design_far_away_or_tiny_is_drawn_alike():
    here = VIEWS["axonometric"].draw(Subject(SHEET, style="line"))
    for scale, away in ((1.0, 1e6), (1e-6, 0.0)):
        there = VIEWS["axonometric"].draw(Subject(SHEET.moved_to(SHEET.vertices_coords * scale + away), style="line"))
        lengths = [
            sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in lines_of(picture, OUTLINE)) / factor
            for picture, factor in ((here, 1.0), (there, scale))
        ]
        assert lengths[0] == pytest.approx(lengths[1], rel=1e-3)
