"""Dragging by equation (9): steps that are least moves, drags that end certified, and what is held on the way."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from designs import ALL, assert_close, eggbox, holed, hybrid, miura, perturbed, tube

import inverse
from inverse import constraints
from inverse.certify import check_frame
from inverse.dragging import LIMITS
from inverse.files import fold_file
from inverse.files.fold_format import frame_of
from inverse.formulation.formulate import formulate
from inverse.model import DesignModel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import geometry
from inverse.origami.pattern import Design
from inverse.solvers.least_move import LeastMove
from inverse.solvers.projection import Projection, balanced

SHEETS = {"miura": miura, "eggbox": eggbox, "hybrid": lambda *_: hybrid(6)}


def certified(design: Design) -> bool:
    return check_frame(frame_of(fold_file.document(design))).certified


def posed(design: Design) -> tuple[DesignModel, Problem]:
    model = DesignModel(design)
    return model, Problem(model.n_variables, [], constraints.hard_constraints(model, LIMITS))


# ---- one step


def test_a_step_is_the_wish_without_what_leaves_the_constraints() -> None:
    """To first order: the dense projection (I - A^+ A) of the wish."""
    model, problem = posed(miura(4, 5))
    x = model.seed_points.ravel()
    jacobian = Point(problem, x, problem.parameters()).jacobian
    dense = jacobian.toarray()[problem.lower == problem.upper]
    projector = np.eye(x.size) - np.linalg.pinv(dense) @ dense
    wish = np.random.default_rng(0).standard_normal(x.size)
    errors = []
    for h in (1e-3, 5e-4, 2.5e-4):
        moved = Projection().moved(Point(problem, x, problem.parameters()), h * wish)
        assert moved is not None
        assert moved.violation < 1e-12
        errors.append(float(np.abs(moved.variables - x - h * projector @ wish).max()))
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.05)


def test_a_bound_that_a_step_would_exceed_is_held() -> None:
    design = eggbox(5, 5)
    model = DesignModel(design)
    top = int(np.argmax(design.vertices_coords[:, 2]))
    highest = float(design.vertices_coords[top, 2])
    roof = constraints.keep_out(model, "roof", np.array([0, 0, highest + 0.01]), np.array([0.0, 0, -1]))
    problem = Problem(model.n_variables, [], [*constraints.hard_constraints(model, LIMITS), roof])
    wish = np.zeros((design.pattern.n_vertices, 3))
    wish[top, 2] = 0.2
    moved = Projection().moved(Point(problem, model.seed_points.ravel(), problem.parameters()), wish.ravel())
    assert moved is not None
    assert model.points(moved.variables)[:, 2].max() == pytest.approx(highest + 0.01, abs=1e-8)
    assert moved.violation < 1e-8


def test_the_order_of_the_factors_changes_nothing_but_the_rounding() -> None:
    model, problem = posed(miura(6, 6))
    jacobian = Point(problem, model.seed_points.ravel(), problem.parameters()).jacobian
    equations = jacobian[problem.lower == problem.upper]
    change = np.random.default_rng(1).standard_normal(equations.shape[0])
    first = LeastMove(equations)
    again = LeastMove(equations, first.order)
    assert_close(again(change), first(change), 1e-10)
    assert_close(equations @ first(change), change, 1e-9)
    gradient = np.random.default_rng(2).standard_normal(equations.shape[1])
    dense = np.linalg.lstsq(equations.toarray().T, -gradient, rcond=None)[0]
    assert_close(first.multipliers(gradient), dense, 1e-8)
    assert_close(again.multipliers(gradient), dense, 1e-8)


def test_a_step_that_is_too_long_is_none() -> None:
    model, problem = posed(miura(4, 4))
    wish = np.zeros(model.n_variables)
    wish[0] = 1e6
    assert Projection().moved(Point(problem, model.seed_points.ravel(), problem.parameters()), wish) is None


def test_balanced_multipliers() -> None:
    """From nothing the multipliers of a solution are found; idle bounds stay idle; worse ones are not taken."""
    target = {"height": "0.3 - 0.2*(x^2 + y^2)", "domain": [[-1, 1], [-1, 1]]}
    loaded = inverse.load({"name": "dome", "pattern": {"size": [6, 6]}, "target": target})
    result, formulation = inverse.solve(loaded), formulate(loaded)
    problem = Problem(formulation.goal.model.n_variables, formulation.objectives, formulation.fixed)
    x = formulation.goal.model.to_dimensionless(result.design.vertices_coords).ravel()
    found = balanced(Point(problem, x, problem.parameters())).balance
    equations = problem.lower == problem.upper
    assert_close(found[~equations], 0, 0)
    assert_close(found[equations], result.multipliers[equations], 1e-6 * np.abs(result.multipliers).max())


# ---- drags


@pytest.mark.parametrize("name", SHEETS)
def test_a_corner_dragged_by_a_third_of_the_diagonal_ends_certified(name: str) -> None:
    design = SHEETS[name](8, 8)
    way = 0.3 * geometry.diagonal(design.vertices_coords) * np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, 0.5, 0.8])
    refined = inverse.refine(design, {0: way}, steps=100)
    assert refined.steps >= 100
    assert refined.residual < 1e-8  # of a bound that is held; equations:
    _, problem = posed(refined.design)
    rows = Point(problem, DesignModel(refined.design).seed_points.ravel(), problem.parameters()).rows
    assert np.abs(rows[problem.lower == problem.upper]).max() < 1e-12
    assert certified(refined.design)
    moved = refined.design.vertices_coords - design.vertices_coords
    assert_close(moved[0], way, 1e-9)
    assert refined.remaining.max() < 1e-9
    lengths = geometry.edge_lengths(design.pattern, refined.design.vertices_coords)
    ratio = lengths / geometry.edge_lengths(design.pattern, design.vertices_coords)
    assert 0.29 < ratio.min() < ratio.max() < 2.5
    # Others follow, the less the farther they are.
    sizes = np.linalg.norm(moved, axis=1)
    near = np.linalg.norm(design.vertices_coords - design.vertices_coords[0], axis=1)
    assert sizes[near > 0.8 * near.max()].mean() < 0.3 * sizes[0]


def test_without_a_wish_only_the_residual_goes() -> None:
    design = perturbed(miura(5, 5), 1e-4, 3)
    refined = inverse.refine(design)
    assert refined.steps == 0
    assert refined.residual < 1e-14
    assert np.abs(refined.design.vertices_coords - design.vertices_coords).max() < 1e-3
    assert certified(refined.design)
    assert not certified(design)


def test_pins_and_bars_are_kept() -> None:
    design = eggbox(6, 6)
    before = design.vertices_coords
    refined = inverse.refine(design, {0: [0.0, 0.0, 0.8]}, pins=[6, 42], bars=[(0, 48), (8, 30)], steps=10)
    after = refined.design.vertices_coords
    assert_close(after[[6, 42]], before[[6, 42]], 1e-11)
    for a, b in ((0, 48), (8, 30)):
        assert np.linalg.norm(after[a] - after[b]) == pytest.approx(np.linalg.norm(before[a] - before[b]), rel=1e-11)
    assert np.abs(after - before).max() > 0.1
    assert certified(refined.design)
    free = inverse.refine(design, {0: [0.0, 0.0, 0.8]}, steps=10).design.vertices_coords
    assert np.abs(free[[6, 42]] - before[[6, 42]]).max() > 1e-3


def test_a_pin_that_is_dragged_stays() -> None:
    design = miura(4, 4)
    refined = inverse.refine(design, {3: [0.0, 0.0, 1.0]}, pins=[3])
    assert_close(refined.design.vertices_coords, design.vertices_coords, 1e-12)
    assert refined.remaining[3] == pytest.approx(1.0)


def test_a_wish_for_all_vertices() -> None:
    """A rigid motion is admissible as a whole; a stretch out of the sheet is not, and is come near to."""
    design = hybrid(5)
    shift = np.tile([0.3, -0.2, 0.5], (design.pattern.n_vertices, 1))
    refined = inverse.refine(design, shift, steps=3)
    assert_close(refined.design.vertices_coords, design.vertices_coords + shift, 1e-11)
    bump = np.zeros((design.pattern.n_vertices, 3))
    bump[len(bump) // 2, 2] = 0.4
    refined = inverse.refine(design, bump, steps=10)
    assert 0 < refined.remaining.max() < 0.4
    assert certified(refined.design)


def test_what_cannot_be_reached_is_told() -> None:
    design = miura(4, 4)
    refined = inverse.refine(design, {12: [0.0, 0.0, 50.0]}, reach=0.0, steps=10)
    assert refined.remaining[12] > 40
    assert geometry.are_convex(design.pattern, refined.design.vertices_coords)
    assert certified(refined.design)


@pytest.mark.parametrize("k", [4, 6])
def test_dependent_equations_of_a_tube(k: int) -> None:
    """Redundant equations are no obstacle: they are cut off, and all of them hold.

    Beside a symmetric tube singular values come down to 1e-7 before they vanish, which costs some digits.
    """
    design = tube(k, 4)
    refined = inverse.refine(design, {0: [0.02, 0.05, 0.03]}, steps=5)
    _, problem = posed(refined.design)
    rows = Point(problem, DesignModel(refined.design).seed_points.ravel(), problem.parameters()).rows
    assert np.abs(rows[problem.lower == problem.upper]).max() < 1e-10
    assert np.abs(refined.design.vertices_coords - design.vertices_coords).max() > 0.01


@pytest.mark.parametrize("name", [name for name in ALL if "tube" not in name])
def test_the_same_in_any_unit(name: str) -> None:
    design = ALL[name]()
    small = design.moved_to(1e-3 * design.vertices_coords)
    a = inverse.refine(design, {1: [0.05, 0.02, 0.1]}, steps=2).design.vertices_coords
    b = inverse.refine(small, {1: [5e-5, 2e-5, 1e-4]}, steps=2).design.vertices_coords
    assert_close(1e3 * b, a, 1e-8)


# ---- refusals


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"move": {99: [0, 0, 1]}}, "a move names vertex 99, which is not there: the design has vertices 0 to 24"),
        ({"move": {-1: [0, 0, 1]}}, "a move names vertex -1"),
        ({"move": {3: [0, 1]}}, r"the move of vertex 3 has shape \(2,\)"),
        ({"move": {3: [0, 1, float("nan")]}}, "the move of vertex 3 is .*: finite numbers"),
        ({"move": np.zeros((4, 3))}, r"for all 25 vertices \(25, 3\) is needed"),
        ({"pins": [25]}, "a pin names vertex 25"),
        ({"bars": [(0, 77)]}, "a bar names vertex 77"),
        ({"bars": [(3, 3)]}, "a bar joins vertex 3 with itself"),
        ({"move": {0: [0, 0, 1]}, "steps": 0}, "0 steps were given"),
    ],
)
def test_refusals(keys: dict, message: str) -> None:
    with pytest.raises(inverse.InputError, match=message):
        inverse.refine(miura(4, 4), **keys)


@pytest.mark.parametrize("make", [lambda: tube(6, 4), lambda: holed(miura, 5)], ids=["tube", "hole"])
def test_what_goes_round_a_hole_stays_closed(make: Callable[[], Design]) -> None:
    design = make()
    size = geometry.diagonal(design.vertices_coords)
    found = inverse.refine(design, {0: (0.05 * size, 0.02 * size, -0.03 * size)})
    assert found.residual < 1e-9
    assert np.abs(found.design.vertices_coords - design.vertices_coords).max() > 0.02 * size
    certificate = check_frame(frame_of(fold_file.document(found.design)))
    assert certificate.checks["loop_closure"].value < 1e-11
    assert certificate.certified


# ---- move by move


def test_moves_go_on_from_where_the_last_one_ended() -> None:
    design = miura(8, 8)
    size = geometry.diagonal(design.vertices_coords)
    drag = inverse.Drag(design, pins=[80])
    for _ in range(30):
        found = drag.move({0: (0.001 * size, -0.002 * size, 0.003 * size)})
        assert found.steps >= 1
        assert found.remaining[0] < 1e-3 * size
        assert found.residual < 1e-12
        assert_close(drag.design.vertices_coords, found.design.vertices_coords, 0)
    assert certified(drag.design)
    after = drag.design.vertices_coords
    way = np.array([0.001, -0.002, 0.003]) * size * 30
    assert np.linalg.norm(after[0] - design.vertices_coords[0] - way) < 0.05 * np.linalg.norm(way)
    assert_close(after[80], design.vertices_coords[80], 1e-11)
    assert drag.move({80: (0.0, 0.0, 1.0)}).steps == 0  # pinned
    assert drag.move(None).steps == 0


def test_one_long_move_is_refining() -> None:
    design = eggbox(6, 6)
    way = {0: [0.0, 0.0, 0.8]}
    assert_close(
        inverse.Drag(design).move(way, steps=10).design.vertices_coords,
        inverse.refine(design, way, steps=10).design.vertices_coords,
        0,
    )


def test_a_drag_refuses_at_each_end() -> None:
    with pytest.raises(inverse.InputError, match="a pin names vertex 25"):
        inverse.Drag(miura(4, 4), pins=[25])
    with pytest.raises(inverse.InputError, match="a move names vertex 99"):
        inverse.Drag(miura(4, 4)).move({99: [0, 0, 1]})
