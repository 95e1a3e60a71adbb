"""The motion is followed from end to end, at every edge, and where it stops is told."""

from __future__ import annotations

import dataclasses

import designs
import numpy as np
import pytest
from certify_cases import document, frame_of, hinged, motion_of, raw, spherical

from inverse import certify
from inverse.certify import collisions, loops
from inverse.certify import dual_quaternions as dual
from inverse.certify.motion import Motion
from inverse.certify.structure import examine
from inverse.files import fold_file

# Dual quaternions, against matrices.


def _screw(seed):
    """A rotation about a line, as a dual quaternion and as a function of points (3, N)."""
    rng = np.random.default_rng(seed)
    point, axis, angle = rng.normal(size=3), rng.normal(size=3), rng.uniform(-3, 3)
    axis /= np.linalg.norm(axis)
    cross = np.cross(axis, np.eye(3)).T
    matrix = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    lines = dual.screw_axes(point[None], axis[None])
    moved = dual.rotations(np.array([np.cos(angle / 2)]), np.array([np.sin(angle / 2)]), lines)
    return moved, lambda p: matrix @ (p - point[:, None]) + point[:, None]


@pytest.mark.parametrize("seed", range(3))
def test_dual_quaternions_move_points_as_matrices_do(seed):
    points = np.random.default_rng(9).normal(size=(3, 7))
    (a, move_a), (b, move_b) = _screw(seed), _screw(seed + 10)
    np.testing.assert_allclose(dual.move(a, points), move_a(points), atol=1e-14)
    np.testing.assert_allclose(dual.move(dual.multiply(a, b), points), move_a(move_b(points)), atol=1e-13)


# Gaps between facets.


SECTORS = np.array([1.0, 1.3, np.pi - 1.0, np.pi - 1.3])
ALTERNATING = np.array([1, -1, 1, -1])


@pytest.mark.parametrize("start", range(4))
@pytest.mark.parametrize("far", [1, 2, 3, 4])
@pytest.mark.parametrize(("kind", "state"), [("CFL", "0.0"), ("FL", "180.0")])
def test_a_gap_is_the_way_of_the_outermost_vertex_on_either_side(kind, state, far, start):
    # In the flat state where all edges are folded everything lies in one plane, and the facets on the two sides of
    # the last edge are turned against each other, about the vertex, by what the alternating angles lack.
    lack = 1e-3
    reach = np.ones(4)
    reach[far - 1] = 3.0
    doc = spherical(SECTORS + lack * ALTERNATING / 4, [kind] * 4, reach)
    doc["faces_vertices"] = [face[start:] + face[:start] for face in doc["faces_vertices"]]
    motion = motion_of(doc)
    (edge,) = motion.mesh.off_tree
    value, where = motion.gap()
    assert where == f"{motion.mesh.name(edge)} at t = {state} degrees"
    corners = {v for f in motion.mesh.sides[edge] for v in motion.mesh.facets[f]}
    points = np.array(doc["vertices_coords"])
    distance = np.linalg.norm(points[sorted(corners)], axis=1).max() / np.linalg.norm(np.ptp(points, axis=0))
    assert value == pytest.approx(2 * np.sin(lack / 2) * distance, rel=1e-6)


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_a_gap_of_a_billionth_of_the_diagonal_is_the_limit(share):
    doc = spherical(SECTORS + 1e-4 / 4, ["FL"] * 4)
    gap = motion_of(doc).gap()[0]
    doc = spherical(SECTORS + share * 1e-9 / gap * 1e-4 / 4, ["FL"] * 4)
    item = certify.check_frame(frame_of(doc)).checks["motion_gap"]
    assert item.value == pytest.approx(share * 1e-9, rel=1e-3)
    assert item.passed == (share < 1)


def test_gaps_are_measured_at_65_states_and_at_both_flat_ones():
    seen = []

    class Watched(Motion):
        def placements(self, theta):
            seen.append(theta)
            return super().placements(theta)

    structure = examine(frame_of(document("miura")))
    motion = Watched(structure.mesh, structure.points, structure.types, *structure.halves)
    motion.gap()
    np.testing.assert_allclose(2 * np.degrees(np.concatenate(seen)), np.linspace(0, 180, 65), atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_no_state_opens_more_than_was_found(seed):
    # Against facets placed one after the other on another way round, at far more states.
    rng = np.random.default_rng(seed)
    doc = document("eggbox" if seed % 2 else "miura")
    doc["vertices_coords"] = (np.array(doc["vertices_coords"]) + 1e-3 * rng.normal(size=(30, 3))).tolist()
    motion = motion_of(doc)
    placed = motion.placements(np.linspace(0, np.pi / 2, 257))
    apart = np.zeros(1)
    for left, right in motion.mesh.sides[motion.mesh.inner]:
        for v in set(motion.mesh.facets[left]) & set(motion.mesh.facets[right]):
            point = motion.points[v][:, None]
            gap = np.linalg.norm(dual.move(placed[:, :, left], point) - dual.move(placed[:, :, right], point), axis=0)
            apart = np.maximum(apart, gap.max())
    # Vertices of the edge alone see no wrong angle about it.
    assert 0.99 * apart[0] < motion.gap()[0] < 10 * apart[0]


def test_facets_with_more_vertices_than_their_neighbour_are_measured_at_all_of_them():
    # A vertex of four triangles, the last of them with two more vertices far out: these are the ones that gape.
    lack = 1e-3
    doc = spherical(SECTORS + lack * ALTERNATING / 4, ["FL"] * 4)
    points = np.array(doc["vertices_coords"])
    for facet in (2, 3):
        a, b = points[1 + facet], points[1 + (facet + 1) % 4]
        faces = [[0, 1 + k, 1 + (k + 1) % 4] for k in range(4)]
        faces[facet] = [0, 1 + facet, 5, 6, 1 + (facet + 1) % 4]
        corners = np.vstack([points[:5], [3 * a + b, 1.5 * a + 2 * b]])
        motion = motion_of(raw(corners, faces, {(0, 1 + k): "FL" for k in range(4)}))
        reach = np.linalg.norm(corners[5:], axis=1).max() / np.linalg.norm(np.ptp(corners, axis=0))
        assert motion.gap()[0] == pytest.approx(2 * np.sin(lack / 2) * reach, rel=1e-6)


@pytest.mark.parametrize("make", [designs.miura, designs.eggbox])
def test_gaps_are_those_of_all_vertices_of_facets_of_any_number_of_sides(make):
    # Facet by facet: where one is, and where each neighbour and the edge between say that it should be.
    design = designs.polygonal(make)
    rng = np.random.default_rng(2)
    points = design.vertices_coords + 1e-3 * rng.normal(size=design.vertices_coords.shape)
    motion = motion_of(fold_file.document(design.moved_to(points)))
    theta = np.linspace(0, np.pi / 2, 65)
    placed = motion.placements(theta)
    gaps = np.zeros((65, len(motion.mesh.off_tree)))
    for gap, edge in zip(gaps.T, motion.mesh.off_tree, strict=True):
        for here, there in (motion.mesh.sides[edge], motion.mesh.sides[edge][::-1]):
            hinge = motion.hinges(theta, np.array([edge]), np.array([here]))[:, :, 0]
            expected = dual.multiply(placed[:, :, here], hinge)
            for v in motion.mesh.facets[there]:
                at = motion.points[v][:, None]
                apart = np.linalg.norm(dual.move(placed[:, :, there], at) - dual.move(expected, at), axis=0)
                np.maximum(gap, apart, out=gap)
    np.testing.assert_allclose(motion._disagreement(theta, placed, motion.mesh.off_tree), gaps, rtol=1e-9, atol=1e-15)
    assert motion.gap()[0] == pytest.approx(gaps.max(), rel=1e-9)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("which", ["sine", "cosine", "points"])
def test_a_motion_that_is_no_number_passes_nothing(which, bad):
    motion = motion_of(document("6-gon tube"))
    strips = loops.shortest_strips(motion.mesh)
    spoilt = getattr(motion, which).copy()
    spoilt[motion.mesh.inner[-1] if which != "points" else -1] = bad
    with np.errstate(all="ignore"):
        motion = dataclasses.replace(motion, **{which: spoilt})
        assert motion.gap() == (None, "the motion is not defined")
        everywhere = getattr(motion, which).copy()
        everywhere[:] = bad
        motion = dataclasses.replace(motion, **{which: everywhere})
        assert loops.closure(motion, strips) == ((None, "the motion is not defined"), ())


def test_one_state_in_which_a_strip_is_no_number_is_enough():
    class Broken(Motion):
        def hinges(self, theta, edges, facets):
            found = super().hinges(theta, edges, facets)
            found[:, -1] = np.nan
            return found

    motion = motion_of(document("6-gon tube"))
    broken = Broken(motion.mesh, motion.points, motion.types, motion.sine, motion.cosine)
    (value, _), found = loops.closure(broken, loops.shortest_strips(motion.mesh))
    assert value is None
    assert found == ()
    assert broken.gap()[0] is None


def test_a_single_fold_has_no_gap():
    assert motion_of(hinged([1.0], [1.0, 1.0])).gap() == (0.0, "no closed chain of facets")


# How far the motion goes.


@pytest.mark.parametrize("kind", ["FL", "CFL"])
@pytest.mark.parametrize("fold", [0.026, 5.0, 30.0, 90.0, 119.0])
def test_a_crossing_is_located_to_a_hundredth_of_a_degree_wherever_it_is(kind, fold):
    doc = hinged(np.radians([fold, fold]), [1.0] * 3)
    doc["bdffpq:edges_type"] = [kind if word == "FL" else word for word in doc["bdffpq:edges_type"]]
    touching = np.degrees(2 * np.arctan(np.tan(np.radians(60)) / np.tan(np.radians(fold / 2))))
    (low, high), (crossing,) = collisions.free_range(motion_of(doc))
    low, high = (low, high) if kind == "FL" else (180 - high, 180 - low)
    assert low == 0
    assert touching - 0.0101 <= high <= touching
    assert crossing.t == pytest.approx(high if kind == "FL" else 180 - high, abs=1e-9)
    assert crossing.facets == ((0, 2),)


def test_between_two_states_a_crossing_is_located_to_a_hundredth_of_a_degree():
    motion = motion_of(hinged(np.radians([60.0, 60]), [1.0] * 3))
    touching = np.degrees(2 * np.arctan(np.tan(np.radians(60)) / np.tan(np.radians(30))))
    for before, beyond in ((0.015, 0.002), (0.002, 0.015), (5.0, 3.0)):
        end = collisions._located(motion, touching - before, touching + beyond, np.array([[7, 8]]))
        assert touching - 0.01 <= end.t <= touching
    # What crosses is told of the state beyond, also where no step was needed.
    assert end.facets == ((0, 2),)
    assert collisions._located(motion, 90.0, 90.009, np.array([[7, 8]])).facets == ((7, 8),)


def test_both_ends_of_the_motion_are_looked_at():
    # Two rows of three squares, on FL and on CFL hinges: each closes at its own end.
    doc = hinged(np.radians([60.0, 60, -20, 60, 60]), [1.0] * 6)
    types = ["FL", "FL", "FL", "CFL", "CFL"]
    for k, word in enumerate(types, 1):
        edge = next(i for i, pair in enumerate(doc["edges_vertices"]) if set(pair) == {k, k + 7})
        doc["bdffpq:edges_type"][edge] = word
    touching = np.degrees(2 * np.arctan(np.tan(np.radians(60)) / np.tan(np.radians(30))))
    (low, high), crossings = collisions.free_range(motion_of(doc))
    assert high <= touching
    assert low >= 180 - touching
    assert [end.t for end in crossings] == [low, high]
    assert crossings[0].facets != crossings[1].facets


def test_up_to_three_crossing_pairs_are_named():
    def told(*offsets):
        # Horizontal squares on the x axis, each pierced by an upright one.
        points, faces = [], []
        for x in offsets:
            for square in (
                [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
                [[0.5, 0.2, -1], [0.5, 0.8, -1], [0.5, 0.8, 1], [0.5, 0.2, 1]],
            ):
                faces.append(list(range(len(points), len(points) + 4)))
                points += (np.array(square) + np.array([x, 0, 0])).tolist()
        return collisions.design_crossings(np.array(points), tuple(map(tuple, faces)))

    assert told(0) == (1.0, "facets 0 and 1")
    assert told(0, 2) == (2.0, "facets 0 and 1, 2 and 3")
    assert told(0, 2, 4) == (3.0, "facets 0 and 1, 2 and 3, 4 and 5")
    assert told(0, 2, 4, 6, 8) == (5.0, "facets 0 and 1, 2 and 3, 4 and 5 and 2 more pairs")
    sound = document("miura")
    facets = tuple(map(tuple, sound["faces_vertices"]))
    assert collisions.design_crossings(np.array(sound["vertices_coords"]), facets) == (0.0, "no facets cross")


def test_ten_pairs_are_listed_where_a_range_ends():
    pairs = np.arange(24).reshape(-1, 2)
    crossing = collisions._located(motion_of(document("miura")), 100.0, 100.005, pairs)
    assert crossing.t == 100.0
    assert crossing.facets == tuple(map(tuple, pairs[:10].tolist()))


def test_states_are_told_as_they_are_looked_at(tmp_path) -> None:
    """All of them where nothing crosses, one after the other."""
    told: list[tuple[int, int]] = []
    fold_file.write(designs.miura(), tmp_path / "sheet.fold")
    quiet = certify.check(tmp_path / "sheet.fold")
    assert certify.check(tmp_path / "sheet.fold", lambda done, of: told.append((done, of))) == quiet
    assert told == [(k, 64) for k in range(1, 65)]
