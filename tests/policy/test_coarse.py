"""Starts from a coarser grid: when there is one, how its movement is spread, and that the same design comes out."""

from __future__ import annotations

import signal
import sys
from typing import Any

import numpy as np
import pytest
from designs import assert_close

import inverse
from inverse.formulation.formulate import formulate
from inverse.origami.pattern import FloatArray
from inverse.policy import coarse
from inverse.solvers.ipopt import EASED
from inverse.solvers.run import Progress

DOME = {"height": "sqrt(1 - x^2 - y^2)", "domain": [[-0.6, 0.6], [-0.6, 0.6]]}


def task(size: tuple[int, int], **keys: Any) -> inverse.spec.Loaded:
    pattern = {"size": list(size), **keys.pop("pattern", {})}
    return inverse.load({"name": "dome", "pattern": pattern, "target": DOME} | keys)


def seed(m: int, n: int) -> inverse.Design:
    return formulate(task((m, n))).goal.model.seed


def sheet(points: FloatArray) -> FloatArray:
    """A cubic movement, which cubic splines follow exactly."""
    x, y = points[..., 0], points[..., 1]
    return np.stack([0.3 * x**2 * y, 0.1 * y**3 - x * y, 0.5 * x**3 + 0.2], axis=-1)


def parameter(m: int, n: int) -> FloatArray:
    u, v = np.meshgrid(np.linspace(0, 1, m + 1), np.linspace(0, 1, n + 1), indexing="ij")
    return np.stack([u, v], axis=-1)


def corrugation(m: int, n: int) -> FloatArray:
    """Movements of the four parities, zero in the mean, in proportion to the facets' size."""
    i, j = np.meshgrid(np.arange(m + 1) % 2, np.arange(n + 1) % 2, indexing="ij")
    own = np.array([[[1.0, 0, 2], [0, -1, 1]], [[-1, 1, 0], [0, 0, -3]]])
    return np.asarray(own[i, j] * (1 + parameter(m, n).sum(axis=-1)[..., None]) / np.sqrt(m * n))


@pytest.mark.parametrize("size", [(8, 8), (10, 12)])
def test_movements_are_spread_by_parity(size: tuple[int, int]) -> None:
    (m, n), (fine_m, fine_n) = size, (2 * size[0], 2 * size[1])
    coarse_seed, fine_seed = seed(m, n), seed(fine_m, fine_n)
    moved = coarse_seed.vertices_coords + (sheet(parameter(m, n)) + corrugation(m, n)).reshape(-1, 3)
    wanted = fine_seed.vertices_coords + (sheet(parameter(fine_m, fine_n)) + corrugation(fine_m, fine_n)).reshape(-1, 3)
    assert_close(coarse.spread(coarse_seed, moved, fine_seed), wanted, 1e-12)


def test_the_coarse_task_is_alike_but_for_its_size() -> None:
    lengths = [2.0] * 40
    loaded = task(
        (40, 60), pattern={"v_lines": ["CFL"] * 59, "lengths_u": lengths, "turn": 90}, fit={"points": "layer"}
    )
    found = coarse.coarsened(loaded)
    assert found is not None
    pattern = found.specification.pattern
    assert isinstance(pattern, inverse.spec.GridPattern)
    assert pattern.size == (20, 30)
    assert (pattern.u_lines, pattern.v_lines, pattern.turn) == ("FL", "CFL", 90)
    assert found.specification.fit == loaded.specification.fit
    formulate(found)


@pytest.mark.parametrize(
    ("size", "keys"),
    [
        ((32, 32), {}),
        ((33, 40), {}),
        ((40, 41), {}),
        ((512, 14), {}),
        ((40, 40), {"pattern": {"v_lines": ["CFL"] + ["FL"] * 38}}),
        ((40, 40), {"pattern": {"lengths_v": [1.0] * 39 + [1.5]}}),
        ((40, 40), {"objectives": {"footprint": 1e-3}}),
        ((40, 40), {"constraints": {"footprint": {"width": 1}}}),
        (
            (40, 40),
            {
                "constraints": {
                    "anchors": [{"side": "u0", "to": {"plane": {"point": [-0.6, 0, 0], "normal": [1, 0, 0]}}}]
                }
            },
        ),
    ],
)
def test_no_coarse_task(size: tuple[int, int], keys: dict[str, Any]) -> None:
    assert coarse.coarsened(task(size, **keys)) is None


def test_the_start_leads_to_the_same_design(monkeypatch: pytest.MonkeyPatch) -> None:
    direct = inverse.solve(task((16, 16)))
    assert {a["facets"] for a in direct.report["attempts"]} == {256}
    monkeypatch.setattr(sys.modules["inverse.policy.coarse"], "FINE", 200)
    result = inverse.solve(task((16, 16)))
    assert result.certified
    assert result.converged
    attempts = result.report["attempts"]
    assert [a["facets"] for a in attempts[:3]] == [64, 64, 256]
    assert any(EASED in a["method"] for a in attempts[3:])
    assert_close(result.design.vertices_coords, direct.design.vertices_coords, 1e-6)


def test_a_stop_on_the_coarse_grid_leaves_the_seed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules["inverse.policy.coarse"], "FINE", 200)
    result = inverse.solve(task((16, 16), solver={"time_limit_s": 1e-3}))
    assert result.interrupted
    assert not result.converged
    assert_close(result.design.vertices_coords, result.seed.vertices_coords, 1e-9)


@pytest.mark.parametrize("at", [0, 3])
def test_a_stop_on_the_fine_grid_gives_a_design(at: int, monkeypatch: pytest.MonkeyPatch) -> None:
    def watch(phase: str, progress: Progress) -> None:
        if phase.startswith("256 facets") and progress.iteration == at:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(sys.modules["inverse.policy.coarse"], "FINE", 200)
    result = inverse.solve(task((16, 16)), watch=watch)
    assert result.interrupted
    assert result.certified
    assert not result.converged
