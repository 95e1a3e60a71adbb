"""Targets, pattern families and sections of users, as specifications name them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from designs import assert_close

import inverse
from inverse import InputError
from inverse.formulation.formulate import formulate
from inverse.origami.pattern import Design
from inverse.surfaces.mesh import MeshTarget
from inverse.surfaces.parametric import HeightTarget

pytestmark = pytest.mark.usefixtures("registered")
HEAD = "name: a\n"
GRID = "pattern: {size: [4, 4]}\n"
FLAT = "target: {height: x*y/9, domain: [[0, 2], [0, 1]]}\n"


@pytest.fixture
def makers(registered: object) -> None:
    @inverse.target("saddle")
    def saddle(*, twist: float, domain: Any = ((-1, 1), (-1, 1))) -> inverse.Target:
        return HeightTarget(f"{twist} * x * y", domain)

    @inverse.pattern_family("tapered")
    def tapered(m: int, n: int, ratio: float = 1.1) -> Design:
        return inverse.seeds.grid((m, n), lengths_u=ratio ** np.arange(m))


def given(folder: Path, text: str) -> Any:
    path = folder / "a.yaml"
    path.write_text(text)
    return formulate(inverse.load(path))


@pytest.mark.usefixtures("makers")
def test_what_is_named_is_made(tmp_path: Path) -> None:
    target = "target: {surface: saddle, twist: 0.2, domain: [[0, 2], [0, 1]]}\n"
    made = given(
        tmp_path, f"{HEAD}pattern: {{kind: family, family: tapered, size: [4, 6], ratio: 2, turn: 90}}\n{target}"
    )
    assert isinstance(made.goal.target, HeightTarget)
    assert_close(made.goal.target.frame.origin[:2], [1, 0.5], 1e-12)
    assert made.goal.model.pattern.grid == (4, 6)
    points = made.goal.model.seed.vertices_coords.reshape(5, 7, 3)
    strips = np.linalg.norm(np.diff(points[:, 0], axis=0), axis=1)
    assert_close(strips[1:] / strips[:-1], np.full(3, 2.0), 1e-9)
    assert_close(points.mean(axis=(0, 1)), made.goal.target.frame.origin, 1e-9)


@pytest.mark.usefixtures("makers")
@pytest.mark.parametrize(
    ("text", "message"),
    [
        (GRID + "target: {surface: |sadle, twist: 1}", r"'sadle' is no target surface: .* Did you mean saddle\?"),
        (GRID + "target: {surface: saddle, twist: 1, |domian: 3}", 'is no parameter .*: allowed are twist, domain.'),
        (GRID + "target: {surface: |saddle}", 'the parameter "twist" of the target surface saddle is missing'),
        (GRID + "target: {surface: |saddle, twist: 1, domain: 3}", "the target surface saddle raised IndexError"),
        (GRID + "target: {surface: |saddle, twist: ++}", "the target surface saddle: "),
        (GRID + "target: {surface: saddle, twist: 1, |height: x}", '"height" is no parameter of the target surface'),
        (GRID + "target: {surface: |3}", "target.surface is 3: it must be text"),
        (FLAT + "pattern: {kind: family, family: |taperd, size: [4, 4]}", "'taperd' is no pattern family: .*tapered"),
        (FLAT + "pattern: {kind: family, family: tapered, size: [4, 4], |rato: 2}", '"rato" is no .*mean ratio'),
        (FLAT + "pattern: {kind: family, family: tapered, size: [4, |0]}", "pattern.size.1 is 0"),
        (FLAT + "pattern: {kind: family, family: |tapered, size: [4, 4], ratio: -1}", "must be positive lengths"),
        (FLAT + "|pattern: {kind: family, family: tapered}", 'the key "size" is missing from pattern'),
    ],
)  # fmt: skip
def test_refusals(text: str, message: str, tmp_path: Path) -> None:
    before = HEAD + text.partition("|")[0]
    place = f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"
    with pytest.raises(InputError, match=message) as caught:
        given(tmp_path, HEAD + text.replace("|", ""))
    assert caught.value.where == f"{tmp_path / 'a.yaml'}:{place}"


def test_what_makers_may_not_do(tmp_path: Path) -> None:
    inverse.target("none")(lambda: None)  # type: ignore[arg-type, return-value]
    with pytest.raises(InputError, match="the target surface none returns a NoneType: a Target is wanted"):
        given(tmp_path, HEAD + GRID + "target: {surface: none}")
    inverse.pattern_family("text")(lambda m, n: "x")  # type: ignore[arg-type, return-value]
    with pytest.raises(InputError, match="the pattern family text returns a str: a Design is wanted"):
        given(tmp_path, HEAD + FLAT + "pattern: {kind: family, family: text, size: [2, 2]}")
    with pytest.raises(InputError, match="the target surface b has a parameter surface, which is a key"):
        inverse.target("b")(lambda surface: None)  # type: ignore[arg-type, return-value]
    with pytest.raises(InputError, match="the pattern family b has a parameter turn, which is a key"):
        inverse.pattern_family("b")(lambda m, n, turn: None)  # type: ignore[arg-type, return-value]
    with pytest.raises(InputError, match="the target surface b is no function"):
        inverse.target("b")(3)  # type: ignore[type-var]


@pytest.mark.parametrize("steps", [3, [1, 2], [(1, 1)], [("x", 1, 1)] * 4, [(1, 1, 1)] * 4, [(1, 1, 1)]])
def test_no_sections(steps: Any) -> None:
    with pytest.raises(InputError, match="section mine"):
        inverse.section("mine", steps)
    assert "mine" not in inverse.seeds.NAMED_SECTIONS


@pytest.mark.parametrize("kind", ["height", "mesh"])
def test_a_far_target_is_moved(kind: str, tmp_path: Path) -> None:
    """The same design as near by, though the surface knows only its own coordinates."""

    @inverse.target("far")
    def far(*, x: float) -> inverse.Target:
        height = HeightTarget(f"0.45 - 0.3*((x - {x})^2 + y^2)", [[x - 0.6, x + 0.6], [-0.6, 0.6]])
        return height if kind == "height" else MeshTarget(*height.triangles())

    found = []
    for x in (0.0, 4096.0):
        path = tmp_path / "a.yaml"
        path.write_text(f"{HEAD}{GRID}target: {{surface: far, x: {x}}}")
        assert formulate(inverse.load(path)).goal.origin.any() == (x > 0)
        result = inverse.solve(inverse.load(path))
        assert result.certified
        found.append(result.design.vertices_coords - [x, 0, 0])
    assert_close(found[1], found[0], 1e-6)


def test_moved_surfaces() -> None:
    origin = np.array([3.0, -2.0, 0.5])
    target = HeightTarget("0.1*x*y", [[2, 4], [-3, -1]])
    there = target.moved(origin)
    assert target.moved(0 * origin) is target
    points = np.random.default_rng(0).standard_normal((9, 3))
    here, away = target.closest(points + origin), there.closest(points)
    assert_close(away.feet, here.feet - origin, 1e-12)
    assert_close(away.weights, here.weights, 1e-12)
    assert_close(there.frame.origin, target.frame.origin - origin, 1e-12)
    assert_close(there.flattened(0.5).triangles()[0], target.flattened(0.5).triangles()[0] - origin, 1e-12)
    assert there.has_kinks is False
