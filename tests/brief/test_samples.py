"""Samples of surfaces against integrals known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from inverse.brief.samples import FINENESS, spread

RECTANGLE = np.array([[0.0, 0, 0], [4, 0, 0], [4, 1, 0], [0, 1, 0]])
HALVES = np.array([[0, 1, 2], [0, 2, 3]])


def test_areas_and_middles_are_those_of_the_surface() -> None:
    """Area and first moments of any cut into equal triangles are exact; second moments to the fineness."""
    found = spread(RECTANGLE, HALVES)
    assert FINENESS <= len(found.points) < 1.2 * FINENESS
    assert found.areas.sum() == pytest.approx(4)
    assert found.points.T @ found.areas == pytest.approx([8, 2, 0])
    assert found.points[:, 0] ** 2 @ found.areas == pytest.approx(64 / 3, rel=1e-3)
    assert np.abs(found.normals - [0, 0, 1]).max() < 1e-12
    assert set(found.triangles.tolist()) == {0, 1}


def test_a_large_triangle_gets_as_many_samples_by_area_as_a_small_one() -> None:
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [10, 0, 0], [40, 0, 0], [10, 30, 0]])
    found = spread(vertices, np.array([[0, 1, 2], [3, 4, 5]]))
    counts = np.bincount(found.triangles)
    assert counts[1] / counts[0] == pytest.approx(900, rel=0.9)
    assert found.areas[found.triangles == 0].sum() == pytest.approx(0.5)


def test_what_is_fine_already_is_sampled_once_a_triangle() -> None:
    n = 80
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    vertices = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    first = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    triangles = np.concatenate(
        [np.stack([first, first + n + 1, first + 1], 1), np.stack([first + n + 1, first + n + 2, first + 1], 1)]
    )
    assert len(spread(vertices, triangles).points) == len(triangles)
