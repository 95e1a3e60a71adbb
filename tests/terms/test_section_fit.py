"""A tube fitted to a section keeps it: a door stays a door."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import inverse
from inverse.formulation.formulate import formulate
from inverse.terms.section_fit import SectionFitting
from inverse.terms.tube_fit import ring_vertices

DOOR = [[-0.5, 0.0], [0.5, 0.0], [0.5, 2.1], [-0.5, 2.1]]


def asked(section: Any, axis: Any = ((0, 0, 0), (0, 3, 0)), **pattern: Any) -> dict[str, Any]:
    target = {"axis": {"polyline": axis}, "section": section}
    return {"name": "door", "pattern": {"kind": "tube", "size": [4, 8], **pattern}, "target": target}


def opening(design: inverse.Design) -> np.ndarray:
    """Width and height (R, 2) of the outline between every two rings of vertices."""
    rings = design.vertices_coords[ring_vertices(design.pattern)]
    return np.ptp((rings[1:] + rings[:-1]) / 2, axis=1)[:, [0, 2]]


def test_the_seed_is_turned_and_sized_onto_the_section() -> None:
    fitting = formulate(inverse.load(asked(DOOR))).goal.fitting
    assert isinstance(fitting, SectionFitting)
    assert opening(fitting.model.seed) == pytest.approx(np.tile([1, 2.1], (8, 1)), rel=0.06)


@pytest.mark.parametrize("turn", [0, 10])
def test_a_door_stays_a_door(turn: float) -> None:
    result = inverse.solve(asked(DOOR, turn=turn))
    assert result.certified
    assert result.converged
    assert opening(result.design) == pytest.approx(np.tile([1, 2.1], (8, 1)), rel=0.005)
    assert result.fit.points == "sections"
    assert result.fit.max < 0.005
    assert result.design.vertices_coords[:, 2].mean() == pytest.approx(1.05, abs=0.01)


def test_a_section_may_taper() -> None:
    small = [[-0.4, 0.0], [0.4, 0.0], [0.4, 1.8], [-0.4, 1.8]]
    result = inverse.solve(asked([[0, DOOR], [1, small]]))
    assert result.certified
    assert result.converged
    found = opening(result.design)
    assert found[[0, -1]] == pytest.approx(np.array([[0.9875, 2.081], [0.8125, 1.819]]), rel=0.05)


def test_far_from_the_origin_the_design_is_the_same() -> None:
    near = formulate(inverse.load(asked(DOOR)))
    far = formulate(inverse.load(asked(DOOR, [[5000, 0, 0], [5000, 3, 0]])))
    assert far.goal.origin.any()
    moved = far.goal.model.seed.vertices_coords + far.goal.origin - [5000, 0, 0]
    assert moved == pytest.approx(near.goal.model.seed.vertices_coords, abs=1e-8)
