"""The oracle itself: it must be able to say no."""

from __future__ import annotations

import numpy as np
import pytest

pytestmark = pytest.mark.node


def degree_four_vertex(directions: list[float]) -> dict:
    """A fan of four triangles around the origin, creases in these directions in degrees."""
    angles = np.radians(directions)
    rim = np.stack([np.cos(angles), np.sin(angles), np.zeros(4)], axis=1)
    return {
        "vertices_coords": [[0.0, 0.0, 0.0], *rim.tolist()],
        "edges_vertices": [[0, 1], [0, 2], [0, 3], [0, 4], [1, 2], [2, 3], [3, 4], [4, 1]],
        "edges_assignment": ["M", "M", "V", "M", "B", "B", "B", "B"],
        "faces_vertices": [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]],
    }


def test_accepts_and_folds_a_flat_foldable_vertex(rabbit_ear):
    findings = rabbit_ear(degree_four_vertex([0, 60, 180, 300]))

    assert findings["validate"]["summary"] == "valid"
    assert findings["kawasaki"] == findings["maekawa"] == []
    angles = np.radians([0, 60, -60, 60])  # sectors 60, -120, 120, -60
    expected = np.vstack([[0, 0], np.stack([np.cos(angles), np.sin(angles)], axis=1)])
    np.testing.assert_allclose(findings["flat_folded"], expected, atol=1e-12)


def test_rejects_a_vertex_that_is_not_flat_foldable(rabbit_ear):
    assert rabbit_ear(degree_four_vertex([0, 60, 180, 299]))["kawasaki"] == [0]


def test_rejects_four_mountains(rabbit_ear):
    fold = degree_four_vertex([0, 60, 180, 300])
    fold["edges_assignment"][2] = "M"
    assert rabbit_ear(fold)["maekawa"] == [0]


def test_rejects_a_reference_to_nothing(rabbit_ear):
    fold = degree_four_vertex([0, 60, 180, 300])
    fold["edges_vertices"][7] = [4, 9]
    findings = rabbit_ear(fold)
    assert findings["validate"]["summary"] == "problematic"
    assert findings["flat_folded"] is None
