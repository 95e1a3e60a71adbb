"""Seeds satisfy the paper's conditions to rounding, by angles measured here, and say where they cannot."""

from __future__ import annotations

import re

import numpy as np
import pytest
from designs import HYBRID_V, SECTIONS, assert_close, eggbox, hybrid, miura, tube
from scipy.spatial.distance import pdist

from inverse.errors import InputError
from inverse.origami import seeds
from inverse.origami.pattern import CFL, FL, Design

LENGTHS = np.array([1.0, 0.4, 2.5, 0.7, 1.3, 0.9, 1.1, 0.5, 2.0])


def angle(points: np.ndarray, a: int, vertex: int, b: int) -> float:
    u, v = points[a] - points[vertex], points[b] - points[vertex]
    u, v = u / np.linalg.norm(u), v / np.linalg.norm(v)
    return float(2 * np.arctan2(np.linalg.norm(u - v), np.linalg.norm(u + v)))


def opposite_angle_residuals(design: Design) -> np.ndarray:
    """Miura vertices: sums of opposite sector angles less pi; Voss vertices: their differences."""
    pattern, points = design.pattern, design.vertices_coords
    kind = {
        frozenset(pair): t for pair, t in zip(pattern.edges_vertices.tolist(), pattern.edges_type.tolist(), strict=True)
    }
    found = []
    for vertex, ring in zip(pattern.interior_vertices.tolist(), pattern.ring_vertices.tolist(), strict=True):
        types = [kind[frozenset((vertex, other))] for other in ring]
        assert types[:2] == types[2:]
        theta = [angle(points, ring[k], vertex, ring[(k + 1) % 4]) for k in range(4)]
        if types[0] == types[1]:
            found += [theta[0] + theta[2] - np.pi, theta[1] + theta[3] - np.pi]
        else:
            found += [theta[0] - theta[2], theta[1] - theta[3]]
    return np.array(found)


def planarity_residuals(design: Design) -> np.ndarray:
    """Distances of the fourth vertices from the planes of the first three, over the mean edge."""
    a, b, c, d = design.vertices_coords[np.array(design.pattern.faces_vertices)].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return np.einsum("ij,ij->i", normal, d - a) / np.linalg.norm(b - a, axis=1).mean()


def assert_exact(design: Design, limit: float = 1e-14) -> None:
    assert np.abs(opposite_angle_residuals(design)).max(initial=0) <= limit
    assert np.abs(planarity_residuals(design)).max() <= limit


@pytest.mark.parametrize("fold_state", [0.05, 0.5, 0.95])
@pytest.mark.parametrize("degrees", [20, 60, 85])
@pytest.mark.parametrize("make", [miura, eggbox, hybrid])
def test_grids_are_exact(make, degrees: float, fold_state: float) -> None:
    design = make(5, sector_angle=np.radians(degrees), fold_state=fold_state)
    assert_exact(design)
    angles = [
        angle(design.vertices_coords, p, v, n) for _, p, v, n in design.pattern.corners.tolist()
    ]  # every facet is a parallelogram of the given sector angle
    assert_close(np.sin(angles), np.sin(np.radians(degrees)), atol=1e-13)


@pytest.mark.parametrize(
    ("u_lines", "v_lines"),
    [("FL", "FL"), ("CFL", "FL"), ("FL", "CFL"), ("CFL", "CFL"), ("FL", HYBRID_V), (HYBRID_V, "FL")],
)
def test_unequal_strips_are_exact_and_have_their_lengths(u_lines, v_lines) -> None:
    m = 9 if u_lines is HYBRID_V else 4
    design = seeds.grid((m, 9), u_lines, v_lines, lengths_u=LENGTHS[:m], lengths_v=LENGTHS[::-1])
    assert_exact(design)
    table = design.vertices_coords.reshape(m + 1, 10, 3)
    assert_close(np.linalg.norm(np.diff(table, axis=0), axis=2), np.repeat(LENGTHS[:m, None], 10, axis=1), atol=1e-14)
    assert_close(np.linalg.norm(np.diff(table, axis=1), axis=2), np.tile(LENGTHS[::-1], (m + 1, 1)), atol=1e-14)


def test_the_words_of_a_seed_are_those_asked_for() -> None:
    design = seeds.grid((3, 9), ["FL", "CFL"], "FL")
    types = [design.pattern.edges_type[k] for k in design.pattern.interior_edges]
    assert types.count(CFL) == 9
    assert types.count(FL) == 9 + 8 * 3
    assert_exact(design)


def test_one_facet_and_one_strip() -> None:
    assert_exact(seeds.grid((1, 1)))
    assert_exact(seeds.grid((1, 9), v_lines=HYBRID_V))


@pytest.mark.parametrize("make", [miura, eggbox, hybrid])
@pytest.mark.parametrize("lengths", [np.ones(8), LENGTHS[:8]])
def test_grids_extend_both_ways(make, lengths: np.ndarray) -> None:
    """Neither drift is lost: the sheet is wide in both directions, and no vertices coincide."""
    points = make(8, lengths_u=lengths).vertices_coords.reshape(9, -1, 3)
    u, v = (points[-1] - points[0]).mean(axis=0), (points[:, -1] - points[:, 0]).mean(axis=0)
    assert np.linalg.norm(np.cross(u, v)) > 0.25 * np.linalg.norm(u) * np.linalg.norm(v)
    assert pdist(points.reshape(-1, 3)).min() > 0.1


@pytest.mark.parametrize("fold_state", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("k", SECTIONS)
def test_tubes_are_exact(k: int, fold_state: float) -> None:
    design = tube(k, 5, fold_state=fold_state, sector_angle=1.1, lengths=LENGTHS[:5])
    assert_exact(design)
    points = design.vertices_coords.reshape(k, 6, 3)
    lengths = [length for _, _, length in SECTIONS[k]]
    around = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=2)
    assert_close(around, np.repeat(np.array(lengths)[:, None], 6, axis=1), atol=1e-14)
    assert pdist(design.vertices_coords).min() > 0.1
    # An axial line is a fold where n flips and an elbow where a flips.
    flips = [SECTIONS[k][i - 1][0] != SECTIONS[k][i][0] for i in range(k)]
    for column, fold in enumerate(flips):
        on_column = (design.pattern.edges_vertices // 6 == column).all(axis=1)
        assert set(design.pattern.edges_type[on_column]) == {FL if fold else CFL}


@pytest.mark.parametrize("make", [miura, eggbox, hybrid])
def test_seeds_depend_on_the_fold_state_continuously(make) -> None:
    states = np.arange(0.05, 0.96, 0.01)
    shapes = np.array([pdist(make(4, fold_state=state).vertices_coords) for state in states])
    assert np.abs(np.diff(shapes, axis=0)).max() < 0.3


def test_unit_and_name_are_kept() -> None:
    design = seeds.grid((2, 2), unit="mm", name="leaf")
    assert (design.unit, design.name) == ("mm", "leaf")


# ---- what is refused


def readings(u_lines: list[str], v_lines: list[str]) -> list[np.ndarray]:
    """Both translation surfaces of two words, (m + 1, n + 1, 3), strips of length 1 (math.md 3)."""
    c, d = 0.75, 2 / 3
    s, w = np.sqrt(1 - c * c), np.sqrt(1 - d * d)

    def signs(words: list[str], flipping: str) -> np.ndarray:
        return np.cumprod([1.0, *(-1.0 if word == flipping else 1.0 for word in words)])

    found = []
    for first, second in (("FL", "CFL"), ("CFL", "FL")):
        a, n, m, b = (
            signs(u_lines, first),
            signs(u_lines, second),
            signs(v_lines, first),
            signs(v_lines, second),
        )
        u = np.cumsum(np.vstack([np.zeros(3), np.c_[n * s, a * c, 0 * a]]), axis=0)
        v = np.cumsum(np.vstack([np.zeros(3), np.c_[0 * b, b * d, m * w]]), axis=0)
        found.append(u[:, None] + v[None])
    return found


def test_mixed_words_that_double_back_are_refused_and_others_are_not() -> None:
    rng = np.random.default_rng(3)
    refused = 0
    for _ in range(40):
        u_lines, v_lines = (rng.choice(["FL", "CFL"], 5).tolist() for _ in range(2))
        coincide = [pdist(points.reshape(-1, 3)).min() < 1e-9 for points in readings(u_lines, v_lines)]
        try:
            design = seeds.grid((6, 6), u_lines, v_lines)
        except InputError as error:
            refused += 1
            what = re.search(r"double back: (vertices coincide|facets cross), first at [uv] line \d", str(error))
            assert what is not None
            # Coincident vertices are claimed where they are.
            assert not all(coincide) or what[1] == "vertices coincide"
            assert what[1] == "facets cross" or any(coincide)
        else:
            assert pdist(design.vertices_coords).min() > 1e-3
            assert not all(coincide)
    assert refused > 30


def test_the_line_at_which_a_seed_doubles_back_is_named() -> None:
    """The steps (d, w), (-d, w), (-d, -w), (d, -w) of the first four strips close a loop."""
    words = ["CFL", "FL", "CFL", "FL"]
    with pytest.raises(InputError, match=r"vertices coincide, first at v line 4 \(counted from 1\)"):
        seeds.grid((3, 5), "FL", words)
    with pytest.raises(InputError, match=r"vertices coincide, first at u line 4 \(counted from 1\)"):
        seeds.grid((5, 3), words, "FL")
    assert_exact(seeds.grid((3, 3), "FL", words[:2]))


@pytest.mark.parametrize(
    ("arguments", "options", "match"),
    [
        (((0, 3),), {}, "size is 0 x 3"),
        (((3, -1),), {}, "size is 3 x -1"),
        (((3, 3), "fl"), {}, "u_lines has the word 'fl'"),
        (((3, 3), "FL", ["FL", "C"]), {}, "v_lines has the word 'C'"),
        (((1, 3), "X"), {}, "u_lines has the word 'X'"),
        (((3, 3), ["FL"]), {}, "u_lines has 1 words, but there are 2 interior lines"),
        (((3, 3), "FL", ["FL"] * 3), {}, "v_lines has 3 words, but there are 2 interior lines"),
        (((3, 3),), {"sector_angle": 0.0}, "sector angle is 0 degrees"),
        (((3, 3),), {"sector_angle": np.pi / 2}, "sector angle is 90 degrees"),
        (((3, 3),), {"sector_angle": np.nan}, "sector angle is nan"),
        (((3, 3),), {"fold_state": 0.0}, "fold state is 0"),
        (((3, 3),), {"fold_state": 1.0}, "fold state is 1"),
        (((3, 3),), {"fold_state": -0.5}, "fold state is -0.5"),
        (((3, 3),), {"lengths_u": [1, 1]}, "lengths_u has 2 lengths, but there are 3 strips"),
        (((3, 3),), {"lengths_v": [1, 0, 1]}, "lengths_v must be positive"),
        (((3, 3),), {"lengths_v": [1, np.inf, 1]}, "lengths_v must be positive"),
        (((3, 3),), {"lengths_u": [1, -1, 1]}, "lengths_u must be positive"),
    ],
)  # fmt: skip
def test_grids_refuse(arguments, options, match: str) -> None:
    with pytest.raises(InputError, match=match):
        seeds.grid(*arguments, **options)


ROUND = SECTIONS[4]


@pytest.mark.parametrize(
    ("section", "options", "match"),
    [
        ([(1, 1, 2), *ROUND[1:]], {}, "n-signed lengths sum to 1 and its a-signed ones to 1"),
        ([(1, 1, 1), (1, -1, 1), (-1, -1, 1)], {}, "n-signed lengths sum to 1 and its a-signed ones to -1"),
        ([(1, 1, 1), (-1, -1, 1)] * 2, {}, r"\(-1, -1\) and \(1, 1\) follow each other"),
        ([(1, 1, 1), (1, 1, 1), (1, -1, 2), (-1, -1, 2), (-1, 1, 2)], {}, r"\(1, 1\) and \(1, 1\) follow"),
        (ROUND, {"lengths": [1, 2]}, "lengths has 2 lengths, but there are 3 strips"),
        (ROUND, {"lengths": [1, -2, 1]}, "lengths must be positive"),
        (ROUND, {"fold_state": 1.0}, "fold state is 1"),
        (ROUND, {"sector_angle": 2.0}, "sector angle is 114.592 degrees"),
        (ROUND, {"n_rows": 0}, "row"),
        ([], {}, "section"),
        ([(2, 1, 1), (2, -1, 1), (-2, -1, 1), (-2, 1, 1)], {}, "2"),
        ([(n, a, -1) for n, a, _ in ROUND], {}, "positive"),
    ],
)  # fmt: skip
def test_tubes_refuse(section, options, match: str) -> None:
    with pytest.raises(InputError, match=match):
        seeds.tube(section, **({"n_rows": 3} | options))
