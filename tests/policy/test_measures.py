"""What is measured of a design, against lengths known by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from inverse.policy import measures


def test_the_fit_is_told_in_lengths_and_relative_to_the_designs_own_size() -> None:
    seed, found = np.array([[0.0, 0, 0], [3, 4, 0]]), np.array([[0.0, 0, 0], [6, 8, 0]])
    distances = {5.0: np.array([0.0, 2.0, 2.0, 4.0]), 10.0: np.array([1.0, 1.0, 1.0, 5.0])}
    fitting = SimpleNamespace(
        distances=lambda points: distances[float(np.linalg.norm(points[1]))], points="facets", told=lambda _: None
    )
    goal: Any = SimpleNamespace(fitting=fitting, model=SimpleNamespace(seed=SimpleNamespace(vertices_coords=seed)))
    one: Any = SimpleNamespace(vertices_coords=found)
    fit = measures.fit(goal, one)
    assert (fit.rms, fit.max) == (pytest.approx(7**0.5), 5.0)
    assert (fit.rms_relative, fit.max_relative) == (pytest.approx(7**0.5 / 10), 0.5)
    assert (fit.start_rms, fit.start_rms_relative) == (pytest.approx(6**0.5), pytest.approx(6**0.5 / 5))
    assert "rings" not in fit.document()


def test_every_side_and_area_that_is_limited_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """A box of 5 x 2 flat, and one of 5 x 2 x 3 half open of which the height alone is limited."""
    box = np.array([[0.0, 0, 0], [5, 2, 3]])
    monkeypatch.setattr(measures.folded, "laid_out", lambda *_: box)
    inf = np.inf

    def state(name: str, limits: list[float], area: float, sides: list[int]) -> Any:
        d = len(limits)
        axes = np.eye(d)[sides]
        return SimpleNamespace(
            name=name, t=0.0, dimension=d, sides=sides, limits=np.array(limits), area=area, axes=lambda _: axes
        )

    packed = (state("flat", [6.0, inf], 11.0, [0, 1]), state("90 degrees", [inf, inf, 4.0], inf, [2]))
    goal: Any = SimpleNamespace(packed=packed, model=SimpleNamespace(design=lambda x: x))
    assert measures.limits(goal, np.zeros(1)) == [
        {"state": "flat", "measure": "length", "value": 5.0, "limit": 6.0},
        {"state": "flat", "measure": "area", "value": 10.0, "limit": 11.0},
        {"state": "90 degrees", "measure": "height", "value": 3.0, "limit": 4.0},
    ]
