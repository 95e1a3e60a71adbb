"""The footprint: packed states as variables agree with folding, boxes hold, and bounds are met as measured."""

from __future__ import annotations

import signal
from typing import Any

import numpy as np
import pytest
from designs import assert_close, best_motion, eggbox, hybrid, miura, perturbed, polygonal, rotation, tube
from scipy.spatial import ConvexHull

import inverse
from inverse import constraints
from inverse.dragging import polish
from inverse.formulation.formulate import formulate
from inverse.model import DesignModel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import footprint
from inverse.origami.folding import fold
from inverse.origami.pattern import FloatArray
from inverse.policy import measures, verdict
from inverse.solvers.run import Progress
from inverse.terms.goal import Goal
from inverse.terms.packed import Packed

BOUNDS = {"edge_length": (0.3, 3.0), "sector_angle": (0.3, 2.7), "fold_angle": (0.35, 2.8)}
STATES = {"developed": 0.0, "t = 0.3": 0.3, "design state": np.pi / 2, "t = 2.5": 2.5, "flat-folded": np.pi}
DESIGNS = {"miura": miura, "eggbox": eggbox, "hybrid": lambda: hybrid(3), "network": polygonal, "tube": tube}
DOME = {"height": "0.45 - 0.3*(x^2 + y^2)", "domain": [[-0.6, 0.6], [-0.6, 0.6]]}
NONE = np.inf


def posed(name: str) -> DesignModel:
    """An irregular design, at an angle to all axes and not of size one; a tube is regular as its seed."""
    seed = DESIGNS[name]()
    seed = seed.moved_to(2.5 * seed.vertices_coords @ rotation(1) + [3.0, -2.0, 1.0])
    if name == "tube":
        return DesignModel(seed)
    model = DesignModel(seed)
    equations = [c for c in constraints.hard_constraints(model, BOUNDS) if c.is_equation]
    problem = Problem(model.n_variables, [], equations)
    x = perturbed(seed.moved_to(model.seed_points), 0.02).vertices_coords.ravel()
    return DesignModel(model.design(polish(Point(problem, x, problem.parameters())).variables))


def packed(model: DesignModel, t: float, limits: list[float] | None = None, measure: Any = "extent") -> Packed:
    sides = 2 if t in (0.0, np.pi) else 3
    return Packed(model, t, measure, np.array(limits or [NONE] * sides), NONE, model.n_variables)


def start_of(state: Packed) -> FloatArray:
    return np.concatenate([state.model.seed_points.ravel(), state.start(state.model.seed_points)])


def problem_of(state: Packed) -> Problem:
    return Problem(state.first + state.n_variables, [], state.constraints())


def laying(state: Packed) -> tuple[Problem, np.ndarray]:
    """Only the equations that lay vertices, and the places of the coordinates that they lay."""
    problem = Problem(state.first + state.n_variables, [], state.constraints()[:2])
    return problem, state.first + np.arange(state.dimension * state.model.pattern.n_vertices)


@pytest.mark.parametrize("t", STATES)
@pytest.mark.parametrize("name", DESIGNS)
def test_equations_lay_facets_as_folding_does(name: str, t: str) -> None:
    model = posed(name)
    state = packed(model, STATES[t])
    problem, own = laying(state)
    x = start_of(state)
    x[own] += 0.01 * np.random.default_rng(0).standard_normal(own.size)
    for _ in range(30):  # each vertex follows those before it, so that errors leave facet by facet
        at = Point(problem, x, problem.parameters())
        x[own] -= np.linalg.solve(at.jacobian[:, own].toarray(), at.rows)
    found = np.zeros((model.pattern.n_vertices, 3))
    found[:, : state.dimension] = state.scale * x[own].reshape(len(found), -1)
    motion = fold(model.seed.moved_to(model.seed_points), np.array([STATES[t]]))
    assert motion.gap[0] < 1e-12
    assert_close(found, footprint.laid_out(model.seed, STATES[t]) / model.scale, 1e-12)
    assert_close(best_motion(found, motion.vertices_coords[0]), motion.vertices_coords[0], 1e-12)
    if t == "design state":
        assert_close(best_motion(found, model.seed_points), model.seed_points, 1e-12)


@pytest.mark.parametrize("t", ["t = 2.5", "flat-folded"])
@pytest.mark.parametrize("name", DESIGNS)
def test_rows_have_full_rank(name: str, t: str) -> None:
    state = packed(posed(name), STATES[t])
    problem, own = laying(state)
    jacobian = Point(problem, start_of(state), problem.parameters()).jacobian
    block = jacobian[:, own].toarray()
    assert block.shape == (own.size, own.size)
    assert np.linalg.svd(block, compute_uv=False)[-1] > 1e-3
    if name == "tube":
        return
    hard = [c for c in constraints.hard_constraints(state.model, BOUNDS) if c.is_equation]
    problem = Problem(problem.n_variables, [], [*hard, *state.constraints()[:2]])
    jacobian = Point(problem, start_of(state), problem.parameters()).jacobian
    assert np.linalg.matrix_rank(jacobian.toarray()) == problem.n_rows


@pytest.mark.parametrize("t", STATES)
@pytest.mark.parametrize("name", DESIGNS)
def test_the_first_box_is_the_smallest_around_the_seed(name: str, t: str) -> None:
    state = packed(posed(name), STATES[t])
    problem, x = problem_of(state), start_of(state)
    assert x.size == problem.n_variables
    assert Point(problem, x, problem.parameters()).violation < 1e-12
    assert_close(state.axes(x), state.seed_axes, 1e-12)
    sizes = state.scale * state.model.scale * x[-state.dimension :]
    assert list(sizes) == sorted(sizes, reverse=True)
    entry = footprint.measured(state.model.seed, {"it": state.t})["it"]
    assert_close(entry["extents"], sizes, 1e-9)
    assert entry["area"] == pytest.approx(sizes[0] * sizes[1])
    # The measure of the seed is 1, by either measure.
    for measure in ("extent", "area"):
        (elements,) = packed(state.model, state.t, measure=measure).measured()
        residuals = np.array(elements.kernel.value(x[elements.variables[0]], elements.parameters[0]))
        assert_close(residuals, np.ones_like(residuals), 1e-12)


@pytest.mark.parametrize(
    ("t", "limits"), [(np.pi, [9.0, 2.0]), (np.pi, [NONE, 2.0]), (1.2, [9.0, 5.0, 2.0]), (1.2, [NONE, NONE, 2.0])]
)
def test_a_turned_box_holds_what_lies_in_it(t: float, limits: list[float]) -> None:
    state = packed(posed("miura"), t, limits, None)
    rng = np.random.default_rng(5)
    x = start_of(state)
    k, d = len(state.sides), state.dimension
    n_turns = state.n_variables - d * state.model.pattern.n_vertices - 2 * k
    # A box of one side in space does not notice a turn about it: such a variable would be singular.
    assert n_turns == (1 if d == 2 else 2 if k == 1 else 3)
    x[-2 * k - n_turns : -2 * k] = rng.uniform(-1, 1, n_turns)
    axes = state.axes(x)
    assert_close(axes @ axes.T, np.eye(k), 1e-12)
    assert np.abs(axes - state.seed_axes[state.sides]).max() > 0.1
    box = next(c for c in state.constraints() if c.name.endswith("box"))
    vertex = box.elements.variables[7]
    rows = np.array(box.elements.kernel.value(x[vertex], [])).ravel() / state.scale
    height = axes @ x[vertex[:d]] - x[-2 * k : x.size - k]
    assert_close(rows, np.concatenate([height, x[-k:] - height]), 1e-12)
    # Extents that only a limit speaks of are held at it, else nothing would determine them.
    assert next(c for c in state.constraints() if c.name.endswith("limits")).is_equation
    assert (box.lower == 0).all()
    assert np.isinf(box.upper).all()


def least_width(points: FloatArray) -> float:
    """Least extent of points (N, 2) in any direction: across one of the hull's sides."""
    from scipy.spatial import ConvexHull

    return float(np.ptp(points @ ConvexHull(points).equations[:, :2].T, axis=0).min())


def task(**keys: Any) -> inverse.spec.Loaded:
    return inverse.load({"name": "dome", "pattern": {"size": [6, 6]}, "target": DOME} | keys)


def test_a_bound_is_met_as_measured_by_folding() -> None:
    free = inverse.solve(task())
    width = 0.6 * least_width(footprint.laid_out(free.design, np.pi)[:, :2])
    bounded = inverse.solve(task(constraints={"footprint": {"width": width}}))
    assert bounded.certified
    assert bounded.converged
    assert least_width(footprint.laid_out(bounded.design, np.pi)[:, :2]) <= width * (1 + 1e-6)
    assert bounded.report["footprint"]["limits"] == [
        {"state": "flat-folded", "measure": "width", "value": pytest.approx(width, rel=1e-6), "limit": width}
    ]
    assert bounded.report["fit"]["rms_relative"] < 0.01
    again = inverse.solve(task(constraints={"footprint": {"width": 0.95 * width}}), start=bounded)
    assert again.certified
    assert again.converged
    assert least_width(footprint.laid_out(again.design, np.pi)[:, :2]) <= 0.95 * width * (1 + 1e-6)


@pytest.mark.parametrize(
    "limits",
    [
        {"state": "developed", "length": 1.7, "width": 1.3},
        {"state": "flat-folded", "area": 0.3},
        {"state": 120, "width": 0.75},
    ],
    ids=["developed", "area", "in between"],
)
def test_other_bounds(limits: dict[str, Any]) -> None:
    result = inverse.solve(task(constraints={"footprint": limits}))
    assert result.certified
    assert result.converged
    found = result.report["footprint"]["limits"]
    assert any(entry["value"] > 0.999 * entry["limit"] for entry in found)  # the bound mattered
    assert all(entry["value"] <= entry["limit"] * (1 + 1e-6) for entry in found)


def test_an_objective_makes_it_smaller_and_a_bound_of_another_state_holds() -> None:
    bound = {"footprint": {"state": "developed", "width": 1.3}}
    free, small = (inverse.solve(task(objectives={"footprint": weight}, constraints=bound)) for weight in (0.0, 1e-3))
    for result in (free, small):
        assert result.certified
        assert result.converged
        assert result.report["footprint"]["limits"][0]["value"] <= 1.3 * (1 + 1e-6)
    before, after = (np.array(r.report["footprint"]["flat-folded"]["extents"]) for r in (free, small))
    assert (after < 0.95 * before).all()
    assert small.report["objective"]["footprint"] > 0


def test_units_do_not_matter() -> None:
    def scaled(size: float) -> inverse.spec.Loaded:
        height = f"{size} * (0.45 - 0.3*((x/{size})^2 + (y/{size})^2))"
        target = {"height": height, "domain": (0.6 * size * np.array([[-1, 1], [-1, 1]])).tolist()}
        limits = {"footprint": {"width": 0.3 * size}}
        return task(target=target, objectives={"footprint": 1e-4}, constraints=limits)

    goals = [formulate(scaled(size)).goal for size in (1.0, 1000.0)]
    starts = [goal.start(goal.model.seed.vertices_coords) for goal in goals]
    assert_close(*starts, 1e-10)
    small, large = (inverse.solve(scaled(size)) for size in (1.0, 1000.0))
    assert all(one.certified and one.converged for one in (small, large))
    assert_close(large.design.vertices_coords / 1000, small.design.vertices_coords, 1e-5)
    ratios = (r.report["footprint"]["deployed_to_packed"]["flat-folded"] for r in (small, large))
    assert next(ratios) == pytest.approx(next(ratios), rel=1e-6)
    assert large.report["objective"] == pytest.approx(small.report["objective"], rel=1e-5)


def test_what_was_found_before_an_interruption_is_kept() -> None:
    def watch(_: str, progress: Progress) -> None:
        if progress.iteration == 9:
            signal.raise_signal(signal.SIGINT)

    result = inverse.solve(task(objectives={"footprint": 1e-3}), watch=watch)
    assert result.interrupted
    assert result.certified
    assert result.report["verdict"]["violations"]["flat-folded box"]["value"] < 1e-7
    assert result.report["fit"]["rms"] < 0.1 * result.report["fit"]["start_rms"]


def test_a_bound_that_does_not_hold_is_told() -> None:
    goal: Goal = formulate(task(constraints={"footprint": {"width": 0.1}})).goal
    x = goal.start(goal.model.seed.vertices_coords)
    x[goal.model.n_variables :] = 0.0  # the packed state claims to be a point; it is not asked
    (found,) = measures.limits(goal, x)
    assert found["value"] == pytest.approx(least_width(footprint.laid_out(goal.model.seed, np.pi)[:, :2]))
    problem = Problem(goal.n_variables, [], goal.packed[0].constraints())
    x = goal.start(goal.model.seed.vertices_coords)
    failed = verdict.judge(Point(problem, x, problem.parameters()), goal).failed
    assert f"the flat-folded width is {found['value']:.6g}, 0.1 allowed" in failed


def test_states_without_use_have_no_variables() -> None:
    def states(**keys: Any) -> list[tuple[str, Any, list[float], float]]:
        goal = formulate(task(**keys)).goal
        places = [(p.first, p.first + p.n_variables) for p in goal.packed]
        ends = [goal.model.n_variables, *(end for _, end in places)]
        assert [first for first, _ in places] == ends[:-1]
        assert goal.n_variables == ends[-1] == goal.start(goal.model.seed.vertices_coords).size
        return [(p.name, p.measure, list(p.limits), p.area) for p in goal.packed]

    assert states(footprint={"state": "developed"}, objectives={"footprint": 0}) == []
    assert states(objectives={"footprint": 1}) == [("flat-folded", "extent", [NONE, NONE], NONE)]
    # No side is longer than the length.
    limits = {"footprint": {"length": 3, "area": 2}}
    assert states(constraints=limits) == [("flat-folded", None, [3, 3], 2)]
    both = states(objectives={"footprint": 1}, footprint={"measure": "area"}, constraints=limits)
    assert both == [("flat-folded", "area", [3, 3], 2)]
    limits = {"footprint": {"state": 30, "width": 2, "height": 1}}
    apart = states(objectives={"footprint": 1}, constraints=limits)
    assert apart == [("flat-folded", "extent", [NONE, NONE], NONE), ("30 degrees", None, [NONE, 2, 1], NONE)]


def test_the_report_of_every_design() -> None:
    design = miura(4, 6)
    found = footprint.measured(design, footprint.FLAT_STATES)
    for word, t in footprint.FLAT_STATES.items():
        points = fold(design, np.array([t])).vertices_coords[0]
        points = points - points.mean(axis=0)
        flat = points @ np.linalg.svd(points)[2][:2].T
        areas, angles = [], np.linspace(0, np.pi, 20001)
        for c, s in zip(np.cos(angles), np.sin(angles), strict=True):
            areas.append(np.ptp(flat @ [c, s]) * np.ptp(flat @ [-s, c]))
        assert found[word]["area"] == pytest.approx(min(areas), rel=1e-3)
        length, width = found[word]["extents"]
        assert length > width >= least_width(flat) * (1 - 1e-12)
        ratio, deployed = found["deployed_to_packed"][word], found["deployed"]
        assert ratio["length"] == pytest.approx(deployed["extents"][0] / length)
        assert ratio["width"] == pytest.approx(deployed["extents"][1] / width)
        assert ratio["area"] == pytest.approx(ratio["length"] * ratio["width"])
    box = found["deployed"]["extents"]
    assert len(box) == 3
    turned = design.moved_to(design.vertices_coords @ rotation(3) + 5)
    assert_close(footprint.measured(turned, footprint.FLAT_STATES)["deployed"]["extents"], box, 1e-9)
    one = footprint.measured(miura(1, 1), footprint.FLAT_STATES)["deployed"]["extents"]
    assert_close(one, [*footprint.measured(miura(1, 1), {"flat": 0.0})["flat"]["extents"], 0], 1e-9)
    # A regular Miura's design state lies in a box along its own axes.
    assert np.prod(box) <= np.prod(np.ptp(design.vertices_coords, axis=0)) * (1 + 1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_the_smallest_box_is_that_of_looking_at_every_side(seed):
    random = np.random.default_rng(seed)
    points = random.normal(size=(40, 3)) * random.uniform(0.2, 3, 3)
    hull = ConvexHull(points)
    volumes = []
    for normal in hull.equations[:, :3]:
        across = np.linalg.svd(normal[None])[2][1:]
        flat = points @ across.T
        sides = ConvexHull(flat).equations[:, :2]
        along = np.column_stack([-sides[:, 1], sides[:, 0]])
        area = (np.ptp(flat @ sides.T, axis=0) * np.ptp(flat @ along.T, axis=0)).min()
        volumes.append(area * np.ptp(points @ normal))
    # Only sides near the best of a few are looked at: of a hull this coarse, all that matter.
    found = np.prod(footprint.extents(points, footprint.box_axes(points)))
    assert found >= min(volumes) * (1 - 1e-9)
    assert found <= 1.05 * min(volumes)
