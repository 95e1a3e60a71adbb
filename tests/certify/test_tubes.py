"""Tubes: vertex conditions alone do not keep a tube closed, and the certificate sees it."""

from __future__ import annotations

import numpy as np
import pytest
from certify_cases import FOUR_GON, SIX_GON, failures, opened_tube, relabelled, verdict

from inverse.certify import loops
from inverse.certify.mesh import build_mesh
from inverse.files import fold_file
from inverse.origami import seeds

SECTIONS = {"4-gon": FOUR_GON, "6-gon": SIX_GON}


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


@pytest.mark.parametrize("section", SECTIONS)
def test_a_loop_tells_its_states_and_how_gaps_may_grow_between_them(section, tmp_path):
    k = len(SECTIONS[section])
    (loop,) = verdict(fold_file.document(opened_tube(SECTIONS[section], 2, 1e-3)), tmp_path).loops
    assert loop.states == k + 1
    assert loop.gap == max(loop.gap_at_states, loop.gap_between) > 1e-5
    # A polynomial of degree k that is 1 or -1 at every node, drawn through the nodes by least squares.
    nodes, between = np.pi * np.arange(k + 1) / (k + 1), np.linspace(0, np.pi, 4001)
    powers = [np.stack([np.cos(t) ** (k - i) * np.sin(t) ** i for i in range(k + 1)], axis=1) for t in (nodes, between)]
    through = powers[1] @ np.linalg.inv(powers[0])
    assert loop.conditioning == pytest.approx(np.abs(through).sum(axis=1).max(), rel=0.02)
    assert 1 < loop.conditioning < 2.5


@pytest.mark.parametrize("seed", range(6))
def test_a_strip_that_winds_is_a_strip_whatever_the_numbering(seed, tmp_path):
    doc = fold_file.document(seeds.tube(SIX_GON, 4))
    strips = []
    for i in range(6):
        columns = [(i + k) % 6 for k in range(6)]
        to_and_fro = [(columns[0], 0), (columns[1], 0), (columns[1], 1), (columns[0], 1), (columns[0], 2)]
        around = [(column, 2) for column in columns[1:]] + [(columns[5], 1), (columns[5], 0)]
        strips.append([4 * column + row for column, row in to_and_fro + around])
    doc["bdffpq:holes"] = strips
    doc = relabelled(doc, np.random.default_rng(seed))
    for strip in doc["bdffpq:holes"]:
        certificate = verdict({**doc, "bdffpq:holes": [strip]}, tmp_path)
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
