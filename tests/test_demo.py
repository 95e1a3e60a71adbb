"""The specifications in targets/ as they are shipped, at full size."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import inverse
from inverse.context import facing_eaves, read_city_json
from inverse.crossing import crossing_facets
from inverse.origami import folding, geometry
from inverse.origami.pattern import FloatArray

pytestmark = pytest.mark.slow
TARGETS = Path(__file__).parents[1] / "targets"
WEST = np.array([[-7.732, -10.610, 20.579], [-4.236, 12.547, 20.640]])
EAST = np.array([[3.410, -12.308, 18.937], [6.970, 10.840, 18.937]])


def solved(name: str) -> inverse.Result:
    result = inverse.solve(inverse.load(TARGETS / name))
    assert result.certified, result.status
    assert result.converged, result.status
    assert result.as_asked
    assert result.coverage.covered >= 0.91
    assert result.report["fit"]["rms"] < 0.15 * result.report["fit"]["start_rms"]
    return result


def off_segment(points: FloatArray, segment: FloatArray) -> float:
    """Largest distance of points (N, 3) from a segment (2, 3)."""
    a, b = segment
    along = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    return float(np.linalg.norm(points - a - along[:, None] * (b - a), axis=1).max())


def test_the_vault_hangs_on_both_eaves_and_keeps_its_headroom() -> None:
    result = solved("vault.yaml")
    assert result.design.pattern.grid == (16, 24)
    points = result.design.vertices_coords.reshape(17, 25, 3)
    size = geometry.diagonal(result.design.vertices_coords)
    assert off_segment(points[0, ::2], WEST) <= 1e-9 * size
    assert off_segment(points[-1, ::2], EAST) <= 1e-9 * size
    assert points[..., 2].min() >= 18.3 - 1e-6
    assert result.report["fit"]["rms_relative"] <= 0.003
    lengths = geometry.edge_lengths(result.design.pattern, result.design.vertices_coords)
    seed_lengths = geometry.edge_lengths(result.seed.pattern, result.seed.vertices_coords)
    assert (lengths / seed_lengths).min() > 0.7
    assert (lengths / seed_lengths).max() < 1.4
    assert result.certificate.free_range == (0.0, 180.0)


def test_the_courtyard_is_covered_and_nothing_passes_its_walls() -> None:
    """Measured by areas in plan: what is under the sky without a facet, and what is beyond the walls."""
    shapely = pytest.importorskip("shapely")
    result = solved("courtyard.yaml")
    points, court = result.design.vertices_coords, shapely.box(-7, -4.5, 7, 4.5)
    facets = [shapely.Polygon(points[list(face), :2]).buffer(0) for face in result.design.pattern.faces_vertices]
    roof = shapely.union_all(facets)
    assert roof.intersection(court).area >= 0.999 * court.area
    assert np.abs(points[:, 0]).max() <= 7 + 1e-6
    assert np.abs(points[:, 1]).max() <= 4.5 + 1e-6
    table = points.reshape(15, 19, 3)
    for side, axis, wall in ((table[0], 0, -7), (table[-1], 0, 7), (table[:, 0], 1, -4.5), (table[:, -1], 1, 4.5)):
        assert np.abs(side[:, axis] - wall).max() <= 1e-8
    assert 6.3 < points[:, 2].max() < 7.3
    (limit,) = [one for one in result.report["footprint"]["limits"] if one["measure"] == "length"]
    assert limit["value"] <= 3 + 1e-5
    assert result.iterations < 120  # 5 seconds of one core
    assert result.certificate.free_range == (0.0, 180.0)


def test_the_eaves_are_those_of_the_buildings() -> None:
    context = read_city_json(TARGETS / "vienna_excerpt.city.jsonl", (1275.0, 340849.0, 30.0))
    names = ("UUID_LOD2_011530-cf0ab883-2798-437c-b530", "UUID_LOD2_011502-469b227e-b1ee-4cea-a625")
    for found, written in zip(facing_eaves(context, *names), (WEST, EAST), strict=True):
        assert np.abs(found[[0, -1]] - written).max() < 0.001  # written to the millimetre
        assert off_segment(found, written) < 0.002


@pytest.mark.parametrize(("name", "rms"), [("dome.yaml", 3e-4), ("landscape.yaml", 1.2e-3), ("pleats.yaml", 1e-2)])
def test_the_other_examples(name: str, rms: float) -> None:
    assert solved(name).report["fit"]["rms_relative"] <= rms


def test_pleats_are_kept_apart() -> None:
    result = solved("pleats.yaml")
    assert len(crossing_facets(result.design.vertices_coords, result.design.pattern.faces_vertices)) == 0


def test_a_large_sheet_folds_without_a_gap() -> None:
    seed = inverse.seeds.grid((64, 64))
    motion = folding.fold(seed)
    assert motion.vertices_coords.shape == (64, 65 * 65, 3)
    assert motion.gap.max() < 1e-11 * geometry.diagonal(seed.vertices_coords)
