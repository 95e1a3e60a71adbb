"""Sound designs are certified; every single kind of fault is found and named."""

from __future__ import annotations

import json
import time
from itertools import combinations

import numpy as np
import pytest
from certify_cases import (
    FOUR_GON,
    SEEDS,
    SIX_GON,
    document,
    edge_index,
    failures,
    frame_of,
    generic,
    relabelled,
    verdict,
    without_facets,
)

from inverse import certify, fold_file, folding, geometry, seeds
from inverse.certify import mobility
from inverse.certify.certificate import LIMITS, judge
from inverse.certify.loops import cut_open, shortest_strips
from inverse.certify.measures import fold_halves
from inverse.certify.mesh import build_mesh
from inverse.certify.motion import Motion
from inverse.certify.structure import examine
from inverse.errors import InputError
from inverse.fold_format import read_frame

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
    assert certificate.checks["planarity"].worst == "facet 0"
    assert not failures(certificate) & {"developability", "flat_foldability", "loop_closure"}


@pytest.mark.parametrize(
    ("name", "failing", "keeping"),
    [("miura", "developability", "flat_foldability"), ("eggbox", "flat_foldability", "developability")],
)
def test_equations_6_and_7_are_told_apart(name, failing, keeping, tmp_path):
    # One vertex with four facets whose sector angles keep one of the two alternating sums only.
    a, b, c = 1.0, 1.3, 1.1
    d = a + c - b if name == "miura" else b + c - a
    sectors = [a, b, c, d]
    directions = _cone(sectors)
    points = np.vstack([np.zeros(3), directions, directions + np.roll(directions, -1, axis=0)])
    faces = [[0, 1 + k, 5 + k, 1 + (k + 1) % 4] for k in range(4)]
    types = ["FL"] * 4 if name == "miura" else ["FL", "CFL", "FL", "CFL"]
    certificate = verdict(_raw(points, faces, {(0, 1 + k): types[k] for k in range(4)}), tmp_path)
    assert certificate.faults == ()
    assert certificate.checks[failing].value > 1e-3
    assert certificate.checks[keeping].value < 1e-14
    assert certificate.checks[failing].worst == "vertex 0"
    assert "motion_gap" in failures(certificate)


def _cone(sectors):
    """Four unit vectors with the given angles between neighbours, (4, 3): two spherical triangles."""
    a, b, c, d = sectors
    diagonal = 1.4
    first, third = np.array([0.0, 0, 1]), np.array([np.sin(diagonal), 0, np.cos(diagonal)])

    def apex(near, far, side):
        cosine = (np.cos(far) - np.cos(near) * np.cos(diagonal)) / (np.sin(near) * np.sin(diagonal))
        sine = side * np.sqrt(1 - cosine**2)
        return np.array([np.sin(near) * cosine, np.sin(near) * sine, np.cos(near)])

    return np.array([first, apex(a, b, 1), third, apex(d, c, -1)])


def _raw(points, faces, types):
    """A document of a small mesh without claims; ``types`` of the interior edges."""
    mesh, _ = build_mesh(faces, len(points))
    rho = np.degrees(2 * np.arctan2(*fold_halves(mesh, points)))
    kind = [types.get(tuple(sorted(e)), "B") for e in mesh.edges.tolist()]
    return {
        "vertices_coords": points.tolist(),
        "edges_vertices": mesh.edges.tolist(),
        "edges_assignment": ["B" if k == "B" else "V" if r > 0 else "M" for k, r in zip(kind, rho, strict=True)],
        "edges_foldAngle": rho.tolist(),
        "faces_vertices": [list(face) for face in faces],
        "bdffpq:edges_type": kind,
    }


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
    certificate = verdict(_strip(np.radians(degrees), 2), tmp_path)
    assert certificate.checks["fold_angle"].value == pytest.approx(180 - abs(degrees))
    assert failures(certificate) == (set() if passes else {"fold_angle"})


# Spoilt topology, types and claims: name of a seed, change of its document, what the fault says.


def _edit(key, value):
    def change(doc):
        doc[key] = value

    return change


def _edge(a, b, **values):
    def change(doc):
        for key, value in values.items():
            doc[{"type": "bdffpq:edges_type", "word": "edges_assignment", "angle": "edges_foldAngle"}[key]][
                edge_index(doc, a, b)
            ] = value

    return change


def _flip_word(doc):
    k = edge_index(doc, 7, 8)
    doc["edges_assignment"][k] = "M" if doc["edges_assignment"][k] == "V" else "V"


def _flip_angle(doc):
    doc["edges_foldAngle"][edge_index(doc, 7, 8)] *= -1


def _nudge_angle(doc):
    doc["edges_foldAngle"][edge_index(doc, 7, 8)] += 1e-5


def _drop_edge(doc):
    for key in ("edges_vertices", "edges_assignment", "edges_foldAngle", "bdffpq:edges_type"):
        del doc[key][5]
    for frame in doc["file_frames"]:
        del frame["edges_foldAngle"][5]


def _add_edge(a, b):
    def change(doc):
        doc["edges_vertices"].append([a, b])
        doc["edges_foldAngle"].append(0.0)
        doc["edges_assignment"].append("B")
        doc["bdffpq:edges_type"].append("B")
        for frame in doc["file_frames"]:
            frame["edges_foldAngle"].append(0.0)

    return change


def _stretch(doc):
    doc["file_frames"][0]["vertices_coords"][3][0] += 1e-5


def _fold_half(doc):
    doc["file_frames"][0]["edges_foldAngle"][10] = 90.0


def _cut_off(doc):
    doc["file_frames"][1]["vertices_coords"].pop()


def _in_space(doc):
    frame = doc["file_frames"][1]
    frame["vertices_coords"] = [[*point, 1.0] for point in frame["vertices_coords"]]
    frame["vertices_coords"][0][2] += 1e-3


def _other_mesh(doc):
    doc["file_frames"][0]["faces_vertices"] = [[0, 1, 2]]


def _swap_frames(doc):
    developed, folded = doc["file_frames"]
    developed["frame_title"], folded["frame_title"] = "flat-folded", "developed"


def _swap_layouts(doc):
    developed, folded = doc["file_frames"]
    developed["vertices_coords"], folded["vertices_coords"] = (
        folded["vertices_coords"],
        developed["vertices_coords"],
    )


def _turn_facet(doc):
    doc["faces_vertices"][3].reverse()


def _repeat_vertex(doc):
    doc["faces_vertices"][3][1] = doc["faces_vertices"][3][0]


def _split_sheet(doc):
    doc["faces_vertices"] = [face for f, face in enumerate(doc["faces_vertices"]) if not 5 <= f < 10]


def _pinch(doc):
    doc["faces_vertices"] = [face for f, face in enumerate(doc["faces_vertices"]) if f in (0, 6)]


def _bow_tie(doc):
    face = doc["faces_vertices"][0]
    points = doc["vertices_coords"]
    # The corner vertex belongs to this facet only.
    a, b, c, d = (np.array(points[v]) for v in face)
    points[face[0]] = (b + 1.5 * (c - b) + 0.25 * (b - a) + 0.5 * (d - c)).tolist()


def _no_area(doc):
    b, c, d = doc["faces_vertices"][0][1:]
    points = np.array(doc["vertices_coords"])
    points[doc["faces_vertices"][0][0]] = (points[b] + points[d]) / 2
    points[c] = points[b] + 0.25 * (points[d] - points[b])
    doc["vertices_coords"] = points.tolist()


def _coincide(doc):
    doc["vertices_coords"][29] = doc["vertices_coords"][0]


def _no_edge(doc):
    doc["vertices_coords"][1] = doc["vertices_coords"][0]


def _new_vertex(doc):
    doc["vertices_coords"].append([0, 0, 0])
    for frame in doc["file_frames"]:
        frame["vertices_coords"].append([0, 0])


def _hole_claim(strips):
    return _edit("bdffpq:holes", strips)


FAULTS = {
    "one edge of another type": ("miura", _edge(7, 8, type="CFL"), "opposite ones must be of one type"),
    "inside typed B": ("miura", _edge(7, 8, type="B"), "edge 7-8 lies inside and is typed B"),
    "boundary typed FL": ("miura", _edge(0, 1, type="FL"), "edge 0-1 lies on the boundary and is typed FL"),
    "inside assigned B": ("miura", _edge(7, 8, word="B"), "edge 7-8 lies inside and is assigned B"),
    "boundary assigned M": ("miura", _edge(0, 1, word="M"), "lies on the boundary and is assigned M"),
    "boundary folded": ("miura", _edge(0, 1, angle=3.0), "edge 0-1 has a fold angle of 3 degrees"),
    "mountain for valley": ("miura", _flip_word, "edge 7-8 is assigned"),
    "fold angle of the other sign": ("miura", _flip_angle, "edge 7-8 has a fold angle"),
    "fold angle a little off": ("miura", _nudge_angle, "edge 7-8 has a fold angle"),
    "edge missing": ("miura", _drop_edge, "is not listed"),
    "edge twice": ("miura", _add_edge(1, 0), "edge 0-1 is listed twice"),
    "edge to nowhere": ("miura", _add_edge(0, 29), "joins vertices 0 and 29, which no facet joins"),
    "edge to itself": ("miura", _add_edge(4, 4), "joins vertices 4 and 4, which no facet joins"),
    "facet turned over": ("miura", _turn_facet, "no oriented manifold"),
    "vertex twice in a facet": ("miura", _repeat_vertex, "3 or more different ones are needed"),
    "two sheets": ("miura", _split_sheet, "is not connected to facet 0"),
    "facets that meet in a vertex": ("miura", _pinch, "is not connected to facet 0"),
    "vertex of no facet": ("miura", _new_vertex, "vertex 30 belongs to no facet"),
    "bow-tie facet": ("miura", _bow_tie, "facet 0 is not simple and convex"),
    "facet without area": ("miura", _no_area, "facet 0 has no area"),
    "coincident vertices": ("miura", _coincide, "vertices 0 and 29 coincide"),
    "edge without length": ("miura", _no_edge, "edge 0-1 has no length"),
    "wrong topology claimed": ("miura", _edit("bdffpq:topology", "cylinder"), "the facets form a disk"),
    "holes claimed for a disk": ("miura", _hole_claim([[0, 1, 2]]), "1 strips, but the surface has 0 holes"),
    "no holes claimed for a tube": ("6-gon tube", _hole_claim([]), "0 strips, but the surface has 1 holes"),
    "strip with a gap": ("6-gon tube", _hole_claim([[0, 4, 8, 12, 16]]), "is no closed strip"),
    "strip around nothing": ("6-gon tube", _hole_claim([[0, 4, 5, 1]]), "do not go once around every hole"),
    "strip twice around": ("6-gon tube", _hole_claim([[0, 4, 8, 12, 16, 20] * 2]), "do not go once around"),
    "strip of words": ("6-gon tube", _hole_claim([["0"]]), "is no list of facets"),
    "grid of another size": ("miura", _edit("bdffpq:grid", [5, 5]), "5 x 5, but there are 20 facets"),
    "grid of another shape": ("miura", _edit("bdffpq:grid", [5, 4]), "of the 5 x 4 grid"),
    "grid of words": ("miura", _edit("bdffpq:grid", ["4", None]), "two numbers of facets are needed"),
    "developed state stretched": ("miura", _stretch, "the developed frame changes the distance"),
    "developed angle wrong": ("eggbox", _fold_half, "the developed frame folds"),
    "flat-folded state too short": ("miura", _cut_off, "the flat-folded frame needs coordinates"),
    "flat-folded state not flat": ("miura", _in_space, "the flat-folded frame is not flat"),
    "flat states exchanged": ("eggbox", _swap_frames, "the flat-folded frame folds"),
    "layouts exchanged": ("eggbox", _swap_layouts, "wrong side up"),
    "frames of another mesh": ("miura", _other_mesh, "the developed frame has its own faces_vertices"),
    "frames are no list": ("miura", _edit("file_frames", 3), "file_frames is no list"),
}  # fmt: skip


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_of_structure_are_named(fault, tmp_path):
    name, change, words = FAULTS[fault]
    doc = document(name)
    change(doc)
    certificate = verdict(doc, tmp_path)
    assert not certificate.certified
    assert any(words in sentence for sentence in certificate.faults), certificate.faults
    assert certificate.checks["structure"].value == len(certificate.faults)
    assert certificate.checks["structure"].worst == certificate.faults[0]


def test_a_wrong_type_breaks_the_motion_as_well(tmp_path):
    doc = document("miura")
    doc["bdffpq:edges_type"][edge_index(doc, 7, 8)] = "CFL"
    certificate = verdict(doc, tmp_path)
    assert failures(certificate) == {"structure", "developability", "flat_foldability", "motion_gap"}
    assert certificate.checks["motion_gap"].value > 1e-3


def test_a_whole_line_of_the_wrong_type_is_sound_but_does_not_move(tmp_path):
    doc = document("miura")
    for j in range(5):
        k = edge_index(doc, 12 + j, 13 + j)
        doc["bdffpq:edges_type"][k] = "CFL"
    # The flat states, which now are different ones, are left out.
    del doc["file_frames"]
    certificate = verdict(doc, tmp_path)
    assert certificate.faults == ()
    assert failures(certificate) == {"flat_foldability", "motion_gap"}


def test_flipped_mountains_are_a_fault_of_structure_only(tmp_path):
    doc = document("eggbox")
    doc["edges_assignment"] = [{"M": "V", "V": "M", "B": "B"}[word] for word in doc["edges_assignment"]]
    del doc["file_frames"]
    assert failures(verdict(doc, tmp_path)) == {"structure"}


def test_seen_from_the_other_side_valleys_are_mountains(tmp_path):
    doc = document("hybrid")
    for face in doc["faces_vertices"]:
        face.reverse()
    doc["edges_assignment"] = [{"M": "V", "V": "M", "B": "B"}[word] for word in doc["edges_assignment"]]
    for frame in [doc, *doc["file_frames"]]:
        frame["edges_foldAngle"] = [-angle for angle in frame["edges_foldAngle"]]
    del doc["bdffpq:grid"]
    certificate = verdict(doc, tmp_path)
    assert certificate.certified, certificate.faults


def test_a_pinched_surface_is_named(tmp_path):
    # Four facets around in a ring whose first and last meet the others in a vertex only.
    doc = document("miura")
    doc["faces_vertices"] = [face for f, face in enumerate(doc["faces_vertices"]) if f not in (6, 12)]
    certificate = verdict(doc, tmp_path)
    assert any("the surface touches itself at vertex 14" in sentence for sentence in certificate.faults)


def test_a_pentagram_turns_twice(tmp_path):
    angle = 2 * np.pi / 5 * np.arange(5)
    points = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    doc = _raw(np.vstack([points, [0, 1, 1]]), [[0, 1, 2, 3, 4], [1, 0, 5]], {(0, 1): "FL"})
    assert verdict(doc, tmp_path).certified
    star = [0, 3, 1, 4, 2]  # the same five edges in another order of vertices
    doc["vertices_coords"] = np.vstack([points[star], [0, 1, 1]]).tolist()
    assert any("facet 0 is not simple and convex" in fault for fault in verdict(doc, tmp_path).faults)


def test_a_vertex_of_degree_three_is_named(tmp_path):
    # A cube's corner: three squares around vertex 0.
    x, y, z = np.eye(3)
    points = np.array([0 * x, x, y, z, x + y, y + z, z + x])
    faces = [[0, 1, 4, 2], [0, 2, 5, 3], [0, 3, 6, 1]]
    certificate = verdict(_raw(points, faces, {(0, 1): "FL", (0, 2): "FL", (0, 3): "FL"}), tmp_path)
    assert certificate.faults == ("interior vertex 0 has 3 edges: 4 are needed",)
    assert "motion_gap" in failures(certificate)


def test_fold_lines_that_no_vertex_joins_are_more_than_one_motion(tmp_path):
    certificate = verdict(fold_file.document(seeds.grid((3, 1))), tmp_path)
    assert failures(certificate) == {"structure"}
    assert "there are 2 independent motions" in certificate.faults[0]
    assert "edge 2-3 and edge 4-5" in certificate.faults[0]
    assert "nothing folds" in verdict(fold_file.document(seeds.grid((1, 1))), tmp_path).faults[0]


def test_strips_around_holes_tie_fold_lines_too(tmp_path):
    # One row of a tube is a planar linkage: k parallel hinges leave k - 3 motions, one for the four-bar.
    assert verdict(fold_file.document(seeds.tube(FOUR_GON, 1)), tmp_path).certified
    certificate = verdict(fold_file.document(seeds.tube(SIX_GON, 1)), tmp_path)
    assert failures(certificate) == {"structure"}
    assert "there are 3 independent motions" in certificate.faults[0]


def test_closed_surfaces_are_refused(tmp_path):
    x, y, z = np.eye(3)
    points = np.array([x, y, -x, -y, z, -z])
    faces = [[k, (k + 1) % 4, 4] for k in range(4)] + [[(k + 1) % 4, k, 5] for k in range(4)]
    types = {tuple(sorted(pair)): "FL" for face in faces for pair in combinations(face, 2)}
    certificate = verdict(_raw(points, faces, types), tmp_path)
    assert certificate.faults[0] == "the surface is no disk, with or without holes"
    assert certificate.topology == "unknown"
    assert certificate.checks["loop_closure"].value is None


# Holes.


def test_holes_are_counted_and_each_gets_its_strip(tmp_path):
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
    certificate = verdict(_strip(1.9, 4), tmp_path)
    assert certificate.checks["crossing_design"].value >= 1
    assert certificate.checks["crossing_design"].worst == "facets 0 and 3"
    assert certificate.free_range is None
    assert "crossing_design" in failures(certificate)


def _strip(rho, count):
    """Unit squares in a row, the folds between them all of ``rho`` radians, typed FL."""
    headings = rho * np.arange(count)
    steps = np.stack([np.cos(headings), np.sin(headings), 0 * headings], axis=1)
    bottom = np.vstack([np.zeros(3), np.cumsum(steps, axis=0)])
    top = count + 1
    points = np.vstack([bottom, bottom + np.array([0, 0, 1])])
    faces = [[k, k + 1, top + k + 1, top + k] for k in range(count)]
    return _raw(points, faces, {(k, top + k): "FL" for k in range(1, count)})


@pytest.mark.parametrize("kind", ["FL", "CFL"])
def test_the_first_crossing_of_the_motion_is_located(kind, tmp_path):
    # Three squares in a row, folded alike: the outer ones meet when the folds reach 120 degrees.
    doc = _strip(np.radians(60), 3)
    doc["bdffpq:edges_type"] = [kind if word == "FL" else word for word in doc["bdffpq:edges_type"]]
    certificate = verdict(doc, tmp_path)
    assert certificate.checks["crossing_design"].passed
    touching = np.degrees(2 * np.arctan(np.tan(np.radians(60)) / np.tan(np.radians(30))))
    low, high = certificate.free_range
    if kind == "CFL":
        low, high = 180 - high, 180 - low
    assert low == 0.0
    assert touching - 0.01 <= high <= touching


def test_a_large_sheet_takes_seconds(tmp_path):
    path = tmp_path / "design.fold"
    fold_file.write(seeds.grid((32, 32)), path)
    start = time.perf_counter()
    certificate = certify.check(path)
    assert time.perf_counter() - start < 10  # 0.8 s measured
    assert certificate.certified
    assert certificate.checks["motion_gap"].value < 1e-12
