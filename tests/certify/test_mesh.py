"""Topology and shape: every fault is told, not only the first or the last, and up to the tolerances."""

from __future__ import annotations

import numpy as np
import pytest
from certify_cases import document, edge_index, failures, frame_of, raw

from inverse import certify
from inverse.certify.mesh import build_mesh
from inverse.certify.structure import examine

JUST = [0.9, 1.1]  # of a tolerance


def _grid(m, n, around=False):
    """Facets of an m x n grid, closed in both directions if ``around``."""
    if around:
        at = [[i % m * n + j % n for j in range(n + 1)] for i in range(m + 1)]
    else:
        at = [[i * (n + 1) + j for j in range(n + 1)] for i in range(m + 1)]
    return [[at[i][j], at[i + 1][j], at[i + 1][j + 1], at[i][j + 1]] for i in range(m) for j in range(n)]


def _built(faces, n_vertices=None):
    return build_mesh(faces, 1 + max(v for face in faces for v in face) if n_vertices is None else n_vertices)


# Surfaces.


@pytest.mark.parametrize(
    ("removed", "n_holes", "topology"),
    [
        ((), 0, "disk"),
        ((8,), 1, "cylinder"),
        ((8, 10), 2, "holes:2"),
        ((8, 10, 12), 3, "holes:3"),
        ((8, 9), 1, "cylinder"),
        ((0, 10), 1, "cylinder"),
        ((0,), 0, "disk"),
    ],
)
def test_holes_are_counted(removed, n_holes, topology):
    mesh, faults = _built([face for f, face in enumerate(_grid(3, 7)) if f not in removed], 32)
    assert mesh.n_holes == n_holes
    assert mesh.topology == topology
    assert len(faults) == len(set(range(32)) - set(mesh.tail.tolist()))
    assert len(mesh.interior_vertices) == 12 - len(set(mesh.edges[mesh.sides[:, 1] < 0].ravel()) & INTERIOR)
    assert len(mesh.off_tree) == len(mesh.inner) - len(mesh.facets) + 1
    assert set(mesh.degrees.tolist()) <= {4}


INTERIOR = {i * 8 + j for i in (1, 2) for j in range(1, 7)}


@pytest.mark.parametrize("removed", [(), (4,), (0, 7)])
def test_surfaces_with_a_handle_are_none_of_ours(removed):
    mesh, _ = _built([face for f, face in enumerate(_grid(3, 5, around=True)) if f not in removed])
    assert mesh.n_holes is None
    assert mesh.topology == "unknown"


def test_every_piece_and_every_pinch_is_named():
    faces = _grid(3, 7)
    mesh, faults = _built([face for f, face in enumerate(faces) if f not in (1, 8, 15, 3, 10, 17)])
    assert mesh is None
    assert [fault for fault in faults if "not connected" in fault] == [
        "facet 1 is not connected to facet 0 by shared edges",
        "facet 2 is not connected to facet 0 by shared edges",
    ]
    # Holes that meet in a vertex, one after the other.
    mesh, faults = _built([face for f, face in enumerate(_grid(6, 6)) if f not in (7, 14, 16, 21)])
    assert mesh is None
    assert faults == [f"the surface touches itself at vertex {v}" for v in (16, 24, 25)]


def test_facets_that_are_none_and_vertices_without_are_named():
    assert build_mesh([], 3) == (None, ["there are no facets"])
    for face, good in (([0, 1, 2], True), ([0, 1], False), ([0, 1, 2, 0], False), ([3, 3, 4], False), ([0], False)):
        _, faults = build_mesh([[0, 1, 2], [1, 0, 3], face] if not good else [face], 3 if good else 5)
        assert faults == ([] if good else [f"facet 2 has vertices {face}: 3 or more different ones are needed"])
    _, faults = build_mesh([[0, 1], [2, 3], [0, 1, 2]], 4)
    assert [fault.split(" has")[0] for fault in faults] == ["facet 0", "facet 1"]
    _, faults = build_mesh([[1, 2, 4]], 6)
    assert faults == [f"vertex {v} belongs to no facet" for v in (0, 3, 5)]


def test_every_edge_that_runs_twice_is_named():
    mesh, faults = build_mesh([[0, 1, 2], [0, 1, 3], [5, 6, 4], [7, 5, 6]], 8)
    assert mesh is None
    assert [fault.split(":")[0] for fault in faults] == [
        "facets 0 and 1 both run from vertex 0 to 1",
        "facets 2 and 3 both run from vertex 5 to 6",
    ]


def test_half_edges_of_a_facet_and_its_neighbours():
    faces = [[0, 1, 2], [1, 0, 3, 4], [2, 1, 5, 6, 7]]
    mesh, faults = _built(faces)
    assert faults == []
    for h, (tail, head) in enumerate(zip(mesh.tail.tolist(), mesh.head.tolist(), strict=True)):
        face = faces[mesh.facet[h]]
        assert face[(face.index(tail) + 1) % len(face)] == head
        assert mesh.head[mesh.previous[h]] == tail
        assert mesh.facet[mesh.previous[h]] == mesh.facet[h]
        beyond = [f for f, other in enumerate(faces) if f != mesh.facet[h] and {tail, head} <= set(other)]
        assert mesh.twin[h] == -1 if not beyond else mesh.facet[mesh.twin[h]] == beyond[0]
        assert set(mesh.edges[mesh.edge_of[h]].tolist()) == {tail, head}
    assert sorted(map(tuple, np.sort(mesh.sides[mesh.inner], axis=1).tolist())) == [(0, 1), (0, 2)]
    # Each edge runs with its left facet on the left.
    for (a, b), (left, _) in zip(mesh.edges.tolist(), mesh.sides.tolist(), strict=True):
        assert faces[left][(faces[left].index(a) + 1) % len(faces[left])] == b


def test_rings_run_once_around_every_interior_vertex():
    mesh, _ = _built(_grid(4, 5))
    for vertex, ring in zip(mesh.interior_vertices, mesh.rings, strict=True):
        assert set(mesh.tail[ring].tolist()) == {vertex}
        assert len(set(mesh.head[ring].tolist())) == 4
        # Counter-clockwise: the facet on the left of one edge lies on the right of the next one.
        assert mesh.facet[mesh.twin[np.roll(ring, -1)]].tolist() == mesh.facet[ring].tolist()


def test_the_tree_reaches_every_facet_by_the_shortest_way():
    mesh, _ = _built(_grid(5, 5))
    depth = {0: 0}
    for level, (facets, parents, edges) in enumerate(mesh.tree, 1):
        for facet, parent, edge in zip(facets.tolist(), parents.tolist(), edges, strict=True):
            assert set(mesh.sides[edge].tolist()) == {facet, parent}
            assert depth[parent] == level - 1
            assert facet not in depth
            depth[facet] = level
    assert depth == {5 * i + j: i + j for i in range(5) for j in range(5)}


# What the file says of the edges.


def test_every_edge_that_is_wrong_is_named():
    doc = document("miura")
    for pair in ((7, 8), (20, 21)):
        doc["bdffpq:edges_type"][edge_index(doc, *pair)] = "B"
    for pair in ((0, 1), (28, 29)):
        doc["bdffpq:edges_type"][edge_index(doc, *pair)] = "CFL"
    for pair in ((13, 14), (21, 22)):
        doc["edges_assignment"][edge_index(doc, *pair)] = "B"
    for pair in ((1, 2), (27, 28)):
        doc["edges_assignment"][edge_index(doc, *pair)] = "V"
    faults = examine(frame_of(doc)).faults
    for words, pairs in (
        ("lies inside and is typed B: FL or CFL is needed", ("7-8", "20-21")),
        ("lies on the boundary and is typed CFL: B is needed", ("0-1", "28-29")),
        ("lies inside and is assigned B: M or V is needed", ("13-14", "21-22")),
        ("lies on the boundary and is assigned V: B is needed", ("1-2", "27-28")),
    ):
        assert [fault for fault in faults if words in fault] == [f"edge {pair} {words}" for pair in pairs]


@pytest.mark.parametrize("pair", [(7, 8), (20, 21)])
def test_without_a_type_of_every_edge_there_is_no_motion(pair):
    doc = document("miura")
    doc["bdffpq:edges_type"][edge_index(doc, *pair)] = "B"
    certificate = certify.check_frame(frame_of(doc))
    unmeasured = {"developability", "flat_foldability", "motion_gap", "loop_closure"}
    assert failures(certificate) == {"structure", *unmeasured}
    assert all(certificate.checks[name].value is None for name in unmeasured)
    assert certificate.free_range is None


def test_edges_listed_twice_or_for_nothing_are_all_named():
    doc = document("miura")
    for pair in ((0, 1), (29, 28), (0, 29), (3, 25)):
        doc["edges_vertices"].append(list(pair))
        doc["edges_foldAngle"].append(0.0)
        doc["edges_assignment"].append("B")
        doc["bdffpq:edges_type"].append("B")
    count = len(doc["edges_vertices"]) - 4
    del doc["file_frames"]
    first = edge_index(doc, 0, 1), edge_index(doc, 28, 29)
    assert examine(frame_of(doc)).faults == [
        f"edge 0-1 is listed twice, as edges {first[0]} and {count}",
        f"edge 28-29 is listed twice, as edges {first[1]} and {count + 1}",
        f"edge {count + 2} joins vertices 0 and 29, which no facet joins",
        f"edge {count + 3} joins vertices 3 and 25, which no facet joins",
    ]


def test_every_vertex_of_two_kinds_of_lines_is_named():
    doc = document("miura")
    for pair in ((7, 8), (20, 21)):
        doc["bdffpq:edges_type"][edge_index(doc, *pair)] = "CFL"
    structure = examine(frame_of(doc))
    assert [fault.split(" has edges")[0] for fault in structure.faults] == [f"vertex {v}" for v in (7, 8, 20, 21)]
    assert structure.signs == (None, None)


# Shapes.


def _pair(shape, facet=1):
    """A document of a plane polygon in x >= 0 from (0, 0) to (0, 1), and a square folded up behind the edge between."""
    points = np.array([[0, 0, 0], [0, 1, 0], [-0.5, 1, 0.8], [-0.5, 0, 0.8], *((x, y, 0) for x, y in shape)], float)
    polygon = [1, 0, *range(4, len(points))]
    square = [0, 1, 2, 3]
    return raw(points, [square, polygon] if facet == 1 else [polygon, square], {(0, 1): "FL"})


def _shape_faults(shape, facet=1):
    return examine(frame_of(_pair(shape, facet))).faults


@pytest.mark.parametrize("facet", [0, 1])
@pytest.mark.parametrize(
    ("turn", "good"), [(1.1e-9, True), (0.9e-9, False), (-0.9e-9, False), (-1.1e-9, False), (-0.1, False)]
)
def test_a_facet_turns_at_every_vertex(turn, good, facet):
    # A vertex in the middle of a side of length 1, off it so that the side turns there.
    faults = _shape_faults([(1, 0), (1 + np.tan(turn / 2) / 2, 0.5), (1, 1)], facet)
    assert faults == ([] if good else [f"facet {facet} is not simple and convex, see its corner at vertex 5"])


@pytest.mark.parametrize(("angle", "good"), [(1.1e-9, True), (0.9e-9, False)])
def test_a_facet_turns_back_at_none(angle, good):
    # A needle; a shorter edge would coincide with its end, and with it the needle's own end.
    faults = _shape_faults([(1 / angle, 0.5)])
    assert any("facet 1 is not simple and convex" in fault for fault in faults) == (not good)


@pytest.mark.parametrize("share", JUST)
def test_a_facet_has_an_area(share):
    # A triangle over the edge of length 1, so low that only its area tells: no corner of it turns enough either.
    faults = _shape_faults([(share * 1e-12, 0.5)])
    assert faults[-1].startswith("facet 1 has no area" if share < 1 else "facet 1 is not simple and convex")


@pytest.mark.parametrize("share", JUST)
@pytest.mark.parametrize("place", ["first", "last"])
def test_vertices_coincide_within_a_billionth_of_the_diagonal(place, share):
    # Two vertices that no edge joins: opposite corners of a sheet rolled up.
    doc = document("miura")
    points = np.array(doc["vertices_coords"])
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    a, b = (0, 14) if place == "first" else (29, 15)
    points[a] = points[b] + np.array([0, 0, share * 1e-9 * diagonal])
    doc["vertices_coords"] = points.tolist()
    now = np.linalg.norm(np.ptp(points, axis=0))
    points[a, 2] = points[b, 2] + share * 1e-9 * now
    doc["vertices_coords"] = points.tolist()
    faults = [fault for fault in examine(frame_of(doc)).faults if "coincide" in fault]
    assert faults == ([f"vertices {min(a, b)} and {max(a, b)} coincide"] if share < 1 else [])


def test_all_pairs_of_vertices_that_coincide_are_named():
    doc = document("miura")
    for a, b in ((0, 14), (29, 15), (5, 26)):
        doc["vertices_coords"][a] = doc["vertices_coords"][b]
    faults = [fault for fault in examine(frame_of(doc)).faults if "coincide" in fault]
    assert faults == ["vertices 0 and 14 coincide", "vertices 5 and 26 coincide", "vertices 15 and 29 coincide"]
    doc = document("miura")
    doc["vertices_coords"] = [[1.0, 2.0, 3.0]] * 30
    assert "all vertices coincide" in examine(frame_of(doc)).faults


@pytest.mark.parametrize("share", JUST)
@pytest.mark.parametrize("pair", [(0, 1), (29, 28)])
def test_edges_have_a_length(pair, share):
    doc = document("miura")
    points = np.array(doc["vertices_coords"])
    a, b = pair
    points[a] = points[b]
    along = np.array([0.0, 0, 1])
    points[a] = points[b] + share * 1e-9 * np.linalg.norm(np.ptp(points, axis=0)) * along
    doc["vertices_coords"] = points.tolist()
    faults = [fault for fault in examine(frame_of(doc)).faults if "has no length" in fault]
    assert faults == ([f"edge {min(pair)}-{max(pair)} has no length"] if share < 1 else [])


def test_every_facet_that_is_none_is_named():
    doc = document("miura")
    points = np.array(doc["vertices_coords"])
    for corner, beyond in ((0, 7), (29, 22)):
        points[corner] = points[beyond] + 0.5 * (points[beyond] - points[corner])  # through the opposite corner
    doc["vertices_coords"] = points.tolist()
    structure = examine(frame_of(doc))
    named = [fault.split(",")[0] for fault in structure.faults if "is not simple and convex" in fault]
    assert named == ["facet 0 is not simple and convex", "facet 19 is not simple and convex"]
    assert structure.halves is None
