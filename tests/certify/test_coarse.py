"""Far from the origin a file's own rounding decides, and the certificate says so instead of blaming the geometry."""

from __future__ import annotations

import json

import designs
import numpy as np
import pytest
from certify_cases import failures, frame_of

from inverse import certify
from inverse.files import fold_file

DESIGNS = {"miura": designs.miura(4, 4), "eggbox": designs.eggbox(4, 4), "6-gon tube": designs.tube(6, 4)}
ANGLES = ("planarity", "developability", "flat_foldability")
COARSE = "place the design near the origin"


def _certificate(design, offset, spoil=0.0, seed=0):
    """Of the design turned and moved away by ``offset`` diagonals, vertex 7 off by ``spoil``."""
    points = design.vertices_coords.copy()
    points[7] += spoil * np.array([1, 2, 3])
    direction = np.random.default_rng(seed).normal(size=3)
    away = offset * np.linalg.norm(np.ptp(points, axis=0)) * direction / np.linalg.norm(direction)
    document = fold_file.document(design.moved_to(points @ designs.rotation(seed).T + away))
    return certify.check_frame(frame_of(json.loads(json.dumps(document))))


def _last_digit(design, offset):
    """Of the largest coordinate, in shortest edges, roughly."""
    points, edges = design.vertices_coords, design.pattern.edges_vertices
    reach = (offset + 1) * np.linalg.norm(np.ptp(points, axis=0))
    return np.spacing(reach) / np.linalg.norm(np.diff(points[edges], axis=1), axis=2).min()


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", DESIGNS)
def test_measures_lose_nothing_beyond_the_rounding_of_the_file(name, seed):
    for offset in (0.0, 1.0, 1e2, 1e4, 1e5, 1e7, 1e9):
        certificate = _certificate(DESIGNS[name], offset, seed=seed)
        for check in ANGLES:
            assert certificate.checks[check].value < 10 * _last_digit(DESIGNS[name], offset), (offset, check)


@pytest.mark.parametrize("name", DESIGNS)
def test_sound_designs_at_coordinates_of_a_national_grid_are_certified(name):
    for offset in (1e2, 1e4, 1e5):
        certificate = _certificate(DESIGNS[name], offset)
        assert certificate.certified, (offset, failures(certificate))


@pytest.mark.parametrize("offset", [1e8, 1e9, 1e11])
@pytest.mark.parametrize("name", DESIGNS)
def test_coordinates_that_are_too_coarse_are_told(name, offset):
    certificate = _certificate(DESIGNS[name], offset)
    assert not certificate.certified
    told = [item for item in certificate.checks.values() if not item.passed and item.value is not None]
    assert told
    for item in told:
        if item.name in ("crossing_design", "fold_angle"):
            continue  # with a grain of millimetres on a model of metres, anything may happen
        assert item.worst.endswith(COARSE), item.sentence
        assert "of the shortest edge, which is too coarse" in item.sentence


@pytest.mark.parametrize("offset", [0.0, 1e2, 1e4, 1e5])
def test_a_fault_of_the_geometry_is_not_put_down_to_coordinates(offset):
    certificate = _certificate(DESIGNS["miura"], offset, spoil=1e-6)
    assert {*ANGLES, "motion_gap"} <= failures(certificate)
    assert not any(COARSE in item.worst for item in certificate.checks.values())
