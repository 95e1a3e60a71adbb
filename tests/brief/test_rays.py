"""Lines that meet a surface, against ray casting by VTK, which shares no code with ours."""

from __future__ import annotations

import numpy as np
import pytest
import pyvista
import trimesh

from inverse.brief.rays import met


@pytest.mark.parametrize("seed", range(6))
def test_as_vtk_casts_them(seed: int) -> None:
    """Random lines and a crumpled sphere; both ways are looked, up to the reach."""
    random = np.random.default_rng(seed)
    ball = trimesh.creation.icosphere(subdivisions=2)
    vertices = ball.vertices * random.uniform(0.6, 1.4, (len(ball.vertices), 1))
    mesh = pyvista.PolyData.from_regular_faces(vertices, ball.faces)
    points = random.normal(scale=1.5, size=(150, 3))
    directions = random.normal(size=(150, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    reach = float(random.uniform(0.2, 3))
    ends = points - reach * directions, points + reach * directions
    wanted = np.array([len(mesh.ray_trace(a, b)[0]) > 0 for a, b in zip(*ends, strict=True)])
    found = met(points, directions, vertices, np.asarray(ball.faces), reach)
    assert 10 < wanted.sum() < 140
    assert (found == wanted).all()


def test_the_reach_is_a_limit() -> None:
    triangle = np.array([[-1.0, -1, 1], [2, -1, 1], [-1, 2, 1]])
    up = np.array([[0.0, 0, 1]])
    for reach, is_met in ((0.999, False), (1.001, True)):
        assert met(np.zeros((1, 3)), up, triangle, np.array([[0, 1, 2]]), reach).tolist() == [is_met]


def test_a_line_through_a_shared_edge_is_not_lost() -> None:
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    on_the_diagonal = np.array([[0.3, 0.3, 0.1], [0.7, 0.7, -0.1]])
    up = np.tile([0.0, 0, 1], (2, 1))
    assert met(on_the_diagonal, up, square, np.array([[0, 1, 2], [0, 2, 3]]), 1.0).all()


def test_nothing_near_meets_nothing() -> None:
    triangle = np.array([[100.0, 0, 0], [101, 0, 0], [100, 1, 0]])
    assert not met(np.zeros((3, 3)), np.tile([0.0, 0, 1], (3, 1)), triangle, np.array([[0, 1, 2]]), 1.0).any()
