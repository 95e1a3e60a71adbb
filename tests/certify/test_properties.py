"""The verdict does not depend on how a file is written, and no file whatsoever makes the certificate fail."""

from __future__ import annotations

import copy
import json

import numpy as np
import pytest
from certify_cases import SIX_GON, document, failures, moved, opened_tube, relabelled, verdict
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from inverse import certify
from inverse.errors import InputError
from inverse.files import fold_file

MEASURED = ("planarity", "developability", "flat_foldability", "fold_angle", "motion_gap", "loop_closure")
SAMPLES = ("miura", "eggbox", "hybrid", "6-gon tube")


def _spoilt(name):
    doc = document(name)
    doc["vertices_coords"][7] = [x + 1e-3 * k for k, x in enumerate(doc["vertices_coords"][7], 1)]
    return doc


def _assert_same(first, second, rel):
    assert failures(first) == failures(second)
    assert first.topology == second.topology
    for name in MEASURED:
        a, b = first.checks[name].value, second.checks[name].value
        # Rounding is all that may differ where the values themselves are rounding.
        assert a == pytest.approx(b, rel=rel, abs=1e-13), name


@pytest.mark.parametrize("scale", [1.0, 1000.0, 0.001])
@pytest.mark.parametrize("make", [document, _spoilt])
@pytest.mark.parametrize("name", SAMPLES)
def test_rigid_motions_and_scaling_change_nothing(name, make, scale, tmp_path):
    rng = np.random.default_rng(5)
    rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    rotation *= np.sign(np.linalg.det(rotation))
    first = verdict(make(name), tmp_path)
    second = verdict(moved(make(name), np.eye(3), np.zeros(3), scale), tmp_path)
    _assert_same(first, second, 1e-9)
    # Gaps are told in diagonals of the bounding box, whose axes do not turn with the design.
    third = verdict(moved(make(name), rotation, np.array([3.0, -2.0, 5.0]), scale), tmp_path)
    assert failures(third) == failures(first)
    for check in ("planarity", "developability", "flat_foldability", "fold_angle"):
        assert third.checks[check].value == pytest.approx(first.checks[check].value, rel=1e-7, abs=1e-13)
    for check in ("motion_gap", "loop_closure"):
        assert third.checks[check].value == pytest.approx(first.checks[check].value, rel=0.8, abs=1e-13)


@pytest.mark.parametrize("name", SAMPLES)
@pytest.mark.parametrize("seed", range(3))
def test_numbering_changes_nothing(name, seed, tmp_path):
    rng = np.random.default_rng(seed)
    _assert_same(verdict(document(name), tmp_path), verdict(relabelled(document(name), rng), tmp_path), rel=1e-9)


def test_numbering_does_not_change_the_verdict_on_a_tube_that_opens(tmp_path):
    doc = fold_file.document(opened_tube(SIX_GON, 3, 0.02))
    first, second = (verdict(d, tmp_path) for d in (doc, relabelled(doc, np.random.default_rng(1))))
    assert failures(first) == failures(second) == {"structure", "motion_gap", "loop_closure"}


def test_exchanging_fl_and_cfl_exchanges_the_flat_states(tmp_path):
    doc = _spoilt("eggbox")
    doc["bdffpq:edges_type"] = [{"FL": "CFL", "CFL": "FL", "B": "B"}[t] for t in doc["bdffpq:edges_type"]]
    first, second = verdict(_spoilt("eggbox"), tmp_path), verdict(doc, tmp_path)
    assert first.checks["developability"].value == pytest.approx(second.checks["flat_foldability"].value)
    assert first.checks["flat_foldability"].value == pytest.approx(second.checks["developability"].value)
    assert first.checks["motion_gap"].value == pytest.approx(second.checks["motion_gap"].value)


@pytest.mark.parametrize("shift", [0.0, -20.0])
@pytest.mark.parametrize("scale", [1e-300, 1e10])
def test_numbers_near_the_ends_of_the_range_are_no_trouble(scale, shift, tmp_path):
    certificate = verdict(moved(document("6-gon tube"), np.eye(3), np.full(3, shift), scale), tmp_path)
    assert certificate.certified, certificate.faults


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=3) | st.just(10**400),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
    max_leaves=6,
)


def _places(node, path=()):
    yield path
    for key, inner in node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ():
        yield from _places(inner, (*path, key))


SMALL = {name: document(name) for name in ("6-gon tube", "one hinge", "miura")}
# Deep places far outnumber the others: choose a depth first.
PLACES = {
    name: {depth: [p for p in _places(doc) if len(p) == depth] for depth in range(1, 5)} for name, doc in SMALL.items()
}


@st.composite
def corrupted(draw):
    """A document with some of its values replaced, removed, exchanged or moved."""
    name = draw(st.sampled_from(sorted(SMALL)))
    doc = copy.deepcopy(SMALL[name])
    for _ in range(draw(st.integers(1, 4))):
        depth = draw(st.sampled_from([d for d, places in PLACES[name].items() if places]))
        *path, key = draw(st.sampled_from(PLACES[name][depth]))
        node = doc
        try:
            for step in path:
                node = node[step]
            action = draw(st.sampled_from(["replace", "number", "remove", "double", "exchange"]))
            if action == "replace":
                node[key] = draw(JSON)
            elif action == "number" and isinstance(node[key], int | float):
                node[key] = draw(st.integers(-1, 30) | st.floats(-1e3, 1e3) | st.just(node[key] * (1 + 1e-6)))
            elif action == "remove":
                del node[key]
            elif action == "double" and isinstance(node, list):
                node.append(copy.deepcopy(node[key]))
            elif action == "exchange" and isinstance(node, list):
                other = draw(st.integers(0, len(node) - 1))
                node[key], node[other] = node[other], node[key]
        except (KeyError, IndexError, TypeError):
            pass  # the place went with an earlier change
    return doc


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(doc=corrupted())
def test_corrupted_files_get_a_certificate_or_an_input_error(doc, tmp_path):
    path = tmp_path / "design.fold"
    path.write_text(json.dumps(doc))
    try:
        certificate = certify.check(path)
    except InputError:
        return
    json.dumps(certificate.document(), allow_nan=False)
    assert all(item.sentence for item in certificate.checks.values())
    assert certificate.certified == (not failures(certificate))


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_moved_vertex_never_passes(data, tmp_path):
    name = data.draw(st.sampled_from(["miura", "eggbox", "6-gon tube"]))
    doc = document(name)
    vertex = data.draw(st.integers(0, len(doc["vertices_coords"]) - 1))
    direction = np.array(data.draw(st.tuples(*[st.floats(-1, 1)] * 3)))
    length = np.linalg.norm(direction)
    if length < 0.1:
        direction, length = np.array([1.0, 0.3, 0.2]), np.linalg.norm([1.0, 0.3, 0.2])
    shift = 10 ** data.draw(st.floats(-6, -1)) * direction / length
    doc["vertices_coords"][vertex] = (np.array(doc["vertices_coords"][vertex]) + shift).tolist()
    # A vertex on the rim may slide in the plane of its facet: then only the flat states can tell.
    assert not verdict(doc, tmp_path).certified
