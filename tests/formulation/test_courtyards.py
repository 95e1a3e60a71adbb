"""Anchors on all four sides: who holds the corners, and that nothing passes the walls."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from designs import assert_close

import inverse
from inverse.errors import InputError
from inverse.formulation.formulate import Formulation, formulate
from inverse.formulation.places import Path, Spot, Straight
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.nlp.redundancy import independent
from inverse.spec import load

A, B, HEIGHT = 3.0, 2.0, 1.0
CORNERS = [[-A, -B, HEIGHT], [A, -B, HEIGHT], [A, B, HEIGHT], [-A, B, HEIGHT]]
PLANES = {
    "u0": {"plane": {"point": [-A, 0, 0], "normal": [2, 0, 0]}},
    "u1": {"plane": {"point": [A, 0, 0], "normal": [1, 0, 0]}},
    "v0": {"plane": {"point": [0, -B, 0], "normal": [0, -1, 0]}},
    "v1": {"plane": {"point": [0, B, 0], "normal": [0, 3, 0]}},
}
EAVES = {
    "u0": {"polyline": [CORNERS[0], CORNERS[3]]},
    "u1": {"polyline": [CORNERS[2], CORNERS[1]]},
    "v0": {"polyline": [CORNERS[0], CORNERS[1]]},
    "v1": {"polyline": [CORNERS[3], CORNERS[2]]},
}
POLYGON = {side: {"polygon": CORNERS} for side in PLANES}
WALLS = {"planes": PLANES, "eaves": EAVES, "polygon": POLYGON}


def court(to: dict[str, Any], size: tuple[int, int] = (6, 8), every: int = 2, **constraints: Any) -> dict[str, Any]:
    anchors = [{"side": side, "every": every, "to": place} for side, place in to.items()]
    return {
        "name": "court",
        "pattern": {"size": list(size)},
        "target": {"height": f"1 + 0.5*(1-(x/{A})^2)*(1-(y/{B})^2)", "domain": [[-A, A], [-B, B]]},
        "constraints": {"anchors": anchors} | constraints,
    }


def equations(made: Formulation) -> np.ndarray:
    """The Jacobian of all equations at a place near the seed that is nothing special."""
    model = made.goal.model
    terms = [c for c in (*made.fixed, *(s.constraint(model) for s in made.sliding)) if (c.lower == c.upper).any()]
    problem = Problem(made.goal.n_variables, [], terms)
    x = made.goal.seed_variables + 0.01 * np.random.default_rng(0).standard_normal(made.goal.n_variables)
    point = Point(problem, x, problem.parameters())
    return point.jacobian[problem.equations].toarray()


@pytest.mark.parametrize("walls", WALLS)
def test_corners_are_shared_out_with_independent_equations(walls: str) -> None:
    made = formulate(load(court(WALLS[walls])))
    at = made.anchored.at
    for vertex, corner in zip((0, 54, 62, 8), CORNERS, strict=True):
        if walls == "planes":
            place = at[vertex]
            assert isinstance(place, Straight)
            assert_close(np.abs(place.direction), [0, 0, 1], 1e-12)
            assert_close(place.point[:2], corner[:2], 1e-12)
        else:
            place = at[vertex]
            assert isinstance(place, Spot)
            assert_close(place.at, corner, 1e-12)
    jacobian = equations(made)
    assert len(independent(jacobian)) == len(jacobian)
    assert made.anchored.notes == (
        "Vertices 0, 8, 54 and 62, which several anchors name, are held where the places of these meet.",
    )
    assert [held.tolist() for held in made.anchored.held] == [
        [0, 2, 4, 6, 8], [54, 56, 58, 60, 62], [0, 18, 36, 54], [8, 26, 44, 62]
    ]  # fmt: skip


@pytest.mark.parametrize("walls", WALLS)
def test_walls_bound_the_whole_mesh_from_within(walls: str) -> None:
    made = formulate(load(court(WALLS[walls])))
    found = made.anchored.walls
    assert len(found) == 4
    normals = sorted(tuple(np.round(wall.plane.normal, 12) + 0.0) for wall in found)
    assert normals == [(-1, 0, 0), (0, -1, 0), (0, 1, 0), (1, 0, 0)]
    for wall in found:
        assert wall.plane.heights(np.zeros((1, 3)))[0] > 0
        assert len(wall.vertices) == 63
    rows = [c for c in made.fixed if c.name.startswith("within")]
    bounded = {label for c in rows for label in c.labels}
    assert {f"vertex {v}" for v in range(63) if v not in made.anchored.at} <= bounded
    # What an anchor holds in a wall is there already: another row for it would depend on the anchor's.
    for constraint in rows:
        for label in constraint.labels:
            vertex = int(label.split()[1])
            side = {"0": "u0", "1": "u1", "2": "v0", "3": "v1"}
            if walls == "planes":
                k = int(constraint.name.split("_")[1])
                assert vertex not in made.anchored.held[k], (side[str(k)], vertex)


@pytest.mark.parametrize("walls", ["planes", "eaves", "polygon"])
def test_a_court_between_four_walls_is_solved(walls: str) -> None:
    task = court(WALLS[walls]) | {"objectives": {"evenness": 1e-3}}
    result = inverse.solve(task)
    assert result.certified, result.status
    assert result.converged, result.status
    points = result.design.vertices_coords
    assert np.abs(points[:, 0]).max() < A + 1e-7
    assert np.abs(points[:, 1]).max() < B + 1e-7
    assert result.notes
    for vertex, corner in zip((0, 54, 62, 8), CORNERS, strict=True):
        assert_close(points[vertex, :2], corner[:2], 1e-7)
    assert_close(np.abs(points[[0, 2, 4, 6, 8], 0]), A, 1e-7)
    assert_close(np.abs(points[[8, 26, 44, 62], 1]), B, 1e-7)


def test_without_walls_a_row_passes_the_anchors() -> None:
    task = court(PLANES)
    for anchor in task["constraints"]["anchors"]:
        anchor["within"] = False
    made = formulate(load(task))
    assert made.anchored.walls == []
    assert not [c for c in made.fixed if c.name.startswith("within")]


def test_eaves_of_two_sides_bound_nothing_unless_asked() -> None:
    task = court({side: EAVES[side] for side in ("u0", "u1")})
    assert formulate(load(task)).anchored.walls == []
    task["constraints"]["anchors"][0]["within"] = True
    (wall,) = formulate(load(task)).anchored.walls
    assert_close(wall.plane.normal, [1, 0, 0], 1e-12)


def test_floors_are_no_walls_unless_asked() -> None:
    task = court({"u0": {"plane": {"point": [0, 0, 0.9], "normal": [0, 0.1, 1]}}})
    assert formulate(load(task)).anchored.walls == []
    task["constraints"]["anchors"][0] |= {"within": True}
    (wall,) = formulate(load(task)).anchored.walls
    assert wall.plane.normal[2] > 0.9


def test_the_inner_corner_of_an_l_bounds_the_side_beside_it() -> None:
    inner = [[-A, B, 1], [0, B, 1], [0, 1.0, 1], [A, 1.0, 1]]
    polygon = {"polygon": [CORNERS[0], CORNERS[1], *inner[::-1]]}
    made = formulate(load(court(dict.fromkeys(PLANES, polygon))))
    by_normal = {tuple(np.round(w.plane.normal, 12) + 0.0): w for w in made.anchored.walls if len(w.vertices) < 63}
    assert set(by_normal) <= {(-1, 0, 0), (0, -1, 0)}
    assert by_normal
    for wall in by_normal.values():
        assert set(wall.vertices.tolist()) <= {8, 17, 26, 35, 44, 53, 62, *range(54, 63)}
    assert len([w for w in made.anchored.walls if len(w.vertices) == 63]) == 4


@pytest.mark.parametrize(
    ("anchors", "message"),
    [
        ([{"side": "u0", "within": True, "to": {"point": [0, 0, 0]}}], "a point or a circle is no wall"),
        (
            [{"vertices": [31], "within": True, "to": {"plane": {"point": [0, 0, 0], "normal": [1, 0, 0]}}}],
            "the seed lies on both sides of this anchor's place",
        ),
        (
            [{"side": "v0", "to": EAVES["v0"]}],
            "vertices 0, 9 and 18 are held on one straight line: the facets between them would lie in one plane",
        ),
        (
            [{"side": side, "to": EAVES[side]} for side in EAVES],
            r"vertices \d+, \d+ and \d+ are held on one straight line",
        ),
        (
            [{"vertices": [0], "to": {"plane": {"point": [0, 0, z], "normal": [0, 0, 1]}}} for z in (0, 1)],
            "vertex 0 cannot be here and where anchor 0 holds it, 1 m away",
        ),
    ],
)
def test_refusals(anchors: list[dict[str, Any]], message: str) -> None:
    with pytest.raises(InputError, match=message):
        formulate(load(court({}, anchors=anchors)))


def test_sides_that_do_not_meet_leave_the_corner_to_the_first() -> None:
    """An eave 0.4 m higher than the other: their common vertex stays on the first, and the notes say so."""
    raised = {"polyline": [[x, y, 1.4] for x, y, _ in (CORNERS[0], CORNERS[1])]}
    made = formulate(load(court({"u0": EAVES["u0"], "v0": raised})))
    place = made.anchored.at[0]
    assert isinstance(place, Path)
    assert_close(place.points, EAVES["u0"]["polyline"], 1e-12)
    assert made.anchored.notes == (
        "Vertex 0 is held by anchor 0 (side u0) and not by anchor 1 (side v0): their places are 0.4 m apart there.",
    )
    assert made.anchored.held[1].tolist() == [18, 36, 54]


def test_a_vertex_named_by_its_number_goes_before_its_side() -> None:
    anchors = [
        {"side": "u0", "to": {"polyline": [CORNERS[0], [-A, 0, HEIGHT + 0.2], CORNERS[3]]}},
        {"vertices": [3], "to": {"point": [-2, 0, 1.5]}},
        {"vertices": [4], "to": {"plane": {"point": [0, 0.2, 0], "normal": [0, 1, 0]}}},
    ]
    made = formulate(load(court({}, anchors=anchors)))
    for vertex, expected in ((3, [-2, 0, 1.5]), (4, [-A, 0.2, HEIGHT + 0.18])):
        place = made.anchored.at[vertex]
        assert isinstance(place, Spot)
        assert_close(place.at, expected, 1e-12)
    assert [held.tolist() for held in made.anchored.held] == [[0, 1, 2, 4, 5, 6, 7, 8], [3], [4]]
    assert len(made.anchored.notes) == 2


def test_a_polygon_that_is_round_holds_no_corner_in_a_point() -> None:
    """A corner goes to a corner: along an oval the mesh's corners are free to slide."""
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    oval = {"polygon": np.c_[4 * np.cos(angle), 3 * np.sin(angle), np.ones(40)].round(6).tolist()}
    made = formulate(load(court(dict.fromkeys(PLANES, oval))))
    assert all(isinstance(made.anchored.at[v], Path) for v in (0, 8, 54, 62))
    jacobian = equations(made)
    assert len(independent(jacobian)) == len(jacobian)


def test_keep_outs_leave_out_what_is_held_in_their_planes() -> None:
    wall = {"plane": {"point": [-A, 0, 0], "normal": [1, 0, 0]}}
    made = formulate(load(court({"u0": wall}, keep_out=[wall, {"below": 0.2}])))
    first, second = (c for c in made.fixed if c.name.startswith("keep_out"))
    assert {f"vertex {v}" for v in range(63)} - set(first.labels) == {f"vertex {v}" for v in (0, 2, 4, 6, 8)}
    assert len(second.labels) == 63
