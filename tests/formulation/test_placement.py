"""A placed seed covers the plan of its target, in every position of that plan."""

from __future__ import annotations

import numpy as np
import pytest
from designs import GENERAL, HYBRID_V, assert_close, miura, relabelled, rotation
from scipy.spatial.distance import pdist

from inverse.formulation import placement
from inverse.origami import seeds
from inverse.origami.pattern import Design
from inverse.surfaces import Frame

FRAMES = {
    "flat": Frame(np.array([1.0, 2, 3]), np.eye(3), (5.0, 3.0)),
    "turned": Frame(np.array([-70.0, 0.2, 9]), rotation(6), (0.02, 0.05)),
}
WORDS = {
    "miura": ("FL", "FL"),
    "eggbox": ("CFL", "FL"),
    "other eggbox": ("FL", "CFL"),
    "hybrid": ("FL", HYBRID_V),
}


def make(words: str, m: int, n: int, **options):
    u_lines, v_lines = WORDS[words]

    def build(lengths_u, lengths_v) -> Design:
        return seeds.grid((m, n), u_lines, v_lines, lengths_u=lengths_u, lengths_v=lengths_v, **options)

    return build


@pytest.mark.parametrize("turn", [0, 90])
@pytest.mark.parametrize("words", WORDS)
@pytest.mark.parametrize("name", FRAMES)
def test_the_drifts_of_a_grid_are_the_sides_of_the_plan(name: str, words: str, turn: int) -> None:
    frame, (m, n) = FRAMES[name], (6, 9)
    design = placement.place_grid(make(words, m, n), (m, n), frame, turn=turn)
    u, v = placement.drifts(design.pattern, design.vertices_coords)
    extent = frame.extent if turn == 0 else frame.extent[::-1]
    assert (np.linalg.norm(u), np.linalg.norm(v)) == pytest.approx(extent, rel=1e-12)
    x, y, z = frame.axes
    along_u, along_v = (x, y) if turn == 0 else (y, -x)
    size = np.linalg.norm(frame.extent)
    assert_close(u / size, extent[0] * along_u / size, 1e-13)
    # v need not be square to u; it lies in the plan and turns from u to the left.
    assert abs(v @ z) < 1e-13 * size
    assert v @ along_v > 0.9 * extent[1]
    assert_close(design.vertices_coords.mean(axis=0), frame.origin, 1e-13 * np.abs(frame.origin).max())


def test_start_size_and_relative_lengths() -> None:
    frame, lengths = FRAMES["turned"], ([1.0, 2, 1, 2], [3.0, 1, 1, 1, 1, 3])
    design = placement.place_grid(make("miura", 4, 6), (4, 6), frame, lengths=lengths, start_size=(7.0, 2.0))
    u, v = placement.drifts(design.pattern, design.vertices_coords)
    assert (np.linalg.norm(u), np.linalg.norm(v)) == pytest.approx((7, 2), rel=1e-12)
    table = design.vertices_coords.reshape(5, 7, 3)
    strips = (
        np.linalg.norm(np.diff(table, axis=0), axis=2)[:, 0],
        np.linalg.norm(np.diff(table, axis=1), axis=2)[0],
    )
    for strip, wanted in zip(strips, lengths, strict=True):
        assert_close(strip / strip[0], np.array(wanted) / wanted[0], 1e-12)


def test_placing_keeps_sector_angles_and_top() -> None:
    """Facets that turned counter-clockwise seen from the sheet's top still do, seen from the plan's."""
    frame = FRAMES["turned"]
    design = placement.place_grid(make("miura", 4, 6, sector_angle=1.2), (4, 6), frame)
    for face in design.pattern.faces_vertices:
        a, b, c, _ = design.vertices_coords[list(face)]
        normal = np.cross(b - a, c - a)
        assert normal @ frame.axes[2] > 0
        cosine = (b - a) @ (c - b) / np.linalg.norm(b - a) / np.linalg.norm(c - b)
        assert abs(cosine) == pytest.approx(np.cos(1.2), abs=1e-10)


@pytest.mark.parametrize("position", range(4))
@pytest.mark.parametrize("turn", [0, 90])
@pytest.mark.parametrize("name", FRAMES)
def test_a_network_of_its_own_is_scaled_as_a_whole(name: str, turn: int, position: int) -> None:
    frame = FRAMES[name]
    seed = relabelled(GENERAL["polygonal"]())[0]
    seed = seed.moved_to(3 * seed.vertices_coords @ rotation(position) + [8.0, 8, 8])
    design = placement.place_file(seed, frame, turn)
    ratio = pdist(design.vertices_coords) / pdist(seed.vertices_coords)
    assert_close(ratio / ratio[0], 1, 1e-9)
    plan = (design.vertices_coords - frame.origin) @ frame.axes.T
    assert_close(plan.mean(axis=0), 0, 1e-12 * np.abs(frame.origin).max())
    extent = np.ptp(plan, axis=0)
    assert extent[0] * extent[1] == pytest.approx(frame.extent[0] * frame.extent[1], rel=1e-9)
    assert extent[2] < 0.6 * min(extent[:2])
    assert (extent[0] > extent[1]) == (turn == 0)  # the longer direction is the first
    a, b, c = design.vertices_coords[list(design.pattern.faces_vertices[0][:3])]
    assert np.cross(b - a, c - a) @ frame.axes[2] > 0


def test_a_grid_from_a_file_lies_as_a_grid_does() -> None:
    frame = FRAMES["flat"]
    seed = miura(5, 4)
    turned = seed.moved_to(seed.vertices_coords @ rotation(4) + 3.0)
    a, b = placement.place_file(seed, frame), placement.place_file(turned, frame)
    assert_close(a.vertices_coords, b.vertices_coords, 1e-12)
    u, _ = placement.drifts(a.pattern, a.vertices_coords)
    assert_close(u / np.linalg.norm(u), [1, 0, 0], 1e-13)


def test_only_grids_drift() -> None:
    design = GENERAL["holed"]()
    with pytest.raises(ValueError, match="only a grid has drifts"):
        placement.drifts(design.pattern, design.vertices_coords)
