"""Tubes from specifications to certified designs: with the exact loop condition, with bars, and around holes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from designs import holed

import inverse
from inverse.nlp.point import Point
from inverse.origami.geometry import diagonal
from inverse.solvers.ipopt import Ipopt
from inverse.solvers.run import Ending
from inverse.spec import load

STRAIGHT = {"polyline": [[0, 0, 0], [0, 0, 6]]}
TAPER = {"axis": STRAIGHT, "radius": [[0, 1.0], [1, 0.6]]}
QUARTER = {"axis": {"arc": [[0, 0, 0], [1.7574, 0, 4.2426], [6, 0, 6]]}, "radius": [[0, 1.0], [1, 0.6]]}
WAIST = {"axis": STRAIGHT, "radius": [[0, 1.0], [0.25, 0.85], [0.5, 0.7], [0.75, 0.85], [1, 1.0]]}


def solve(sides: int, rows: int, target: dict[str, Any], **keys: Any) -> inverse.Result:
    task = {"name": "tube", "pattern": {"kind": "tube", "size": [sides, rows]}, "target": target}
    return inverse.solve(load(task | keys))


def assert_solved(result: inverse.Result, deviation: float = 0.01) -> None:
    """Certified and converged, near the target, and with nothing to hide about its closure."""
    assert result.ending == "solved", result.status
    assert result.report["fit"]["mean_over_radius"] <= deviation
    (loop,) = result.certificate.loops
    assert loop.states == len(loop.facets) + 1
    assert loop.gap < 1e-12
    motion = inverse.fold(result.design)
    assert motion.gap.max() < 1e-12 * diagonal(result.design.vertices_coords)
    told = result.report["equations"]
    k, rows = result.design.pattern.grid or (0, 0)
    assert told["freedom"] == 3 * rows + 7 * k // 2
    assert told["rows"] - told["rank"] == 3 * (rows - 1)
    assert 1 < told["condition"] < 1e5


def test_a_taper_needs_the_exact_condition() -> None:
    exact = solve(6, 10, TAPER)
    assert_solved(exact, 1e-3)
    bars = solve(6, 10, TAPER, constraints={"loop": "bars"})
    assert bars.certified
    assert sum(bars.report["objective"].values()) > 1000 * sum(exact.report["objective"].values())
    assert bars.report["fit"]["mean_over_radius"] > 0.05


@pytest.mark.parametrize("sides", [4, 8])
def test_tapers_of_other_sections(sides: int) -> None:
    assert_solved(solve(sides, 6, TAPER), 1e-3)


@pytest.mark.parametrize("sides", [4, 6, 8])
def test_waists(sides: int) -> None:
    assert_solved(solve(sides, 10, WAIST))


def test_a_long_tube_along_a_quarter_circle() -> None:
    result = solve(8, 24, QUARTER)
    assert_solved(result, 5e-3)
    assert result.certificate.free_range == (0.0, 180.0)


def test_the_same_task_gives_the_same_design() -> None:
    first, second = (solve(6, 6, TAPER) for _ in range(2))
    assert np.array_equal(first.design.vertices_coords, second.design.vertices_coords)


def test_the_other_solver_does_without_independent_rows() -> None:
    assert_solved(solve(4, 6, TAPER, solver={"method": "nlopt"}), 1e-3)


@pytest.mark.parametrize("holes", [((3, 3),), ((2, 2), (2, 3), (3, 2), (3, 3))], ids=["one facet", "four facets"])
def test_a_dome_with_a_hole(holes: tuple[tuple[int, int], ...], tmp_path: Path) -> None:
    inverse.write(holed(size=7, holes=holes), tmp_path / "holed.fold")
    task = {
        "name": "dome",
        "pattern": {"kind": "file", "file": str(tmp_path / "holed.fold")},
        "target": {"height": "0.45 - 0.3*(x^2+y^2)", "domain": [[-1, 1], [-1, 1]]},
    }
    result = inverse.solve(load(task))
    assert result.certified, result.status
    assert result.converged, result.status
    assert result.design.pattern.n_holes == 1
    assert result.certificate.loops[0].gap < 1e-12
    assert result.report["fit"]["rms_relative"] < 0.0005


def test_newton_is_given_independent_equations_and_the_approach_all(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[tuple[bool, int, float]] = []
    right = Ipopt._run

    def watched(solver: Ipopt, start: Point, parameters: Any, left_out: Any, *more: Any, **options: Any) -> Any:
        run = right(solver, start, parameters, left_out, *more, **options)
        # The last parameter is 0 where the constraints' curvature is left out: the approach.
        push = np.abs(run.end.balance[left_out]).max(initial=0.0) / np.abs(run.end.balance).max()
        # A run that breaks off has pushes of its last step.
        seen.append((bool(start.parameters[-1] == 0.0), len(left_out), push if run.ending is Ending.SOLVED else 0.0))
        return run

    monkeypatch.setattr(Ipopt, "_run", watched)
    result = solve(4, 6, TAPER)
    assert result.ending == "solved"
    assert {(is_approach, count) for is_approach, count, _ in seen} == {(True, 0), (False, 15)}
    assert max(push for *_, push in seen) < 1e-12, seen


def test_a_tube_is_packed() -> None:
    """docs/footprint.md says how far."""
    free, packed = solve(6, 10, TAPER), solve(6, 10, TAPER, objectives={"footprint": 1e-3})
    assert packed.ending == "solved", packed.status
    areas = [result.report["footprint"]["flat-folded"]["area"] for result in (free, packed)]
    assert areas[0] == pytest.approx(3.21 * 2.01, rel=0.01)
    assert areas[1] == pytest.approx(2.18 * 1.31, rel=0.01)
    limit = solve(6, 10, TAPER, constraints={"footprint": {"length": 2.9}})
    assert limit.ending == "solved", limit.status
