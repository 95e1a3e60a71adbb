"""Thick panels: closed forms, no contact within the range, the first contact beyond it."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import combinations
from pathlib import Path

import designs
import manifold3d
import numpy as np
import pytest
import shapely
from certify_cases import generic
from hypothesis import given
from hypothesis import strategies as st

import inverse
from inverse.errors import InputError
from inverse.fabricate.panels import panels as panels_module
from inverse.fabricate.panels.boxes import overlapping_boxes
from inverse.fabricate.panels.contacts import RESOLUTION, first_contacts, penetrations
from inverse.fabricate.panels.frames import local_corners
from inverse.fabricate.panels.panels import panels
from inverse.fabricate.panels.report import report_lines
from inverse.fabricate.panels.separation import gaps
from inverse.fabricate.panels.thickness import Thickness, motion_range
from inverse.origami import folding, geometry
from inverse.origami.pattern import Design, Pattern

DELTA = np.radians(10)
VAULT = Path(__file__).parents[2] / "targets" / "vault.yaml"


def strip(fold: float, count: int = 3) -> Design:
    """Squares in a row, every one folded by ``fold`` towards the one before."""
    heading = np.cumsum([0.0, *[fold] * (count - 1)])
    x, z = np.cumsum(np.r_[0, np.cos(heading)]), np.cumsum(np.r_[0, np.sin(heading)])
    points = np.concatenate([np.stack([x, np.full_like(x, y), z], axis=1) for y in (0.0, 1.0)])
    n = count + 1
    faces = [[k, k + 1, n + k + 1, n + k] for k in range(count)]
    return Design(Pattern.from_faces(faces, 2 * n, designs.all_fl), points)


def thickest(design: Design, share: float = 0.9, **options: float) -> Thickness:
    return Thickness(share * float(panels(design, Thickness(1e-9, **options)).largest.min()), **options)


CASES = designs.ALL | {
    "generic Miura": lambda: generic(designs.miura(6, 6), 0.05),
    "generic eggbox": lambda: generic(designs.eggbox(6, 6), 0.05),
    "tube6 of 10 rows": lambda: designs.tube(6, 10),
}


@pytest.mark.parametrize("side", [1, -1])
def test_the_valley_side_is_cut_back_by_thickness_times_cot_half_delta(side: int):
    thick = panels(strip(side * 0.7, 2), Thickness(0.02, delta=np.radians(40)))
    valley, mountain = (0, 1) if side == 1 else (1, 0)
    expected = 1 - 0.02 / np.tan(np.radians(20))
    designs.assert_close(thick.areas[:, valley], expected, 1e-12)
    designs.assert_close(thick.areas[:, mountain], 1.0, 1e-12)


@pytest.mark.parametrize("make", [designs.miura, designs.eggbox, designs.tube])
def test_outlines_are_those_of_half_planes_cut_by_shapely(make: Callable[[], Design]):
    design = make()
    angles = geometry.fold_angles(design.pattern, design.vertices_coords)
    delta = np.random.default_rng(1).uniform(0.3, 0.5, len(angles))
    height = 0.02
    thick = panels(design, Thickness(0.018, delta, hinge=0.004))
    edges_of = map(list, design.pattern.faces_edges)
    for f, (corners, edges) in enumerate(zip(local_corners(design), edges_of, strict=True)):
        whole = shapely.Polygon(corners)
        left = []
        for side in (1, -1):
            cut = whole
            for k, edge in enumerate(edges):
                if side * angles[edge] > 0:
                    line = shapely.LineString([corners[k], corners[(k + 1) % len(corners)]])
                    width = height / np.tan(delta[edge] / 2)
                    cut = cut.difference(line.buffer(width, single_sided=True).union(line.buffer(1e-9)))
                    # A half-plane ends nowhere: prolong the band.
                    far = shapely.affinity.scale(line, 50, 50)
                    cut = cut.difference(far.buffer(width, cap_style="flat"))
            left.append(cut)
        left.append(left[0].intersection(left[1]))
        designs.assert_close(thick.areas[f], [part.area for part in left], 1e-7)


@pytest.mark.parametrize("make", [designs.miura, designs.eggbox, designs.hybrid, designs.tube])
def test_at_the_limits_some_fold_leaves_delta_and_none_less(make: Callable[[], Design]):
    design = make()
    delta = np.random.default_rng(0).uniform(0.1, 0.3, len(design.pattern.edges_vertices))
    reach = motion_range(design, Thickness(0.01, delta))
    left = np.pi - np.abs(folding.fold_angles_at(design, np.array([reach.low, reach.high]))) - delta
    for t, margin in zip((reach.low, reach.high), left[:, design.pattern.interior_edges], strict=True):
        assert margin.min() > -1e-12
        assert abs(margin.min()) < 1e-12 or t in (0.0, np.pi)


@pytest.mark.parametrize("hinge", [0.0, 0.004])
@pytest.mark.parametrize("name", CASES)
def test_no_panels_meet_between_the_limits(name: str, hinge: float):
    thick = panels(design := CASES[name](), thickest(design, delta=DELTA, hinge=hinge))
    t = np.r_[thick.range.states(24), np.random.default_rng(0).uniform(thick.range.low, thick.range.high, 8)]
    assert not any(penetrations(thick, t))


@pytest.mark.parametrize("delta", [0.02, 1.0, 30.0])
@pytest.mark.parametrize("make", [lambda: generic(designs.staircase(), 0.05), designs.polygonal])
def test_corners_are_cut_back_for_every_delta(make: Callable[[], Design], delta: float):
    design = make()
    thick = panels(design, thickest(design, delta=np.radians(delta)))
    assert any(len(outline) > 4 for outlines in thick.outlines for outline in outlines)
    t = np.r_[thick.range.states(24), np.random.default_rng(0).uniform(thick.range.low, thick.range.high, 8)]
    assert not any(penetrations(thick, t))


def vault() -> Design:
    return inverse.solve(inverse.load(VAULT, ["pattern.size=[16,16]"])).design


@pytest.mark.parametrize("make", [
    lambda: designs.tube(6, 10),
    designs.staircase,
    pytest.param(vault, marks=pytest.mark.slow),
])  # fmt: skip
def test_manifold_alone_finds_no_overlap_within_the_range_and_some_beyond(make: Callable[[], Design]):
    # No separating planes, no tolerance: every pair of layers whose boxes meet is intersected.
    design = make()
    thick = panels(design, thickest(design, delta=DELTA))
    smallest = thick.volumes.sum(axis=1).min()

    def overlap(t: float) -> float:
        bodies = thick.bodies_at(np.array([t]))[0]
        layers = bodies.shape[1]
        corners = bodies.reshape(len(bodies) * layers, -1, 3)
        solids = [manifold3d.Manifold.hull_points(np.ascontiguousarray(points)) for points in corners]
        pairs = overlapping_boxes(corners.min(axis=1), corners.max(axis=1))
        return max((solids[a] ^ solids[b]).volume() for a, b in pairs.tolist() if a // layers != b // layers)

    assert max(overlap(t) for t in thick.range.states(24)) < 1e-9 * smallest
    assert overlap(thick.range.high + np.radians(0.1)) > 1e-9 * smallest
    if thick.range.low > 0:
        assert overlap(thick.range.low - np.radians(0.1)) > 1e-9 * smallest


@pytest.mark.parametrize("name", ["miura", "eggbox", "hybrid", "tube6", "holed", "polygonal_eggbox"])
def test_beyond_the_limits_neighbours_meet_at_once(name: str):
    design = CASES[name]()
    thick = panels(design, thickest(design, delta=DELTA))
    limits, flat = (thick.range.low, thick.range.high), (0.0, np.pi)
    neighbours = {frozenset(pair) for pair in design.pattern.edges_faces.tolist()}
    for contact, limit, end in zip(first_contacts(thick), limits, flat, strict=True):
        if limit == end:
            assert contact is None
            continue
        assert contact is not None
        assert 0 < abs(contact.t - limit) <= 2 * RESOLUTION  # a contact has at least some volume
        assert (contact.t < limit) == (end == 0.0)
        assert frozenset(contact.facets) in neighbours
        assert contact.volume > 0


def test_without_cutting_corners_back_panels_that_share_a_vertex_meet(monkeypatch: pytest.MonkeyPatch):
    design = designs.staircase()
    thickness = thickest(design, delta=DELTA)
    monkeypatch.setattr(panels_module, "with_corners_cut", lambda design, cuts, t: cuts)
    thick = panels(design, thickness)
    found = [contact for state in penetrations(thick, thick.range.states(24)) for contact in state]
    assert found
    for contact in found:
        shared = set.intersection(*(set(design.pattern.faces_vertices[f]) for f in contact.facets))
        assert len(shared) == 1


@pytest.mark.parametrize("layers", [1e-4, 0.02])
def test_a_contact_within_the_range_is_where_the_closed_form_says(layers: float):
    # Seen along the folds, the inner corner of an outer square's end meets its mirror image over the middle square.
    design = strip(np.radians(60), 3)

    def fold_at(t: float) -> float:
        return float(2 * np.arctan(np.tan(t / 2) * np.tan(np.radians(30))))

    contact = first_contacts(panels(design, Thickness(layers, DELTA)))[1]
    assert contact is not None
    assert contact.facets == (0, 2)
    inner = np.pi - np.arctan2(layers, 1.0)  # cos(phi) + layers sin(phi) = 1/2, phi = pi - fold
    expected = inner - np.arccos(0.5 / np.hypot(1.0, layers))
    assert fold_at(contact.t) == pytest.approx(expected, abs=2 * RESOLUTION)


def test_penetration_is_the_volume_of_the_closed_form():
    # Two squares folded beyond the limit: seen along the fold two right-angled corners in a wedge overlap in a kite.
    thickness, delta, fold = 0.05, np.radians(60), np.radians(150)
    thick = panels(strip(0.7, 2), Thickness(thickness, delta))
    t = 2 * np.arctan(np.tan(fold / 2) / np.tan(0.35))
    ((contact,),) = penetrations(thick, np.array([t]))
    half = (np.pi - fold) / 2
    # Half of the overlap is what of one layer lies beyond the bisector: a triangle at its inner corner.
    depth = thickness - np.tan(half) * thickness / np.tan(delta / 2)
    # The inner wall is at distance w from the fold; the bisector rises from there to the layer's outside.
    w = thickness / np.tan(delta / 2)
    assert contact.volume == pytest.approx(2 * 0.5 * depth * (thickness / np.tan(half) - w), rel=1e-9)


def random_prism(numbers: np.random.Generator) -> np.ndarray:
    angles = np.sort(numbers.uniform(0, 2 * np.pi, 5))
    outline = np.stack([np.cos(angles), np.sin(angles), np.zeros(5)], axis=1)
    bottom = outline * numbers.uniform(0.3, 1.0)
    turn = designs.rotation(int(numbers.integers(1 << 30)))
    both = np.stack([bottom, bottom + np.array([0, 0, numbers.uniform(0.05, 0.5)])])
    return both @ turn.T + numbers.uniform(-0.7, 0.7, 3)


@given(st.integers(0, 2**32 - 1))
def test_separating_planes_agree_with_manifold(seed: int):
    numbers = np.random.default_rng(seed)
    one, other = random_prism(numbers), random_prism(numbers)
    gap = float(gaps(one[None], other[None])[0])
    a, b = (manifold3d.Manifold.hull_points(np.ascontiguousarray(p.reshape(-1, 3))) for p in (one, other))
    volume = (a ^ b).volume()
    if gap > 0:
        assert volume == 0
        assert a.min_gap(b, 10.0) >= gap - 1e-9
    elif gap < -1e-6:
        assert volume > 0


@given(st.integers(0, 2**32 - 1), st.integers(1, 60))
def test_boxes_are_those_of_all_pairs(seed: int, count: int):
    numbers = np.random.default_rng(seed)
    low = numbers.integers(0, 12, (count, 3)).astype(float)
    high = low + numbers.integers(0, 5, (count, 3))
    expected = {
        (i, j) for i, j in combinations(range(count), 2) if (low[i] <= high[j]).all() and (low[j] <= high[i]).all()
    }
    found = [tuple(pair) for pair in overlapping_boxes(low, high).tolist()]
    assert len(found) == len(set(found))
    assert set(found) == expected


@pytest.mark.parametrize("hinge", [0.0, 0.01])
@pytest.mark.parametrize("name", ["generic Miura", "generic eggbox", "tube6", "polygonal"])
def test_a_thickness_too_large_names_the_facet_and_one_that_works(name: str, hinge: float):
    design = CASES[name]()
    with pytest.raises(InputError) as refused:
        panels(design, Thickness(0.5, DELTA, hinge))
    facet = int(re.search(r"too thick for facet (\d+)", refused.value.message).group(1))
    told = re.search(r"largest thickness that works is (\S+) m;", refused.value.hint).group(1)
    thick = panels(design, Thickness(float(told), DELTA, hinge))
    assert thick.largest.argmin() == facet
    assert (thick.areas > 0).all()
    with pytest.raises(InputError, match=f"facet {facet}\\b"):
        panels(design, Thickness(1.001 * float(told), DELTA, hinge))


@pytest.mark.parametrize(("wrong", "words"), [
    ({"thickness": 0.0}, "thickness of a layer is 0: it must be greater than 0"),
    ({"thickness": -0.1}, "must be greater than 0"),
    ({"thickness": float("nan")}, "must be greater than 0"),
    ({"delta": 0.0}, "delta is 0 degrees: it must lie between 0 and 180"),
    ({"delta": np.pi}, "delta is 180 degrees"),
    ({"delta": -0.1}, "between 0 and 180"),
    ({"hinge": -0.001}, "hinge sheet is -0.001"),
    ({"hinge": float("inf")}, "hinge sheet is inf"),
])  # fmt: skip
def test_values_out_of_their_range_are_refused(wrong: dict[str, float], words: str):
    with pytest.raises(InputError, match=words):
        Thickness(**{"thickness": 0.01} | wrong)


def test_a_delta_that_leaves_no_state_and_a_wrong_number_of_them_are_refused():
    with pytest.raises(InputError, match="no state leaves delta at every foldline: edge "):
        panels(designs.eggbox(), Thickness(0.01, np.radians(120)))
    with pytest.raises(InputError, match="3 values of delta are given for 40 edges"):
        panels(designs.miura(), Thickness(0.01, np.full(3, 0.2)))


def test_the_report_tells_range_and_contacts():
    design = strip(np.radians(60), 3)
    lines = report_lines(panels(design, Thickness(0.02, DELTA)))
    assert lines[0].startswith("panels fold from t = 0 to 17")
    assert "panels penetrate each other in that range, the most 0 and 2" in lines[1]
    assert lines[2] == "first contact towards the developed state: none"
    assert lines[3].startswith("first contact towards the flat-folded state: panels 0 and 2 at t = ")
    assert lines[4].startswith("without thickness, facets 0 and 2 cross beyond t = 14")
    free = report_lines(panels(designs.miura(), Thickness(0.01)))
    assert free[1] == "no panels penetrate each other at 24 states of that range"
    assert len(free) == 4


def test_a_report_tells_what_it_is_at() -> None:
    told: list[tuple[str, int, int]] = []
    report_lines(panels(designs.miura(), Thickness(0.01)), 6, lambda *words: told.append(words))
    states = [(done, of) for words, done, of in told if words == "looking for panels that meet, states"]
    assert states == [(k, 6) for k in range(6)]
    assert any(words.startswith("looking for the first contact, at t = ") and not of for words, _, of in told)
