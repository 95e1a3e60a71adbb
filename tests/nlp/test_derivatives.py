"""Taylor tests of every term's derivatives, through the assembled functions that the solver is given.

Objectives are those of ``OBJECTIVES``; a public function of ``inverse.constraints`` that returns a constraint
and is not built below fails ``test_every_term_is_here``.
"""

from __future__ import annotations

import inspect
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import casadi
import numpy as np
import pytest
from designs import assert_close, holed, hybrid, polygonal, rotation, tube

import inverse
from inverse import constraints, cylinder_loop, objectives
from inverse.formulation import anchors
from inverse.model import DesignModel
from inverse.nlp import compiled
from inverse.nlp.kernels import Kernel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.nlp.term import Constraint
from inverse.objectives import OBJECTIVES
from inverse.origami.holes import hole_strips
from inverse.origami.pattern import Design
from inverse.surfaces import Target
from inverse.surfaces.axis import arc
from inverse.surfaces.mesh import MeshTarget
from inverse.surfaces.parametric import BetweenTarget, HeightTarget
from inverse.surfaces.tube import TubeTarget
from inverse.terms import separation
from inverse.terms.goal import Goal
from inverse.terms.packed import Packed
from inverse.terms.surface_fit import SurfaceFitting
from inverse.terms.tube_fit import TubeFitting, is_tube

MESHES: dict[str, Callable[[], Design]] = {
    "grid": lambda: hybrid(2),
    "general": polygonal,
}
STEPS = 1e-3 * 0.5 ** np.arange(4)
BOUNDS = {"edge_length": (0.3, 3.0), "sector_angle": (0.3, 2.7), "fold_angle": (0.35, 2.8)}


def posed(name: str) -> DesignModel:
    """A mesh at an angle to all axes, away from the origin and not of size one."""
    seed = MESHES[name]()
    return DesignModel(seed.moved_to(2.5 * seed.vertices_coords @ rotation(1) + [3.0, -2.0, 1.0]))


# ---- every constraint

POINT, NORMAL = np.array([3.1, -1.7, 0.6]), np.array([0.3, -0.5, 0.8])
FEW = np.array([0, 2, 7])


def on_segment(model: DesignModel) -> list[Constraint]:
    start = model.seed.vertices_coords[FEW] + [0.1, 0.2, -0.3]
    return [constraints.on_segment(model, "on_segment", FEW, start, start + np.diag([1.0, 2.0, -3.0]) + 0.4)]


def apart(model: DesignModel) -> list[Constraint]:
    count = len(model.pattern.faces_vertices)
    found = separation.in_design(model, np.array([[0, count - 1], [1, 9], [3, 12]]))
    assert found is not None
    return [found]


def sliding(model: DesignModel) -> list[Constraint]:
    line = model.seed.vertices_coords[[0, 3, 8]]
    return [anchors.PolylineAnchor("sliding", FEW, line, np.array([0, 1, 1])).constraint(model)]


def packed(model: DesignModel) -> list[Packed]:
    """All that a box can have: both its sides measured and limited, one side held, a turn in space."""
    none, scale = np.inf, model.scale
    uses = [
        (np.pi, "extent", [3.0, none], 7.0),
        (0.0, None, [none, 2.0], none),
        (1.2, None, [none, none, 0.5], none),
        (0.4, None, [4.0, 3.0, 2.0], none),
    ]
    found: list[Packed] = []
    for t, measure, limits, area in uses:
        first = found[-1].first + found[-1].n_variables if found else model.n_variables
        found.append(Packed(model, t, measure, scale * np.array(limits), scale**2 * area, first))
    return found


CONSTRAINTS: dict[str, Callable[[DesignModel], list[Constraint]]] = {
    "opposite_angles": lambda model: [constraints.opposite_angles(model)],
    "planarity": constraints.planarity,
    "edge_length": lambda model: [constraints.edge_length(model, BOUNDS["edge_length"])],
    "sector_angle": lambda model: [constraints.sector_angle(model, BOUNDS["sector_angle"])],
    "fold_angle": lambda model: [constraints.fold_angle(model, BOUNDS["fold_angle"])],
    "bars": lambda model: [constraints.bars(model, "bars", np.array([[0, 1], [0, 7]]))],
    "on_point": lambda model: [constraints.on_point(model, "on_point", FEW[:1], POINT)],
    "on_plane": lambda model: [constraints.on_plane(model, "on_plane", FEW, POINT, NORMAL)],
    "on_line": lambda model: [constraints.on_line(model, "on_line", FEW, POINT, NORMAL)],
    "on_segment": on_segment,
    "on_circle": lambda model: [constraints.on_circle(model, "on_circle", FEW, POINT, NORMAL, 2.2)],
    "keep_out": lambda model: [constraints.keep_out(model, "keep_out", POINT, NORMAL)],
    "separation": apart,
    "separation in a state": lambda model: separation.in_state(model, np.array([[0, 3], [9, 1], [2, 5]]), 2.1),
    "sliding anchor": sliding,
    "packed states": lambda model: [constraint for state in packed(model) for constraint in state.constraints()],
}


def test_every_term_is_here() -> None:
    public = {
        name
        for name, function in inspect.getmembers(constraints, inspect.isfunction)
        if not name.startswith("_") and "Constraint" in str(inspect.signature(function).return_annotation)
    }
    lacking = public - set(CONSTRAINTS) - {"hard_constraints"}
    assert not lacking, f"build {sorted(lacking)} in CONSTRAINTS, so that their derivatives are tested"
    assert set(constraints.BOUNDED) == set(BOUNDS), "give bounds to new names of constraints.BOUNDED"
    for name in MESHES:
        hard = {c.name for c in constraints.hard_constraints(posed(name), BOUNDS)}
        assert hard <= {c.name for build in CONSTRAINTS.values() for c in build(posed(name))}


# ---- every objective, towards every kind of target


def between() -> Target:
    curve = np.array([[-3.0, -8, 0], [-2, 1, 1], [-3, 4, 0]])
    return BetweenTarget([curve, curve * [-3, 1, 1]], 1.0, "catenary")


def mesh() -> Target:
    x, y = (k.ravel() for k in np.meshgrid(np.arange(-4.0, 12), np.arange(-12.0, 6), indexing="ij"))
    corner = (np.arange(15)[:, None] * 18 + np.arange(17)).ravel()
    faces = np.r_[np.c_[corner, corner + 18, corner + 19], np.c_[corner, corner + 19, corner + 1]]
    return MeshTarget(np.c_[x, y, 0.03 * x * y + 0.2 * np.sin(x)], faces)


def tube_target() -> Target:
    """A bent one that passes through the middle of the meshes."""
    return TubeTarget(arc([-3.0, -8, 0], [4, -4, 2], [6, 5, -1]), np.array([[0.0, 2.0], [0.6, 1.5], [1.0, 2.5]]))


GOALS: dict[str, tuple[Callable[[], Target], objectives.FitPoints]] = {
    "height": (
        lambda: HeightTarget("0.4 - 0.03*(x^2 + y^2) + 0.1*sin(x*y/4)", [[-30, 30], [-30, 30]]),
        "facets",
    ),
    "height beside its domain": (lambda: HeightTarget("1 - 0.1*x*y", [[-1, 2.1], [-7, -3.3]]), "facets"),
    "height, vertices": (lambda: HeightTarget("exp(-x^2/9)*y", [[-30, 30], [-30, 30]]), "vertices"),
    "mesh": (mesh, "facets"),
    "mesh, vertices": (mesh, "vertices"),
    "between": (between, "facets"),
    "mesh, layer": (mesh, "layer"),
    "tube": (tube_target, "facets"),
    "height, layer": (lambda: HeightTarget("0.1*x*x - y", [[-30, 30], [-30, 30]]), "layer"),
}


def spread(points: casadi.SX, _: casadi.SX) -> casadi.SX:
    """An objective of a user's own: squared distances of vertices from the next ones, and one angle."""
    step = points[1:, :] - points[:-1, :]
    return casadi.vertcat(casadi.sum2(step**2), casadi.atan2(points[0, 0] + 9, points[1, 1] - 8))


@pytest.fixture
def own_objective(registered: object) -> None:
    inverse.objective("spread", per="mesh", weight=0.1)(spread)


@dataclass(frozen=True)
class Task:
    """A problem of one mesh, the seed's variables, the names of the blocks that each registered term has in it."""

    start: np.ndarray
    problem: Problem
    blocks: dict[str, list[str]]


@cache
def constrained(mesh: str) -> Task:
    """All constraints of a mesh in one problem."""
    return together(posed(mesh), CONSTRAINTS)


def together(model: DesignModel, terms: dict[str, Callable[[DesignModel], list[Constraint]]]) -> Task:
    """Constraints of a model in one problem."""
    blocks = {term: build(model) for term, build in terms.items()}
    start = np.concatenate([model.seed_points.ravel(), *(state.start(model.seed_points) for state in packed(model))])
    problem = Problem(start.size, [], [c for found in blocks.values() for c in found])
    return Task(start, problem, {term: [b.name for b in found] for term, found in blocks.items()})


@cache
def targeted(mesh: str, goal: str, terms: tuple[str, ...]) -> Task:
    """Objectives of a mesh in one problem with the hard constraints."""
    make, points = GOALS[goal]
    model = posed(mesh)
    t, measure = {"facets": (np.pi, "extent"), "vertices": (0.0, "area"), "layer": (1.2, "extent")}[points]
    boxed = Packed(model, t, measure, np.full(2 if t in (0, np.pi) else 3, np.inf), np.inf, model.n_variables)
    target = make()
    rings = isinstance(target, TubeTarget) and is_tube(model.pattern)
    fitting = TubeFitting(model, target) if rings else SurfaceFitting(model, target, points)
    about = Goal(fitting, (boxed,))
    blocks = {term: objectives.build(about, {t: float(t == term) for t in OBJECTIVES}) for term in terms}
    hard = constraints.hard_constraints(model, BOUNDS)
    problem = Problem(about.n_variables, [o for found in blocks.values() for o in found], hard)
    return Task(
        about.start(model.seed.vertices_coords),
        problem,
        {term: [b.name for b in found] for term, found in blocks.items()},
    )


def assert_second_order(function: Callable, slope: np.ndarray, x: np.ndarray, along: np.ndarray, what: str) -> None:
    """The remainder f(x + h d) - f(x) - h f' d falls by four whenever h is halved, or is none at all."""
    start = np.asarray(function(x))
    remainder = np.array([np.linalg.norm(np.asarray(function(x + h * along)) - start - h * slope) for h in STEPS])
    if remainder.max() > 1e-12 * (np.linalg.norm(start) + np.linalg.norm(slope)):
        ratios = remainder[:-1] / remainder[1:]
        assert ((ratios > 3.8) & (ratios < 4.2)).all(), f"{what}: remainders {remainder}, ratios {ratios}"


def assert_derivatives(task: Task, term: str) -> None:
    """Rows and Jacobian, value and gradient, gradient and Hessian, with all other terms' factors at zero."""
    problem, names, rng = task.problem, task.blocks[term], np.random.default_rng(11)
    assert names
    own = np.concatenate([np.full(c.lower.size, c.name in names) for c in problem.constraints])
    p = problem.parameters()
    for k, objective in enumerate(problem.objectives):
        p[k] = 0.7 if objective.name in names else 0.0
    assert own.any() or p[: len(problem.objectives)].any()

    def rows(x: np.ndarray) -> np.ndarray:
        return Point(problem, x, p).rows[own]

    for _ in range(2):
        x = task.start + 0.07 * rng.standard_normal(problem.n_variables)
        along = rng.standard_normal(x.size) / 3
        lam_g = np.where(own, rng.standard_normal(problem.n_rows), 0.0)

        def value(x: np.ndarray) -> float:
            return Point(problem, x, p).objective

        def gradient(x: np.ndarray, lam_g: np.ndarray = lam_g) -> np.ndarray:
            jacobian = Point(problem, x, p).jacobian
            return 1.3 * Point(problem, x, p).gradient + jacobian.T @ lam_g

        upper = problem.functions["hess_lag"](x, p, 1.3, lam_g).full()
        assert not np.tril(upper, -1).any()
        hessian = upper + np.triu(upper, 1).T
        slope = Point(problem, x, p).jacobian @ along
        assert_second_order(rows, slope[own], x, along, f"Jacobian of {term}")
        assert_second_order(value, Point(problem, x, p).gradient @ along, x, along, f"gradient of {term}")
        assert_second_order(gradient, hessian @ along, x, along, f"curvature of {term}")


@pytest.mark.parametrize("term", CONSTRAINTS)
@pytest.mark.parametrize("mesh", MESHES)
def test_constraints(mesh: str, term: str) -> None:
    assert_derivatives(constrained(mesh), term)


def test_packed_states_of_a_tube() -> None:
    term = "packed states"
    assert_derivatives(together(DesignModel(tube()), {term: CONSTRAINTS[term]}), term)


CLOSED: dict[str, Callable[[], Design]] = {"tube": lambda: tube(6), "hole": holed}


@pytest.mark.parametrize("mesh", CLOSED)
def test_closed_strips(mesh: str) -> None:
    model = DesignModel(CLOSED[mesh]())
    (strip,) = hole_strips(model.pattern)
    terms: dict[str, Callable[[DesignModel], list[Constraint]]] = {
        "exact": lambda model: cylinder_loop.exact(model, "exact", strip),
        "bars": lambda model: [cylinder_loop.bars(model, "bars", strip)],
    }
    task = together(model, terms)
    for term in terms:
        assert_derivatives(task, term)


@pytest.mark.parametrize("goal", GOALS)
@pytest.mark.parametrize("mesh", MESHES)
def test_objectives(mesh: str, goal: str) -> None:
    if GOALS[goal][1] == "layer" and mesh != "grid":
        with pytest.raises(inverse.InputError, match="need a grid"):
            targeted(mesh, goal, tuple(OBJECTIVES))
        return
    for term in OBJECTIVES:
        assert_derivatives(targeted(mesh, goal, tuple(OBJECTIVES)), term)


@pytest.mark.parametrize("goal", ["tube", "mesh"])
def test_objectives_of_a_tube(goal: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ring by ring towards an axis, facet by facet towards any other target."""
    monkeypatch.setitem(MESHES, "tube", tube)
    task = targeted.__wrapped__("tube", goal, tuple(OBJECTIVES))
    for term in OBJECTIVES:
        assert_derivatives(task, term)
    fit = next(o.elements for o in task.problem.objectives if o.name == "fit")
    assert fit.count == {"tube": 4, "mesh": 24}[goal]


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.usefixtures("own_objective")
def test_a_registered_objective(mesh: str) -> None:
    assert_derivatives(targeted(mesh, "height", ("fit", "spread")), "spread")


# ---- the assembled value, and tests that must fail


@pytest.mark.usefixtures("own_objective")
@pytest.mark.parametrize("mesh", MESHES)
def test_the_objective_is_the_sum_of_weighted_mean_squares(mesh: str) -> None:
    task = targeted(mesh, "mesh", (*OBJECTIVES,))
    problem, rng = task.problem, np.random.default_rng(2)
    x = rng.standard_normal(problem.n_variables)
    p = problem.parameters()
    start, expected = len(problem.objectives), {}
    for k, objective in enumerate(problem.objectives):
        e = objective.elements
        p[k] = rng.uniform(0.5, 2)
        own = p[start : start + e.parameters.size].reshape(e.parameters.shape)
        residuals = [np.asarray(e.kernel.value(x[v], q)) for v, q in zip(e.variables, own, strict=True)]
        expected[objective.name] = p[k] * np.mean(np.square(residuals))
        start += e.parameters.size
    assert Point(problem, x, p).objective_terms == pytest.approx(expected, rel=1e-13)
    assert Point(problem, x, p).objective == pytest.approx(sum(expected.values()), rel=1e-13)
    assert float(problem.functions["nlp"](x, p)[0]) == pytest.approx(sum(expected.values()), rel=1e-13)


def test_rows_stand_in_the_order_of_the_constraints() -> None:
    task = constrained("general")
    rng = np.random.default_rng(4)
    x, p = rng.standard_normal(task.problem.n_variables), task.problem.parameters()
    rows = Point(task.problem, x, p).rows
    expected = [
        np.asarray(c.elements.kernel.value(x[v], q)).ravel()
        for c in task.problem.constraints
        for v, q in zip(c.elements.variables, c.elements.parameters, strict=True)
    ]
    assert_close(rows, np.concatenate(expected), 1e-12)


@pytest.mark.parametrize("spoilt", ["jacobian", "curvature", "gradient", "square_curvature"])
def test_a_wrong_kernel_is_noticed(spoilt: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """One nonzero of one element's derivative is off by a thousandth."""
    right = Kernel.__init__

    def wrong(self: Kernel, *arguments, **options) -> None:
        right(self, *arguments, **options)
        function = getattr(self, spoilt)
        inputs = [casadi.SX.sym(f"i{k}", function.sparsity_in(k)) for k in range(function.n_in())]
        output = function(*inputs)
        if output.nnz():  # linear residuals have no curvature
            output.nz[0] = output.nz[0] * 1.001
        setattr(self, spoilt, casadi.Function(function.name(), inputs, [output]))

    monkeypatch.setattr(Kernel, "__init__", wrong)
    monkeypatch.setattr(compiled, "_kept", OrderedDict())  # else functions of right kernels of the same form are used
    task, term = (
        (constrained.__wrapped__("grid"), "opposite_angles")
        if spoilt in ("jacobian", "curvature")
        else (targeted.__wrapped__("grid", "height", ("fit",)), "fit")
    )
    what = {"jacobian": "Jacobian", "gradient": "gradient"}.get(spoilt, "curvature")
    with pytest.raises(AssertionError, match=f"{what} of {term}: remainders"):
        assert_derivatives(task, term)
