"""Profiles measured from surfaces around an axis."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from designs import assert_close, rotation

from inverse.errors import InputError
from inverse.formulation.formulate import build_target, formulate
from inverse.spec import load
from inverse.surfaces import around
from inverse.surfaces.axis import Axis, arc
from inverse.surfaces.expression import SPACE, parse
from inverse.surfaces.mesh import MeshTarget
from inverse.surfaces.tube import TubeTarget
from inverse.terms.tube_fit import TubeFitting

LINE = Axis([[0, 0, 0], [0, 0, 4]], smooth=False)
QUARTER = arc([0, 0, 0], [1 - np.sqrt(0.5), 0, np.sqrt(0.5)], [1, 0, 1])


def implicit(axis: Axis, text: str) -> np.ndarray:
    return around.of_implicit(axis, parse(text, SPACE, "implicit expression"))


def test_a_hyperboloid() -> None:
    profile = implicit(LINE, "x^2 + y^2 - (z - 1)^2 - 1")
    assert_close(profile[:, 0], np.linspace(0, 1, len(profile)), 1e-15)
    assert_close(profile[:, 1], np.sqrt(1 + (4 * profile[:, 0] - 1) ** 2), 4 * around.INSET)


def test_an_ellipse_has_its_mean_distance() -> None:
    angle = np.linspace(0, 2 * np.pi, 20001)[:-1]
    polar = 1 / np.hypot(np.cos(angle) / 2, np.sin(angle))
    assert_close(implicit(LINE, "x^2/4 + y^2 - 1")[:, 1], polar.mean(), 1e-4)


def test_a_torus_about_a_bent_axis() -> None:
    """The axis is a quarter of the circle about (1, 0, 0); the surface passes it at 0.3, from outside or inside."""
    for text in ("(sqrt((x - 1)^2 + z^2) - 1)^2 + y^2 - 0.09", "0.09 - y^2 - (hypot(x - 1, z) - 1)^2"):
        assert_close(implicit(QUARTER, text)[:, 1], 0.3, 1e-6)


def test_the_first_sheet_from_the_axis_counts() -> None:
    assert_close(implicit(LINE, "(x^2 + y^2 - 1) * (x^2 + y^2 - 4)")[:, 1], 1.0, 1e-9)


def test_a_mesh_is_measured_as_what_it_approximates() -> None:
    """A round tube's own picture as the mesh gives its profile back, up to the facets of the picture."""
    profile = np.array([[0.0, 1.0], [0.4, 0.7], [1.0, 0.9]])
    for axis in (LINE, QUARTER):
        tube = TubeTarget(axis, profile * [1, 0.4])
        found = around.of_mesh(axis, MeshTarget(*tube.triangles()))
        assert_close(found[:, 1], tube.radii(found[:, 0]), 2e-3 * 0.4)


def test_turned_and_moved() -> None:
    turn, shift = rotation(4), np.array([5.0, -3, 1])
    box = trimesh.creation.box((1.0, 2.0, 6.0))
    points = np.add(box.vertices, [0, 0, 2])
    axis = Axis(LINE.points @ turn + shift, smooth=False)
    profile = around.of_mesh(axis, MeshTarget(points @ turn + shift, np.asarray(box.faces)))
    angle = np.linspace(0, 2 * np.pi, 20001)[:-1]
    polar = np.minimum(0.5 / np.abs(np.cos(angle)), 1 / np.maximum(np.abs(np.sin(angle)), 1e-9))
    assert_close(profile[:, 1], polar.mean(), 5e-3)


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("x^2 + y^2 + 1", "0 of"),
        ("x - 1", "0 of"),
        ("x^2 + y^2 - 1 + max(0, z - 2)", r"0\.7"),
        ("log(-1 - z^2)", "0"),
    ],
)
def test_a_surface_that_is_not_around_is_refused(text: str, place: str) -> None:
    with pytest.raises(InputError, match=f"not all around the axis at the fraction {place}"):
        implicit(LINE, text)


def test_a_mesh_that_ends_too_soon_is_refused() -> None:
    tube = TubeTarget(Axis([[0, 0, -1], [0, 0, 2]], smooth=False), 0.5)
    with pytest.raises(InputError, match=r"not all around the axis at the fraction 0\.5"):
        around.of_mesh(LINE, MeshTarget(*tube.triangles()))


def test_specifications_name_surfaces(tmp_path: Path) -> None:
    tube = TubeTarget(LINE, np.array([[0.0, 1.0], [1.0, 0.8]]))
    trimesh.Trimesh(*tube.triangles(), process=False).export(tmp_path / "tube.obj")
    axis = {"polyline": [[0, 0, 0], [0, 0, 4]]}
    for keys in ({"mesh": "tube.obj"}, {"implicit": "sqrt(x^2 + y^2) - 1 + z/20"}):
        mapping = {"name": "t", "pattern": {"kind": "tube", "size": [4, 3]}, "target": {"axis": axis} | keys}
        loaded = load(mapping, folder=tmp_path)
        target = build_target(loaded)
        assert isinstance(target, TubeTarget)
        assert_close(target.radii(np.array([0.0, 0.5, 1.0])), [1.0, 0.9, 0.8], 2e-3)
        assert isinstance(formulate(loaded).goal.fitting, TubeFitting)
    with pytest.raises(InputError, match="there is no such file"):
        build_target(load(mapping | {"target": {"axis": axis, "mesh": "missing.obj"}}, folder=tmp_path))
