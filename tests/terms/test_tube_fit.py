"""Rings of facets around an axis: what is fitted, what is measured, where the seed is placed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from designs import assert_close, holed, perturbed, rotation, tube

import inverse
from inverse import objectives
from inverse.formulation.formulate import Formulation, formulate
from inverse.model import DesignModel
from inverse.nlp.kernels import Elements
from inverse.origami import geometry, seeds
from inverse.origami.pattern import Design
from inverse.policy import measures
from inverse.spec import load
from inverse.surfaces.axis import Axis
from inverse.surfaces.tube import TubeTarget
from inverse.terms import tube_fit
from inverse.terms.goal import Goal

SIDE = float(6 * np.sqrt(0.5))
BEND: dict[str, Any] = {"arc": [[0, 0, 0], [6 - SIDE, 0, SIDE], [6, 0, 6]]}
LINE: dict[str, Any] = {"polyline": [[2, 0, 0], [2, 3, 4]]}


def task(axis: dict[str, Any] = LINE, radius: Any = 1, size: tuple[int, int] = (6, 5), **keys: Any) -> dict[str, Any]:
    pattern = {"kind": "tube", "size": list(size)} | keys.pop("pattern", {})
    return {"name": "tube", "pattern": pattern, "target": {"axis": axis, "radius": radius}} | keys


def formulated(*arguments: Any, **keys: Any) -> Formulation:
    return formulate(load(task(*arguments, **keys)))


def residuals(elements: Elements, points: np.ndarray, model: DesignModel, parameters: np.ndarray) -> np.ndarray:
    x = model.to_dimensionless(points).ravel()[elements.variables]
    return np.array(elements.kernel.value.map(elements.count)(x.T, parameters.T)).T


# ---- placement


@pytest.mark.parametrize("turn", [0, 35])
@pytest.mark.parametrize("size", [(4, 3), (6, 4), (8, 2)])
def test_a_seed_on_a_straight_axis_fits_at_once(size: tuple[int, int], turn: float) -> None:
    lengths = np.linspace(1, 2, size[1]).tolist()
    goal = formulated(LINE, 0.7, size, pattern={"turn": turn}).goal
    found = measures.fit(goal, goal.model.seed)
    assert found.max < 1e-12
    assert_close(found.rings.ends, [0, 1], 1e-12)
    blocks = [e for name in ("fit", "coverage") for e in objectives.OBJECTIVES[name].build(goal)]
    assert [e.name for e in blocks] == ["fit", "coverage"]
    for e in blocks:
        assert_close(residuals(e, goal.model.seed.vertices_coords, goal.model, e.parameters), 0.0, 1e-12)
    uneven = formulated(LINE, 0.7, size, pattern={"lengths_v": lengths}).goal
    rows = tube_fit.ring_vertices(uneven.model.pattern)
    steps = np.diff(uneven.model.seed.vertices_coords[rows].mean(axis=1) @ [0, 0.6, 0.8])
    assert_close(steps / steps[0], lengths, 1e-9)


def test_a_turn_is_about_the_axis() -> None:
    straight, turned = (formulated(pattern={"turn": turn}).goal.model.seed.vertices_coords for turn in (0, 25))
    offsets = [points - [2, 0, 0] for points in (straight, turned)]
    along = np.array([0, 0.6, 0.8])
    for a, b in zip(*offsets, strict=True):
        assert a @ along == pytest.approx(b @ along, abs=1e-9)
        across = [v - (v @ along) * along for v in (a, b)]
        assert np.linalg.norm(across[0]) == pytest.approx(np.linalg.norm(across[1]), abs=1e-9)
    first, second = (v[0] - (v[0] @ along) * along for v in offsets)
    angle = np.arctan2(np.cross(first, second) @ along, first @ second)
    assert abs(np.degrees(angle)) == pytest.approx(25, abs=1e-6)


def test_a_seed_for_a_bend_is_as_long_as_the_axis_and_lies_on_its_chord() -> None:
    goal = formulated(BEND, [[0, 1.0], [1, 0.6]], (8, 12)).goal
    seed = goal.model.seed
    ends = seed.vertices_coords[tube_fit.ring_vertices(seed.pattern)[[0, -1]]].mean(axis=1)
    chord = np.array([1, 0, 1]) / np.sqrt(2)
    assert np.diff(ends, axis=0)[0] @ chord == pytest.approx(3 * np.pi, rel=1e-4)
    centroids = tube_fit.ring_centroids(seed.pattern, seed.vertices_coords)
    assert_close(centroids.mean(axis=(0, 1)), [3, 0, 3], 1e-9)
    radii = [np.sqrt(np.mean(np.sum(np.cross(ring - [3, 0, 3], chord) ** 2, axis=1))) for ring in centroids]
    assert_close(radii, goal.target.mean_radius, 1e-9)  # type: ignore[attr-defined]


def test_a_seed_moves_turns_and_grows_with_its_target() -> None:
    turn, shift = rotation(8), np.array([3.0, -1, 2])
    moved = (250 * np.array(LINE["polyline"]) @ turn + shift).tolist()
    one, other = formulated(LINE, 0.8).goal, formulated({"polyline": moved}, 200).goal
    assert_close(
        geometry.edge_lengths(one.model.pattern, one.model.seed_points),
        geometry.edge_lengths(other.model.pattern, other.model.seed_points),
        1e-9,
    )
    assert measures.fit(other, other.model.seed).max < 1e-9


# ---- figures and residuals


def wavy(goal: Goal) -> Design:
    return perturbed(goal.model.seed, 0.05, 3)


def test_figures_of_a_bent_tube_against_the_circle() -> None:
    """Distances of facets from a circular axis in closed form."""
    goal = formulated(BEND, [[0, 1.0], [1, 0.6]], (6, 9)).goal
    design = wavy(goal)
    centroids = tube_fit.ring_centroids(design.pattern, design.vertices_coords)

    def seen(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Fraction of the quarter circle about (6, 0, 0), and distance from it; straight beyond its ends."""
        x, y, z = (points - [6, 0, 0]).T
        t = np.arctan2(z, -x) / (np.pi / 2)
        inside = np.hypot(np.hypot(x, z) - 6, y)
        before, after = np.hypot(x + 6, y), np.hypot(z - 6, y)
        return t, np.where(z < 0, before, np.where(x > 0, after, inside))

    rings = centroids.mean(axis=1)
    t, offsets = seen(rings)
    inside = np.clip(t, 0, 1)
    rms = np.sqrt((seen(centroids.reshape(-1, 3))[1].reshape(9, 6) ** 2).mean(axis=1))
    expected = offsets, rms - (1 - 0.4 * inside)
    for found, wanted in zip(tube_fit.deviations(goal.target, centroids), expected, strict=True):
        assert_close(found, wanted, 1e-6)
    told = measures.fit(goal, design)
    relative = np.hypot(*expected) / (1 - 0.4 * inside)
    assert told.points == "rings"
    assert told.rings.mean_over_radius == pytest.approx(relative.mean(), rel=1e-5)
    assert told.rings.max_over_radius == pytest.approx(relative.max(), rel=1e-5)
    assert told.rms == pytest.approx(np.sqrt(np.mean(np.hypot(*expected) ** 2)), rel=1e-5)


@pytest.mark.parametrize("axis", [LINE, BEND], ids=["line", "arc"])
def test_residuals_are_the_figures_where_their_parameters_are_fresh(axis: dict[str, Any]) -> None:
    goal = formulated(axis, [[0, 1.0], [0.5, 0.9], [1, 0.5]], (6, 7)).goal
    model, points = goal.model, wavy(goal).vertices_coords
    (fit,) = objectives.OBJECTIVES["fit"].build(goal)
    rows = residuals(fit, points, model, goal.fitting.refreshed(points)["fit"])
    rows *= model.scale * model.refinement
    offsets, wide = tube_fit.deviations(goal.target, tube_fit.ring_centroids(model.pattern, points))
    assert_close(np.linalg.norm(rows[:, :3], axis=1), offsets, 1e-9)
    assert_close(rows[:, 3], wide, 1e-9)


@pytest.mark.parametrize(("axis", "radius"), [(LINE, [[0, 1.0], [0.5, 0.9], [1, 0.5]]), (BEND, 1.0)])
def test_parameters_are_right_to_first_order(axis: dict[str, Any], radius: Any) -> None:
    """The radius deviation, with its parameters kept, changes as the figure does."""
    goal = formulated(axis, radius, (6, 7)).goal
    model, points = goal.model, wavy(goal).vertices_coords
    (fit,) = objectives.OBJECTIVES["fit"].build(goal)
    kept = goal.fitting.refreshed(points)["fit"]
    along = np.random.default_rng(4).standard_normal(points.shape)
    errors = []
    for h in (1e-2, 5e-3):
        moved = points + h * along
        _, wide = tube_fit.deviations(goal.target, tube_fit.ring_centroids(model.pattern, moved))
        errors.append(np.abs(residuals(fit, moved, model, kept)[:, 3] * model.scale * model.refinement - wide).max())
    assert errors[0] > 1e-8
    assert errors[1] < errors[0] / 3.5


def test_rings_are_drawn_to_their_places_along_the_axis() -> None:
    goal = formulated().goal
    model = goal.model
    moved = model.seed.vertices_coords + 0.3 * np.array([0, 0.6, 0.8])
    (fit,), (ends,) = (objectives.OBJECTIVES[name].build(goal) for name in ("fit", "coverage"))
    rows = residuals(fit, moved, model, goal.fitting.refreshed(moved)["fit"])
    size = model.scale * model.refinement
    assert_close(rows, np.tile([0, 0, 0, 0, tube_fit.ALONG * 0.3 / size], (5, 1)), 1e-9)
    assert_close(residuals(ends, moved, model, ends.parameters), tube_fit.ENDS * 0.3 / size, 1e-9)


def test_a_share_of_the_target_is_straighter_with_the_same_seed() -> None:
    whole, part = (formulate(load(task(BEND, [[0, 1.0], [1, 0.6]])), share) for share in (1.0, 0.25))
    assert_close(part.goal.model.seed.vertices_coords, whole.goal.model.seed.vertices_coords, 0)
    seed = whole.goal.model.seed
    assert measures.fit(part.goal, seed).rms < 0.5 * measures.fit(whole.goal, seed).rms


# ---- other terms


def test_fairness_goes_on_around_closed_rings() -> None:
    """A displacement that turns with the tube has the same second differences at every vertex around."""
    model = DesignModel(tube(6, 4))
    target = TubeTarget(Axis([[0, 0, 0], [0, 0, 4]], smooth=False), 1.0)
    (fairness,) = objectives.OBJECTIVES["fairness"].build(Goal(tube_fit.TubeFitting(model, target)))
    triples = fairness.variables.reshape(-1, 3, 3)[:, :, 0] // 3
    around = triples[(triples % 5 == triples[:, :1] % 5).all(axis=1)]  # vertices of one row
    middle, count = np.unique(around[:, 1], return_counts=True)
    assert_close(count, 1, 0)
    rows = np.arange(30).reshape(6, 5)[:, 1:-1]  # interior rows are lines, the open ends are not
    assert set(middle) == set(rows.ravel())
    column, before, after = around[:, 1] // 5, around[:, 0] // 5, around[:, 2] // 5
    assert_close((column - before) % 6, 2, 0)
    assert_close((after - column) % 6, 2, 0)


def test_a_bent_seed_follows_axis_and_radius() -> None:
    """On a straight axis with its own radius it is the seed; on an arc its rings lie around it, wide as asked for."""
    still = formulated(LINE, 0.8).goal
    assert_close(still.fitting.fair_points(), still.model.seed_points, 1e-9)
    goal = formulated(BEND, [[0, 1.0], [1, 0.6]], (6, 60)).goal
    points = goal.model.to_lengths(goal.fitting.fair_points())
    centroids = tube_fit.ring_centroids(goal.model.pattern, points)
    offsets, wide = tube_fit.deviations(goal.target, centroids)
    assert max(offsets.max(), np.abs(wide).max()) < 0.02  # rows are straight, the axis is not
    assert_close(goal.target.axis.closest(centroids.mean(axis=1)), (np.arange(60) + 0.5) / 60, 1e-3)
    (fairness,) = objectives.OBJECTIVES["fairness"].build(goal)
    assert_close(residuals(fairness, points, goal.model, fairness.parameters), 0.0, 1e-9)


def test_a_tube_from_a_file_runs_from_its_first_end_to_its_last(tmp_path: Path) -> None:
    design = tube(6, 5)
    design = design.moved_to(design.vertices_coords @ rotation(5))
    inverse.write(design, tmp_path / "tube.fold")
    mapping = task(LINE, 0.8) | {"pattern": {"kind": "file", "file": "tube.fold"}}
    goal = formulate(load(mapping, folder=tmp_path)).goal
    ends = goal.model.seed.vertices_coords[tube_fit.ring_vertices(goal.model.pattern)[[0, -1]]].mean(axis=1)
    assert_close(geometry.unit(ends[1] - ends[0]), [0, 0.6, 0.8], 1e-9)


def test_a_file_without_rings_is_refused(tmp_path: Path) -> None:
    inverse.write(holed(), tmp_path / "holed.fold")
    mapping = task() | {"pattern": {"kind": "file", "file": "holed.fold"}}
    with pytest.raises(inverse.InputError, match="needs a tube of two or more rows, numbered as a grid"):
        formulate(load(mapping, folder=tmp_path))


def test_fairness_of_four_around_names_no_vertex_twice() -> None:
    goal = Goal(
        tube_fit.TubeFitting(DesignModel(tube(4, 5)), TubeTarget(Axis([[0, 0, 0], [0, 0, 4]], smooth=False), 1.0))
    )
    (fairness,) = objectives.OBJECTIVES["fairness"].build(goal)
    triples = fairness.variables.reshape(-1, 3, 3)[:, :, 0]
    assert all(len(set(triple)) == 3 for triple in triples.tolist())


@pytest.mark.parametrize("loop", ["exact", "bars"])
def test_the_middle_row_is_closed(loop: str) -> None:
    made = formulated(size=(6, 5), constraints={"loop": loop})
    constraint = next(c for c in made.fixed if c.name == "loop_0")
    row = {"exact": 2, "bars": 0}[loop]  # the paper keeps an end
    assert constraint.labels == (f"strip of 6 facets from facet {row}",)
    x = made.goal.seed_variables
    rows = np.asarray(
        constraint.elements.kernel.value(x[constraint.elements.variables[0]], constraint.elements.parameters[0])
    )
    assert_close(rows.ravel(), constraint.lower[0], 1e-12)


def test_a_tube_solves_to_a_taper() -> None:
    result = inverse.solve(load(task(LINE, [[0, 1.0], [1, 0.7]], (4, 4))))
    assert result.certified, result.status
    assert result.report["fit"]["mean_over_radius"] < 1e-3


def test_rings_of_a_seed_at_any_place() -> None:
    """Facets and vertices of the rings, in order around."""
    design = seeds.tube(seeds.SECTIONS[6], 3)
    facets, vertices = tube_fit.ring_facets(design.pattern), tube_fit.ring_vertices(design.pattern)
    heights = design.vertices_coords[:, 2]
    assert all(np.ptp(heights[ring]) < 1e-12 for ring in vertices)
    for j, ring in enumerate(facets):
        for i, facet in enumerate(ring.tolist()):
            after = (i + 1) % 6
            own = {vertices[j, i], vertices[j, after], vertices[j + 1, i], vertices[j + 1, after]}
            assert own == set(design.pattern.faces_vertices[facet])
