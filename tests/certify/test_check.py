"""Sound designs are certified; every single kind of fault is found and named."""

from __future__ import annotations

import json
import time

import numpy as np
import pytest
from certify_cases import (
    SEEDS,
    document,
    failures,
    frame_of,
    generic,
    relabelled,
    spherical,
    strip,
    verdict,
    without_facets,
)

from inverse import certify
from inverse.certify import mobility
from inverse.certify.certificate import LIMITS, judge
from inverse.certify.loops import cut_open, shortest_strips
from inverse.certify.measures import fold_halves
from inverse.certify.mesh import build_mesh
from inverse.certify.motion import Motion
from inverse.certify.structure import examine
from inverse.errors import InputError
from inverse.files import fold_file
from inverse.files.fold_format import read_frame
from inverse.origami import folding, geometry, seeds

RESIDUALS = ("planarity", "developability", "flat_foldability", "motion_gap", "loop_closure")


@pytest.mark.parametrize("name", SEEDS)
def test_seeds_are_certified_to_rounding(name, tmp_path):
    certificate = verdict(document(name), tmp_path)
    assert certificate.faults == ()
    assert certificate.certified
    assert tuple(certificate.checks) == tuple(LIMITS)
    assert max(certificate.checks[check].value for check in RESIDUALS) < 1e-14
    assert certificate.topology == SEEDS[name].pattern.topology
    assert certificate.free_range == (0.0, 180.0)


@pytest.mark.parametrize("words", [("FL", "FL"), ("CFL", "FL"), ("FL", ["FL", "CFL", "CFL", "FL"])])
def test_designs_without_symmetry_are_certified(words, tmp_path):
    design = generic(seeds.grid((4, 5), *words), 0.05)
    certificate = verdict(fold_file.document(design), tmp_path)
    assert certificate.certified, certificate.faults
    assert max(certificate.checks[check].value for check in RESIDUALS) < 1e-13


def test_document_is_the_contracts(tmp_path):
    certificate = verdict(document("6-gon tube"), tmp_path)
    told = json.loads(json.dumps(certificate.document(), allow_nan=False))
    assert told["certified"] is True
    assert list(told["checks"]) == [
        "structure", "planarity", "developability", "flat_foldability",
        "fold_angle", "motion_gap", "loop_closure", "crossing_design",
    ]  # fmt: skip
    assert all(set(item) == {"value", "limit", "unit", "worst", "pass"} for item in told["checks"].values())
    assert told["free_range"] == [0.0, 180.0]
    assert "fold_angle: passed" in certificate.checks["fold_angle"].sentence
    assert "at least 1" in certificate.checks["fold_angle"].sentence


def test_what_cannot_be_measured_is_null_and_fails(tmp_path):
    doc = document("miura")
    doc["faces_vertices"].append(doc["faces_vertices"][0])
    told = verdict(doc, tmp_path).document()
    assert not told["certified"]
    assert told["free_range"] is None
    for name in LIMITS:
        if name != "structure":
            assert told["checks"][name]["value"] is None
            assert told["checks"][name]["pass"] is False
            assert told["checks"][name]["worst"] == "not measured: structure"


def test_only_an_unreadable_file_raises(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        certify.check(tmp_path / "none.fold")


# The second opinion agrees with the first one, which is written by other formulas.


@pytest.mark.parametrize("name", SEEDS)
def test_fold_angles_and_motion_agree_with_the_folding_module(name, tmp_path):
    design = SEEDS[name]
    fold_file.write(design, tmp_path / "design.fold")
    structure = examine(read_frame(tmp_path / "design.fold"))
    mesh = structure.mesh
    motion = Motion(mesh, structure.points, structure.types, *structure.halves)
    angle = {frozenset(e): 2 * np.arctan2(s, c) for e, s, c in zip(mesh.edges.tolist(), *structure.halves, strict=True)}
    for edge, rho in zip(
        design.pattern.edges_vertices.tolist(),
        geometry.fold_angles(design.pattern, design.vertices_coords),
        strict=True,
    ):
        assert angle[frozenset(edge)] == pytest.approx(rho, abs=1e-14)
    t = np.linspace(0, np.pi, 9)
    ours = motion.vertices(t / 2) * structure.unit
    theirs = folding.fold(design, t).vertices_coords
    centre = design.vertices_coords[0] - structure.points[0] * structure.unit
    np.testing.assert_allclose(ours + centre, theirs, atol=1e-13 * structure.unit)


def test_motion_is_exact_in_the_flat_states(tmp_path):
    fold_file.write(SEEDS["eggbox"], tmp_path / "design.fold")
    structure = examine(read_frame(tmp_path / "design.fold"))
    motion = Motion(structure.mesh, structure.points, structure.types, *structure.halves)
    for state in motion.vertices(np.array([0.0, np.pi / 2])):
        assert np.linalg.svd(state - state.mean(axis=0))[1][2] < 1e-14


def test_limits_are_exact_for_the_smallest_fold():
    points = np.array([[0, 0, 0], [0, 1, 0], [-1, 0.5, 0], [1, 0.5, 1e-13]], np.float64)
    mesh, _ = build_mesh([[0, 1, 2], [1, 0, 3]], 4)
    motion = Motion(mesh, points, np.ones(5, np.int64), *fold_halves(mesh, points))
    developed, folded = motion.vertices(np.array([0.0, np.pi / 2]))
    np.testing.assert_allclose(developed[3], [1, 0.5, 0], atol=1e-15)
    np.testing.assert_allclose(folded[3], [-1, 0.5, 0], atol=1e-15)


def test_what_is_no_number_fails():
    for value in (np.nan, np.inf, None):
        item = judge("fold_angle", (value, "somewhere"))
        assert item.value is None
        assert not item.passed
        assert "FAILED, somewhere" in item.sentence


@pytest.mark.parametrize(("p", "rho"), [(1.0, 0.3), (1.0, -0.3), (0.4, 2.9), (2.0, -np.pi / 2)])
def test_fold_angle_in_closed_form(p, rho):
    # Two facets with the common edge 0-1 on the y axis: the left one in z = 0, the right one up by rho.
    points = np.array([[0, 0, 0], [0, 1, 0], [-p, 0.5, 0], [np.cos(rho), 0.5, np.sin(rho)]], np.float64)
    mesh, faults = build_mesh([[0, 1, 2], [1, 0, 3]], 4)
    assert faults == []
    sine, cosine = (x[mesh.inner] for x in fold_halves(mesh, points))
    assert sine == pytest.approx(np.sin(rho / 2), abs=1e-15)
    assert cosine == pytest.approx(np.cos(rho / 2), abs=1e-15)


# Spoilt numbers.


def test_one_vertex_off_by_a_millionth_is_found_by_every_measure(tmp_path):
    doc = document("miura")
    doc["vertices_coords"][14] = [x + 1e-6 * k for k, x in enumerate(doc["vertices_coords"][14], 1)]
    certificate = verdict(doc, tmp_path)
    assert {"planarity", "developability", "flat_foldability", "motion_gap"} <= failures(certificate)
    for name in ("planarity", "developability", "flat_foldability"):
        assert 1e-8 < certificate.checks[name].value < 1e-4
    assert certificate.checks["motion_gap"].worst.startswith("edge ")
    assert certificate.free_range is None


def test_a_corner_vertex_off_only_bends_its_facet(tmp_path):
    doc = document("miura")
    doc["vertices_coords"][0][2] += 1e-8
    certificate = verdict(doc, tmp_path)
    assert "planarity" in failures(certificate)
    assert certificate.checks["planarity"].worst.startswith("facet 0, ")
    assert not failures(certificate) & {"developability", "flat_foldability", "loop_closure"}


@pytest.mark.parametrize(
    ("name", "failing", "keeping"),
    [("miura", "developability", "flat_foldability"), ("eggbox", "flat_foldability", "developability")],
)
def test_equations_6_and_7_are_told_apart(name, failing, keeping, tmp_path):
    # One vertex with four facets whose sector angles keep one of the two alternating sums only.
    a, b, c = 1.0, 1.3, 1.1
    d = a + c - b if name == "miura" else b + c - a
    types = ["FL"] * 4 if name == "miura" else ["FL", "CFL", "FL", "CFL"]
    certificate = verdict(spherical([a, b, c, d], types), tmp_path)
    assert certificate.faults == ()
    assert certificate.checks[failing].value > 1e-3
    assert certificate.checks[keeping].value < 1e-14
    assert certificate.checks[failing].worst == "vertex 0"
    assert "motion_gap" in failures(certificate)


@pytest.mark.parametrize(
    ("fold_state", "passes"), [(0.9998, False), (0.999, True), (0.5, True), (0.0005, True), (0.00005, False)]
)
def test_a_nearly_flat_design_state_certifies_nothing(fold_state, passes, tmp_path):
    # All folds of this seed go to 0 at both ends.
    certificate = verdict(fold_file.document(seeds.grid((3, 3), fold_state=fold_state)), tmp_path)
    assert failures(certificate) == (set() if passes else {"fold_angle"})
    assert (certificate.checks["fold_angle"].value >= 1) == passes


@pytest.mark.parametrize(("degrees", "passes"), [(179.5, False), (178.5, True), (-178.5, True), (-179.5, False)])
def test_a_nearly_closed_fold_certifies_nothing_either(degrees, passes, tmp_path):
    certificate = verdict(strip(np.radians(degrees), 2), tmp_path)
    assert certificate.checks["fold_angle"].value == pytest.approx(180 - abs(degrees))
    assert failures(certificate) == (set() if passes else {"fold_angle"})


@pytest.mark.parametrize("value", [0.9999, 0.9999999, np.nextafter(1, 0)])
def test_a_value_that_rounds_to_its_limit_is_told_with_more_digits(value):
    item = judge("fold_angle", (value, "edge 3-9"))
    assert not item.passed
    told = item.sentence.split(", ")[1].split(" degrees")[0]
    assert 0.999 < float(told) < 1
    assert len(told) <= 18
    above = judge("planarity", (max(1e-9 * (2 - value), np.nextafter(1e-9, 1)), "facet 0"))
    assert not above.passed
    assert float(above.sentence.split(", ")[1].split(" edge")[0]) > 1e-9


def test_the_limit_itself_and_other_values_are_told_with_few_digits():
    assert "passed, 1 degrees (at least 1 allowed)" in judge("fold_angle", (1.0, "edge 3-9")).sentence
    assert "passed, 17.1 degrees (at least 1 allowed)" in judge("fold_angle", (17.123456, "edge 3-9")).sentence
    assert "passed, 0 faults (at most 0 allowed)" in judge("structure", (0.0, "no faults")).sentence


@pytest.mark.parametrize("degrees", [0.99999999, 179.00000001])
def test_a_fold_just_beyond_the_limit_is_told_apart_from_it(degrees, tmp_path):
    sentence = verdict(strip(np.radians(degrees), 2), tmp_path).checks["fold_angle"].sentence
    assert "FAILED, 0.99999999" in sentence
    assert f"folded by {degrees}" in sentence


# Small facets beside large ones.


SHORT = {"lengths_u": [1e-6, 1, 1], "lengths_v": [1e-6, 1, 1, 1]}


@pytest.mark.parametrize("words", [("FL", "FL"), ("CFL", "FL")])
def test_sound_designs_with_short_edges_are_certified(words, tmp_path):
    certificate = verdict(fold_file.document(seeds.grid((3, 4), *words, **SHORT)), tmp_path)
    assert certificate.certified, failures(certificate)


@pytest.mark.parametrize("short", [1e-6, 1e-4, 1e-2])
def test_a_small_facet_is_measured_by_itself(short, tmp_path):
    doc = fold_file.document(seeds.grid((3, 4), lengths_u=[short, 1, 1], lengths_v=[short, 1, 1, 1]))
    off_plane = np.cross(*(np.subtract(doc["vertices_coords"][v], doc["vertices_coords"][0]) for v in (1, 5)))
    # Half a millionth of a degree, which in mean edges is as little as 1e-14.
    off_plane *= 1e-8 * short / np.linalg.norm(off_plane)
    doc["vertices_coords"][0] = (np.array(doc["vertices_coords"][0]) + off_plane).tolist()
    certificate = verdict(doc, tmp_path)
    assert "planarity" in failures(certificate)
    assert certificate.checks["planarity"].value == pytest.approx(2.5e-9, rel=0.2)
    assert certificate.checks["planarity"].worst == "facet 0, by its shortest edge"


# Holes.


def test_holes_are_counted_and_each_gets_itsstrip(tmp_path):
    doc = fold_file.document(seeds.grid((7, 9)))
    ring = [9, 10, 11, 20, 29, 28, 27, 18]  # around facet (2, 1), in the numbering of the whole grid
    removed = {19, 42}
    renumber = {f: f - sum(r < f for r in removed) for f in range(63)}
    other = [f + 23 for f in ring]
    strips = [[renumber[f] for f in strip] for strip in (ring, other)]
    doc = without_facets(doc, removed, strips)
    certificate = verdict(doc, tmp_path)
    assert certificate.certified, certificate.faults
    assert certificate.topology == "holes:2"
    assert [len(loop.facets) for loop in certificate.loops] == [8, 8]
    assert {frozenset(loop.facets) for loop in certificate.loops} == {frozenset(strip) for strip in strips}
    # Twice the same hole is not every hole; a strip around both is as good as one around the other.
    doc["bdffpq:holes"] = [strips[0], strips[0][::-1]]
    assert "do not go once around every hole" in verdict(doc, tmp_path).faults[0]


def test_strips_close_up_and_cross_the_cuts_once():
    doc = without_facets(fold_file.document(seeds.grid((9, 9))), {10, 16, 40, 64, 70}, [])
    mesh, _ = build_mesh(doc["faces_vertices"], len(doc["vertices_coords"]))
    windings = cut_open(mesh).windings
    turns = []
    for facets, edges in shortest_strips(mesh):
        sides = [set(side) for side in mesh.sides[edges].tolist()]
        assert sides == [{a, b} for a, b in zip(facets, np.roll(facets, -1), strict=True)]
        sign = np.where(mesh.sides[edges, 0] == facets, 1, -1)
        turns.append(sign @ windings[edges])
        assert np.count_nonzero(windings[edges].any(axis=1)) == 1
    assert len(turns) == 5
    assert abs(round(np.linalg.det(np.array(turns)))) == 1
    # A cut starts alone: the last edges of one may serve other holes too, its stretch does not.
    for hole, stretch in enumerate(cut_open(mesh).stretches):
        around = np.abs(windings[list(stretch)])
        assert around[:, hole].all()
        assert (around == around[0]).all()


def test_one_hinge_beside_a_hole_is_tied_by_the_strip_around_it():
    # The hinges between a hole and the outer rim meet no interior vertex.
    for words in (("FL", "FL"), ("CFL", "FL"), ("FL", "CFL")):
        design = generic(seeds.grid((4, 5), *words), 0.05)
        doc = without_facets(fold_file.document(design), {6}, [])
        doc = relabelled(doc, np.random.default_rng(1))
        structure = examine(frame_of(doc))
        motion = Motion(structure.mesh, structure.points, structure.types, *structure.halves)
        assert mobility.groups(structure.mesh)[0] == 5
        assert mobility.freedom(motion, shortest_strips(structure.mesh)) == 1
        assert mobility.freedom(motion, ()) == 5


# Crossing.


def test_facets_that_cross_in_the_design_state_are_named(tmp_path):
    certificate = verdict(strip(1.9, 4), tmp_path)
    assert certificate.checks["crossing_design"].value >= 1
    assert certificate.checks["crossing_design"].worst == "facets 0 and 3"
    assert certificate.free_range is None
    assert "crossing_design" in failures(certificate)


@pytest.mark.parametrize("kind", ["FL", "CFL"])
def test_the_first_crossing_of_the_motion_is_located(kind, tmp_path):
    # Three squares in a row, folded alike: the outer ones meet when the folds reach 120 degrees.
    doc = strip(np.radians(60), 3)
    doc["bdffpq:edges_type"] = [kind if word == "FL" else word for word in doc["bdffpq:edges_type"]]
    certificate = verdict(doc, tmp_path)
    assert certificate.checks["crossing_design"].passed
    touching = np.degrees(2 * np.arctan(np.tan(np.radians(60)) / np.tan(np.radians(30))))
    low, high = certificate.free_range
    if kind == "CFL":
        low, high = 180 - high, 180 - low
    assert low == 0.0
    assert touching - 0.01 <= high <= touching
    (crossing,) = certificate.crossings
    assert crossing.t in certificate.free_range
    assert crossing.facets == ((0, 2),)
    assert certificate.document()["crossings"] == [{"t": crossing.t, "facets": [[0, 2]]}]


def test_a_large_sheet_takes_seconds(tmp_path):
    path = tmp_path / "design.fold"
    fold_file.write(seeds.grid((32, 32)), path)
    start = time.perf_counter()
    certificate = certify.check(path)
    assert time.perf_counter() - start < 10  # 0.8 s measured
    assert certificate.certified
    assert certificate.checks["motion_gap"].value < 1e-12
