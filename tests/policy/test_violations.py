"""Violations in the unit of the file: measured on the design here, and compared with what the sentences say."""

from __future__ import annotations

import re
from typing import Any

import casadi
import numpy as np
import pytest
from domes import task

import inverse
from inverse.formulation.formulate import formulate
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import geometry
from inverse.policy import verdict

RAIL = [[-0.7, -0.7, 1.0], [-0.7, 0.7, 1.0]]


class Spoilt:
    """A task at a design that was spoilt, and what is said of it."""

    def __init__(self, constraints: dict[str, Any], spoil: Any = None, **keys: Any) -> None:
        loaded = task(constraints=constraints, **keys)
        formulation = formulate(loaded)
        self.goal = formulation.goal
        terms = [*formulation.fixed, *(one.constraint(self.goal.model) for one in formulation.sliding)]
        problem = Problem(self.goal.n_variables, formulation.objectives, terms)
        self.pattern, self.seed = self.goal.model.pattern, self.goal.model.seed.vertices_coords
        self.points = self.seed.copy()
        if spoil is not None:
            spoil(self.points)
        at = Point(problem, self.goal.start(self.points), problem.parameters())
        self.said = verdict.violated(at, self.goal, loaded.specification.constraints)

    def sentence(self, key: str) -> str:
        (found,) = [one for one in self.said if key in one]
        return found


def number(text: str, before: str) -> float:
    found = re.search(rf"([\d.e+-]+) {re.escape(before)}", text)
    assert found, text
    return float(found[1])


@pytest.mark.parametrize(("key", "sign", "word"), [("below", 1, "low"), ("above", -1, "high")])
def test_how_far_a_vertex_is_too_low_or_too_high(key: str, sign: int, word: str) -> None:
    spoilt = Spoilt({"keep_out": [{"below": -9}, {key: 0.5 * sign}]})
    missing = sign * (0.5 * sign - spoilt.points[:, 2])
    sentence = spoilt.sentence("keep_out")
    worst = int(re.findall(r"vertex (\d+)", sentence)[0])
    assert missing[worst] == pytest.approx(missing.max(), abs=1e-9)
    assert sentence == (
        f"vertex {worst} is {missing.max():.3g} m too {word} (constraints.keep_out.1: {key} {0.5 * sign:g} m)"
    )


def test_how_far_a_vertex_is_behind_a_plane() -> None:
    keep_out = {"plane": {"point": [0.1, 0, 0], "normal": [5, 0, 0]}}
    spoilt = Spoilt({"keep_out": [keep_out]})
    far = 0.1 - spoilt.points[:, 0].min()
    assert f"is {far:.3g} m on the wrong side of its plane (constraints.keep_out.0)" in spoilt.sentence("keep_out")


PLACES: dict[str, tuple[dict[str, Any], Any]] = {
    "point": ({"point": [0, 0, 1]}, lambda p: np.linalg.norm(p - [0, 0, 1])),
    "plane": ({"plane": {"point": [0, 0, 1], "normal": [0, 0, 3]}}, lambda p: abs(p[2] - 1)),
    "polyline": ({"polyline": RAIL}, lambda p: np.hypot(p[0] + 0.7, p[2] - 1)),
    "circle": (
        {"circle": {"center": [0, 0, 1], "normal": [0, 0, 1], "radius": 2}},
        lambda p: np.hypot(p[2] - 1, np.hypot(p[0], p[1]) - 2),
    ),
}


@pytest.mark.parametrize("name", PLACES)
def test_how_far_a_vertex_is_from_its_anchor(name: str) -> None:
    to, distance = PLACES[name]
    spoilt = Spoilt({"anchors": [{"vertices": [3], "to": to}]})
    far = float(distance(spoilt.points[3]))
    assert spoilt.sentence("vertex 3 ") == f"vertex 3 is {far:.3g} m from its {name} (constraints.anchors.0)"


@pytest.mark.parametrize(("factors", "word"), [([0.3, 0.8], "long (at most"), ([1.2, 3.0], "short (at least")])
def test_how_much_an_edge_is_too_long_or_too_short(factors: list[float], word: str) -> None:
    spoilt = Spoilt({"edge_length": factors}, units="mm")
    sentence = spoilt.sentence("edge_length")
    a, b = map(int, re.findall(r"edge (\d+)-(\d+)", sentence)[0])
    length = float(np.linalg.norm(spoilt.points[a] - spoilt.points[b]))
    bound = length * (0.8 if "most" in word else 1.2)
    assert sentence == (
        f"edge {a}-{b} is {abs(bound - length):.3g} mm too {word} {bound:.3g} mm, constraints.edge_length)"
    )


@pytest.mark.parametrize(("limits", "word"), [([20, 40], "sharp (at most 40"), ([100, 160], "flat (at least 100")])
def test_how_much_a_fold_is_too_flat_or_too_sharp(limits: list[float], word: str) -> None:
    spoilt = Spoilt({"fold_angle": limits})
    sentence = spoilt.sentence("fold_angle")
    pair = tuple(map(int, re.findall(r"edge (\d+)-(\d+)", sentence)[0]))
    angle = abs(np.degrees(geometry.fold_angles(spoilt.pattern, spoilt.points)))[
        spoilt.pattern.edge_between[frozenset(pair)]
    ]
    off = angle - 40 if "most" in word else 100 - angle
    assert f"is {off:.2g} degrees too {word}, constraints.fold_angle)" in sentence


def test_a_fold_that_is_turned_over() -> None:
    def mirror(points: Any) -> None:
        points[:, 2] *= -1

    sentence = next(one for one in Spoilt({}, mirror).said if "fold of edge" in one)
    assert re.search(r"the fold of edge \d+-\d+ is turned over: a (valley|mountain) of \d+ degrees", sentence)


@pytest.mark.parametrize(("limits", "word"), [([14, 110], "blunt (at most 110"), ([70, 166], "sharp (at least 70")])
def test_how_much_an_angle_is_too_blunt_or_too_sharp(limits: list[float], word: str) -> None:
    spoilt = Spoilt({"sector_angle": limits}, pattern={"size": [4, 4], "sector_angle": 60})
    sentence = spoilt.sentence("sector_angle")
    assert re.match(r"the angle of facet \d+ at vertex \d+ is 10 degrees too ", sentence)
    assert f"too {word}, constraints.sector_angle)" in sentence


def test_what_is_bent_and_what_does_not_fold_flat() -> None:
    spoilt = Spoilt({}, lambda points: points.__setitem__((24, 2), points[24, 2] + 0.05))
    bent, flat = spoilt.sentence("is not plane"), spoilt.sentence("does not fold flat")
    facet = int(re.findall(r"facet (\d+)", bent)[0])
    a, b, c, d = spoilt.points[list(spoilt.pattern.faces_vertices[facet])]
    normal = np.cross(b - a, c - b)
    off = abs((d - a) @ normal) / np.linalg.norm(normal)
    assert bent == f"facet {facet} is not plane: a corner is {off:.3g} m off"
    assert number(flat, "degrees off") > 0.1


@pytest.mark.usefixtures("registered")
def test_constraints_of_ones_own_have_their_unit() -> None:
    @inverse.constraint("ceiling", per="vertex", unit="length", upper=0.0)
    def ceiling(points: casadi.SX, _: casadi.SX) -> casadi.SX:
        return points[0, 2]

    @inverse.constraint("slope", per="edge", unit="angle", upper=0.1)
    def slope(points: casadi.SX, _: casadi.SX) -> casadi.SX:
        return casadi.atan2(points[1, 2] - points[0, 2], 1.0)

    spoilt = Spoilt({"own": {"ceiling": None, "slope": None}})
    far = spoilt.points[:, 2].max()
    assert f"is {far:.2g} m beyond what is allowed (constraints.own.ceiling)" in spoilt.sentence("own.ceiling")
    assert number(spoilt.sentence("own.slope"), "degrees beyond") > 1


def test_what_holds_is_not_mentioned() -> None:
    assert Spoilt({"keep_out": [{"below": -9}]}).said == []
