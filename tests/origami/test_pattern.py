"""The topology of a pattern, checked against its definitions by brute force."""

from __future__ import annotations

from itertools import pairwise

import designs
import numpy as np
import pytest
from designs import (
    ALL,
    GENERAL,
    GRIDS,
    all_cfl,
    all_fl,
    assert_close,
    edge_types,
    holed,
    miura,
    relabelled,
    tube,
)
from hypothesis import given, settings
from hypothesis import strategies as st

from inverse.origami import folding, geometry, seeds
from inverse.origami.pattern import CFL, FL, B, Design, Pattern


def kagome() -> list[list[int]]:
    """A hexagon, six triangles on its sides, six quads in their gaps: inner vertices have four edges."""
    faces = [list(range(6))]
    faces += [[(k + 1) % 6, k, 6 + k] for k in range(6)]
    return faces + [[(k + 1) % 6, 6 + k, 12 + k, 6 + (k + 1) % 6] for k in range(6)]


def words(pattern: Pattern) -> dict[frozenset[int], int]:
    return dict(zip(map(frozenset, pattern.edges_vertices.tolist()), pattern.edges_type.tolist(), strict=True))


@pytest.mark.parametrize("name", ALL)
def test_edges_and_corners_by_brute_force(name: str) -> None:
    pattern = ALL[name]().pattern
    directed = {}
    for f, face in enumerate(pattern.faces_vertices):
        for a, b in zip(face, face[1:] + face[:1], strict=True):
            assert (a, b) not in directed
            directed[a, b] = f
    assert len({frozenset(pair) for pair in directed}) == len(pattern.edges_vertices)
    for (a, b), (left, right), kind in zip(
        pattern.edges_vertices.tolist(), pattern.edges_faces.tolist(), pattern.edges_type, strict=True
    ):
        assert directed[a, b] == left
        assert directed.get((b, a), -1) == right
        assert (kind == B) == (right == -1)
    corners = {
        (f, face[k - 1], v, face[(k + 1) % len(face)])
        for f, face in enumerate(pattern.faces_vertices)
        for k, v in enumerate(face)
    }
    assert set(map(tuple, pattern.corners.tolist())) == corners
    assert len(pattern.corners) == len(corners)


@pytest.mark.parametrize("name", ALL)
def test_rings_close_around_their_vertex(name: str) -> None:
    pattern = ALL[name]().pattern
    degree = np.bincount(pattern.edges_vertices.ravel())
    on_boundary = np.unique(pattern.edges_vertices[pattern.edges_faces[:, 1] < 0])
    np.testing.assert_array_equal(pattern.interior_vertices, np.setdiff1d(np.arange(pattern.n_vertices), on_boundary))
    assert set(degree[pattern.interior_vertices]) == {4}
    corners = set(map(tuple, pattern.corners.tolist()))
    for row, v in enumerate(pattern.interior_vertices.tolist()):
        ring, edges, faces = (t[row].tolist() for t in (pattern.ring_vertices, pattern.ring_edges, pattern.ring_faces))
        for k in range(4):
            assert set(pattern.edges_vertices[edges[k]]) == {v, ring[k]}
            # A facet turning counter-clockwise comes in from the later spoke, goes out along the earlier.
            assert (faces[k], ring[(k + 1) % 4], v, ring[k]) in corners


def test_rings_turn_counter_clockwise_seen_from_above() -> None:
    design = relabelled(miura(4, 5))[0]
    pattern, flat = design.pattern, folding.flat_state(design, 0.0)
    for v, ring in zip(pattern.interior_vertices, pattern.ring_vertices, strict=True):
        x, y = (flat[ring] - flat[v])[:, :2].T
        turns = np.mod(np.diff(np.r_[np.arctan2(y, x), np.arctan2(y[0], x[0])]), 2 * np.pi)
        assert turns.sum() == pytest.approx(2 * np.pi, abs=1e-12)


@pytest.mark.parametrize("name", ALL)
def test_a_line_goes_straight_on_and_keeps_its_type(name: str) -> None:
    pattern = ALL[name]().pattern
    kind = words(pattern)
    rings = dict(zip(pattern.interior_vertices.tolist(), pattern.ring_vertices.tolist(), strict=True))
    walked = []
    for line in pattern.lines:
        pairs = list(pairwise(line))
        assert len({kind[frozenset(pair)] for pair in pairs}) == 1
        walked += map(frozenset, pairs)
        closed = line[0] == line[-1]
        around = [*pairs, pairs[0]] if closed else pairs
        for (a, v), (_, b) in pairwise(around):
            assert (rings[v].index(a) - rings[v].index(b)) % 4 == 2
        assert closed or not {line[0], line[-1]} & set(rings)
    assert sorted(map(sorted, walked)) == sorted(sorted(pair) for pair, t in kind.items() if t != B)


def test_numbering_of_grids_and_their_words() -> None:
    u_lines, v_lines = ["FL", "CFL", "FL"], ["CFL", "FL", "FL", "CFL"]
    m, n = 4, 5
    pattern = seeds.grid_pattern((m, n), u_lines, v_lines)
    assert pattern.grid == (m, n)
    assert pattern.topology == "disk"
    table = np.arange((m + 1) * (n + 1)).reshape(m + 1, n + 1)
    for i in range(m):
        for j in range(n):
            expected = (table[i, j], table[i + 1, j], table[i + 1, j + 1], table[i, j + 1])
            assert pattern.faces_vertices[i * n + j] == expected
    kind = words(pattern)
    lines = {min(line, line[::-1]): kind[frozenset(line[:2])] for line in pattern.lines}
    types = {"FL": FL, "CFL": CFL}
    expected = {tuple(table[i + 1].tolist()): types[w] for i, w in enumerate(u_lines)}
    expected |= {tuple(table[:, j + 1].tolist()): types[w] for j, w in enumerate(v_lines)}
    assert lines == expected
    miura_vertices = [u == v for u in u_lines for v in v_lines]
    np.testing.assert_array_equal(pattern.interior_vertices, table[1:-1, 1:-1].ravel())
    np.testing.assert_array_equal(pattern.is_miura_vertex, miura_vertices)


def test_numbering_of_tubes() -> None:
    pattern = tube(6, 4).pattern
    assert pattern.grid == (6, 4)
    assert pattern.topology == "cylinder"
    assert pattern.faces_vertices[5 * 4 + 1] == (
        26,
        1,
        2,
        27,
    )  # the last facet round goes on to the first column
    closed = [line for line in pattern.lines if line[0] == line[-1]]
    assert sorted(sorted(set(line)) for line in closed) == [[5 * i + j for i in range(6)] for j in (1, 2, 3)]
    assert len(pattern.lines) == 6 + 3


@pytest.mark.parametrize("m", [1, 2, 5])
@pytest.mark.parametrize("n", [1, 3])
def test_degrees_of_freedom_of_a_grid(m: int, n: int) -> None:
    assert seeds.grid_pattern((m, n)).degrees_of_freedom == 5 * (m + n) + 1


@pytest.mark.parametrize("name", ["staircase", "polygonal", "miura", "kagome"])
def test_degrees_of_freedom_of_a_disk_from_its_boundary(name: str) -> None:
    """3 + E_b + half the boundary vertices' degrees (math.md 2), whatever is inside."""
    pattern = Pattern.from_faces(kagome(), 18, all_fl) if name == "kagome" else ALL[name]().pattern
    boundary = pattern.edges_vertices[pattern.edges_type == B]
    degree = np.bincount(pattern.edges_vertices.ravel())[np.unique(boundary)]
    assert 2 * pattern.degrees_of_freedom == 6 + 2 * len(boundary) + degree.sum()


def test_facets_of_any_number_of_sides() -> None:
    pattern = Pattern.from_faces(kagome(), 18, all_fl)
    assert pattern.interior_vertices.tolist() == list(range(6))
    assert sorted(map(len, pattern.lines)) == [4] * 6
    assert all(set(line[1:3]) in [{k, (k + 1) % 6} for k in range(6)] for line in pattern.lines)
    assert pattern.degrees_of_freedom == 3 * 18 - 2 * 6 - (3 + 6)


def test_holes_are_counted() -> None:
    assert holed().pattern.topology == "cylinder"
    assert GENERAL["two_holes"]().pattern.topology == "holes:2"
    assert GENERAL["staircase"]().pattern.topology == "disk"


@pytest.mark.parametrize("name", ALL)
def test_facet_signs(name: str) -> None:
    pattern = ALL[name]().pattern
    inner = pattern.interior_edges
    left, right = pattern.edges_faces[inner].T
    for kind in (FL, CFL):
        signs = pattern.facet_signs(kind)
        assert set(signs) <= {1, -1}
        np.testing.assert_array_equal(signs[left] != signs[right], pattern.edges_type[inner] == kind)


def test_the_other_reading_exchanges_the_types_of_lines() -> None:
    pattern = ALL["hybrid"]().pattern
    other = designs.exchanged(pattern)
    swap = {B: B, FL: CFL, CFL: FL}
    assert other.edges_type.tolist() == [swap[t] for t in pattern.edges_type.tolist()]
    np.testing.assert_array_equal(other.is_miura_vertex, pattern.is_miura_vertex)
    np.testing.assert_array_equal(other.facet_signs(FL), pattern.facet_signs(CFL))


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.sampled_from(sorted(ALL)), st.integers(0, 2**32 - 1))
def test_numbers_of_vertices_and_facets_mean_nothing(name: str, seed: int) -> None:
    design = ALL[name]()
    other, vertex, facet = relabelled(design, seed)
    a, b = design.pattern, other.pattern
    assert (a.topology, a.degrees_of_freedom) == (b.topology, b.degrees_of_freedom)
    np.testing.assert_array_equal(np.sort(vertex[a.interior_vertices]), b.interior_vertices)
    moved = {frozenset(vertex[list(pair)].tolist()): kind for pair, kind in words(a).items()}
    assert moved == words(b)

    def lines(pattern: Pattern, number: np.ndarray) -> set[frozenset[frozenset[int]]]:
        """Every line as the set of its edges, since a closed one may start anywhere."""
        moved = [number[list(line)].tolist() for line in pattern.lines]
        return {frozenset(map(frozenset, pairwise(line))) for line in moved}

    assert lines(a, vertex) == lines(b, np.arange(b.n_vertices))
    assert_close(
        geometry.facet_normals(b, other.vertices_coords)[facet],
        geometry.facet_normals(a, design.vertices_coords), atol=1e-13,
    )  # fmt: skip


@pytest.mark.parametrize("name", GRIDS)
def test_patterns_are_read_from_types_alone(name: str) -> None:
    """The same facets with all lines of one type are another, valid pattern."""
    design = GRIDS[name]()
    faces, count = design.pattern.faces_vertices, design.pattern.n_vertices
    again = Pattern.from_faces(faces, count, edge_types(design, np.arange(count)))
    np.testing.assert_array_equal(again.edges_type, design.pattern.edges_type)
    assert Pattern.from_faces(faces, count, all_cfl).is_miura_vertex.all()


def test_a_moved_design_copies_its_coordinates() -> None:
    design = miura(2, 2)
    coords = design.vertices_coords + 1
    moved = design.moved_to(coords)
    coords[0] = 7
    assert isinstance(moved, Design)
    np.testing.assert_array_equal(moved.vertices_coords, design.vertices_coords + 1)
    assert moved.pattern is design.pattern
