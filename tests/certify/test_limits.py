"""Every limit of the certificate from both sides: what is just within passes, what is just beyond fails, by name."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from certify_cases import document, edge_index, failures, four_facets, frame_of, hinged, raw, spherical, verdict

from inverse import certify
from inverse.certify import coarse
from inverse.certify.certificate import LIMITS, Certificate, Crossing, Loop, judge, told_apart
from inverse.certify.structure import examine

# As the contract and the README promise them.
PROMISED = {
    "structure": (0, "faults"),
    "planarity": (1e-9, "edge lengths"),
    "developability": (1e-9, "rad"),
    "flat_foldability": (1e-9, "rad"),
    "fold_angle": (1, "degrees"),
    "motion_gap": (1e-9, "diagonals"),
    "loop_closure": (1e-9, "diagonals"),
    "crossing_design": (0, "pairs"),
}
JUST = [0.99, 1.01]  # of a limit


@pytest.mark.parametrize("name", PROMISED)
def test_a_value_passes_up_to_its_limit_and_no_further(name):
    limit, unit = PROMISED[name]
    good, bad = (np.inf, -np.inf) if name == "fold_angle" else (-np.inf, np.inf)
    for value, passes in ((limit, True), (np.nextafter(limit, good), True), (np.nextafter(limit, bad), False)):
        item = judge(name, (value, "somewhere"))
        assert (item.passed, item.value, item.limit, item.unit) == (passes, value, limit, unit)
    assert list(LIMITS) == list(PROMISED)
    for value in (np.nan, np.inf, -np.inf, None):
        assert not judge(name, (value, "somewhere")).passed


@pytest.mark.parametrize(
    ("value", "limit", "told"),
    [
        (1.0, 1.0, "1"),
        (0.9994, 1.0, "0.999"),
        (0.9996, 1.0, "0.9996"),
        (0.99996, 1.0, "0.99996"),
        (17.123456, 1.0, "17.1"),
        (float(np.nextafter(1.0, 0)), 1.0, "0.9999999999999999"),
        # This one takes seventeen digits.
        (float(np.nextafter(1.0, 2)), 1.0, "1.0000000000000002"),
    ],
)
def test_a_value_is_told_with_as_few_digits_as_show_that_it_is_not_its_limit(value, limit, told):
    assert told_apart(value, limit) == told


# Planes.


@pytest.mark.parametrize("share", JUST)
@pytest.mark.parametrize(
    ("widths", "vertex", "facet", "unit", "by"),
    [
        ((1.0, 1.0, 1.0), 0, 0, 1.0, "the mean edge"),
        ((1.0, 1.0, 1.0), 3, 2, 1.0, "the mean edge"),
        ((1.0, 0.1), 0, 0, 5.2 / 7, "the mean edge"),
        ((0.1, 1.0), 2, 1, 5.2 / 7, "the mean edge"),
        ((1.0, 0.1), 2, 1, 0.1, "its shortest edge"),
        ((0.1, 1.0), 0, 0, 0.1, "its shortest edge"),
    ],
)
def test_a_corner_off_the_plane_of_its_rectangle(widths, vertex, facet, unit, by, share, tmp_path):
    # One corner of a rectangle up by h: the best plane leaves h / 4 at each.
    doc = hinged([1.0] * (len(widths) - 1), widths)
    heading = 1.0 * facet
    normal = np.array([-np.sin(heading), np.cos(heading), 0])
    doc["vertices_coords"][vertex] = (doc["vertices_coords"][vertex] + share * 4e-9 * unit * normal).tolist()
    check = verdict(doc, tmp_path).checks["planarity"]
    assert check.value == pytest.approx(share * 1e-9, rel=1e-4)
    assert check.passed == (share < 1)
    assert check.worst.startswith(f"facet {facet}, by ")
    if len(set(widths)) > 1:  # where all edges are alike the mean is one of them, to rounding
        assert check.worst == f"facet {facet}, by {by}"


@pytest.mark.parametrize("sides", [(4, 5), (5, 4), (4, 6), (6, 5), (3, 4), (5, 3)])
@pytest.mark.parametrize("facet", [0, 1])
def test_facets_of_any_number_of_sides_must_be_plane(sides, facet, tmp_path):
    # Two polygons inscribed in half circles on a common diameter, one of them turned up by 60 degrees.
    first, second = (
        np.stack([np.sin(angle), -np.cos(angle), 0 * angle], axis=1)
        for angle in (np.linspace(0, np.pi, n) for n in sides)
    )
    up = np.array([-np.cos(np.pi / 3), 0, np.sin(np.pi / 3)])
    rest = second[1:-1, :1] * up + second[1:-1] * [0, 1, 0]
    n, m = len(first), len(rest)
    faces = [list(range(n)), [n - 1, *range(n + m - 1, n - 1, -1), 0]]
    points = np.vstack([first, rest])
    assert verdict(raw(points, faces, {(0, n - 1): "FL"}), tmp_path).certified
    normal = np.array([0, 0, 1.0]) if facet == 0 else np.cross(up, [0, 1, 0])
    points[1 if facet == 0 else n] += 1e-7 * normal
    check = verdict(raw(points, faces, {(0, n - 1): "FL"}), tmp_path).checks["planarity"]
    assert check.passed == (sides[facet] == 3)
    if not check.passed:
        assert check.worst.startswith(f"facet {facet}, ")


# Sector angles.


SECTORS = {
    # Opposite angles sum to pi: flat both unfolded and folded up.
    "FL FL FL FL": [1.0, 1.3, np.pi - 1.0, np.pi - 1.3],
    "CFL CFL CFL CFL": [1.0, 1.3, np.pi - 1.0, np.pi - 1.3],
    "FL CFL FL CFL": [1.0, 1.3, 1.0, 1.3],
    "CFL FL CFL FL": [1.0, 1.3, 1.0, 1.3],
}
# What each equation sums up at the vertex, facet k between edges k and k + 1.
DEVELOPED = {
    "FL FL FL FL": [1, 1, 1, 1],
    "CFL CFL CFL CFL": [1, -1, 1, -1],
    "FL CFL FL CFL": [1, -1, -1, 1],
    "CFL FL CFL FL": [1, 1, -1, -1],
}
FOLDED = {
    "FL FL FL FL": [1, -1, 1, -1],
    "CFL CFL CFL CFL": [1, 1, 1, 1],
    "FL CFL FL CFL": [1, 1, -1, -1],
    "CFL FL CFL FL": [1, -1, -1, 1],
}


@pytest.mark.parametrize("share", [*JUST, -JUST[0], -JUST[1]])
@pytest.mark.parametrize(
    ("spoilt", "kept"), [("developability", "flat_foldability"), ("flat_foldability", "developability")]
)
@pytest.mark.parametrize("kinds", SECTORS)
def test_equations_6_and_7_to_a_billionth_in_both_directions(kinds, spoilt, kept, share, tmp_path):
    row = np.array((DEVELOPED if spoilt == "developability" else FOLDED)[kinds])
    # The two equations' rows are orthogonal, so that one can be spoilt alone.
    doc = spherical(np.array(SECTORS[kinds]) + share * 1e-9 * row / 4, kinds.split())
    certificate = verdict(doc, tmp_path)
    check = certificate.checks[spoilt]
    assert check.value == pytest.approx(abs(share) * 1e-9, rel=1e-4)
    assert check.passed == (abs(share) < 1)
    assert check.worst == "vertex 0"
    assert certificate.checks[kept].value < 1e-14


@pytest.mark.parametrize(("boundary", "interior"), [(1, 7), (4, 10), (25, 19), (28, 22), (6, 7), (23, 22)])
def test_every_interior_vertex_is_measured(boundary, interior, tmp_path):
    # A vertex of the boundary off by a little changes the sectors at the one interior vertex beside it.
    doc = document("miura")
    points = np.array(doc["vertices_coords"])
    points[boundary] += 1e-6 * np.array([1, 2, 3])
    doc["vertices_coords"] = points.tolist()
    certificate = verdict(doc, tmp_path)
    for name in ("developability", "flat_foldability"):
        assert certificate.checks[name].worst == f"vertex {interior}"
        assert certificate.checks[name].value > 1e-8


# Fold angles.


@pytest.mark.parametrize("margin", JUST)
@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("place", [0, 1, 2])
def test_the_fold_nearest_to_flat_decides_wherever_it_is(place, sign, closed, margin, tmp_path):
    folds = np.radians([60.0, 70.0, 80.0])
    folds[place] = sign * np.radians(180 - margin if closed else margin)
    check = verdict(hinged(folds, [1.0, 1.1, 1.2, 1.3]), tmp_path).checks["fold_angle"]
    assert check.value == pytest.approx(margin, abs=1e-9)
    assert check.passed == (margin > 1)
    assert check.worst.startswith(f"edge {place + 1}-{place + 6}, folded by ")


# Coordinates that are too coarse.


def _far(diagonals, **values):
    """The structure of a sheet that reaches so many diagonals from the origin along x, checks of the given values."""
    doc = document("miura")
    points = np.array(doc["vertices_coords"])
    size = np.linalg.norm(np.ptp(points, axis=0))
    nearest = points[:, 0].max() if diagonals > 0 else points[:, 0].min()
    points[:, 0] += diagonals * size - nearest
    doc["vertices_coords"] = points.tolist()
    structure = examine(frame_of(doc))
    found = dict.fromkeys(LIMITS, (0.0, "there")) | {name: (value, "there") for name, value in values.items()}
    return structure, found


def _share(structure):
    """Last digit of the largest coordinate in shortest edges."""
    a, b = structure.given[structure.mesh.edges].transpose(1, 0, 2)
    return np.spacing(np.abs(structure.given).max()) / np.linalg.norm(a - b, axis=1).min()


ROUNDED = ["planarity", "developability", "flat_foldability", "motion_gap", "loop_closure"]


@pytest.mark.parametrize("name", ROUNDED)
@pytest.mark.parametrize("factor", [29.9, 30.1])
def test_rounding_excuses_up_to_thirty_digits(name, factor):
    structure, _ = _far(1e8)
    value = factor * _share(structure)
    assert value > 1e-9
    structure, found = _far(1e8, **{name: value})
    told = coarse.explained(found, structure)
    assert told[name][0] == value  # it still fails
    assert ("too coarse" in told[name][1]) == (factor < 30)
    assert {key for key, item in told.items() if item != found[key]} <= {name}


@pytest.mark.parametrize(
    ("name", "value"), [("fold_angle", 1.5), ("crossing_design", 1.0), *((n, 1e-9) for n in ROUNDED)]
)
def test_rounding_is_no_excuse_for_other_checks_nor_told_of_what_passes(name, value):
    structure, found = _far(1e11, **{name: value})
    assert coarse.explained(found, structure) == found


@pytest.mark.parametrize(("diagonals", "told"), [(9.9, False), (10.1, True), (-9.9, False), (-10.1, True)])
def test_nearer_than_ten_diagonals_the_place_is_not_blamed(diagonals, told):
    structure, found = _far(diagonals, planarity=2e-9)
    # An edge so short that the last digit matters even here.
    given = structure.given.copy()
    tail, head = structure.mesh.edges[0]
    given[head] = given[tail] + np.array([0, 1e-7, 0])
    structure = dataclasses.replace(structure, given=given)
    assert 30 * _share(structure) > 2e-9
    assert ("too coarse" in coarse.explained(found, structure)["planarity"][1]) == told


def test_faults_of_a_far_design_are_put_down_to_its_place_only_where_that_can_be():
    structure, found = _far(1e11, structure=2.0)
    assert "too coarse" in coarse.explained(found, structure)["structure"][1]  # claims of angles, which differ
    broken = dataclasses.replace(structure, faults=["a fault of topology"])
    assert coarse.explained(found, broken) == found
    spoilt = dataclasses.replace(broken, halves=None)  # facets that are none any more
    assert "too coarse" in coarse.explained(found, spoilt)["structure"][1]
    # At 1e5 diagonals angles are good to more than the millionth of a degree that claims are held to.
    structure, found = _far(1e5, structure=2.0)
    assert coarse.explained(found, structure) == found


# What is told.


def test_sentences_count():
    loop = Loop((4, 5, 6), 4, 1e-3, 2e-3, 1.5)
    assert loop.gap == 2e-3
    assert dataclasses.replace(loop, gap_at_states=3e-3).gap == 3e-3
    assert "strip of 3 facets from facet 4: opens by 0.001 diagonals at 4 states" in loop.sentence
    assert Crossing(12.5, ((1, 7),)).sentence == "facets 1 and 7 cross beyond t = 12.50 degrees"
    assert Crossing(12.5, ((1, 7), (2, 3), (4, 5))).sentence.startswith("facets 1 and 7 and 2 more pairs cross")


def test_a_certificate_writes_every_loop_and_crossing_and_fifty_faults():
    sentences = tuple(f"fault {k}" for k in range(60))
    loops = Loop((4, 5, 6), 4, 1e-3, 2e-3, 1.5), Loop((1, 2, 3, 7), 5, 0.5, 0.25, 1.6)
    crossings = Crossing(10.0, ((1, 2), (3, 4))), Crossing(170.0, ((5, 6),))
    told = Certificate(False, {}, (10.0, 170.0), "holes:2", 2, sentences, loops, crossings).document()
    assert told["faults"] == list(sentences[:50])
    assert told["free_range"] == [10.0, 170.0]
    assert (told["topology"], told["n_holes"]) == ("holes:2", 2)
    assert told["crossings"] == [{"t": 10.0, "facets": [[1, 2], [3, 4]]}, {"t": 170.0, "facets": [[5, 6]]}]
    assert [(loop["facets"], loop["states"], loop["gap"]) for loop in told["loops"]] == [
        ([4, 5, 6], 4, 2e-3),
        ([1, 2, 3, 7], 5, 0.5),
    ]


# One rule at a time: a design that breaks it and nothing else is not certified.


def _alone(name):
    """A document that fails in the check of this name only."""
    if name == "fold_angle":
        return hinged([np.radians(0.5)], [1.0, 1.0])
    if name == "crossing_design":
        points, faces = four_facets(crossed=True, sides=3)
        return raw(points, faces, {(0, 1 + k): word for k, word in enumerate(["FL", "CFL"] * 2)})
    doc = hinged([1.0], [1.0, 1.0])
    if name == "planarity":
        doc["vertices_coords"][0][1] += 8e-9
    else:
        k = edge_index(doc, 1, 4)
        doc["edges_assignment"][k] = {"M": "V", "V": "M"}[doc["edges_assignment"][k]]
    return doc


@pytest.mark.parametrize("name", ["structure", "planarity", "fold_angle", "crossing_design"])
def test_one_failing_check_is_enough(name, tmp_path):
    certificate = verdict(_alone(name), tmp_path)
    assert failures(certificate) == {name}
    assert not certificate.certified
    # The motion is told of all the same, unless it starts from facets that cross.
    assert certificate.free_range == (None if name == "crossing_design" else (0.0, 180.0))


@pytest.mark.parametrize("name", PROMISED)
def test_no_check_is_left_out_of_the_verdict(name, monkeypatch):
    # Most designs that fail in one check fail in others too: here each is made to fail alone.
    frame = frame_of(document("6-gon tube"))
    assert certify.check_frame(frame).certified
    monkeypatch.setitem(LIMITS, name, (np.inf if name == "fold_angle" else -1.0, "of anything"))
    certificate = certify.check_frame(frame)
    assert failures(certificate) == {name}
    assert not certificate.certified
