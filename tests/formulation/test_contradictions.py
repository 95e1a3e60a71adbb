"""Tasks that contradict themselves are refused at once, and nothing that a design meets ever is."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from domes import DOME, PATTERNS, dome, task

import inverse
from inverse.formulation import contradictions
from inverse.formulation.formulate import formulate
from inverse.origami import footprint, geometry
from inverse.origami.pattern import Design

BIG = {"height": "sqrt(100 - x^2 - y^2)", "domain": [[-6, 6], [-6, 6]]}
TUBE: dict[str, Any] = {
    "pattern": {"kind": "tube", "size": [6, 8]},
    "target": {"axis": {"polyline": [[0, 0, 0], [0, 0, 6]]}, "radius": 1},
}
DOOR = {"polygon": [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]}


def plane(point: list[float], normal: list[float]) -> dict[str, Any]:
    return {"plane": {"point": point, "normal": normal}}


def line(*points: list[float]) -> dict[str, Any]:
    return {"polyline": list(points)}


def circle(z: float) -> dict[str, Any]:
    return {"circle": {"center": [0, 0, z], "normal": [0, 1, 0], "radius": 2}}


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "above and below": (
        {"keep_out": [{"below": 6}, {"above": 4}]},
        "constraints.keep_out.1: the keep-outs leave no room: no point is below 4 m (this one) and is above 6 m "
        "(constraints.keep_out.0)",
    ),
    "three planes, each two of which leave room": (
        {"keep_out": [plane([0, 0, 0], [1, 0, 0]), plane([-1, 0, 0], [-1, 1, 0]), plane([0, -5, 0], [0, -1, 0])]},
        "no point meets this one and meets constraints.keep_out.0 and meets constraints.keep_out.1",
    ),
    "too thin for a fold": (
        {"keep_out": [{"below": 6}, plane([0, 0, 6.0001], [0, 0, -2])]},
        "between this keep-out and constraints.keep_out.0 there are 0.0001 m, but with these limits of folds and edges "
        "the mesh is at least 0.00677 m thick",
    ),
    "points too far apart": (
        {"anchors": [{"vertices": [0], "to": {"point": [0, 0, 0]}}, {"vertices": [1], "to": {"point": [0, 9, 0]}}]},
        "constraints.anchors.1: vertices 0 (constraints.anchors.0) and 1 are held 9 m or more apart, but the edges "
        "between them are 3.02 m long at most",
    ),
    "lines too far apart": (
        {
            "anchors": [
                {"side": "u0", "every": 2, "to": line([0, 0, 0], [9, 0, 0])},
                {"side": "u1", "every": 2, "to": line([0, 99, 0], [9, 99, 0])},
            ]
        },
        "are held 99 m or more apart, but the edges between them are 54.4 m long at most",
    ),
    "an edge on a line that is too short": (
        {"anchors": [{"vertices": [0, 1], "to": line([0, 0, 0], [0.01, 0, 0])}]},
        "are held 0.01 m or less apart, but the edge between them is 0.302 m long at least",
    ),
    "a line under a floor": (
        {"keep_out": [{"below": 6}], "anchors": [{"side": "u0", "every": 2, "to": line([-6, -6, 5], [-6, 6, 5])}]},
        "constraints.anchors.0.to: this anchor's place is 1 m or more within constraints.keep_out.0",
    ),
    "a plane under a floor": (
        {"keep_out": [{"below": 6}], "anchors": [{"side": "u0", "every": 2, "to": plane([0, 0, 5], [0, 0, 1])}]},
        "this anchor's place is 1 m or more within constraints.keep_out.0",
    ),
    "a circle under a floor": (
        {"keep_out": [{"below": 6}], "anchors": [{"side": "u0", "every": 2, "to": circle(0)}]},
        "this anchor's place is 4 m or more within constraints.keep_out.0",
    ),
    "a line that leaves one keep-out where it enters another": (
        {
            "keep_out": [plane([1, 0, 0], [1, 0, 0]), plane([0, 1, 0], [0, 1, 0])],
            "anchors": [{"vertices": [0, 1], "to": line([-4, 4, 7], [4, -4, 7])}],
        },
        "this anchor's place is nowhere outside of all keep-outs",
    ),
    "a vertex on two levels": (
        {
            "anchors": [
                {"vertices": [5], "to": plane([0, 0, 5], [0, 0, 1])},
                {"vertices": [5], "to": plane([0, 0, 6], [0, 0, -1])},
            ]
        },
        "vertex 5 cannot be here and where anchor 0 holds it, 1 m away",
    ),
    "a box shorter than an edge": (
        {"footprint": {"state": "flat-folded", "length": 0.2, "width": 0.1}},
        "is at least 0.34 m long, but the box's diagonal is 0.224 m",
    ),
    "a box narrower than a facet": (
        {"footprint": {"state": "developed", "length": 20, "width": 0.01}},
        "is at least 0.039 m wide, but the box 0.01 m",
    ),
    "no right angle": (
        {"sector_angle": [95, 120]},
        "the angles of a facet with 4 sides are 90 degrees in the mean, which is not between 95 and 120",
    ),
}


def refusal(**keys: Any) -> str:
    loaded = inverse.load({"name": "t", "pattern": {"size": [16, 16], "u_lines": "CFL"}, "target": BIG} | keys)
    began = time.perf_counter()
    with pytest.raises(inverse.InputError) as caught:
        formulate(loaded)
    assert time.perf_counter() - began < 10  # a second on an idle machine
    return str(caught.value)


@pytest.mark.parametrize("name", REFUSED)
def test_what_contradicts_itself_is_refused_with_the_places_of_both(name: str) -> None:
    constraints, expected = REFUSED[name]
    assert expected in refusal(constraints=constraints)


def test_lines_of_the_file_are_named(tmp_path: Path) -> None:
    path = tmp_path / "t.yaml"
    path.write_text(
        "name: t\npattern: {size: [4, 4]}\ntarget: {height: '0', domain: [[0, 1], [0, 1]]}\n"
        "constraints:\n  keep_out:\n    - below: 6\n    - above: 4\n"
    )
    with pytest.raises(inverse.InputError) as caught:
        formulate(inverse.load(path))
    assert str(caught.value).startswith(f"{path}:7:7: ")
    assert "(constraints.keep_out.0 (line 6))" in str(caught.value)
    with pytest.raises(inverse.InputError, match=re.escape("constraints.keep_out.0 (--set constraints.keep_out=[{b")):
        formulate(inverse.load(path, ["constraints.keep_out=[{below: 6}, {above: 4}]"]))


@pytest.mark.parametrize(
    ("size", "why"), [([1, 1], "it has no folds"), ([1, 10], "its 9 folds move independently"), ([3, 1], "its 2 folds")]
)
def test_strips_are_no_mechanism(size: list[int], why: str) -> None:
    said = refusal(pattern={"size": size})
    assert f"pattern.size: a grid of {size[0]} x {size[1]} facets has no interior vertex: {why}" in said


@pytest.mark.parametrize("to", [DOOR, line([1, 0, 0], [0, 1, 0], [-1, 0, 0]), circle(0)])
def test_both_ends_of_a_tube_on_one_curve(to: dict[str, Any]) -> None:
    said = refusal(**TUBE, constraints={"anchors": [{"side": "ends", "to": to}]})
    assert f"both ends of the tube would be held on one {next(iter(to))}" in said
    formulate(task(**TUBE, constraints={"anchors": [{"side": "v0", "to": DOOR}]}))
    formulate(task(**TUBE, constraints={"anchors": [{"side": "ends", "to": plane([0, 0, 0], [0, 0, 1])}]}))


# ---- nothing that has a solution is refused


def constraints_met(design: Design, seed: Design, random: np.random.Generator) -> dict[str, Any]:
    """Constraints at random that a design meets, most of them so closely that they touch it."""
    pattern, points = design.pattern, design.vertices_coords
    folds = np.degrees(np.abs(geometry.fold_angles(pattern, points)[pattern.interior_edges]))
    sectors = np.degrees(geometry.sector_angles(pattern, points))
    factors = geometry.edge_lengths(pattern, points) / geometry.edge_lengths(pattern, seed.vertices_coords)
    found: dict[str, Any] = {
        "fold_angle": [float(folds.min()), float(folds.max())],
        "sector_angle": [float(sectors.min()), float(sectors.max())],
        "edge_length": [float(factors.min()), float(factors.max())],
        "keep_out": [],
        "anchors": [],
    }
    for _ in range(random.integers(0, 5)):
        normal = random.standard_normal(3)
        normal = np.eye(3)[2] * random.choice([-1, 1]) if random.random() < 0.5 else normal / np.linalg.norm(normal)
        point = points[np.argmin(points @ normal)]
        found["keep_out"].append(plane(point.tolist(), normal.tolist()))
    found["keep_out"] += [{"below": float(points[:, 2].min())}, {"above": float(points[:, 2].max())}]
    left = random.permutation(pattern.n_vertices).tolist()
    for _ in range(random.integers(1, 5)):
        vertices = [left.pop() for _ in range(random.integers(1, 4))]
        own, kind = points[vertices], random.choice(["point", "polyline", "plane", "circle"])
        if kind == "point":
            vertices, to = vertices[:1], {"point": own[0].tolist()}
        elif kind == "plane":
            vertices, to = vertices[:1], plane(own[0].tolist(), random.standard_normal(3).tolist())
        elif kind == "circle":
            arm, other = random.standard_normal((2, 3))
            centre = own[0] + arm
            to = {
                "circle": {
                    "center": centre.tolist(),
                    "normal": np.cross(arm, other).tolist(),
                    "radius": float(np.linalg.norm(arm)),
                }
            }
            vertices = vertices[:1]
        else:
            to = line(*own.tolist(), (own[-1] + random.standard_normal(3)).tolist())
        found["anchors"].append({"vertices": vertices, "to": to})
    return found


@pytest.mark.parametrize("number", range(12))
@pytest.mark.parametrize("name", PATTERNS)
def test_what_a_design_meets_is_not_refused(name: str, number: int) -> None:
    result = dome(name)
    random = np.random.default_rng(number)
    constraints = constraints_met(result.design, result.seed, random)
    if random.random() < 0.5:
        state = str(random.choice(["developed", "flat-folded"]))
        points = footprint.laid_out(result.design, {"developed": 0.0, "flat-folded": np.pi}[state])
        box = np.sort(footprint.extents(points, footprint.box_axes(points)))[::-1]
        constraints["footprint"] = {"state": state, "length": float(box[0]), "width": float(box[1])}
    formulate(task(pattern=PATTERNS[name], target=DOME, constraints=constraints))


@pytest.mark.parametrize("path", sorted((Path(__file__).parents[2] / "targets").glob("*.yaml")), ids=lambda p: p.stem)
def test_no_target_is_refused(path: Path) -> None:
    formulate(inverse.load(path))


def test_an_anchored_vertex_may_touch_a_keep_out_and_another_anchor() -> None:
    corner = {"vertices": [0], "to": plane([0, 0, 6], [0, 0, 1])}
    rail = {"vertices": [0], "to": line([-6, -6, 6], [-6, 6, 6])}
    formulate(task(target=BIG, constraints={"keep_out": [{"below": 6}], "anchors": [corner, rail]}))


def test_every_rule_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    rules = [name for name in vars(contradictions._Task) if name.startswith("check_")]
    asked = []
    for name in rules:
        monkeypatch.setattr(contradictions._Task, name, lambda _, name=name: asked.append(name))
    formulate(task())
    assert sorted(asked) == sorted(rules)
