"""Tasks far from the origin: solved like those at home, and told in the coordinates of their specification."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from designs import assert_close
from domes import task

import inverse
from inverse import objectives
from inverse.crossing import crossing_facets
from inverse.errors import InputError
from inverse.formulation.formulate import formulate
from inverse.surfaces.parametric import HeightTarget

HOME = (0.0, 0.0, 0.0)
NATIONAL = (600000.0, 340000.0, 150.0)
FAR = (1e7, -1e7, 1000.0)
LEFT, RIGHT = np.array([[-5.0, -11, 2], [-5, 12, 3]]), np.array([[6.0, -12, 1], [6, 11, 1]])


def vault(offset: tuple[float, ...], _: Path) -> dict[str, Any]:
    left, right = (LEFT + offset).tolist(), (RIGHT + offset).tolist()
    x, y, z = offset
    return {
        "pattern": {"size": [6, 8]},
        "target": {"between": [left, right], "rise": 3.0, "profile": "parabola"},
        "constraints": {
            "anchors": [
                {"side": "u0", "every": 2, "to": {"polyline": left}},
                {"vertices": [60], "to": {"circle": {"center": [x + 6, y, z], "normal": [0, 1, 0], "radius": 1}}},
                {"vertices": [62], "to": {"plane": {"point": [x + 6, y, z], "normal": [1, 0, 0]}}},
            ],
            "keep_out": [{"below": z - 2}, {"plane": {"point": [x, y, z + 9], "normal": [0, 0, -1]}}],
        },
        "require": {"coverage": 0.8},
    }


def mesh(offset: tuple[float, ...], folder: Path) -> dict[str, Any]:
    vertices, triangles = HeightTarget("0.45 - 0.3*(x^2 + y^2)", [[-0.6, 0.6]] * 2).triangles()
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in (vertices + offset).tolist()]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles.tolist()]
    name = f"dome at {offset[0]:g}.obj"
    (folder / name).write_text("\n".join(lines))
    return {"target": {"mesh": name}}


def height(offset: tuple[float, ...], _: Path) -> dict[str, Any]:
    x, y, z = offset
    return {
        "target": {
            "height": f"{z!r} + 0.45 - 0.3*((x - ({x!r}))^2 + (y - ({y!r}))^2)",
            "domain": [[x - 0.6, x + 0.6], [y - 0.6, y + 0.6]],
        }
    }


def tube(offset: tuple[float, ...], _: Path) -> dict[str, Any]:
    axis = (np.array([[0.0, 0, 0], [0, 0.5, 2], [0, 0, 4]]) + offset).tolist()
    return {"pattern": {"kind": "tube", "size": [4, 4]}, "target": {"axis": {"spline": axis}, "radius": 1}}


def implicit(offset: tuple[float, ...], _: Path) -> dict[str, Any]:
    x, y, z = offset
    axis = [[x, y, z], [x, y, z + 4]]
    text = f"(x - ({x!r}))^2 + (y - ({y!r}))^2 - (1 - 0.1*(z - {z!r}))^2"
    return {"pattern": {"kind": "tube", "size": [4, 4]}, "target": {"axis": {"polyline": axis}, "implicit": text}}


TASKS = {"vault": vault, "mesh": mesh, "height": height, "tube": tube, "implicit": implicit}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("far")


@cache
def solved(name: str, offset: tuple[float, ...], folder: Path) -> inverse.Result:
    return inverse.solve(task(folder, **TASKS[name](offset, folder)))


@pytest.mark.parametrize("name", TASKS)
@pytest.mark.parametrize("offset", [(1e5, -1e5, 100.0), FAR])
def test_a_task_is_solved_anywhere(name: str, offset: tuple[float, ...], folder: Path) -> None:
    home, away = solved(name, HOME, folder), solved(name, offset, folder)
    assert home.ending == "solved"
    assert away.ending == "solved" if offset != FAR else away.ending in ("solved", "too_far")
    assert away.converged
    # Rounds on a mesh or around an axis end by rounding; all others take the same steps.
    if name in ("vault", "height"):
        assert away.report["iterations"] == home.report["iterations"]
    assert away.report["fit"]["rms"] == pytest.approx(home.report["fit"]["rms"], rel=1e-4, abs=1e-9)
    assert_close(away.design.vertices_coords - offset, home.design.vertices_coords, 1e-6)
    assert_close(away.seed.vertices_coords - offset, home.seed.vertices_coords, 1e-6)
    assert_close(away.target[0] - offset, home.target[0], 1e-6)


def test_what_numbers_cannot_tell_is_said(folder: Path) -> None:
    away = solved("mesh", FAR, folder)
    assert away.ending == "too_far"
    assert away.converged
    assert not away.certified
    assert away.report["certified"] is False
    assert "numbers of 1e+07 are 2e-09 apart; " in away.status
    assert away.status.endswith("Subtract a point near by from all coordinates of the task.")


def test_going_on_from_a_far_result(folder: Path) -> None:
    first = solved("height", NATIONAL, folder)
    again = inverse.solve(task(folder, **height(NATIONAL, folder)), start=first)
    assert again.converged
    assert_close(again.design.vertices_coords, first.design.vertices_coords, 1e-6)


def test_near_the_origin_nothing_is_moved(folder: Path) -> None:
    near = (30.0, -50.0, 20.0)
    assert not formulate(task(folder, **height(near, folder))).goal.origin.any()
    goal = formulate(task(folder, **height(NATIONAL, folder))).goal
    assert_close(goal.origin, NATIONAL, 1.0)
    assert np.abs(goal.model.seed.vertices_coords).max() < 3


@pytest.mark.usefixtures("registered")
def test_terms_of_ones_own_are_told_the_coordinates_of_the_specification(folder: Path) -> None:
    found = []
    for name, offset in (("near", HOME), ("far", NATIONAL)):
        objectives.objective(name, per="mesh")(lambda points, _, level=offset[2]: points[:, 2] - level)
        result = inverse.solve(task(folder, **height(offset, folder), objectives={name: 1.0, "fit": 0.0}))
        assert result.report["objective"][name] < 0.1
        found.append(result.design.vertices_coords - offset)
    assert_close(found[1], found[0], 1e-6)


def test_a_far_height_without_a_value_is_refused_where_it_is() -> None:
    target = {"height": "sqrt(1 - (x - 600000)^2)", "domain": [[599998, 600002], [0, 4]]}
    with pytest.raises(InputError, match=r"no value at \(599998, 0\)"):
        formulate(task(target=target))


@pytest.mark.parametrize("scale", [1.0, 1e-6])
def test_facets_that_meet_far_away_do_not_cross(scale: float, folder: Path) -> None:
    """As the certificate looks at them: coordinates of 1 and facets of a millionth."""
    home = solved("vault", HOME, folder).design
    faces = home.pattern.faces_vertices
    turned = home.vertices_coords.copy()
    turned[31] += [7, 0, -1]
    crossing = crossing_facets(turned, faces)
    assert len(crossing) > 0
    for points, expected in ((home.vertices_coords, crossing[:0]), (turned, crossing)):
        np.testing.assert_array_equal(crossing_facets((points + NATIONAL) * scale, faces), expected)
