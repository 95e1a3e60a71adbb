"""What the constraints' rows mean, measured by angles, lengths and distances of the mesh itself."""

from __future__ import annotations

import numpy as np
import pytest
from designs import (
    ALL,
    GENERAL,
    GRIDS,
    assert_close,
    eggbox,
    holds,
    hybrid,
    miura,
    perturbed,
    polygonal,
    relabelled,
    rotation,
    rows_of,
    tube,
)

from inverse import constraints
from inverse.model import DesignModel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.nlp.term import Constraint
from inverse.origami import folding, geometry
from inverse.origami.pattern import Design
from inverse.solvers.projection import polish

BOUNDS = {"edge_length": (0.3, 3.0), "sector_angle": (0.2, np.pi - 0.2), "fold_angle": (0.3, 2.8)}
DISKS = {
    **GRIDS,
    "staircase": GENERAL["staircase"],
    "polygonal": GENERAL["polygonal"],
    "polygonal eggbox": GENERAL["polygonal_eggbox"],
    "large miura": lambda: miura(7, 6, sector_angle=1.2, fold_state=0.3),
    "large eggbox": lambda: eggbox(5, 8, sector_angle=0.7, fold_state=0.6),
    "other hybrid": lambda: hybrid(5, sector_angle=1.2, lengths_u=[1, 2, 0.5, 1, 3]),
}


def equations(design: Design) -> Problem:
    model = DesignModel(design)
    return Problem(3 * design.pattern.n_vertices, [], constraints.hard_constraints(model, {}))


# ---- equations


@pytest.mark.parametrize("name", ALL)
def test_seeds_satisfy_all_constraints(name: str) -> None:
    design = ALL[name]()
    model = DesignModel(design)
    found = constraints.hard_constraints(model, BOUNDS)
    assert [c.name for c in found if c.is_equation] == [c.name for c in found if c.name not in BOUNDS]
    for constraint in found:
        assert len(constraint.labels) == constraint.elements.count
        assert holds(constraint, model, design.vertices_coords).all() or constraint.is_equation
        if constraint.is_equation:
            assert_close(rows_of(constraint, model, design.vertices_coords), 0, 1e-14)


@pytest.mark.parametrize("name", DISKS)
def test_equations_of_a_disk_are_independent(name: str) -> None:
    """Full row rank, so that the solutions near the seed have the dimension counted by the pattern."""
    design = DISKS[name]()
    problem = equations(design)
    jacobian = Point(problem, DesignModel(design).seed_points.ravel(), problem.parameters()).jacobian
    sizes = np.linalg.svd(jacobian.toarray(), compute_uv=False)
    assert len(sizes) == problem.n_rows
    assert sizes[-1] > 1e-3 * sizes[0] / np.sqrt(problem.n_rows)
    assert problem.n_variables - problem.n_rows == design.pattern.degrees_of_freedom
    if design.pattern.grid is not None:
        assert design.pattern.degrees_of_freedom == 5 * sum(design.pattern.grid) + 1


def test_equations_of_a_symmetric_tube_are_not() -> None:
    problem = equations(design := tube(6, 3))
    jacobian = Point(problem, DesignModel(design).seed_points.ravel(), problem.parameters()).jacobian
    assert problem.n_rows == 2 * 12 + 18
    assert np.linalg.matrix_rank(jacobian.toarray(), tol=1e-9) < problem.n_rows


def test_vertices_of_a_tube_do_not_close_its_motion() -> None:
    """math.md 5: every vertex and facet can be right and the strips around still part when it moves."""
    design = tube(6, 3)
    problem, model = equations(design), DesignModel(design)
    x = polish(
        Point(problem, model.to_dimensionless(perturbed(design, 0.02).vertices_coords).ravel(), problem.parameters())
    ).variables
    assert_close(Point(problem, x, problem.parameters()).rows, 0, 1e-13)
    assert folding.fold(model.design(x), np.array([0.5])).gap[0] > 1e-5


@pytest.mark.parametrize("name", ["miura", "eggbox", "polygonal"])
def test_opposite_angles_are_cosines_of_sector_angles(name: str) -> None:
    design = ALL[name]()
    model, pattern = DesignModel(design), design.pattern
    points = perturbed(design, 0.1).vertices_coords
    rows = rows_of(constraints.opposite_angles(model), model, points)
    cosine = dict(
        zip(
            map(tuple, pattern.corners[:, [0, 2]].tolist()),
            np.cos(geometry.sector_angles(pattern, points)),
            strict=True,
        )
    )
    for row, v, faces, miura_like in zip(
        rows,
        pattern.interior_vertices.tolist(),
        pattern.ring_faces.tolist(),
        pattern.is_miura_vertex,
        strict=True,
    ):
        a, b, c, d = (cosine[f, v] for f in faces)
        sign = 1 if miura_like else -1
        assert_close(row, [a + sign * c, b + sign * d], 1e-14)


def test_planarity_is_zero_for_planar_facets_only() -> None:
    design = polygonal()
    model = DesignModel(design)
    for constraint in constraints.planarity(model):
        sides = constraint.elements.kernel.n_variables // 3
        assert constraint.lower.shape[1] == sides - 3
        assert [int(label.removeprefix("facet ")) for label in constraint.labels] == [
            f for f, face in enumerate(design.pattern.faces_vertices) if len(face) == sides
        ]
        for k, label in enumerate(constraint.labels):
            face = design.pattern.faces_vertices[int(label.removeprefix("facet "))]
            normal = geometry.facet_normals(design.pattern, design.vertices_coords)[int(label.removeprefix("facet "))]
            for corner in range(3, sides):
                points = design.vertices_coords.copy()
                points[face[corner]] += 1e-3 * normal
                row = rows_of(constraint, model, points)[k]
                assert np.flatnonzero(np.abs(row) > 1e-6).tolist() == [corner - 3]


# ---- bounds


@pytest.mark.parametrize("limits", [(0.4, 2.3), (1.0, 1.9), (0.02, 3.12)])
@pytest.mark.parametrize("name", ["miura", "eggbox", "polygonal"])
def test_fold_angles_hold_where_the_angle_does(name: str, limits: tuple[float, float]) -> None:
    """Over the whole motion, and for the mirrored mesh, whose folds have all changed their signs."""
    design = ALL[name]()
    model, inner = DesignModel(design), design.pattern.interior_edges
    constraint = constraints.fold_angle(model, limits)
    sign = np.sign(geometry.fold_angles(design.pattern, design.vertices_coords))[inner]
    seen = set()
    for points in folding.fold(design, np.linspace(0.02, 3.12, 25)).vertices_coords:
        for shape in (points, points * [1, 1, -1]):
            angles = geometry.fold_angles(design.pattern, shape)[inner]
            margin = np.minimum(np.abs(sign * angles - limits[0]), np.abs(sign * angles - limits[1]))
            within = (sign * angles >= limits[0]) & (sign * angles <= limits[1])
            assert (holds(constraint, model, shape) == within)[margin > 1e-9].all()
            seen |= set(within.tolist())
    assert seen == {True, False}
    assert not holds(constraint, model, design.vertices_coords * [1, 1, -1]).any()
    angles = np.abs(geometry.fold_angles(design.pattern, design.vertices_coords)[inner])
    middle = np.mean(limits)
    assert_close(rows_of(constraint, model, design.vertices_coords)[:, 0], np.cos(angles - middle), 1e-14)


@pytest.mark.parametrize("limits", [(0.6, 2.2), (0.9, np.pi - 0.9)])
def test_sector_angles_hold_where_the_angles_do(limits: tuple[float, float]) -> None:
    design = polygonal()
    pattern, model = design.pattern, DesignModel(design)
    constraint = constraints.sector_angle(model, limits)
    kept = [tuple(int(word) for word in label.split() if word.isdigit()) for label in constraint.labels]
    places = [pattern.corners[:, [0, 2]].tolist().index(list(corner)) for corner in kept]
    for seed in range(5):
        points = perturbed(design, 0.2, seed).vertices_coords
        angles = geometry.sector_angles(pattern, points)[places]
        within = (angles >= limits[0]) & (angles <= limits[1])
        np.testing.assert_array_equal(holds(constraint, model, points), within)
        assert set(within.tolist()) == {True, False}


@pytest.mark.parametrize("name", ["hybrid", "polygonal", "tube6"])
def test_sector_angles_left_out_are_implied(name: str) -> None:
    """Limits symmetric about 90 degrees: every angle left out equals a kept one or is its supplement."""
    design = ALL[name]()
    model, pattern = DesignModel(design), design.pattern
    labels = constraints.sector_angle(model, (0.3, np.pi - 0.3)).labels
    every = constraints.sector_angle(model, (0.3, np.pi - 0.4)).labels
    assert set(labels) < set(every)
    assert len(every) == len(pattern.corners)
    assert len(every) - len(labels) == 2 * len(pattern.interior_vertices)
    sine = dict(zip(every, np.sin(geometry.sector_angles(pattern, design.vertices_coords)), strict=True))
    for label in set(every) - set(labels):
        same_vertex = [sine[other] for other in labels if other.split()[-1] == label.split()[-1]]
        assert np.abs(np.array(same_vertex) - sine[label]).min() < 1e-14


def test_edge_lengths_hold_where_the_lengths_do() -> None:
    design = hybrid(3, lengths_u=[1, 0.3, 2])
    model = DesignModel(design)
    constraint = constraints.edge_length(model, (0.8, 1.3))
    assert_close(rows_of(constraint, model, design.vertices_coords), 1, 1e-14)
    points = perturbed(design, 0.3).vertices_coords
    factor = geometry.edge_lengths(design.pattern, points) / geometry.edge_lengths(
        design.pattern, design.vertices_coords
    )
    np.testing.assert_array_equal(holds(constraint, model, points), (factor >= 0.8) & (factor <= 1.3))
    assert_close(rows_of(constraint, model, points)[:, 0], factor**2, 1e-13)


# ---- what does not matter


def hard(model: DesignModel) -> list[Constraint]:
    return constraints.hard_constraints(model, BOUNDS | {"sector_angle": (0.2, 2.9)})


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e6])
@pytest.mark.parametrize("name", ["hybrid", "polygonal_eggbox", "tube8"])
def test_rows_do_not_change_with_position_and_unit(name: str, size: float) -> None:
    design = ALL[name]()
    points = perturbed(design, 0.1).vertices_coords
    turn, shift = rotation(3), np.array([3.0, -5.0, 2.0])
    here, there = (
        DesignModel(design),
        DesignModel(design.moved_to(size * (design.vertices_coords @ turn + shift))),
    )
    for a, b in zip(hard(here), hard(there), strict=True):
        assert (a.name, a.labels) == (b.name, b.labels)
        assert_close(a.lower, b.lower, 0)
        assert_close(rows_of(a, here, points), rows_of(b, there, size * (points @ turn + shift)), 1e-12)


@pytest.mark.parametrize("name", ["hybrid", "polygonal_eggbox", "two_holes"])
def test_rows_do_not_change_with_numbers(name: str) -> None:
    design = ALL[name]()
    other, vertex, _ = relabelled(design, 8)
    points = perturbed(design, 0.1).vertices_coords
    moved = np.empty_like(points)
    moved[vertex] = points
    here, there = DesignModel(design), DesignModel(other)
    after = {c.name: c for c in hard(there)}
    assert len(after) == len(hard(here))
    for before in hard(here):
        a, b = rows_of(before, here, points), rows_of(after[before.name], there, moved)
        assert a.shape == b.shape
        if before.name == "opposite_angles":  # differences change their signs with the spoke that comes first
            a, b = np.abs(a), np.abs(b)
        if not before.name.startswith("planarity"):  # volumes depend on the corner that comes first
            assert_close(np.sort(a, axis=None), np.sort(b, axis=None), 1e-13)


@pytest.mark.parametrize("size", [1e-3, 1e6])
def test_variables_are_centred_and_of_the_size_of_an_edge(size: float) -> None:
    seed = polygonal()
    model = DesignModel(seed.moved_to(size * (seed.vertices_coords + np.array([4.0, 5.0, -6.0]))))
    assert_close(model.seed_points.mean(axis=0), 0, 1e-13)
    assert geometry.edge_lengths(seed.pattern, model.seed_points).mean() == pytest.approx(1, abs=1e-13)
    again = model.design(model.seed_points.ravel())
    assert_close(again.vertices_coords / size, model.seed.vertices_coords / size, 1e-13)
    assert model.variables_of(np.array([[0, 2]])).tolist() == [[0, 1, 2, 6, 7, 8]]
