"""Lines that meet a surface, against ray casting by VTK, which shares no code with ours."""

from __future__ import annotations

import numpy as np
import pytest
import pyvista
import trimesh

from inverse.brief.rays import met, met_by_any, met_from_above
from inverse.surfaces.nearest import Nearest


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
    found = met(points, directions, Nearest(vertices, np.asarray(ball.faces)), reach)
    assert 10 < wanted.sum() < 140
    assert (found == wanted).all()


def test_the_reach_is_a_limit() -> None:
    triangle = np.array([[-1.0, -1, 1], [2, -1, 1], [-1, 2, 1]])
    up = np.array([[0.0, 0, 1]])
    for reach, is_met in ((0.999, False), (1.001, True)):
        assert met(np.zeros((1, 3)), up, Nearest(triangle, np.array([[0, 1, 2]])), reach).tolist() == [is_met]


def test_a_line_through_a_shared_edge_is_not_lost() -> None:
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    on_the_diagonal = np.array([[0.3, 0.3, 0.1], [0.7, 0.7, -0.1]])
    up = np.tile([0.0, 0, 1], (2, 1))
    assert met(on_the_diagonal, up, Nearest(square, np.array([[0, 1, 2], [0, 2, 3]])), 1.0).all()


def test_nothing_near_meets_nothing() -> None:
    triangle = np.array([[100.0, 0, 0], [101, 0, 0], [100, 1, 0]])
    assert not met(np.zeros((3, 3)), np.tile([0.0, 0, 1], (3, 1)), Nearest(triangle, np.array([[0, 1, 2]])), 1.0).any()


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("seed", range(4))
def test_what_a_tree_finds_is_what_looking_at_every_triangle_finds(seed: int, scale: float) -> None:
    """Lines through vertices, edges and facets of a surface, some along them, from near and far."""
    random = np.random.default_rng(seed)
    x, y = (k.ravel().astype(float) for k in np.meshgrid(np.arange(9), np.arange(9), indexing="ij"))
    vertices = np.column_stack([x, y, random.integers(0, 3, 81)])
    first = (np.arange(8)[:, None] * 9 + np.arange(8)).ravel()
    triangles = np.concatenate(
        [np.stack([first, first + 9, first + 10], 1), np.stack([first, first + 10, first + 1], 1)]
    )
    triangles = triangles[random.random(len(triangles)) < 0.8]
    middles = vertices[triangles].mean(axis=1)
    points = np.concatenate([vertices, middles, (vertices[triangles[:, 0]] + vertices[triangles[:, 1]]) / 2])
    points[:, 2] += random.normal(size=len(points)).round(1)
    points = np.concatenate([points, random.uniform(-1, 10, (200, 3))])
    directions = random.integers(-1, 2, points.shape).astype(float)
    directions[~directions.any(axis=1)] = [0, 0, 1]
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    surface, points = Nearest(scale * vertices, triangles), scale * points
    found = met(points, directions, surface, 0.7 * scale)
    assert (found == met_by_any(points, directions, surface.vertices, triangles, 0.7 * scale)).all()
    plan, up = np.array([1.0, 1.0, 0.0]), np.tile([0.0, 0.0, 1.0], (len(points), 1))
    above = met_from_above(points, surface)
    assert (above == met_by_any(points * plan, up, surface.vertices * plan, triangles, 0.0)).all()
    assert 0.05 < found.mean() < 0.95
    assert 0.05 < above.mean() < 0.95
