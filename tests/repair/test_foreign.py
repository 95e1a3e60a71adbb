"""Files of other programs: any subset of keys is read, every fault is a sentence with its place."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from designs import assert_close, eggbox, holed, miura, polygonal, staircase
from foreign_files import assignments, crease_pattern, scrambled_facets, write_fold, write_obj
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from inverse import repair
from inverse.errors import InputError
from inverse.files import fold_file
from inverse.origami.pattern import Design
from inverse.repair.foreign import read_foreign
from inverse.repair.grid import grid_of, numbered_size
from inverse.repair.network import Network, build_network


def network(path: Path) -> Network:
    return build_network(read_foreign(path), path)


def facet_sets(faces: Any) -> set[frozenset[int]]:
    return {frozenset(face) for face in faces}


SQUARES = {
    "vertices_coords": [[0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]],
    "edges_vertices": [[0, 1], [1, 2], [3, 4], [4, 5], [0, 3], [1, 4], [2, 5]],
    "edges_assignment": ["B", "B", "B", "B", "B", "M", "B"],
}


# ---- what is read


def test_facets_are_found_from_the_edges_of_a_crease_pattern(tmp_path: Path) -> None:
    for design in (miura(4, 5), staircase(), polygonal()):
        found = network(write_fold(crease_pattern(design), tmp_path))
        assert found.is_flat
        assert facet_sets(found.design.pattern.faces_vertices) == facet_sets(design.pattern.faces_vertices)
        assert sorted(found.assignments.values()) == sorted(w for w in assignments(design) if w != "B")


def test_a_loop_of_border_edges_is_a_hole(tmp_path: Path) -> None:
    design = holed()
    found = network(write_fold(crease_pattern(design), tmp_path))
    assert found.design.pattern.topology == "cylinder"
    assert facet_sets(found.design.pattern.faces_vertices) == facet_sets(design.pattern.faces_vertices)


def test_facets_are_turned_one_way(tmp_path: Path) -> None:
    design = eggbox(4, 5)
    document = {"vertices_coords": design.vertices_coords.tolist(), "faces_vertices": scrambled_facets(design)}
    assert document["faces_vertices"] != [list(face) for face in design.pattern.faces_vertices]
    found = network(write_fold(document, tmp_path)).design.pattern
    assert found.n_holes == 0
    assert found.faces_vertices[0] == tuple(document["faces_vertices"][0])


def test_a_crease_pattern_is_seen_from_above(tmp_path: Path) -> None:
    """Clockwise facets are turned, a pattern in a tilted plane is laid flat."""
    document = {**SQUARES, "faces_vertices": [[0, 3, 4, 1], [1, 4, 5, 2]]}
    assert network(write_fold(document, tmp_path)).design.pattern.faces_vertices[0] == (1, 4, 3, 0)
    document["vertices_coords"] = [[x, 0.6 * y, 0.8 * y] for x, y in SQUARES["vertices_coords"]]
    found = network(write_fold(document, tmp_path))
    assert found.is_flat
    assert not found.design.vertices_coords[:, 2].any()
    assert_close(np.linalg.norm(np.subtract(*found.design.vertices_coords[[0, 5]])), 5**0.5, 1e-12)


def test_flat_edges_join_their_facets_and_lone_vertices_go(tmp_path: Path) -> None:
    """Every quad is cut by a diagonal, one by a fan around a vertex of its own."""
    design = miura(3, 3)
    points, faces, edges = design.vertices_coords, [], []
    for f, (a, b, c, d) in enumerate(design.pattern.faces_vertices):
        if f == 4:
            faces += [[a, b, 16], [b, c, 16], [c, d, 16], [d, a, 16]]
            edges += [[a, 16], [b, 16], [c, 16], [d, 16]]
            points = np.vstack([points, points[[a, b, c, d]].mean(axis=0)])
        else:
            faces += [[a, b, c], [a, d, c]]
            edges += [[a, c]]
    document = {"vertices_coords": points.tolist(), "faces_vertices": faces,
                "edges_vertices": edges, "edges_assignment": ["F"] * len(edges)}  # fmt: skip
    found = network(write_fold(document, tmp_path))
    assert facet_sets(found.design.pattern.faces_vertices) == facet_sets(design.pattern.faces_vertices)
    assert found.file_vertices.tolist() == list(range(16))


def test_the_first_frame_with_coordinates_and_what_it_inherits(tmp_path: Path) -> None:
    design = miura(2, 3)
    faces = [list(face) for face in design.pattern.faces_vertices]
    document = {
        "file_title": "of the root\u0000",
        "frame_unit": "mm",
        "faces_vertices": faces,
        "file_frames": [
            {"frame_title": "empty"},
            {"frame_inherit": True, "frame_parent": 0, "vertices_coords": design.vertices_coords.tolist()},
        ],
    }
    found = read_foreign(write_fold(document, tmp_path))
    assert_close(found.vertices_coords, design.vertices_coords, 0)
    assert (found.unit, found.name) == ("mm", "of the root ")
    assert found.faces_vertices == design.pattern.faces_vertices


def test_fold_angles_stand_in_for_assignments(tmp_path: Path) -> None:
    document = {**SQUARES, "edges_foldAngle": [0, 0, 0, 0, 0, 30, 0]}
    document["edges_assignment"] = ["B"] * 5 + ["U", "B"]
    assert network(write_fold(document, tmp_path)).assignments == {(1, 4): "V"}


def test_an_obj_mesh_keeps_its_quads(tmp_path: Path) -> None:
    design = polygonal()
    facets = scrambled_facets(design)
    found = read_foreign(write_obj(design.vertices_coords, facets, tmp_path))
    assert found.vertices_coords.tobytes() == design.vertices_coords.tobytes()
    assert found.faces_vertices == tuple(map(tuple, facets))
    backwards = tmp_path / "b.obj"
    backwards.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3/7 -2/8/9 -1\n")
    assert read_foreign(backwards).faces_vertices == ((0, 1, 2),)


def test_a_grid_is_recognised_however_it_is_numbered(tmp_path: Path) -> None:
    design = miura(3, 4)
    assert numbered_size(design.pattern) == (3, 4)
    turned = [list(face)[::-1] for face in design.pattern.faces_vertices]
    found = network(write_obj(design.vertices_coords, turned, tmp_path)).design.pattern
    assert numbered_size(found) == (3, 4)
    number = np.random.default_rng(0).permutation(20)
    points = np.empty_like(design.vertices_coords)
    points[number] = design.vertices_coords
    found = network(write_obj(points, [number[face].tolist() for face in turned], tmp_path)).design.pattern
    assert numbered_size(found) is None
    grid = grid_of(found)
    assert grid is not None
    assert sorted(grid.shape) == [4, 5]
    for other in (staircase(), polygonal(), holed()):
        assert grid_of(other.pattern) is None


# ---- what is refused

CROSS = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [1, 1, 0], [2, 1, 0]]
MOEBIUS = {
    "vertices_coords": [[np.cos(a), np.sin(a), z] for a in np.arange(5) * 2 * np.pi / 5 for z in (0.0, 1.0)],
    "faces_vertices": [[2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1] for k in range(4)] + [[8, 1, 0, 9]],
}


def at(*points: list[float]) -> dict[str, Any]:
    """The two squares with more vertices, or, six of them, with others."""
    return {**SQUARES, "vertices_coords": [*points] if len(points) == 6 else [*SQUARES["vertices_coords"], *points]}


def middle(word: str) -> dict[str, Any]:
    """The two squares with another word for the edge between them."""
    return {**SQUARES, "edges_assignment": ["B"] * 5 + [word, "B"]}


def edge(document: dict[str, Any], *more: list[int], word: str = "M") -> dict[str, Any]:
    return document | {
        "edges_vertices": [*document["edges_vertices"], *more],
        "edges_assignment": [*document["edges_assignment"], *[word] * len(more)],
    }


REFUSED: dict[str, tuple[object, str]] = {
    "empty": ("", "the file is empty"),
    "no JSON": ('{"a": ', "not JSON"),
    "a list": ([], "JSON object"),
    "nothing": ({}, "no frame of the file has vertices_coords"),
    "no vertices": ({"vertices_coords": [], "edges_vertices": []}, "no vertices"),
    "no topology": ({"vertices_coords": [[0, 0], [1, 0], [0, 1]]}, "neither edges_vertices nor faces_vertices"),
    "NaN": ({**SQUARES, "vertices_coords": [[float("nan"), 0]] * 6}, "not finite"),
    "huge": ({**SQUARES, "vertices_coords": [[1e60, 0]] + [[0, 1]] * 5}, "vertex 0 is at"),
    "four coordinates": ({**SQUARES, "vertices_coords": [[0, 0, 0, 0]] * 6}, "rows of 3"),
    "mixed coordinates": ({**SQUARES, "vertices_coords": [[0, 0]] * 5 + [[1, 1, 1]]}, "rows of 2"),
    "one point": ({**SQUARES, "vertices_coords": [[3, 3]] * 6}, "all vertices of the pattern coincide"),
    "one line": ({**SQUARES, "vertices_coords": [[k, k] for k in range(6)]}, "on one line"),
    "bad index": (edge(SQUARES, [0, 6]), "names a vertex that is not there"),
    "loop": (edge(SQUARES, [2, 2]), "joins vertex 2 to itself"),
    "twice": (edge(SQUARES, [4, 1]), "edge 1-4 is listed twice, as edges 5 and 7"),
    "word": (edge(SQUARES, [0, 5], word="X"), "edges_assignment.7. is 'X': allowed are B, M, V, F, U, C"),
    "words": ({**SQUARES, "edges_assignment": ["B"]}, "each of the 7 edges"),
    "orphans": ({"vertices_coords": CROSS, "faces_vertices": [[0, 1, 4]], "edges_foldAngle": [1]}, "no edges_vertices"),
    "own parent": ({"file_frames": [{**SQUARES, "frame_inherit": True, "frame_parent": 1}]}, "inherits from frame 1"),
    "frames": ({"file_frames": 3}, "file_frames must be a list"),
    "crossing": (edge(SQUARES, [0, 4], [3, 1]), "edges 0-4 and 1-3 cross"),
    "vertex on edge": (edge(at([1, 0.5]), [6, 5]), "1-4 and 5-6 cross or touch"),
    "upon each other": (
        {**SQUARES, "edges_vertices": [[0, 1], [0, 2], [2, 5], [5, 3], [3, 0]], "edges_assignment": ["B"] * 5},
        "edges 0-. and 0-. lie upon each other",
    ),
    "dangling": (edge(at([0.5, 0.5]), [0, 6]), "edge .-. has the same region on both sides"),
    "pieces": (edge(at([5, 5], [6, 5], [5, 6]), [6, 7], [7, 8], [8, 6]), "2 separate pieces"),
    "3D edges only": (
        at([0, 0, 0], [1, 0, 0], [2, 0, 1], [0, 1, 0], [1, 1, 0], [2, 1, 1]),
        "no faces_vertices, and facets can be found from the edges of a flat crease pattern only",
    ),
    "cut": (middle("C"), "edge 1-4 lies between two facets and is assigned C"),
    "no side": ({**edge(SQUARES, [0, 4]), "faces_vertices": [[0, 1, 4, 3], [1, 2, 5, 4]]}, "edge 0-4 is no side"),
    "flat only": (middle("F"), "nothing folds"),
    "folded": (
        at([0, 0], [1, 0], [0.2, 0], [0, 1], [1, 1], [0.2, 1]) | {"faces_vertices": [[0, 1, 4, 3], [1, 2, 5, 4]]},
        "facet . lies upside down",
    ),
    "two facets": ({"vertices_coords": CROSS, "faces_vertices": [[0, 1, 3], [2, 4, 5]]}, "not connected"),
    "three facets": (
        {"vertices_coords": [*CROSS, [1, 0, 1]], "faces_vertices": [[0, 1, 4, 3], [1, 2, 5, 4], [1, 4, 6]]},
        "edge 1-4 belongs to 3 facets",
    ),
    "two sides": ({"vertices_coords": CROSS, "faces_vertices": [[0, 1]]}, "3 or more different vertices"),
    "Moebius": (MOEBIUS, "not orientable"),
    "zero edge": (
        {"vertices_coords": [[0, 0, 0], [1, 0, 0], [1, 0, 0], [0, 1, 1], [2, 1, 0]],
         "faces_vertices": [[0, 1, 2, 3], [1, 2, 4]]},
        "edge 1-2 has no length",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_a_fold_file_is_refused_with_a_sentence(name: str, tmp_path: Path) -> None:
    document, words = REFUSED[name]
    path = write_fold(document, tmp_path)
    with pytest.raises(InputError, match=words) as caught:
        network(path)
    assert caught.value.where is not None
    assert caught.value.where.startswith(str(path))


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("", None, "the file is empty"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n", None, "no facets"),
        ("v 0 0\n", 1, "three finite numbers"),
        ("v 0 0 nan\n", 1, "three finite numbers"),
        ("v 0 0 zero\n", 1, "three finite numbers"),
        ("v 0 0 0\nv 1 0 0\nf 1 2\n", 3, "three or more vertex numbers"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n", 4, "three or more vertex numbers"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", 4, "names vertex 0"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", 4, "names vertex -4"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2 4\n", 5, "names vertex 4, but the file has 3"),
    ],
)
def test_an_obj_file_is_refused_with_its_line(text: str, line: int | None, words: str, tmp_path: Path) -> None:
    path = tmp_path / "pattern.obj"
    path.write_text(text)
    with pytest.raises(InputError, match=words) as caught:
        read_foreign(path)
    assert caught.value.where == (str(path) if line is None else f"{path}:{line}")


def test_what_is_no_file(tmp_path: Path) -> None:
    for name in ("missing.fold", "missing.obj"):
        with pytest.raises(InputError, match="no such file"):
            read_foreign(tmp_path / name)
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(InputError, match="this is a folder"):
        read_foreign(tmp_path / "folder.obj")
    with pytest.raises(InputError, match=r"allowed are \.fold, \.obj"):
        read_foreign(tmp_path / "pattern.dxf")


def test_all_vertices_of_another_degree_are_listed(tmp_path: Path) -> None:
    """A grid of quads cut into triangles: every interior vertex has six edges."""
    design = miura(4, 5)
    facets = [t for a, b, c, d in design.pattern.faces_vertices for t in ([a, b, c], [a, c, d])]
    with pytest.raises(InputError, match=r"12 interior vertices do not have four edges: vertex 7 has 6, 8 has 6.* 20 has 6 and 2 more\n") as caught:  # noqa: E501 # fmt: skip
        network(write_obj(design.vertices_coords, facets, tmp_path))
    assert "polygons" in str(caught.value.hint)


# ---- whatever the input, a sentence

DOCUMENTS = [
    json.dumps({**crease_pattern(miura(3, 3)), "frame_unit": "m"}),
    json.dumps(fold_file.document(eggbox(3, 3))),
]
never = settings(max_examples=40, deadline=None, derandomize=True,
                 suppress_health_check=[HealthCheck.function_scoped_fixture])  # fmt: skip
json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda children: st.lists(children, max_size=4) | st.dictionaries(st.text(max_size=5), children, max_size=3),
    max_leaves=6,
)


def only_refused(path: Path, **options: Any) -> None:
    try:
        assert isinstance(repair(path, **options).design, Design)
    except InputError as error:
        assert error.message  # noqa: PT017


@never
@given(data=st.data(), base=st.sampled_from(DOCUMENTS), far=st.booleans())
def test_a_fold_file_changed_anywhere(data: st.DataObject, base: str, far: bool, tmp_path: Path) -> None:
    document = json.loads(base)
    for _ in range(data.draw(st.integers(1, 3))):
        key = data.draw(st.sampled_from(sorted(document)))
        holder: Any = document
        place: Any = key
        while isinstance(holder[place], list | dict) and holder[place] and data.draw(st.booleans()):
            holder = holder[place]
            keys = sorted(holder) if isinstance(holder, dict) else range(len(holder))
            place = data.draw(st.sampled_from(list(keys)))
        change = data.draw(st.sampled_from(["value", "copy", "gone"]))
        if change == "value":
            holder[place] = data.draw(json_values)
        elif change == "copy" and isinstance(holder, list):
            holder.append(copy.deepcopy(holder[place]))
        else:
            del holder[place]
        if not document:
            break
    only_refused(write_fold(json.dumps(document), tmp_path), far=far)


@never
@given(moves=st.lists(st.floats(-3, 3), min_size=48, max_size=48), far=st.booleans())
def test_vertices_moved_anywhere(moves: list[float], far: bool, tmp_path: Path) -> None:
    design = eggbox(3, 3)
    points = design.vertices_coords + np.reshape(moves, (16, 3))
    only_refused(write_obj(points, scrambled_facets(design), tmp_path), far=far)


@never
@given(text=st.text(st.sampled_from("vf 0123-./#\nx"), max_size=200) | st.text(max_size=50))
def test_any_text_as_a_file(text: str, tmp_path: Path) -> None:
    for name in ("pattern.obj", "pattern.fold"):
        path = tmp_path / name
        path.write_bytes(text.encode("utf-8", "surrogatepass"))
        only_refused(path)
