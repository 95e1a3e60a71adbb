"""What facets hide, against rays that are cast one by one."""

from __future__ import annotations

import designs
import numpy as np
import pytest
import shapely

from inverse.boards.body import Body, body_of
from inverse.boards.hidden import Facets, rest_of
from inverse.pictures.camera import basis

CASES = {
    "miura": designs.miura(6, 6),
    "eggbox": designs.eggbox(5, 6),
    "hybrid": designs.hybrid(6),
    "tube": designs.tube(6, 5),
}
VIEWS = [(-1.1, 0.5), (0.4, -0.6), (-np.pi / 2, 0.0), (2.0, 0.02), (-np.pi / 2, np.pi / 2)]


def seen(name: str, view: tuple[float, float]) -> Body:
    design = CASES[name]
    return body_of(design.pattern, design.vertices_coords).seen(basis(*view))


NOWHERE = -1e9


def cast(points: np.ndarray, body: Body) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rays from points (N, 3) to the viewer, three answers (N, F).

    Which facets cover them, how far the facets' planes are before them, and how far the points are from the facets'
    outlines as seen. Facets seen edge on cover nothing.
    """
    inside, margin = np.zeros((len(points), len(body.polygons)), bool), np.full((len(points), len(body.polygons)), 1.0)
    depth = np.full(inside.shape, NOWHERE)
    for f, polygon in enumerate(body.polygons):
        normal = np.cross(polygon[1] - polygon[0], polygon[2] - polygon[0])
        if abs(normal[2]) < 1e-6 * np.linalg.norm(normal):
            continue
        flat = polygon[:, :2]
        step = np.roll(flat, -1, axis=0) - flat
        off = points[:, None, :2] - flat
        across = (step[:, 0] * off[..., 1] - step[:, 1] * off[..., 0]) * np.sign(normal[2])
        inside[:, f] = (across > 0).all(axis=1)
        depth[:, f] = polygon[0, 2] - (points[:, :2] - flat[0]) @ normal[:2] / normal[2] - points[:, 2]
        share = np.clip((off * step).sum(axis=2) / (step**2).sum(axis=1), 0, 1)
        margin[:, f] = np.linalg.norm(off - share[..., None] * step, axis=2).min(axis=1)
    return inside, depth, margin


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("name", CASES)
def test_lines_are_hidden_where_rays_meet_a_facet_before_them(name: str, view: tuple[float, float]):
    body = seen(name, view)
    facets = Facets(body.polygons)
    owners, parts = facets.hidden(body.edges)
    shares = np.random.default_rng(0).uniform(0.02, 0.98, (len(body.edges), 12))
    hidden = np.zeros(shares.shape, bool)
    for owner, (low, high) in zip(owners, parts, strict=True):
        hidden[owner] |= (shares[owner] > low) & (shares[owner] < high)
    points = body.edges[:, :1] + shares[..., None] * (body.edges[:, 1:] - body.edges[:, :1])
    inside, depth, margin = cast(points.reshape(-1, 3), body)
    apart = np.abs(depth) > 1e-4  # not the facets beside the line, nor those that it touches
    clear = ((margin > 1e-5) | ~apart).all(axis=1)  # lines behind an outline, as seen, may be drawn or not
    before = (inside & apart & (depth > 0)).any(axis=1)
    assert clear.sum() > 50 or 0.0 in view or np.pi / 2 in view  # seeds have all lines over others there
    assert (hidden.ravel() == before)[clear].all()


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("name", CASES)
def test_areas_are_seen_where_rays_meet_them_first(name: str, view: tuple[float, float]):
    body = seen(name, view)
    facets = Facets(body.polygons)
    areas = facets.visible_areas()
    low, high = body.points[:, :2].min(axis=0), body.points[:, :2].max(axis=0)
    places = np.random.default_rng(1).uniform(low, high, (400, 2))
    inside, depth, margin = cast(np.column_stack([places, np.zeros(len(places))]), body)
    depths = np.where(inside, depth, NOWHERE)
    first, second = np.sort(depths, axis=1)[:, -1], np.sort(depths, axis=1)[:, -2]
    points = shapely.points(places)
    covered = first > NOWHERE
    sure = (margin > 1e-4).all(axis=1) & (~covered | (first - second > 1e-6))
    seen_in = np.array([shapely.contains_properly(area, points) for area in areas]).T
    assert sure.sum() > 100 or view[1] == 0.02
    assert (seen_in[sure & covered].sum(axis=1) == 1).all()
    assert (seen_in.argmax(axis=1) == depths.argmax(axis=1))[sure & covered].all()
    assert not seen_in[sure & ~covered].any()


def square(tilt: float) -> np.ndarray:
    """A square around the origin, tilted about the y axis."""
    c, s = np.cos(tilt), np.sin(tilt)
    return np.array([[x * c, y, x * s] for x, y in [(-1, -1), (1, -1), (1, 1), (-1, 1)]])


def test_facets_that_cross_hide_each_other_up_to_where_they_meet():
    low, high = square(0.5), square(-0.5)
    facets = Facets([low, high])
    areas = facets.visible_areas()
    right, left = shapely.box(0, -1, 1, 1), shapely.box(-1, -1, 0, 1)
    c = np.cos(0.5)
    assert areas[0].intersection(right).area == pytest.approx(2 * c)
    assert areas[0].intersection(left).area == pytest.approx(0, abs=1e-6)
    assert areas[1].intersection(left).area == pytest.approx(2 * c)
    # A line of the second across both halves is hidden on the right.
    owners, parts = facets.hidden(np.array([[high[0] + [0, 0.5, 0], high[1] + [0, 0.5, 0]]]))
    assert owners.tolist() == [0]
    np.testing.assert_allclose(parts, [[0.5, 1.0]], atol=1e-5)


def test_facets_in_a_circle_need_no_order():
    """Three bars, each over the next one."""
    bars = []
    for turn in np.radians([0, 120, 240]):
        c, s = np.cos(turn), np.sin(turn)
        bar = np.array([[-2, 0.4, -1], [2, 0.4, 1], [2, 0.8, 1], [-2, 0.8, -1.0]])
        bars.append(np.column_stack([c * bar[:, 0] - s * bar[:, 1], s * bar[:, 0] + c * bar[:, 1], bar[:, 2]]))
    areas = Facets(bars).visible_areas()
    whole = shapely.union_all([shapely.Polygon(bar[:, :2]) for bar in bars])
    assert sum(area.area for area in areas) == pytest.approx(whole.area)
    lost = [shapely.Polygon(bar[:, :2]).area - area.area for bar, area in zip(bars, areas, strict=True)]
    assert min(lost) > 0.05


def test_a_facet_hides_no_line_of_its_own_nor_of_what_it_touches():
    body = Body((square(0.0), square(0.0) + np.array([2, 0, 0])), np.zeros((0, 2, 3)), np.zeros((0, 2), int))
    edges = np.stack([body.polygons[0], np.roll(body.polygons[0], -1, axis=0)], axis=1)
    owners, _ = Facets(body.polygons).hidden(edges)
    assert not len(owners)


def test_what_intervals_leave():
    owners, parts = rest_of(3, np.array([0, 0, 2]), np.array([[0.0, 0.2], [0.5, 0.7], [0.0, 1.0]]))
    assert owners.tolist() == [0, 0, 1]
    np.testing.assert_allclose(parts, [[0.2, 0.5], [0.7, 1.0], [0.0, 1.0]])
