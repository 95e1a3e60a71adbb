"""Tubes in specifications: what is refused and where, the open ends as sides, freedoms that are left."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from designs import assert_close

import inverse
from inverse.errors import InputError
from inverse.formulation.anchors import PolylineAnchor
from inverse.formulation.formulate import formulate
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import seeds
from inverse.spec import load

TEXT = """\
name: tube
pattern:
  kind: tube
  size: [4, 3]
  section: [[1, 1, 2], [1, -1, 1], [-1, -1, 2], [-1, 1, 1]]
target:
  axis: {polyline: [[0, 0, 0], [0, 0, 3]]}
  radius: [[0, 1], [1, 0.8]]
"""
SECTION = "section: [[1, 1, 2], [1, -1, 1], [-1, -1, 2], [-1, 1, 1]]"
AXIS = "axis: {polyline: [[0, 0, 0], [0, 0, 3]]}"
RADIUS = "radius: [[0, 1], [1, 0.8]]"
TARGET = f"{AXIS}\n  {RADIUS}"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            SECTION,
            "section: |[[1, 1, 2], [1, -1, 1], [-1, -1, 2], [-1, 1, 1.5]]",
            "the section does not close: its n-signed lengths sum to -0.5 and its a-signed ones to 0.5",
        ),
        (SECTION, "section: |[[1, 1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 3]]", "the section does not close"),
        (SECTION, "section: |[[1, 1, 1], [-1, -1, 1], [1, -1, 1], [-1, 1, 1]]", "section steps (1, 1) and (-1, -1)"),
        (SECTION, "section: |plus", "the section has 12 steps, but the tube has 4 facets around"),
        (SECTION, "section: |pluss", "'pluss' is no section: registered are 10-gon, 4-gon, 6-gon, 8-gon, L, plus."),
        (SECTION, "section: [[1, |2, 1], [1, -1, 1], [-1, -1, 2], [-1, 1, 1]]", "2 is no sign: allowed are 1, -1."),
        (SECTION, "|lengths_v: [1, 2]", "lengths_v has 2 lengths, but the tube has 3 rows"),
        (SECTION, "turn: |left", 'pattern.turn is "left": it must be a number'),
        ("size: [4, 3]\n  " + SECTION, "size: |[5, 3]", "a tube of 5 facets around needs a section: "),
        ("size: [4, 3]\n  " + SECTION, "size: |[12, 3]", "a tube of 12 facets around needs a section: "),
        (TARGET, AXIS, 'a target around an axis needs exactly one of radius, section, mesh, implicit; given none'),
        (AXIS, "axis: |{}", "an axis needs exactly one of polyline, spline, arc; given none of them"),
        (AXIS, "axis: {arc: |[[0, 0, 0], [0, 0, 3]]}", "[[0, 0, 0], [0, 0, 3]] should be a list of 3: [start, on the"),
        (AXIS, "axis: |{arc: [[0, 0, 0], [0, 0, 1], [0, 0, 3]]}", "the three points of the arc lie on a line"),
        (AXIS, "axis: |{spline: [[0, 0, 0], [1, 0, 1], [0, 0, 0]]}", "the axis ends where it begins"),
        (AXIS, "axis: {polyline: |[[0, 0, 0], [0, 0, 0]]}", "points 0 and 1 of this polyline"),
        (RADIUS, "radius: |[[0, 1], [0, 0.8]]", "the fractions of the profile must increase, but 0 follows 0"),
        (RADIUS, "radius: [[0, 1], [|1.5, 0.8]]", "target.radius.1.0 is 1.5: it must be at most 1"),
        (RADIUS, "radius: |1.0e-9", "a tube with a mean radius of 1e-09 around an axis of length 3 cannot be made of"),
        (RADIUS, "radius: |[[0, 1.0e+9], [1, 2.0e+9]]", "a tube with a mean radius of 1.5e+09 around an axis"),
        (RADIUS, "radius: |[[0, 1]]", "a profile needs two or more pairs [fraction, radius]"),
        (RADIUS, "implicit: |x^2 + w", "`w` at position 7 of the implicit expression is no variable or constant"),
        (RADIUS, "implicit: |x - 1", "the surface is not all around the axis at the fraction 0 of its length"),
        (RADIUS, RADIUS + "\n  |mesh: a.obj", "a target around an axis needs exactly one of radius, section, mesh"),
        (RADIUS, "radius: |-1", "target.radius is -1: it must be greater than 0"),
        (TARGET, '|height: x\n  domain: [[0, 1], [0, 1]]', "a tube needs a target around an axis"),
        ("kind: tube\n  size: [4, 3]\n  " + SECTION, "|size: [4, 3]", "a grid has no rings to lie around an axis"),
        (TARGET, TARGET + "\nfit: |{points: layer}", "of a tube the rings of facets are fitted"),
        (
            TARGET,
            TARGET + "\nconstraints: {anchors: [{side: |u0, to: {plane: {point: [0, 0, 0], normal: [0, 0, 1]}}}]}",
            "'u0' names no boundary of this pattern",
        ),
        (
            TARGET,
            TARGET + "\nconstraints: {anchors: [{side: v0, to: {polygon: |[[0, 0, 0], [1, 0, 0], [0, 0, 0]]}}]}",
            "the polygon closes by itself: leave out its last point [0, 0, 0]",
        ),
    ],
)  # fmt: skip
def test_refusals(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert TEXT.count(old) == 1
    text = TEXT.replace(old, new)
    before, bar, after = text.partition("|")
    (tmp_path / "tube.yaml").write_text(before + after)
    with pytest.raises(InputError) as caught:
        formulate(load(tmp_path / "tube.yaml"))
    where, _, told = str(caught.value).partition(": ")
    assert told.startswith(message)
    if bar:
        place = f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"
        assert where == f"{tmp_path / 'tube.yaml'}:{place}"


@pytest.mark.parametrize("name", [*seeds.NAMED_SECTIONS, None])
def test_sections_by_their_names(name: str | None) -> None:
    steps = seeds.NAMED_SECTIONS[name or "6-gon"]
    pattern = {"kind": "tube", "size": [len(steps), 2]} | ({"section": name} if name else {})
    found = load({"name": "tube", "pattern": pattern, "target": {"axis": LINE, "radius": 1}})
    assert found.specification.pattern.steps == steps  # type: ignore[union-attr]


# ---- anchors

LINE: dict[str, Any] = {"polyline": [[0, 0, 0], [0, 0, 4]]}
SQUARE = [[1.0, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]


def task(anchors: list[dict[str, Any]], size: tuple[int, int] = (6, 4), **target: Any) -> dict[str, Any]:
    return {
        "name": "tube",
        "pattern": {"kind": "tube", "size": list(size)},
        "target": {"axis": LINE, "radius": 1} | target,
        "constraints": {"anchors": anchors},
    }


def level(z: float) -> dict[str, Any]:
    return {"plane": {"point": [0, 0, z], "normal": [0, 0, 1]}}


def held(mapping: dict[str, Any]) -> list[int]:
    found = formulate(load(mapping))
    anchored = [c.elements.variables[:, 0] // 3 for c in found.fixed if c.name.startswith("anchor")]
    return np.concatenate([*anchored, *(s.vertices for s in found.sliding)]).tolist()


def test_the_open_ends_are_sides() -> None:
    first, last = list(range(0, 30, 5)), list(range(4, 30, 5))
    assert held(task([{"side": "v0", "to": level(0)}])) == first
    assert held(task([{"side": "v1", "to": level(4)}])) == last
    assert held(task([{"side": "ends", "to": level(0)}])) == first + last
    assert held(task([{"side": "ends", "every": 3, "to": level(0)}])) == [0, 15, 4, 19]


def test_vertices_go_around_a_polygon() -> None:
    corners = np.array([*SQUARE, SQUARE[0]])
    anchor = PolylineAnchor("polygon", np.arange(4), corners, np.array([0, 3, 3, 2]))
    places = np.array([[1.0, 0, 0], [1, 0, 0], [0.5, -0.5, 0], [0, -1, 0]])
    assert anchor.moved_on(places).segments.tolist() == [3, 0, 3, 3]
    open_line = PolylineAnchor("polyline", np.arange(1), corners[:-1], np.array([2]))
    assert open_line.moved_on(np.array([[0.0, -1, 0]])).segments.tolist() == [2]


def test_ends_that_are_held() -> None:
    """A square end on a polygon, a tilted plane at the other: both hold, and the tube tapers between."""
    to = [
        {"side": "v0", "to": {"polygon": SQUARE}},
        {"side": "v1", "to": {"plane": {"point": [0, 0, 4], "normal": [0, 0.1, 1]}}},
    ]
    result = inverse.solve(load(task(to, (4, 6), radius=[[0, 0.8], [1, 0.6]])))
    assert result.certified, result.status
    assert result.converged, result.status
    table = result.design.vertices_coords.reshape(4, 7, 3)
    assert_close(np.abs(table[:, 0, :2]).sum(axis=1), 1.0, 1e-8)
    assert_close(table[:, 0, 2], 0.0, 1e-8)
    assert_close((table[:, -1] - [0, 0, 4]) @ [0, 0.1, 1], 0.0, 1e-8)


def test_anchors_take_no_more_freedoms_than_a_tube_has() -> None:
    """Four facets around and 3 rows leave 9 + 14."""
    with pytest.raises(InputError, match="takes 24 freedoms, but of the pattern's 23 only 23 are left"):
        formulate(load(task([{"vertices": list(range(12)), "to": {"polygon": SQUARE}}], (4, 3))))


@pytest.mark.parametrize(("k", "rows"), [(4, 3), (4, 5), (6, 3)])
def test_degrees_of_freedom_of_generic_tubes(k: int, rows: int) -> None:
    """Columns minus rank of all equations at a tube that is not symmetric: 3R + 7k/2."""
    axis = {"spline": [[0, 0, 0], [0.3, 0.2, 2], [0.2, 0.9, 4]]}
    loaded = load(task([], (k, rows), axis=axis, radius=[[0, 1], [0.4, 0.8], [1, 0.75]]))
    result = inverse.solve(loaded)
    assert result.certified, result.status
    made = formulate(loaded)
    problem = Problem(made.goal.n_variables, made.objectives, [c for c in made.fixed if c.is_equation])
    x = made.goal.start(result.design.vertices_coords)
    jacobian = Point(problem, x, problem.parameters()).jacobian
    sizes = np.linalg.svd(jacobian.toarray(), compute_uv=False)
    rank = int((sizes > 1e-9 * sizes[0]).sum())
    assert problem.n_variables - rank == 3 * rows + 7 * k // 2
    assert result.design.pattern.degrees_of_freedom == 3 * rows + 7 * k // 2


@pytest.mark.parametrize(("around", "word"), [(12, "plus"), (5, None)])
def test_a_missing_section_is_named(around: int, word: str | None) -> None:
    """What the hint says works."""
    pattern: dict[str, Any] = {"kind": "tube", "size": [around, 4]}
    task = {"name": "x", "pattern": pattern, "target": {"axis": {"polyline": [[0, 0, 0], [0, 0, 6]]}, "radius": 1}}
    with pytest.raises(InputError) as caught:
        load(task)
    assert (caught.value.hint == f"Write section: {word}.") == (word is not None)
    if word is not None:
        load(task | {"pattern": pattern | {"section": word}})
