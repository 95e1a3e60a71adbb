"""Patterns that are slightly off come back exact and hardly moved; others are refused with the reason."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import designs
import numpy as np
import pytest
from designs import GENERAL, GRIDS, assert_close, eggbox, hybrid, miura, perturbed, relabelled, staircase, tube
from foreign_files import assignments, crease_pattern, generic, scrambled_facets, write_fold, write_obj

import inverse
from inverse.cli import commands
from inverse.errors import InputError
from inverse.files import fold_file
from inverse.origami import folding, geometry, seeds
from inverse.origami.pattern import CFL, FL, Design
from inverse.pictures import rendering
from inverse.repair import line_types, repair
from inverse.repair.assignments import foldings
from inverse.repair.measures import residuals
from inverse.repair.repairing import OFF, Repair
from inverse.repair.snap import faults_of

NOISE = 1e-4
DISKS = {**GRIDS, **{name: make for name, make in GENERAL.items() if make().pattern.n_holes == 0}}


def run(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    code = commands.run(arguments)
    printed = capsys.readouterr()
    return code, printed.out, printed.err


def assert_repaired(result: Repair) -> None:
    assert result.status == "exact and certified"
    assert result.certified
    assert result.converged
    assert max(result.report["after"].values()) < 1e-13
    assert max(residuals(result.design).document().values()) < 1e-13


def assert_types(found: Design, wanted: Design) -> None:
    """The same types edge by edge, or all of them exchanged."""
    exchanged = designs.exchanged(wanted.pattern)
    same = [np.array_equal(found.pattern.edges_type, p.edges_type) for p in (wanted.pattern, exchanged)]
    assert any(same)


# ---- semi-folded states


@pytest.mark.parametrize("name", DISKS)
def test_a_mesh_without_any_key_comes_back_exact(name: str, tmp_path: Path) -> None:
    """Numbering and orientation scrambled, types forgotten, vertices moved at random."""
    design = relabelled(generic(DISKS[name](), 0.02), 3)[0]
    noisy = perturbed(design, NOISE, 4)
    result = repair(write_obj(noisy.vertices_coords, scrambled_facets(design), tmp_path))
    assert_repaired(result)
    assert_types(result.design, design)
    before, moved = result.report["before"], result.report["moved"]
    assert NOISE / 5 < before["developability"] < 30 * NOISE
    assert NOISE / 5 < before["planarity"] < 10 * NOISE
    # The least move is no longer than the way back to where the noise began.
    back = np.linalg.norm(noisy.vertices_coords - design.vertices_coords)
    assert 0.1 * back < np.linalg.norm(moved["vertices"]) < back * 1.01
    assert_close(
        np.linalg.norm(result.design.vertices_coords - noisy.vertices_coords, axis=1), moved["vertices"], 1e-15
    )
    assert moved["max"] == max(moved["vertices"]) == moved["vertices"][moved["worst_vertex"]]
    assert moved["max_relative"] == pytest.approx(moved["max"] / geometry.diagonal(noisy.vertices_coords))


def test_an_exact_design_stays_where_it_is(tmp_path: Path) -> None:
    design = generic(hybrid(4), 0.02)
    fold_file.write(design, tmp_path / "design.fold")
    for given in (tmp_path / "design.fold", str(tmp_path / "design.fold"), design):
        result = repair(given)
        assert_repaired(result)
        assert result.report["moved"]["max"] < 1e-13
        np.testing.assert_array_equal(result.design.pattern.edges_type, design.pattern.edges_type)
        assert result.design.pattern.grid == design.pattern.grid


def test_residuals_are_those_of_the_certificate() -> None:
    """c_dev and c_ff by another formula, at both readings of every family."""
    for make in GRIDS.values():
        for exchanged in (False, True):
            design = perturbed(make(), 1e-3, 5)
            if exchanged:
                design = replace(design, pattern=designs.exchanged(design.pattern))
            found = residuals(design).document()
            checks = inverse.certify.check_frame(inverse.files.fold_format.frame_of(fold_file.document(design))).checks
            for name in ("developability", "flat_foldability"):
                assert checks[name].value == pytest.approx(found[name], rel=1e-9)
            assert checks["planarity"].value == pytest.approx(found["planarity"], rel=1e-2)


def test_of_two_readings_the_one_with_more_foldlines() -> None:
    design = hybrid(4)
    few = replace(design, pattern=designs.exchanged(design.pattern))
    types = line_types.deduced(few)
    np.testing.assert_array_equal(types, design.pattern.edges_type)
    assert (types == FL).sum() > (types == CFL).sum()


def test_mountains_and_valleys_decide_at_right_angles() -> None:
    """Near 90 degrees everywhere, noise may make either reading nearer; the number of mountains does not mind."""
    for make, is_miura in ((miura, True), (eggbox, False)):
        misled = 0
        for seed in range(20):
            design = perturbed(make(2, 2, sector_angle=np.radians(89.8)), 3e-3, seed)
            theta = line_types.ring_angles(design.pattern, design.vertices_coords)[0]
            as_miura = np.abs(theta[:2] + theta[2:] - np.pi).max() < np.abs(theta[:2] - theta[2:]).max()
            misled += as_miura != is_miura
            assert (line_types._votes(design)[0] > 0) == is_miura
        assert misled > 1


def test_the_types_that_contradict_the_fewest_votes() -> None:
    outvoted = np.ones((4, 4)) - np.eye(4)
    outvoted[0, 1] = outvoted[1, 0] = -1.5
    assert abs(line_types._two_colouring(outvoted).sum()) == 4
    # Two groups that differ: no single change improves on all alike.
    groups = np.kron(np.eye(2), np.full((3, 3), 10.0)) - np.kron(1 - np.eye(2), np.ones((3, 3)))
    np.fill_diagonal(groups, 0)
    assert line_types._two_colouring(groups).tolist() in ([1, 1, 1, -1, -1, -1], [-1, -1, -1, 1, 1, 1])


def test_types_may_be_given(tmp_path: Path) -> None:
    design = perturbed(eggbox(4, 5), NOISE)
    path = write_obj(design.vertices_coords, scrambled_facets(design), tmp_path)
    deduced = repair(path)
    assert deduced.design.pattern.grid == (4, 5)
    for words in ({"u_lines": "CFL", "v_lines": "fl"}, {"u_lines": "CFL,CFL,CFL"}):
        result = repair(path, **words)
        assert_repaired(result)
        np.testing.assert_array_equal(result.design.pattern.edges_type, design.pattern.edges_type)
        assert result.report["line_types"]["found"] == "given"
    lines = result.report["line_types"]["lines"]
    assert sorted(line["type"] for line in lines) == ["CFL"] * 3 + ["FL"] * 4
    for words, message in [
        ({"u_lines": "FL,CFL"}, "--u-lines has 2 words, but the grid has 3"),
        ({"v_lines": "LF"}, "--v-lines has 'LF': allowed are FL and CFL"),
        ({"u_lines": "FL"}, r"the sector angles at vertex \d+ are off by"),
    ]:
        with pytest.raises(InputError, match=message):
            repair(path, **words)
    other = staircase()
    with pytest.raises(InputError, match="no grid of quads"):
        repair(write_obj(other.vertices_coords, scrambled_facets(other), tmp_path), u_lines="FL")


def test_types_of_the_file_are_kept(tmp_path: Path) -> None:
    design = eggbox(4, 4)
    other = replace(design, pattern=designs.exchanged(design.pattern))
    for one in (design, other):
        document = fold_file.document(perturbed(one, NOISE))
        result = repair(write_fold(document, tmp_path))
        assert_repaired(result)
        np.testing.assert_array_equal(result.design.pattern.edges_type, one.pattern.edges_type)
    document["bdffpq:edges_type"][document["bdffpq:edges_type"].index("FL")] = "B"
    with pytest.raises(InputError, match=r"gives interior edge .* no type"):
        repair(write_fold(document, tmp_path))


# ---- flat crease patterns

FLAT: dict[str, Callable[[], Design]] = {
    "generic": lambda: generic(miura(5, 6)),
    "strips": lambda: seeds.grid((4, 5), "FL", "FL", lengths_u=[1, 2, 1.5, 1], lengths_v=[1, 1, 2, 1, 0.7]),
    "staircase": lambda: generic(staircase(), 0.03),
    "polygonal": GENERAL["polygonal"],
}


@pytest.mark.parametrize("with_assignments", [True, False], ids=["M/V", "no M/V"])
@pytest.mark.parametrize("name", FLAT)
def test_a_crease_pattern_is_folded_and_made_exact(name: str, with_assignments: bool, tmp_path: Path) -> None:
    design = FLAT[name]()
    document = crease_pattern(design, NOISE)
    if not with_assignments:
        document["edges_assignment"] = [w if w == "B" else "U" for w in document["edges_assignment"]]
    result = repair(write_fold(document, tmp_path))
    assert_repaired(result)
    report = result.report
    assert report["state"] == "crease pattern"
    assert report["mountains_and_valleys"] == ("from the file" if with_assignments else "searched")
    assert (result.design.pattern.edges_type != CFL).all()
    low, high = report["folded_to"].values()
    assert low > 20
    assert high < 160
    assert report["before"]["flat_foldability"] > NOISE / 2
    # Measured where a reader can: between the pattern as drawn and the new developed state, laid upon it.
    assert report["moved"]["max"] < 10 * NOISE
    drawn, new = np.array(document["vertices_coords"]), folding.flat_state(result.design, 0.0)[:, :2]
    for a, b in design.pattern.edges_vertices.tolist():
        assert abs(np.linalg.norm(drawn[a] - drawn[b]) - np.linalg.norm(new[a] - new[b])) < 20 * NOISE
    if with_assignments:
        words = dict(zip(map(frozenset, result.design.pattern.edges_vertices.tolist()), assignments(result.design),
                         strict=True))  # fmt: skip
        wanted = map(frozenset, document["edges_vertices"])
        assert [words[pair] for pair in wanted] == document["edges_assignment"]


def test_a_large_crease_pattern_stays_near_the_drawing(tmp_path: Path) -> None:
    """Facets are placed one after another, and yet errors do not add up from one side to the other."""
    result = repair(write_fold(crease_pattern(generic(miura(12, 12)), NOISE), tmp_path))
    assert_repaired(result)
    assert result.report["moved"]["rms"] < 1.2 * np.sqrt(2) * NOISE


def test_the_search_takes_back_what_does_not_fit(tmp_path: Path) -> None:
    """Vertices numbered in any order, two creases assigned at random: some choices fail only vertices later."""
    for seed in range(8):
        design = relabelled(generic(miura(4, 4), 0.12, seed), seed)[0]
        document = crease_pattern(design)
        kept = np.random.default_rng(seed).choice(design.pattern.interior_edges, 2, replace=False)
        words = document["edges_assignment"]
        document["edges_assignment"] = [w if w == "B" or e in kept else "U" for e, w in enumerate(words)]
        result = repair(write_fold(document, tmp_path))
        assert_repaired(result)
        assert result.report["moved"]["max"] < 1e-9
        found = assignments(result.design)
        index = {frozenset(pair): k for k, pair in enumerate(result.design.pattern.edges_vertices.tolist())}
        for e in kept.tolist():
            assert found[index[frozenset(document["edges_vertices"][e])]] == words[e]


def miura_map(m: int, n: int, angle: float = np.radians(70)) -> dict[str, Any]:
    """The textbook map fold: parallelograms in n columns, mirrored from row to row, and its alternating creases."""
    points = [[i + (j % 2) / np.tan(angle), j] for i in range(m + 1) for j in range(n + 1)]
    edges, words = [], []
    for i in range(m + 1):
        for j in range(n + 1):
            here = i * (n + 1) + j
            if i < m:  # straight creases, mountain and valley by turns
                edges.append([here, here + n + 1])
                words.append("B" if j in (0, n) else "MV"[(i + j + 1) % 2])
            if j < n:  # zigzags, each one all mountain or all valley
                edges.append([here, here + 1])
                words.append("B" if i in (0, m) else "MV"[i % 2])
    return {"vertices_coords": points, "edges_vertices": edges, "edges_assignment": words}


def test_the_miura_map(tmp_path: Path) -> None:
    document = miura_map(5, 4)
    result = repair(write_fold(document, tmp_path))
    assert_repaired(result)
    assert result.report["moved"]["max"] < 1e-13
    # Half-angle tangents of straight and zigzag creases differ by the factor cos(angle).
    tangents = np.tan(np.abs(geometry.fold_angles(result.design.pattern, result.design.vertices_coords)) / 2)
    tangents = np.unique(np.round(tangents[result.design.pattern.interior_edges], 9))
    assert len(tangents) == 2
    assert tangents[0] / tangents[1] == pytest.approx(np.cos(np.radians(70)))


def test_a_state_that_runs_into_itself_is_folded_less(tmp_path: Path) -> None:
    """A long row of leaning facets curls up; the fold state is taken back until nothing crosses."""
    result = repair(write_fold(curling(), tmp_path))
    assert_repaired(result)
    assert result.report["folded_to"]["largest_degrees"] < 60


def curling(columns: int = 12) -> dict[str, Any]:
    """Two rows of trapezoids: the creases between them lean left and right by turns and are all mountains."""
    points, edges, words = [], [], []
    for i in range(columns + 1):
        lean = (-1) ** i / np.tan(np.radians(70))
        points += [[i + lean, -1.0], [i, 0.0], [i + lean, 1.0]]
        edges += [[3 * i, 3 * i + 1], [3 * i + 1, 3 * i + 2]]
        words += ["B" if i in (0, columns) else "M"] * 2
        if i < columns:
            edges += [[3 * i + j, 3 * i + 3 + j] for j in range(3)]
            words += ["B", "U", "B"]
    return {"vertices_coords": points, "edges_vertices": edges, "edges_assignment": words}


@pytest.mark.parametrize(
    ("straight", "zigzag", "words"),
    [
        ("MV", "MV", "vertex 4 has 2 mountains and 2 valleys: they must differ by 2"),
        ("MM", "MM", "vertex 4 has 4 mountains and 0 valleys: they must differ by 2"),
        ("MM", "MV", "the mountains and valleys at vertex 4 cannot fold: the two creases of its smallest"),
        ("MV", "VV", "the mountains and valleys at vertex 4 cannot fold: the two creases of its smallest"),
    ],
)
def test_mountains_and_valleys_that_cannot_be(straight: str, zigzag: str, words: str, tmp_path: Path) -> None:
    document = miura_map(2, 2)
    for pair, word in zip([[4, 7], [1, 4], [3, 4], [4, 5]], straight + zigzag, strict=True):
        document["edges_assignment"][document["edges_vertices"].index(pair)] = word
    with pytest.raises(InputError, match=words):
        repair(write_fold(document, tmp_path))


def test_a_crease_pattern_that_tears(tmp_path: Path) -> None:
    """Flat-foldable at each vertex, but no common ratio of the two lines through four of them."""
    document = torn_pattern()
    with pytest.raises(InputError, match=r"tears when it is folded: the sector angles at vertex \d+ change by 0"):
        repair(write_fold(document, tmp_path))
    document["edges_assignment"] = [w if w == "B" else "U" for w in document["edges_assignment"]]
    with pytest.raises(InputError, match="no mountains and valleys were found with which"):
        repair(write_fold(document, tmp_path))


def torn_pattern() -> dict[str, Any]:
    """A crease pattern moved at random, and back only as far as to meet Kawasaki's condition again."""
    design = generic(miura(4, 4), 0.1)
    flat = folding.flat_state(design, 0.0)[:, :2]
    document = crease_pattern(design)
    rng = np.random.default_rng(0)
    ring = design.pattern.ring_vertices
    x = flat + 0.2 * rng.standard_normal(flat.shape)

    def kawasaki(x: np.ndarray) -> np.ndarray:
        spokes = x[ring] - x[design.pattern.interior_vertices][:, None]
        angle = np.arctan2(spokes[..., 1], spokes[..., 0])
        theta = (np.roll(angle, -1, axis=1) - angle) % (2 * np.pi)
        return theta[:, 0] + theta[:, 2] - np.pi

    for _ in range(20):
        r = kawasaki(x)
        jacobian = np.empty((len(r), x.size))
        for k in range(x.size):
            y = x.copy()
            y.ravel()[k] += 1e-6
            jacobian[:, k] = (kawasaki(y) - r) / 1e-6
        x = x - np.linalg.lstsq(jacobian, r, rcond=None)[0].reshape(x.shape)
    assert np.abs(kawasaki(x)).max() < 1e-9
    document["vertices_coords"] = x.tolist()
    return document


def test_the_two_ways_to_fold_a_vertex(tmp_path: Path) -> None:
    """Four creases at random angles fold as they say: with these mountains and valleys the vertex closes."""
    rng = np.random.default_rng(2)
    for k in range(4):
        a, b = rng.uniform(0.5, 2.6, 2)
        directions = np.cumsum([0, a, b, np.pi - a])
        rim = np.stack([np.cos(directions), np.sin(directions)], axis=1)
        document = {
            "vertices_coords": [[0, 0], *rim.tolist()],
            "edges_vertices": [[0, 1], [0, 2], [0, 3], [0, 4]],
            "faces_vertices": [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]],
        }
        signs = set()
        for first, second in ("MM", "MV", "VM", "VV"):  # creases 0 and 1, then 0 and 2: both ways come up
            for places in ((0, 1), (0, 2)):
                words = ["U"] * 4
                words[places[0]], words[places[1]] = first, second
                try:
                    result = repair(write_fold({**document, "edges_assignment": words}, tmp_path))
                except InputError:
                    continue
                assert result.report["moved"]["max"] < 1e-12, k
                signs.add("".join(w for w in assignments(result.design) if w != "B"))
        assert len(signs) == 4, "two ways, each with mountains and valleys exchanged"
        assert all(word.count("M") in (1, 3) for word in signs)


# ---- refusals and failures


def test_one_vertex_half_a_radian_off(tmp_path: Path) -> None:
    """Refused with the vertex and the way out; with ``far`` it is repaired."""
    design = miura(4, 4)
    points = design.vertices_coords.copy()
    points[12] += 0.25 * geometry.unit(points[12] - points[11])
    path = write_obj(points, scrambled_facets(design), tmp_path)
    off = residuals(design.moved_to(points)).angles
    assert 0.3 < off.max() < 0.7
    worst = design.pattern.interior_vertices[np.argmax(off)]
    with pytest.raises(
        InputError, match=rf"vertex {worst} are off by {off.max():.3g} rad.*: 0.1 rad is allowed"
    ) as caught:
        repair(path)
    assert "--far" in str(caught.value.hint)
    assert str(caught.value.where) == str(path)
    result = repair(path, far=True)
    assert_repaired(result)


def test_what_is_just_near_enough() -> None:
    design = eggbox(4, 4)
    rng = np.random.default_rng(0)
    direction = rng.standard_normal(design.vertices_coords.shape)
    sizes = np.array(
        [residuals(design.moved_to(design.vertices_coords + h * direction)).angles.max() for h in (0.01, 0.02)]
    )
    step = 0.01 * OFF / sizes[0]
    near = design.moved_to(design.vertices_coords + 0.9 * step * direction)
    assert_repaired(repair(near))
    with pytest.raises(InputError, match=r"0\.1 rad is allowed"):
        repair(design.moved_to(design.vertices_coords + 1.1 * step * direction))


def test_a_facet_that_is_not_plane(tmp_path: Path) -> None:
    """A corner vertex of the grid bends its facet and no sector angle."""
    design = miura(3, 3)
    points = design.vertices_coords.copy()
    normal = geometry.facet_normals(design.pattern, points)[0]
    points[0] += 0.6 * normal
    path = write_obj(points, scrambled_facets(design), tmp_path)
    with pytest.raises(InputError, match=r"the facet with vertices .* is off its plane by 0.\d+ mean edges"):
        repair(path)


def test_a_mesh_that_came_out_broken_is_told() -> None:
    """Newton's method keeps no bound, so what it did is looked at."""
    design = miura(3, 3)
    assert faults_of(design, design, 0.0) == []
    for change, words in [
        (design.vertices_coords * [1, 1, -1], "changed between mountain and valley"),
        (design.vertices_coords * 6, "became 6 times as long"),
        (design.vertices_coords[[5, *range(1, 16)]], "a facet is not convex"),
    ]:
        assert words in "; ".join(faults_of(design, design.moved_to(change), 0.0))
    assert "could not be satisfied" in faults_of(design, design, 1e-3)[0]


def test_closure_around_a_hole_is_not_promised() -> None:
    result = repair(perturbed(tube(6, 3), NOISE))
    assert result.converged
    assert not result.certified
    assert "not closure around holes" in result.status
    assert result.report["after"]["developability"] < 1e-13


def test_a_crease_pattern_has_foldlines_only(tmp_path: Path) -> None:
    path = write_fold(miura_map(3, 3), tmp_path)
    with pytest.raises(InputError, match="is CFL, but in a flat crease pattern"):
        repair(path, u_lines="CFL")


# ---- the command


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rendering, "lacking", lambda: "no pictures here")
    monkeypatch.chdir(tmp_path)
    design = perturbed(miura(4, 4), NOISE)
    path = write_obj(design.vertices_coords, scrambled_facets(design), tmp_path)
    code, printed, said = run(["repair", str(path)], capsys)
    assert code == 0
    assert "exact and certified" in said
    for words in ("before    c_dev", "after     c_dev", "moved     ", "lines     6 FL, 0 CFL: deduced"):
        assert words in printed
    out = tmp_path / "out" / "pattern"
    names = {"design.fold", "certificate.json", "report.json", "crease_pattern.svg"}
    assert {file.name for file in out.iterdir()} == names
    assert json.loads((out / "certificate.json").read_text())["certified"]
    report = json.loads((out / "report.json").read_text())
    assert len(report["moved"]["vertices"]) == 25
    assert report["certified"]
    assert report["converged"]
    assert inverse.check(out / "design.fold").certified


def test_the_command_as_json_and_its_codes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rendering, "lacking", lambda: "no pictures here")
    good = write_fold(miura_map(3, 3), tmp_path)
    code, printed, _ = run(["repair", str(good), "--json", "-o", str(tmp_path / "good")], capsys)
    summary = json.loads(printed)
    assert code == 0
    assert summary["certified"]
    assert summary["line_types"]["FL"] == 12
    assert set(summary["moved"]) == {"max", "max_relative", "worst_vertex", "rms", "rms_relative"}

    fold_file.write(perturbed(tube(6, 3), NOISE), tmp_path / "tube.fold")
    code, _, said = run(["repair", str(tmp_path / "tube.fold"), "-o", str(tmp_path / "tube")], capsys)
    assert code == 1
    assert "NOT REPAIRED" in said
    assert not json.loads((tmp_path / "tube" / "certificate.json").read_text())["certified"]

    design = miura(3, 3)
    off = perturbed(design, 0.2)
    bad = write_obj(off.vertices_coords, scrambled_facets(design), tmp_path)
    code, _, said = run(["repair", str(bad), "-o", str(tmp_path / "bad")], capsys)
    assert code == 2
    assert "--far" in said
    assert not (tmp_path / "bad").exists()


def test_the_function_is_the_function() -> None:
    import inverse.repair.foreign

    assert callable(inverse.repair)
    assert inverse.repair is repair
    assert inverse.Repair is Repair
    assert foldings.__module__ == "inverse.repair.assignments"


@pytest.mark.parametrize(("more", "certified"), [("", True), ("v 2 0 0.1\nf 2 5 4\n", False)])
def test_triangles_without_an_interior_vertex(tmp_path: Path, more: str, certified: bool) -> None:
    """There is no equation that they could violate; of three the two folds move on their own."""
    (tmp_path / "roof.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0.2\nf 1 2 3\nf 2 4 3\n" + more)
    result = inverse.repair(tmp_path / "roof.obj")
    assert result.converged
    assert result.certified == certified
    assert result.report["moved"]["max"] == 0
    assert certified or "2 independent motions" in result.status
