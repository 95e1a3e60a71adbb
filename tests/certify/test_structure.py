"""Every fault of topology, line types, facets and claims is found and named."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from certify_cases import FOUR_GON, SIX_GON, document, edge_index, failures, raw, verdict

from inverse.files import fold_file
from inverse.origami import seeds


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
    doc = raw(np.vstack([points, [0, 1, 1]]), [[0, 1, 2, 3, 4], [1, 0, 5]], {(0, 1): "FL"})
    assert verdict(doc, tmp_path).certified
    star = [0, 3, 1, 4, 2]  # the same five edges in another order of vertices
    doc["vertices_coords"] = np.vstack([points[star], [0, 1, 1]]).tolist()
    assert any("facet 0 is not simple and convex" in fault for fault in verdict(doc, tmp_path).faults)


def test_a_vertex_of_degree_three_is_named(tmp_path):
    # A cube's corner: three squares around vertex 0.
    x, y, z = np.eye(3)
    points = np.array([0 * x, x, y, z, x + y, y + z, z + x])
    faces = [[0, 1, 4, 2], [0, 2, 5, 3], [0, 3, 6, 1]]
    certificate = verdict(raw(points, faces, {(0, 1): "FL", (0, 2): "FL", (0, 3): "FL"}), tmp_path)
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
    certificate = verdict(raw(points, faces, types), tmp_path)
    assert certificate.faults[0] == "the surface is no disk, with or without holes"
    assert certificate.topology == "unknown"
    assert certificate.checks["loop_closure"].value is None
