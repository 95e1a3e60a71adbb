"""Small domes that several test files solve, each once, and what every good design keeps."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import inverse
from inverse.origami import folding, geometry

DOME = {"height": "0.45 - 0.3*(x^2 + y^2)", "domain": [[-0.6, 0.6], [-0.6, 0.6]]}
PATTERNS: dict[str, dict[str, Any]] = {
    "miura": {"size": [6, 6]},
    "eggbox": {"size": [6, 7], "u_lines": "CFL"},
    "hybrid": {"size": [6, 9], "v_lines": ["FL", "FL", "FL", "CFL", "CFL", "FL", "FL", "FL"]},
    "other": {"size": [8, 6], "sector_angle": 70, "fold_state": 0.3, "lengths_u": [1, 2] * 4, "turn": 90},
}


def task(folder: Path = Path(), **keys: Any) -> inverse.spec.Loaded:
    keys = {"name": "dome", "pattern": PATTERNS["miura"], "target": DOME} | keys
    return inverse.load(keys, folder=folder)


@cache
def dome(pattern: str = "miura") -> inverse.Result:
    return inverse.solve(task(pattern=PATTERNS[pattern]))


def assert_good(result: inverse.Result, gain: float = 0.02) -> None:
    """Certified, converged, nearer to its target than the seed by ``gain``, and within its bounds."""
    assert result.certified
    assert result.converged
    assert not result.interrupted
    design, seed, fit = result.design, result.seed, result.report["fit"]
    assert fit["rms"] < gain * fit["start_rms"]
    assert result.coverage.covered > 0.4  # networks of their own are no rectangles
    assert np.abs(design.vertices_coords - seed.vertices_coords).max() > 0.01 * geometry.diagonal(seed.vertices_coords)
    pattern, points = design.pattern, design.vertices_coords
    folds = np.degrees(geometry.fold_angles(pattern, points))[pattern.interior_edges]
    before = geometry.fold_angles(pattern, seed.vertices_coords)[pattern.interior_edges]
    assert (np.sign(folds) == np.sign(before)).all()
    assert np.abs(folds).min() > 20 - 1e-4
    assert np.abs(folds).max() < 160 + 1e-4
    sectors = np.degrees(geometry.sector_angles(pattern, points))
    assert sectors.min() > 14 - 1e-4
    assert sectors.max() < 166 + 1e-4
    factors = geometry.edge_lengths(pattern, points) / geometry.edge_lengths(pattern, seed.vertices_coords)
    assert factors.min() > 0.3 - 1e-6
    assert factors.max() < 3 + 1e-6
    assert folding.fold(design).gap.max() < 1e-12 * geometry.diagonal(points)
