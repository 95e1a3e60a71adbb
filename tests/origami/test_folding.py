"""The motion against closed forms, and what every motion must keep."""

from __future__ import annotations

import itertools

import designs
import numpy as np
import pytest
from designs import ALL, GENERAL, GRIDS, TUBES, assert_close, best_motion, eggbox, miura, relabelled
from scipy.spatial.distance import pdist

from inverse.origami import folding, geometry
from inverse.origami.pattern import CFL, FL, Design, Pattern

T = np.array([0.0, 0.1, 0.7, np.pi / 2, 2.0, 3.0, np.pi])
EXACT = {"miura": miura, "eggbox": eggbox}


def hinge(angle: float) -> Design:
    """Two unit squares; the second is turned up (towards the side seen counter-clockwise) by ``angle``."""
    c, s = np.cos(angle), np.sin(angle)
    points = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1 + c, 0, s], [1 + c, 1, s]]
    types = lambda edges: np.full(len(edges), FL, np.int8)  # noqa: E731
    return Design(Pattern.from_faces([[0, 1, 2, 3], [1, 4, 5, 2]], 6, types), np.array(points))


@pytest.mark.parametrize("angle", [0.3, 2.8, -0.3, -2.8])
def test_a_valley_is_positive_and_folds_by_the_half_angle_tangent(angle: float) -> None:
    design = hinge(angle)
    edge = design.pattern.interior_edges[0]
    assert geometry.fold_angles(design.pattern, design.vertices_coords)[edge] == pytest.approx(angle, abs=1e-14)
    motion = folding.fold(design, T)
    expected = 2 * np.arctan2(np.sin(T / 2) * np.sin(angle / 2), np.cos(T / 2) * np.cos(angle / 2))
    assert_close(motion.fold_angles[:, edge], expected, 1e-14)
    for state, turned in zip(motion.vertices_coords, expected, strict=True):
        assert_close(state, hinge(turned).vertices_coords, 1e-14)


def half_cell(make, t: float) -> tuple[float, float, float, float]:
    """Lengths S, L, V, H of half a unit cell with sides 1, gamma = 1 rad, designed with c = g + 0.4 (1 - g).

    For the Miura these are Schenk and Guest's, in terms of the inclination theta of its facets, whose tangent
    grows with tan(t/2). For the eggbox c is solved from tan(rho/2) = s d / w on its FL lines.
    """
    g = np.cos(1.0)
    c0 = g + 0.4 * (1 - g)
    s0, d0 = np.sqrt(1 - c0**2), g / c0
    w0 = np.sqrt(1 - d0**2)
    if make is miura:
        theta = np.arctan2(np.sin(t / 2) * w0, np.cos(t / 2) * s0 * d0)
        root = np.sqrt(1 - np.sin(theta) ** 2 * np.sin(1.0) ** 2)
        return np.cos(theta) * np.sin(1.0) / root, root, g / root, np.sin(theta) * np.sin(1.0)
    sine, cosine = np.sin(t / 2) * s0 * d0, np.cos(t / 2) * w0
    full, part = np.hypot(sine, cosine), np.hypot(sine, cosine * g)
    return sine * np.sin(1.0) / part, part / full, g * full / part, cosine * np.sin(1.0) / full


@pytest.mark.parametrize("t", T)
@pytest.mark.parametrize("name", EXACT)
def test_closed_form_of_the_unit_cells(name: str, t: float) -> None:
    m, n = 4, 6
    make = EXACT[name]
    design = make(m, n, sector_angle=1.0, fold_state=0.4)
    points = folding.fold(design, np.array([t])).vertices_coords[0]
    S, L, V, H = half_cell(make, t)
    i, j = (x.ravel() for x in np.meshgrid(np.arange(m + 1), np.arange(n + 1), indexing="ij"))
    if make is miura:
        expected = np.c_[S * i, V * (i % 2) + L * j, H * (j % 2)]
    else:
        expected = np.c_[S * i, V * (i % 2) + L * (j % 2), H * j]
    assert_close(best_motion(points, expected), expected, 1e-13)
    assert_close(pdist(points), pdist(expected), 1e-13)


@pytest.mark.parametrize("t", T[1:-1])
def test_fold_angles_of_a_miura_keep_their_ratio(t: float) -> None:
    """tan(rho/2) on the lines of one direction is cos(gamma) times that of the other, at every state."""
    design = miura(3, 3, sector_angle=0.9, fold_state=0.3)
    pattern = design.pattern
    angles = folding.fold_angles_at(design, np.array([t]))[0]
    along_v = np.ptp(pattern.edges_vertices // 4, axis=1) == 0
    inner = pattern.edges_type == FL
    first, second = (
        np.unique(np.round(np.tan(np.abs(angles[k]) / 2), 12)) for k in (inner & along_v, inner & ~along_v)
    )
    assert len(first) == len(second) == 1
    assert first[0] / second[0] == pytest.approx(np.cos(0.9), rel=1e-10)


@pytest.mark.parametrize("fold_state", [0.2, 0.5])
def test_a_miura_state_is_the_seed_of_another_fold_state(fold_state: float) -> None:
    """c^2 = (g^2 + tau^2 T^2) / (1 + tau^2 T^2), T = tan of half a fold angle in the design state."""
    g = np.cos(np.pi / 3)
    c0 = g + fold_state * (1 - g)
    design = miura(5, 4, fold_state=fold_state)
    for t in (0.3, 1.2, 1.9):
        squared = np.tan(t / 2) ** 2 * (c0**2 - g**2) / (1 - c0**2)
        c = np.sqrt((g**2 + squared) / (1 + squared))
        other = miura(5, 4, fold_state=(c - g) / (1 - g))
        assert_close(pdist(folding.fold(design, np.array([t])).vertices_coords[0]), pdist(other.vertices_coords), 1e-12)


@pytest.mark.parametrize("name", ALL)
def test_facets_stay_rigid_and_meet(name: str) -> None:
    """Every distance within a facet is kept, so that its sides, diagonals and flatness are too."""
    design = ALL[name]()
    motion = folding.fold(design)
    assert len(motion.t) == 64
    assert motion.t[[0, -1]].tolist() == [0.0, np.pi]
    assert motion.gap.max() <= 1e-13
    pairs = np.array([p for face in design.pattern.faces_vertices for p in itertools.combinations(face, 2)])
    a, b = design.vertices_coords[pairs].transpose(1, 0, 2)
    moved = motion.vertices_coords[:, pairs[:, 0]] - motion.vertices_coords[:, pairs[:, 1]]
    before = np.broadcast_to(np.linalg.norm(a - b, axis=1), moved.shape[:2])
    assert_close(np.linalg.norm(moved, axis=2), before, 5e-14)
    held = list(design.pattern.faces_vertices[0])
    assert_close(motion.vertices_coords[:, held] - design.vertices_coords[held], 0, 0)


@pytest.mark.parametrize("name", ALL)
def test_the_shape_has_the_fold_angles_that_are_told(name: str) -> None:
    design = ALL[name]()
    motion = folding.fold(design, np.array([0.4, 1.2, 2.6]))
    for angles, points in zip(motion.fold_angles, motion.vertices_coords, strict=True):
        assert_close(geometry.fold_angles(design.pattern, points), angles, 1e-12)


@pytest.mark.parametrize("name", ALL)
def test_ninety_degrees_is_the_design_itself(name: str) -> None:
    design = ALL[name]()
    motion = folding.fold(design, np.array([np.pi / 2]))
    assert_close(motion.vertices_coords[0], design.vertices_coords, 1e-13)
    rho = geometry.fold_angles(design.pattern, design.vertices_coords)
    assert_close(motion.fold_angles[0], rho, 1e-15)


@pytest.mark.parametrize("name", GRIDS)
def test_limits_are_exact(name: str) -> None:
    """0 and +-pi to the last bit: FL flat and CFL closed when developed, the other way round flat-folded."""
    design = GRIDS[name]()
    types = design.pattern.edges_type
    sign = np.sign(geometry.fold_angles(design.pattern, design.vertices_coords))
    developed, folded = folding.fold_angles_at(design, np.array([0.0, np.pi]))
    assert np.array_equal(developed, np.where(types == CFL, sign * np.pi, 0.0))
    assert np.array_equal(folded, np.where(types == FL, sign * np.pi, 0.0))


@pytest.mark.parametrize("t", [0.0, np.pi])
@pytest.mark.parametrize("name", [*GRIDS, *GENERAL])
def test_flat_states_are_flat_and_turn_facets_by_their_signs(name: str, t: float) -> None:
    design = ALL[name]()
    pattern = design.pattern
    flat = folding.flat_state(design, t)
    assert_close(flat[:, 2], 0, 1e-13)
    a, b = design.vertices_coords[pattern.edges_vertices].transpose(1, 0, 2)
    lengths = np.linalg.norm(np.diff(flat[pattern.edges_vertices], axis=1)[:, 0], axis=1)
    assert_close(lengths, np.linalg.norm(a - b, axis=1), 1e-13)
    x, y = flat[:, :2].T
    area = np.array(
        [x[list(f)] @ np.roll(y[list(f)], -1) - y[list(f)] @ np.roll(x[list(f)], -1) for f in pattern.faces_vertices]
    )
    np.testing.assert_array_equal(np.sign(area), pattern.facet_signs(CFL if t == 0 else FL))


@pytest.mark.parametrize("name", ["miura", "staircase", "polygonal", "holed"])
def test_a_developed_miura_is_a_sheet_with_full_angles(name: str) -> None:
    """All FL: signed sector angles sum to 360 degrees, the facets' areas add up without overlap."""
    design = ALL[name]()
    pattern, flat = design.pattern, folding.flat_state(design, 0.0)
    total = np.zeros(pattern.n_vertices)
    _, previous, vertex, following = pattern.corners.T
    a, b = flat[following] - flat[vertex], flat[previous] - flat[vertex]
    np.add.at(total, vertex, np.arctan2(np.cross(a, b)[:, 2], np.einsum("ij,ij->i", a, b)))
    assert_close(total[pattern.interior_vertices], 2 * np.pi, 1e-12)
    if name == "miura":  # a chevron sheet of 4 by 4 unit rhombs with angles of 60 degrees
        expected = np.array([[np.sqrt(0.75) * i, j + 0.5 * (i % 2)] for i in range(5) for j in range(5)])
        assert_close(pdist(flat), pdist(expected), 1e-13)


def test_a_flat_folded_miura_is_one_column_of_facets() -> None:
    """All sectors are stacked: one strip along v that repeats with every second line."""
    flat = folding.flat_state(miura(4, 6), np.pi).reshape(5, 7, 3)
    assert_close(flat[::2], np.tile(flat[0], (3, 1, 1)), 1e-13)
    assert_close(flat[1::2], np.tile(flat[1], (2, 1, 1)), 1e-13)
    assert np.linalg.norm(flat[0, 6] - flat[0, 0]) == pytest.approx(6 * np.cos(np.pi / 3), abs=1e-12)


@pytest.mark.parametrize("name", ["miura", "eggbox", "hybrid", "polygonal", "tube6"])
def test_exchanging_the_types_runs_the_motion_backward(name: str) -> None:
    design = ALL[name]()
    other = Design(designs.exchanged(design.pattern), design.vertices_coords)
    forward, backward = folding.fold(design, T), folding.fold(other, np.pi - T)
    assert_close(forward.fold_angles, backward.fold_angles, 1e-13)
    assert_close(forward.vertices_coords, backward.vertices_coords, 1e-12)


@pytest.mark.parametrize("name", ["hybrid", "polygonal", "two_holes", "tube8"])
def test_the_motion_does_not_depend_on_numbers(name: str) -> None:
    design = ALL[name]()
    other, vertex, _ = relabelled(design, 5)
    a, b = folding.fold(design, T), folding.fold(other, T)
    for here, there in zip(a.vertices_coords, b.vertices_coords, strict=True):
        assert_close(pdist(there[vertex]), pdist(here), 1e-12)


def test_two_motions_composed_are_one() -> None:
    """tau multiplies: folding a state at tan = p by tan = q is folding the design by p q."""
    design = GENERAL["polygonal_eggbox"]()
    first, second = 0.8, 2.1
    state = design.moved_to(folding.fold(design, np.array([first])).vertices_coords[0])
    both = 2 * np.arctan(np.tan(first / 2) * np.tan(second / 2))
    assert_close(
        folding.fold(state, np.array([second])).vertices_coords,
        folding.fold(design, np.array([both])).vertices_coords, 1e-12,
    )  # fmt: skip


@pytest.mark.parametrize("name", ["miura", "eggbox", "hybrid", "polygonal", "holed", *TUBES])
def test_a_wrong_design_shows_a_gap(name: str) -> None:
    """An interior vertex moved by 1e-3 breaks its conditions; the design state itself still fits together."""
    design = ALL[name]()
    points = design.vertices_coords.copy()
    points[design.pattern.interior_vertices[-1]] += [1e-3, -4e-4, 3e-4]
    motion = folding.fold(design.moved_to(points), np.array([0.5, np.pi / 2, 2.5]))
    assert motion.gap[[0, 2]].min() > 1e-4
    assert motion.gap[1] < 1e-14


@pytest.mark.parametrize("t", [[-1e-9], [0.2, 3.2], [np.nan], [np.inf]])
def test_amounts_outside_the_motion_are_refused(t: list[float]) -> None:
    with pytest.raises(ValueError, match="run from 0"):
        folding.fold(miura(2, 2), np.array(t))
