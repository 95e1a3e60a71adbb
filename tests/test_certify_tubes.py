"""Tubes: vertex conditions alone do not keep a tube closed, and the certificate sees it."""

from __future__ import annotations

import numpy as np
import pytest
from certify_cases import FOUR_GON, SIX_GON, failures, relabelled, verdict

from inverse import fold_file, seeds
from inverse.certify import loops
from inverse.certify.mesh import build_mesh

SECTIONS = {"4-gon": FOUR_GON, "6-gon": SIX_GON}


def _conditions(design, x):
    """Residuals of the vertex conditions (6), (7) as cosines and of planarity as volumes."""
    pattern, points = design.pattern, x.reshape(-1, 3)
    spokes = points[pattern.ring_vertices] - points[pattern.interior_vertices][:, None]
    spokes /= np.linalg.norm(spokes, axis=2, keepdims=True)
    cosines = np.einsum("ikd,ikd->ik", spokes, np.roll(spokes, -1, axis=1))
    opposite = np.where(pattern.is_miura_vertex, 1, -1)[:, None] * cosines[:, 2:]
    quads = points[np.array(pattern.faces_vertices)]
    volumes = np.linalg.det(quads[:, 1:] - quads[:, :1])
    return np.concatenate([(cosines[:, :2] + opposite).ravel(), volumes])


def opened_tube(section, n_rows, amount, seed=1):
    """A tube that closes in the design state and satisfies every condition but that of its loop.

    A seed moved in a random direction, then brought back to the conditions by Newton steps of least norm.
    """
    design = seeds.tube(section, n_rows)
    x = design.vertices_coords.ravel()
    x = x + amount * np.random.default_rng(seed).normal(size=x.size)
    step = 1e-6
    for _ in range(30):
        residual = _conditions(design, x)
        if np.abs(residual).max() < 1e-15:
            break
        jacobian = np.stack(
            [
                (_conditions(design, x + step * e) - _conditions(design, x - step * e)) / (2 * step)
                for e in np.eye(x.size)
            ],
            axis=1,
        )
        x = x - np.linalg.lstsq(jacobian, residual, rcond=1e-7)[0]
    return design.moved_to(x.reshape(-1, 3))


@pytest.mark.parametrize("amount", [1e-4, 0.03])
@pytest.mark.parametrize("section", SECTIONS)
def test_a_tube_that_opens_is_rejected_with_gap_and_state(section, amount, tmp_path):
    doc = fold_file.document(opened_tube(SECTIONS[section], 2, amount))
    del doc["file_frames"]  # it has no flat states to show
    certificate = verdict(doc, tmp_path)
    assert failures(certificate) == {"motion_gap", "loop_closure"}
    for name in ("planarity", "developability", "flat_foldability"):
        assert certificate.checks[name].value < 1e-13
    for name in ("motion_gap", "loop_closure"):
        assert 0.1 * amount < certificate.checks[name].value < 10 * amount
        assert " at t = " in certificate.checks[name].worst
    assert certificate.checks["motion_gap"].worst.startswith("edge ")
    assert certificate.checks["loop_closure"].worst.startswith("hole 0, strip of ")


def test_every_closed_strip_of_a_tube_opens_alike_in_rotation(tmp_path):
    # Homologous strips are conjugate: closure does not depend on which one is taken.
    doc = fold_file.document(opened_tube(SIX_GON, 3, 0.02))
    first = verdict(doc, tmp_path)
    doc["faces_vertices"] = doc["faces_vertices"][9:] + doc["faces_vertices"][:9]
    for key in ("bdffpq:holes", "bdffpq:grid", "file_frames"):
        del doc[key]
    second = verdict(doc, tmp_path)
    gaps = [certificate.checks["loop_closure"].value for certificate in (first, second)]
    assert gaps[0] == pytest.approx(gaps[1], rel=0.2)


def test_closure_at_the_nodes_alone_finds_the_gap(monkeypatch, tmp_path):
    doc = fold_file.document(opened_tube(SIX_GON, 2, 1e-3))
    everywhere = verdict(doc, tmp_path).checks["loop_closure"].value
    monkeypatch.setattr(loops, "N_SPOT_CHECKS", 0)
    at_nodes = verdict(doc, tmp_path).checks["loop_closure"].value
    assert 0.2 * everywhere < at_nodes <= everywhere


@pytest.mark.parametrize("column", range(6))
def test_a_strip_that_winds_is_a_strip_whatever_the_numbering(column, tmp_path):
    doc = fold_file.document(seeds.tube(SIX_GON, 4))
    i, j = column, (column + 1) % 6
    there = [(i, 0), (j, 0), (j, 1), (i, 1), (i, 2)]
    rest = [((column + k) % 6, 2) for k in range(1, 6)]
    back = [((column + 5) % 6, row) for row in (1, 0)]
    doc["bdffpq:holes"] = [[4 * a + b for a, b in there + rest + back]]
    doc = relabelled(doc, np.random.default_rng(column))
    certificate = verdict(doc, tmp_path)
    assert certificate.certified, certificate.faults
    mesh, _ = build_mesh(doc["faces_vertices"], len(doc["vertices_coords"]))
    cuts = loops.cut_open(mesh)
    assert len(cuts.stretches[0]) == np.count_nonzero(cuts.windings) >= 4


@pytest.mark.parametrize("n_rows", [2, 7])
@pytest.mark.parametrize("section", SECTIONS)
def test_the_strip_around_a_tube_is_the_shortest(section, n_rows, tmp_path):
    certificate = verdict(fold_file.document(seeds.tube(SECTIONS[section], n_rows)), tmp_path)
    assert certificate.certified
    (loop,) = certificate.loops
    assert len(loop.facets) == len(SECTIONS[section])
    # Facets (i, j) are i n_rows + j: a straight strip stays in one row.
    assert len({f % n_rows for f in loop.facets}) == 1


def test_an_odd_number_of_lines_around_a_hole_leaves_no_flat_state(tmp_path):
    # The frustum of a pyramid: four planar facets around, one fold of another type than it should be.
    angle = np.pi / 2 * np.arange(4)
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    doc = fold_file.document(seeds.tube(FOUR_GON, 1))
    doc["vertices_coords"] = np.stack([2 * ring, ring + np.array([0, 0, 1])], axis=1).reshape(-1, 3).tolist()
    del doc["file_frames"]
    k = next(k for k, pair in enumerate(doc["edges_vertices"]) if set(pair) == {0, 1})
    doc["bdffpq:edges_type"][k] = {"FL": "CFL", "CFL": "FL"}[doc["bdffpq:edges_type"][k]]
    certificate = verdict(doc, tmp_path)
    assert any("the number of FL lines around a hole is odd" in fault for fault in certificate.faults)
    assert any("the number of CFL lines around a hole is odd" in fault for fault in certificate.faults)
    assert certificate.checks["developability"].value is None
