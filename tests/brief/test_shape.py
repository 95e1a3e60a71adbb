"""Slenderness and diameters of facets known by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from inverse.brief import shape


class SimplePattern:
    """A pattern as far as facets are looked at one by one."""

    def __init__(self, faces: list[tuple[int, ...]]) -> None:
        self.faces_vertices = faces
        self.faces_by_sides = {len(face): [f] for f, face in enumerate(faces)}


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_a_rectangle_a_rhombus_and_a_triangle(scale: float) -> None:
    """Width over diameter: of 1 x 10 it is 1 / sqrt(101); of a rhombus of 5 degrees sin 5 / (2 cos 2.5)."""
    sharp = np.radians(5.0)
    rhombus = [[0, 0], [1, 0], [1 + np.cos(sharp), np.sin(sharp)], [np.cos(sharp), np.sin(sharp)]]
    cases = {
        1 / np.sqrt(101): ([[0, 0], [10, 0], [10, 1], [0, 1]], 101**0.5),
        np.sin(sharp) / (2 * np.cos(sharp / 2)): (rhombus, 2 * np.cos(sharp / 2)),
        np.sqrt(3) / 2: ([[0, 0], [1, 0], [0.5, 3**0.5 / 2]], 1.0),
    }
    for wanted, (corners, diameter) in cases.items():
        points = np.array([[x, y, 0.0] for x, y in corners]) * scale
        one: Any = SimplePattern([tuple(range(len(corners)))])
        assert shape.slenderness(one, points) == pytest.approx([wanted])
        assert shape.diameters(one, points) == pytest.approx([diameter * scale])
