"""Polygons: what is refused, what lies within, triangles that fill them; heights over them."""

from __future__ import annotations

import numpy as np
import pytest

import inverse
from inverse.errors import InputError
from inverse.formulation.formulate import build_target, formulate
from inverse.surfaces import polygon as polygons
from inverse.surfaces.sheet import check_sheet

ELL = np.array([[0.0, 0], [12, 0], [12, 4], [5, 4], [5, 10], [0, 10]])


def area(points: np.ndarray, cells: np.ndarray) -> float:
    a, b, c = points[cells].transpose(1, 0, 2)
    u, v = b - a, c - a
    return float(np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum() / 2)


@pytest.mark.parametrize("spacing", [0.3, 1.0, 20.0])
def test_triangles_fill_a_polygon_and_no_more(spacing: float) -> None:
    rim = polygons.divided(ELL, spacing)
    inside, cells = polygons.filled(rim, spacing)
    assert area(np.concatenate([rim, inside]), cells) == pytest.approx(78)
    assert polygons.within(inside, ELL).all()


def test_corners_may_go_round_either_way() -> None:
    assert polygons.checked(ELL[::-1], "it") == pytest.approx(ELL)
    assert polygons.within(np.array([[1.0, 9], [9, 9], [9, 1]]), ELL).tolist() == [True, False, True]


@pytest.mark.parametrize(
    ("corners", "match"),
    [
        ([[0, 0], [2, 2], [2, 0], [0, 1]], "sides 0 and 2 of it meet"),
        ([[0, 0], [1, 1], [2, 2]], "no area"),
        ([[0, 0], [1, 0], [1, 0], [0, 1]], "corners 1 and 2 of it coincide"),
    ],
)
def test_refusals(corners: list[list[float]], match: str) -> None:
    with pytest.raises(InputError, match=match):
        polygons.checked(np.array(corners, np.float64), "it")


def asked(height: str, domain: object) -> dict[str, object]:
    return {"name": "h", "pattern": {"size": [12, 12]}, "target": {"height": height, "domain": domain}}


def test_heights_over_a_polygon_are_trimmed_to_it() -> None:
    loaded = inverse.load(asked("1 - 0.01*x^2", ELL))
    target = build_target(loaded)
    points = target.triangles()[0]
    assert points[:, 2] == pytest.approx(1 - 0.01 * points[:, 0] ** 2)
    check_sheet(target, 1.0)  # type: ignore[arg-type]
    facets = len(formulate(loaded).goal.model.pattern.faces_vertices)
    assert facets / 144 == pytest.approx(78 / 120, abs=0.05)


def test_far_away_it_is_the_same() -> None:
    near = formulate(inverse.load(asked("1 - 0.01*x^2", ELL))).goal
    far = formulate(inverse.load(asked("1 - 0.01*(x - 5000)^2", ELL + np.array([5000, 0])))).goal
    assert far.origin.any()
    assert far.model.seed_points == pytest.approx(near.model.seed_points, abs=1e-6)


@pytest.mark.parametrize(
    ("height", "domain", "match"),
    [
        ("x", [[0, 0], [2, 2], [2, 0], [0, 1]], "sides 0 and 2 of the domain meet"),
        ("sqrt(x - 1)", ELL, "no value at"),
        ("x", [[0, 1]], "should be a list of 2"),
        ("x", [[0, 1, 2], [0, 1, 2], [0, 1, 2]], r"\[x, y\]"),
    ],
)
def test_wrong_domains_are_refused(height: str, domain: object, match: str) -> None:
    with pytest.raises(InputError, match=match) as caught:
        build_target(inverse.load(asked(height, domain)))
    assert "target" in str(caught.value.where)
