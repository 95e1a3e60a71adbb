"""Design files keep every bit, are written whole or not at all, and other programs read them."""

from __future__ import annotations

import copy
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from designs import ALL, GENERAL, GRIDS, assert_close, best_motion, miura, polygonal, relabelled
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from inverse.errors import InputError
from inverse.files import fold_file
from inverse.origami import folding, geometry
from inverse.origami.pattern import Design

ARRAYS = ("edges_vertices", "edges_faces", "edges_type", "interior_vertices", "ring_vertices", "corners")
once_per_test = settings(
    max_examples=60,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)


def assert_same(a: Design, b: Design) -> None:
    assert a.vertices_coords.tobytes() == b.vertices_coords.tobytes()
    assert a.pattern.faces_vertices == b.pattern.faces_vertices
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(a.pattern, name), getattr(b.pattern, name))
    assert (a.unit, a.name, a.pattern.grid, a.pattern.topology) == (
        b.unit,
        b.name,
        b.pattern.grid,
        b.pattern.topology,
    )


@pytest.mark.parametrize("name", ALL)
def test_round_trip(name: str, tmp_path: Path) -> None:
    design = ALL[name]()
    fold_file.write(design, tmp_path / "design.fold")
    again = fold_file.read(tmp_path / "design.fold")
    assert_same(design, again)
    assert fold_file.document(design) == fold_file.document(again)


@once_per_test
@given(
    moves=st.lists(st.floats(-0.1, 0.1, allow_subnormal=True), min_size=27, max_size=27),
    size=st.floats(1e-6, 1e6),
    name=st.text(max_size=20),
)
def test_round_trip_keeps_every_bit(moves: list[float], size: float, name: str, tmp_path: Path) -> None:
    seed = miura(2, 2)
    coords = (seed.vertices_coords + np.reshape(moves, (9, 3))) * size
    design = Design(seed.pattern, coords, "mm", name)
    fold_file.write(design, tmp_path / "design.fold")
    assert_same(design, fold_file.read(tmp_path / "design.fold"))


def test_what_a_document_says() -> None:
    design = relabelled(polygonal())[0]
    document = fold_file.document(design)
    angles = np.array(document["edges_foldAngle"])
    words = np.array(document["edges_assignment"])
    assert_close(np.radians(angles), geometry.fold_angles(design.pattern, design.vertices_coords), 1e-14)
    np.testing.assert_array_equal(words == "V", angles > 0)
    np.testing.assert_array_equal(words == "M", angles < 0)
    np.testing.assert_array_equal(words == "B", np.array(document["bdffpq:edges_type"]) == "B")
    assert [frame["frame_title"] for frame in document["file_frames"]] == ["developed", "flat-folded"]
    for frame, t in zip(document["file_frames"], (0.0, np.pi), strict=True):
        assert (frame["frame_parent"], frame["frame_inherit"]) == (0, True)
        flat = np.array(frame["vertices_coords"])
        assert flat.shape == (design.pattern.n_vertices, 2)
        assert_close(flat, folding.flat_state(design, t)[:, :2], 1e-14)
        assert set(np.abs(frame["edges_foldAngle"])) <= {0.0, 180.0}


# ---- writing


@pytest.mark.parametrize("broken", ["replace", "chmod", "fdopen"])
def test_a_write_that_fails_leaves_what_was_there(broken: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "design.fold"
    fold_file.write(miura(2, 2), path)
    before = path.read_bytes()

    def fail(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, broken, fail)
    with pytest.raises(OSError, match="No space"):
        fold_file.write(miura(3, 3), path)
    monkeypatch.undo()
    assert path.read_bytes() == before
    assert os.listdir(tmp_path) == ["design.fold"]


def test_numbers_that_are_not_finite_are_not_written(tmp_path: Path) -> None:
    design = miura(2, 2)
    coords = design.vertices_coords.copy()
    coords[4] = np.nan
    with pytest.raises(ValueError, match="JSON"):
        fold_file.write(design.moved_to(coords), tmp_path / "design.fold")
    assert os.listdir(tmp_path) == []


# ---- reading


def read(document: Any, folder: Path) -> Design:
    path = folder / "design.fold"
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    return fold_file.read(path)


def changed(key: str, value: Any) -> dict[str, Any]:
    document = fold_file.document(miura(2, 2))
    if value is None:
        del document[key]
    else:
        document[key] = value(document[key]) if callable(value) else value
    return document


KEYS = (
    "vertices_coords", "edges_vertices", "faces_vertices",
    "edges_foldAngle", "edges_assignment", "bdffpq:edges_type",
)  # fmt: skip


@pytest.mark.parametrize("value", [None, 7, "x", {}, [None], [[0.5, "a", 1]], True, [[]]], ids=str)
@pytest.mark.parametrize("key", KEYS)
def test_a_key_that_is_missing_or_of_another_form_is_named(key: str, value: Any, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=f"{key}|facet 0 has vertices") as caught:
        read(changed(key, value), tmp_path)
    assert caught.value.where == str(tmp_path / "design.fold")


@pytest.mark.parametrize(
    ("key", "value", "match"),
    [
        ("vertices_coords", lambda v: [[*v[0], 0.0], *v[1:]], "vertices_coords must be a list of rows of 3"),
        ("vertices_coords", lambda v: v[:-1], "names a vertex that is not there|vertex numbers below 8"),
        ("vertices_coords", lambda v: [*v, [0, 0, 0]], "vertex 9 belongs to no facet"),
        ("vertices_coords", lambda v: [[np.nan] * 3, *v[1:]], "not finite"),
        ("vertices_coords", lambda v: [[-np.inf] * 3, *v[1:]], "not finite"),
        ("vertices_coords", lambda v: [[10**400] * 3, *v[1:]], "too large"),
        ("edges_vertices", lambda v: [[0, 99], *v[1:]], r"edges_vertices\[0\] names a vertex"),
        ("edges_vertices", lambda v: [[-1, 0], *v[1:]], r"edges_vertices\[0\] names a vertex"),
        ("edges_vertices", lambda v: [[10**30, 0], *v[1:]], "too large"),
        ("edges_foldAngle", lambda v: v[:-1], "edges_foldAngle has 11 entries for 12 edges"),
        ("edges_assignment", lambda v: v[:-1], "edges_assignment must be a list with one word"),
        ("edges_assignment", lambda v: ["F", *v[1:]], r"edges_assignment\[0\] is 'F': allowed are M, V, B"),
        ("edges_assignment", lambda v: [["M"], *v[1:]], r"edges_assignment\[0\]"),
        ("bdffpq:edges_type", lambda v: ["FFL", *v[1:]], r"edges_type\[0\] is 'FFL': allowed are B, FL, CFL"),
        ("bdffpq:edges_type", lambda v: ["B"] * len(v), "interior edge .* has no type"),
        ("faces_vertices", lambda v: [[0, 1, True], *v[1:]], r"faces_vertices\[0\]"),
        ("faces_vertices", lambda v: [v[0][::-1], *v[1:]], "same direction"),
        ("faces_vertices", lambda v: [v[0][:2], *v[1:]], "facet 0 has vertices"),
        ("bdffpq:grid", [7, 7], "grid"),
        ("bdffpq:grid", ["a", 2], "grid"),
        ("bdffpq:grid", [None, 2], "grid"),
        ("bdffpq:grid", [2, 2, 2], "grid"),
    ],
)  # fmt: skip
def test_what_is_refused(key: str, value: Any, match: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=match):
        read(changed(key, value), tmp_path)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("", "the file is empty"),
        ("{", "design.fold:1:2: this is not JSON"),
        ("[]", "the file must hold a JSON object"),
        ("[" * 100_000, "nested too deeply"),
        ('{"vertices_coords": ' + "[" * 100_000 + "}", "nested too deeply"),
        ("null", "JSON object"),
        ('{"vertices_coords": [[1, 2, ' + "9" * 5000 + "]]}", "JSON|large"),
    ],
)
def test_text_that_is_no_document(text: str, match: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=match):
        read(text, tmp_path)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such file"):
        fold_file.read(tmp_path / "missing.fold")
    with pytest.raises(InputError, match="this is a folder"):
        fold_file.read(tmp_path)
    (tmp_path / "bytes.fold").write_bytes(b"\xff\xfe{}")
    with pytest.raises(InputError, match=r"bytes\.fold:1:1: the byte 0xff is not valid UTF-8"):
        fold_file.read(tmp_path / "bytes.fold")


SAMPLES = [fold_file.document(design) for design in (miura(2, 2), relabelled(polygonal())[0])]
anything = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 40) | st.floats() | st.sampled_from(["", "FL", "M", "x", 10**400]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.sampled_from([*KEYS, "x"]), inner, max_size=2),
    max_leaves=6,
)


@settings(once_per_test, max_examples=400)
@given(data=st.data())
def test_any_change_of_a_document_is_read_or_refused(data: st.DataObject, tmp_path: Path) -> None:
    """Nothing but :class:`InputError` comes out, whatever stands in the file."""
    document = copy.deepcopy(data.draw(st.sampled_from(SAMPLES)))
    for _ in range(data.draw(st.integers(1, 3))):
        holder: Any = document
        for _ in range(data.draw(st.integers(0, 3))):
            inner = [
                x for x in (holder.values() if isinstance(holder, dict) else holder) if isinstance(x, list | dict) and x
            ]
            if not inner:
                break
            holder = data.draw(st.sampled_from(inner))
        places = list(holder) if isinstance(holder, dict) else list(range(len(holder)))
        place = data.draw(st.sampled_from(places))
        if data.draw(st.booleans()):
            holder[place] = data.draw(anything)
        elif len(holder) > 1:
            del holder[place]
    try:
        design = read(document, tmp_path)
    except InputError as refusal:
        where = refusal.where or ""
    else:
        where = str(tmp_path)
        assert np.isfinite(design.vertices_coords).all()
        assert design.pattern.n_vertices == len(design.vertices_coords)
    assert where.startswith(str(tmp_path))


# ---- other programs


@pytest.mark.node
@pytest.mark.parametrize("name", ["miura", "staircase", "polygonal", "holed"])
def test_rabbit_ear_folds_the_developed_state_as_we_do(name: str, rabbit_ear) -> None:
    """All lines are FL, so that the developed state is a crease pattern."""
    design = (GRIDS | GENERAL)[name]()
    document = fold_file.document(design)
    assert rabbit_ear(document)["validate"]["summary"] == "valid"
    developed = {k: v for k, v in document.items() if not k.startswith("file_frames")} | {
        k: v for k, v in document["file_frames"][0].items() if k.startswith(("vertices", "edges"))
    }
    findings = rabbit_ear(developed)
    assert findings["validate"]["summary"] == "valid"
    assert findings["kawasaki"] == findings["maekawa"] == []
    folded = np.array(document["file_frames"][1]["vertices_coords"])
    assert_close(best_motion(folded, np.array(findings["flat_folded"])), findings["flat_folded"], 1e-9)


def _stretched(factors: list[float]) -> dict[str, Any]:
    found = fold_file.document(miura(3, 3))
    found["vertices_coords"] = (np.array(found["vertices_coords"]) * factors).tolist()
    return found


@pytest.mark.parametrize(
    ("factors", "match"),
    [
        ([1e300, 1, 1], r"vertex \d+ is at .*: coordinates up to 1e\+12 are allowed"),
        ([1, 0, 0], "facet 0 .* has no area"),
        ([0, 0, 0], "all vertices of the design coincide"),
        ([1e-200, 1e-200, 1e-200], "at least 1e-12 is needed"),
    ],
)
def test_designs_that_no_arithmetic_can_hold(factors: list[float], match: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=match) as caught:
        read(_stretched(factors), tmp_path)
    assert str(tmp_path) in str(caught.value)


def test_a_design_too_far_away_for_its_digits(tmp_path: Path) -> None:
    document = _stretched([1, 1, 1])
    document["vertices_coords"] = (np.array(document["vertices_coords"]) + 1e11).tolist()
    with pytest.raises(InputError, match="away from the origin"):
        read(document, tmp_path)


def test_a_key_given_twice_is_refused(tmp_path: Path) -> None:
    text = json.dumps(_stretched([1, 1, 1]))[:-1] + ', "faces_vertices": []}'
    with pytest.raises(InputError, match="the key 'faces_vertices' is given twice"):
        read(text, tmp_path)


def test_a_byte_order_mark_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "design.fold"
    path.write_bytes(b"\xef\xbb\xbf" + json.dumps(_stretched([1, 1, 1])).encode())
    assert len(fold_file.read(path).pattern.faces_vertices) == 9
