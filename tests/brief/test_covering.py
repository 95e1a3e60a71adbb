"""What a mesh covers and what lies beyond, against areas known by hand."""

from __future__ import annotations

import numpy as np
import pytest

from inverse._types import FloatArray, IntArray
from inverse.brief import covering
from inverse.brief.covering import Coverage
from inverse.brief.sheets import Sheet

Surface = tuple[FloatArray, IntArray]


def coverage(target: Surface, mesh: Surface, reach: float, *, has_holes: bool = True) -> Coverage:
    return covering.coverage(Sheet.of(*target), Sheet.of(*mesh), reach, has_holes=has_holes)


def is_roof(target: Surface) -> bool:
    return covering.is_roof(Sheet.of(*target))


def rectangle(x: tuple[float, float], y: tuple[float, float], z: float = 0.0) -> Surface:
    (a, b), (c, d) = x, y
    return np.array([[a, c, z], [b, c, z], [b, d, z], [a, d, z]]), np.array([[0, 1, 2], [0, 2, 3]])


def joined(*parts: Surface) -> Surface:
    first = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    return np.concatenate([v for v, _ in parts]), np.concatenate(
        [t + k for (_, t), k in zip(parts, first, strict=False)]
    )


def turned(surface: Surface) -> Surface:
    """Upright: z becomes x, so that what was up looks sideways."""
    return np.ascontiguousarray(surface[0][:, [2, 0, 1]]), surface[1]


def frame_with_hole() -> Surface:
    """6 x 6 with a hole of 2 x 2 in the middle."""
    corners = [[0, 0], [6, 0], [6, 6], [0, 6], [2, 2], [4, 2], [4, 4], [2, 4]]
    sides = [[k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k] for k in range(4)]
    triangles = [t for a, b, c, d in sides for t in ([a, b, c], [a, c, d])]
    return np.column_stack([np.array(corners, float), np.zeros(8)]), np.array(triangles)


@pytest.mark.parametrize("upright", [False, True])
def test_half_of_it_covered_and_a_third_of_the_mesh_beyond(upright: bool) -> None:
    """A target of 4 x 1; a mesh of 3 x 1 above it, of which 2 lie over it."""
    target, mesh = rectangle((0, 4), (0, 1)), rectangle((2, 5), (0, 1), 0.2)
    if upright:
        target, mesh = turned(target), turned(mesh)
    assert is_roof(target) is not upright
    found = coverage(target, mesh, 0.5)
    assert found.seen == ("along the normal" if upright else "open to sky")
    assert found.covered == pytest.approx(0.5, abs=0.02)
    assert found.beyond == pytest.approx(1, abs=0.05)
    assert found.beyond_share == pytest.approx(1 / 3, abs=0.02)
    assert found.parts == ()


def test_a_roof_keeps_the_rain_off_from_any_height_but_a_wall_is_near() -> None:
    high = rectangle((0, 4), (0, 1), 50.0)
    assert coverage(rectangle((0, 4), (0, 1)), high, 0.5).covered == 1
    assert coverage(turned(rectangle((0, 4), (0, 1))), turned(high), 0.5).covered == 0


def test_a_mesh_below_covers_as_one_above() -> None:
    assert coverage(rectangle((0, 4), (0, 1)), rectangle((0, 4), (0, 1), -0.3), 0.5).covered == 1


def test_a_sloping_roof_is_seen_from_the_sky() -> None:
    """Leaning by 45 degrees; what hangs vertically above its lower half covers half of it."""
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 1]])
    found = coverage((vertices, np.array([[0, 1, 2], [0, 2, 3]])), rectangle((0, 1), (0, 0.5), 3.0), 0.1)
    assert found.seen == "open to sky"
    assert found.covered == pytest.approx(0.5, abs=0.02)


def test_every_component_is_told_by_itself() -> None:
    """Two of 1 x 1 and 2 x 1; the mesh is over the second and the ground between."""
    target = joined(rectangle((0, 1), (0, 1)), rectangle((9, 11), (0, 1)))
    found = coverage(target, rectangle((8, 11), (0, 1), 0.1), 0.5)
    assert found.covered == pytest.approx(2 / 3, abs=0.01)
    assert [(part.kind, part.area) for part in found.parts] == [
        ("component", pytest.approx(1)),
        ("component", pytest.approx(2)),
    ]
    assert [part.covered for part in found.parts] == [0, 1]
    assert found.parts[1].place == pytest.approx((10, 0.5, 0))
    assert found.beyond_share == pytest.approx(1 / 3, abs=0.02)


@pytest.mark.parametrize("upright", [False, True])
def test_a_hole_that_is_covered_is_told_and_lies_beyond(upright: bool) -> None:
    target, mesh = frame_with_hole(), rectangle((0, 6), (0, 3), 0.1)
    if upright:
        target, mesh = turned(target), turned(mesh)
    found = coverage(target, mesh, 0.5)
    (part, hole) = found.parts
    assert (part.kind, hole.kind) == ("component", "hole")
    assert hole.area == pytest.approx(4)
    assert hole.covered == pytest.approx(0.5, abs=0.03)
    assert found.covered == pytest.approx(0.5, abs=0.02)
    assert found.beyond == pytest.approx(2, abs=0.1)
    assert coverage(target, mesh, 0.5, has_holes=False).parts == ()


def test_a_hole_that_is_no_convex_polygon() -> None:
    """An L of 2 x 2 without a quarter: parts of the fan around its middle turn back and count against."""
    rim = np.array([[2.0, 2], [4, 2], [4, 3], [3, 3], [3, 4], [2, 4]])
    outer = 3 + (rim - 3) * 4
    vertices = np.column_stack([np.vstack([outer, rim]), np.zeros(12)])
    sides = [[k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k] for k in range(6)]
    target = vertices, np.array([t for a, b, c, d in sides for t in ([a, b, c], [a, c, d])])
    found = coverage(target, rectangle((-9, 15), (2, 3), 0.1), 0.5)
    (hole,) = [part for part in found.parts if part.kind == "hole"]
    assert hole.area == pytest.approx(3)
    assert hole.covered == pytest.approx(2 / 3, abs=0.03)


def test_facets_that_look_down_are_no_roof() -> None:
    """Half of a cylinder is a roof; more of it, which turns in below, is seen along its normals."""
    for most, wanted in ((90.0, True), (150.0, False)):
        angle = np.radians(np.linspace(-most, most, 60))
        ring = np.column_stack([np.sin(angle), 0 * angle, np.cos(angle)])
        vertices = np.vstack([ring, ring + np.array([0, 3, 0])])
        k = np.arange(59)
        triangles = np.vstack([np.column_stack([k, k + 1, k + 61]), np.column_stack([k, k + 61, k + 60])])
        assert is_roof((vertices, triangles)) is wanted
