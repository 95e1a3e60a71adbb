"""What a file claims beside its design state is held against it in every place, up to the tolerances and no further."""

from __future__ import annotations

import numpy as np
import pytest
from certify_cases import document, edge_index, frame_of, hinged, without_facets

from inverse.certify import claims
from inverse.certify.structure import examine
from inverse.files import fold_file
from inverse.origami import seeds

JUST = [0.9, 1.1]  # of a tolerance


def _faults(doc):
    frame = frame_of(doc)
    structure = examine(frame)
    return tuple(structure.faults + claims.faults(structure, frame))


def _diagonal(doc):
    return float(np.linalg.norm(np.ptp(np.array(doc["vertices_coords"]), axis=0)))


# Fold angles and their signs.


@pytest.mark.parametrize("share", [*JUST, -JUST[0], -JUST[1]])
@pytest.mark.parametrize("place", [0, 10, -1])
def test_a_fold_angle_must_be_the_one_of_the_vertices_to_a_millionth_of_a_degree(place, share):
    doc = document("miura")
    doc["edges_foldAngle"][place] += share * 1e-6
    faults = _faults(doc)
    assert len(faults) == (abs(share) > 1)
    a, b = sorted(doc["edges_vertices"][place])
    assert all(fault.startswith(f"edge {a}-{b} has a fold angle of ") for fault in faults)


def test_every_wrong_edge_is_named_whatever_is_missing_beside():
    doc = document("miura")
    wrong = [edge_index(doc, *pair) for pair in ((7, 8), (21, 22))]
    for k in wrong:
        doc["edges_assignment"][k] = {"M": "V", "V": "M"}[doc["edges_assignment"][k]]
    for k in (5, 0):
        for key in ("edges_vertices", "edges_assignment", "edges_foldAngle", "bdffpq:edges_type"):
            del doc[key][k]
    del doc["file_frames"]
    faults = _faults(doc)
    assert sum("is not listed" in fault for fault in faults) == 2
    assert [fault.split(" is assigned")[0] for fault in faults if "is assigned" in fault] == ["edge 7-8", "edge 21-22"]


@pytest.mark.parametrize(
    ("degrees", "matters"), [(9e-7, False), (1.1e-6, True), (180 - 9e-7, False), (180 - 1.1e-6, True)]
)
@pytest.mark.parametrize("sign", [1, -1])
def test_mountain_or_valley_says_nothing_where_the_sheet_is_flat(degrees, matters, sign):
    doc = hinged([sign * np.radians(degrees)], [1.0, 1.0])
    k = edge_index(doc, 1, 4)
    true = doc["edges_assignment"][k]
    assert _faults(doc) == ()
    doc["edges_assignment"][k] = {"M": "V", "V": "M"}[true]
    name = {"M": "mountain", "V": "valley"}[true]
    assert len(_faults(doc)) == matters
    assert all(f"edge 1-4 is assigned {doc['edges_assignment'][k]}, but it is a {name}" in x for x in _faults(doc))


def test_an_edge_that_is_said_to_be_no_fold_is_one_fault():
    doc = document("miura")
    del doc["file_frames"]
    doc["edges_assignment"][edge_index(doc, 7, 8)] = "B"
    assert _faults(doc) == ("edge 7-8 lies inside and is assigned B: M or V is needed",)


# Flat states.


FRAMES = {"developed": 0, "flat-folded": 1}


def _scaled(doc, title, change):
    """The document with flat coordinates changed; ``change`` in diagonals."""
    frame = doc["file_frames"][FRAMES[title]]
    assert frame["frame_title"] == title
    points = np.array(frame["vertices_coords"], float) / _diagonal(doc)
    frame["vertices_coords"] = (change(points) * _diagonal(doc)).tolist()
    return _faults(doc)


@pytest.mark.parametrize("share", JUST)
@pytest.mark.parametrize("title", FRAMES)
@pytest.mark.parametrize(("vertex", "sign"), [(0, 1), (0, -1), (29, 1), (29, -1)])
def test_distances_within_facets_hold_to_a_ten_millionth_of_the_diagonal(vertex, sign, title, share):
    def change(points):
        inwards = points[{0: 7, 29: 22}[vertex]] - points[vertex]
        points[vertex] += sign * share * 1e-7 * inwards / np.linalg.norm(inwards)
        return points

    faults = _scaled(document("miura"), title, change)
    assert len(faults) == (share > 1)
    # The diagonal of the facet changes most.
    pair = {0: "0 and 7", 29: "22 and 29"}[vertex]
    assert all(f"the {title} frame changes the distance of vertices {pair} of a facet by 1.1e-07" in x for x in faults)


@pytest.mark.parametrize("title", FRAMES)
def test_sides_alone_do_not_make_a_facet(title):
    # A row of parallelograms sheared: every edge keeps its length, the diagonals do not.
    doc = fold_file.document(seeds.grid((1, 4)))
    del doc["bdffpq:grid"]

    def change(points):
        low, high = points[:5], points[5:].copy()
        arm = high - low
        turn = np.array([[np.cos(0.01), np.sin(0.01)], [-np.sin(0.01), np.cos(0.01)]])
        return np.vstack([low, low + arm[:, :2] @ turn])

    faults = _scaled(doc, title, change)
    assert any(f"the {title} frame changes the distance" in fault for fault in faults)


@pytest.mark.parametrize("share", JUST)
@pytest.mark.parametrize("title", FRAMES)
def test_a_flat_state_is_flat_to_a_ten_millionth_of_the_diagonal(title, share):
    def change(points):
        heights = np.zeros(len(points))
        heights[-1] = share * 1e-7
        return np.column_stack([points, 3 + heights])

    faults = _scaled(document("miura"), title, change)
    assert faults == ((f"the {title} frame is not flat",) if share > 1 else ())


@pytest.mark.parametrize("title", FRAMES)
@pytest.mark.parametrize("place", [0, 7, -1])
@pytest.mark.parametrize("bad", ["short", "long", "text", "true", "infinite", "huge", "none", "uneven", "four"])
def test_coordinates_that_are_none(title, place, bad):
    doc = document("miura")
    rows = doc["file_frames"][FRAMES[title]]["vertices_coords"]
    if bad in ("short", "long"):
        rows[:] = rows[:-1] if bad == "short" else [*rows, rows[0]]
    elif bad in ("uneven", "four"):
        for row in [rows[place]] if bad == "uneven" else rows:
            row += [0.0] * (4 - len(row) if bad == "four" else 1)
    else:
        rows[place][1] = {"text": "0", "true": True, "infinite": float("inf"), "huge": 10**400, "none": None}[bad]
    assert _faults(doc) == (f"the {title} frame needs coordinates of every vertex",)


@pytest.mark.parametrize("title", FRAMES)
def test_flat_states_may_be_mirrored_moved_and_in_space(title):
    for change in (
        lambda p: p * [-1, 1],
        lambda p: p + np.array([5, -7]),
        lambda p: np.column_stack([p, np.full(len(p), 2.0)]),
        lambda p: p @ np.array([[0.6, 0.8], [-0.8, 0.6]]),
    ):
        assert _scaled(document("miura"), title, change) == ()


@pytest.mark.parametrize("title", FRAMES)
@pytest.mark.parametrize("last", [False, True])
def test_one_facet_on_the_wrong_side_is_named(title, last):
    # The facet at the end of a row mirrored in its edge to the next one.
    doc = fold_file.document(seeds.grid((1, 4)))
    del doc["bdffpq:grid"]
    free, hinge = ([4, 9], [3, 8]) if last else ([0, 5], [1, 6])

    def change(points):
        points = points[:, :2]
        start, along = points[hinge[0]], points[hinge[1]] - points[hinge[0]]
        for v in free:
            arm = points[v] - start
            points[v] = start + 2 * (arm @ along) / (along @ along) * along - arm
        return points

    # Sides are told relative to facet 0.
    assert f"the {title} frame has facet {3 if last else 1} wrong side up" in _scaled(doc, title, change)


@pytest.mark.parametrize("title", FRAMES)
@pytest.mark.parametrize("share", JUST)
@pytest.mark.parametrize("place", [0, 24, -1])
@pytest.mark.parametrize("sign", [1, -1])
def test_fold_angles_of_flat_states_hold_to_a_millionth_of_a_degree(title, share, place, sign):
    doc = document("eggbox")
    doc["file_frames"][FRAMES[title]]["edges_foldAngle"][place] += sign * share * 1e-6
    faults = _faults(doc)
    assert len(faults) == (share > 1)
    a, b = sorted(doc["edges_vertices"][place])
    assert all(fault.startswith(f"the {title} frame folds edge {a}-{b} by ") for fault in faults)


@pytest.mark.parametrize("title", FRAMES)
@pytest.mark.parametrize("angles", [None, 3, [], ["0"] * 49, [0.0] * 48, [0.0] * 50])
def test_fold_angles_of_flat_states_that_are_none(title, angles):
    doc = document("eggbox")
    doc["file_frames"][FRAMES[title]]["edges_foldAngle"] = angles
    assert _faults(doc) == (f"the {title} frame needs a fold angle for each edge",)


def test_without_fold_angles_a_flat_state_is_its_coordinates():
    doc = document("eggbox")
    for frame in doc["file_frames"]:
        del frame["edges_foldAngle"]
    assert _faults(doc) == ()
    doc["file_frames"][1]["vertices_coords"][3][0] += 1e-3
    assert len(_faults(doc)) == 1


@pytest.mark.parametrize("title", FRAMES)
@pytest.mark.parametrize("key", ["edges_vertices", "faces_vertices", "edges_assignment", "bdffpq:edges_type"])
def test_a_flat_state_of_another_mesh_is_told_by_each_key(title, key):
    doc = document("eggbox")
    frame = doc["file_frames"][FRAMES[title]]
    frame[key] = list(doc[key])
    assert _faults(doc) == ()
    frame[key] = frame[key][:-1]
    assert _faults(doc) == (f"the {title} frame has its own {key}",)


@pytest.mark.parametrize("place", range(4))
def test_every_frame_is_looked_at(place):
    doc = document("eggbox")
    developed, folded = doc["file_frames"]
    bad = {**developed, "vertices_coords": [[0.0, 0.0]] * 30}
    other = {"frame_title": "a state between", "vertices_coords": "anything"}
    frames = [developed, other, folded, 7]
    doc["file_frames"] = [*frames[:place], bad, *frames[place:]]
    faults = _faults(doc)
    assert sum("the developed frame changes the distance" in fault for fault in faults) == 1
    assert [fault for fault in faults if "is no frame" in fault] == [f"file_frames[{4}] is no frame"]


def test_the_distance_that_is_most_wrong_is_told():
    def change(points):
        points[29] += 1e-5
        points[0] -= 1e-3
        return points

    (fault,) = _scaled(document("miura"), "developed", change)
    assert "the distance of vertices 0 and " in fault


# Holes and grids.


def _two_holes():
    doc = fold_file.document(seeds.grid((7, 9)))
    ring = [9, 10, 11, 20, 29, 28, 27, 18]  # around facet (2, 1), in the numbering of the whole grid
    removed = {19, 42}
    strips = [[f - sum(r < f for r in removed) for f in strip] for strip in (ring, [f + 23 for f in ring])]
    return without_facets(doc, removed, strips), strips


def test_strips_go_round_each_hole_once_in_any_direction_and_from_anywhere():
    doc, (first, second) = _two_holes()
    for strips in ([first, second], [second, first], [first[::-1], second], [first[3:] + first[:3], second[::-1]]):
        assert _faults({**doc, "bdffpq:holes": strips}) == ()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda a, b: [a], "bdffpq:holes has 1 strips, but the surface has 2 holes"),
        (lambda a, b: [a, b, a], "bdffpq:holes has 3 strips, but the surface has 2 holes"),
        (lambda a, b: {"0": a}, "bdffpq:holes has no list of strips, but the surface has 2 holes"),
        (lambda a, b: [a, []], "bdffpq:holes[1] is no list of facets"),
        (lambda a, b: [a, 3], "bdffpq:holes[1] is no list of facets"),
        (lambda a, b: [a, [*b[:-1], float(b[-1])]], "bdffpq:holes[1] is no list of facets"),
        (lambda a, b: [a, [True, *b]], "bdffpq:holes[1] is no list of facets"),
        (lambda a, b: [a, b[:-1]], "bdffpq:holes[1] is no closed strip: facet {b[6]} shares no edge with the next one"),
        (lambda a, b: [a[1:], b], "bdffpq:holes[0] is no closed strip: facet {a[7]} shares no edge with the next one"),
        (lambda a, b: [a, b[:3] + b[4:]], "bdffpq:holes[1] is no closed strip: facet {b[2]} shares no edge"),
        (lambda a, b: [a, a], "the strips of bdffpq:holes do not go once around every hole"),
        (lambda a, b: [a, b + b], "the strips of bdffpq:holes do not go once around every hole"),
        (lambda a, b: [b + b, a], "the strips of bdffpq:holes do not go once around every hole"),
        (lambda a, b: [a, b[:2]], "the strips of bdffpq:holes do not go once around every hole"),
    ],
)
def test_strips_that_are_none(make, words):
    doc, (a, b) = _two_holes()
    (fault,) = _faults({**doc, "bdffpq:holes": make(a, b)})
    assert words.format(a=a, b=b) in fault


@pytest.mark.parametrize("claim", [None, [], [4], [4, 5, 1], [4.0, 5], [True, 20], [0, 0], [-4, -5], ["4", 5]])
def test_grids_that_are_none(claim):
    (fault,) = _faults({**document("miura"), "bdffpq:grid": claim})
    assert "two numbers of facets are needed" in fault


def test_grids_number_their_facets_and_vertices():
    for name, sizes in (("miura", [(2, 10), (5, 4), (20, 1), (1, 20)]), ("6-gon tube", [(4, 6), (12, 2), (24, 1)])):
        for size in sizes:
            (fault,) = _faults({**document(name), "bdffpq:grid": list(size)})
            assert f"is not facet ({0}, " in fault
            assert f"of the {size[0]} x {size[1]} grid" in fault
    # Two facets in each other's places: only these are wrong, and the last ones as well as the first ones.
    for f, place in ((0, "(0, 0)"), (18, "(3, 3)")):
        doc = document("miura")
        faces = doc["faces_vertices"]
        faces[f], faces[f + 1] = faces[f + 1], faces[f]
        (fault,) = _faults(doc)
        assert fault == f"facet {f} is not facet {place} of the 4 x 5 grid that bdffpq:grid claims"


def test_claims_are_shortened_in_messages():
    for claim, told in (("x" * 38, f"'{'x' * 38}'"), ("x" * 39, f"'{'x' * 36}..."), ("disk ", "'disk '")):
        (fault,) = _faults({**document("miura"), "bdffpq:topology": claim})
        assert fault == f"bdffpq:topology is {told}, but the facets form a disk"


def test_the_topology_is_named():
    doc, _ = _two_holes()
    for claim in ("disk", "cylinder", "holes:1", "holes:3", 2):
        (fault,) = _faults({**doc, "bdffpq:topology": claim})
        assert fault.endswith("but the facets form a holes:2")
    assert _faults({key: item for key, item in doc.items() if key != "bdffpq:topology"}) == ()
