"""Objectives and constraints of users: what they are given, mean and refuse; their derivatives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi
import numpy as np
import pytest
from designs import assert_close, hybrid, polygonal
from domes import task

import inverse
from inverse import InputError, objectives
from inverse.formulation.formulate import Formulation, formulate
from inverse.formulation.given import Given
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import geometry
from inverse.terms import own
from inverse.terms.own_constraints import CONSTRAINTS

pytestmark = pytest.mark.usefixtures("registered")
Function = Callable[[casadi.SX, casadi.SX], Any]


def height(points: casadi.SX, seed: casadi.SX) -> casadi.SX:
    return points[0, 2] - 0.5 * seed[0, 2]


def middle(points: casadi.SX, seed: casadi.SX) -> casadi.SX:
    """Linear, of all vertices, three residuals."""
    return casadi.sum1(points - 1.05 * seed) / points.shape[0]


def stretch(points: casadi.SX, _: casadi.SX) -> casadi.SX:
    """Curved, a sum over all vertices of terms of two: a sparse Hessian."""
    return casadi.sumsqr(points[1:, :] - points[:-1, :]) / points.shape[0] - 0.1


def unevenness(points: casadi.SX, _: casadi.SX) -> casadi.SX:
    """Curved, and every vertex with every other: the root of the variance of heights."""
    z = points[:, 2]
    return casadi.sqrt(casadi.sumsqr(z - casadi.sum1(z) / z.numel()) / z.numel())


def each(points: casadi.SX, seed: casadi.SX) -> casadi.SX:
    """A residual for every vertex of the mesh, curved."""
    return casadi.sin(points[:, 0]) * points[:, 2] - seed[:, 2]


def side(points: casadi.SX, seed: casadi.SX) -> casadi.SX:
    now, before = (casadi.sumsqr(p[1, :] - p[0, :]) for p in (points, seed))
    return casadi.vertcat(now, before * points[0])


def spread(points: casadi.SX, _: casadi.SX) -> casadi.SX:
    return casadi.sumsqr(points - casadi.repmat(casadi.sum1(points) / points.shape[0], points.shape[0], 1))


TERMS: dict[str, tuple[own.Per, str, Function]] = {
    "height": ("vertex", "length", height),
    "side": ("edge", "length^2", side),
    "spread": ("facet", "length^2", spread),
    "middle": ("mesh", "length", middle),
    "stretch": ("mesh", "length^2", stretch),
    "unevenness": ("mesh", "length", unevenness),
    "each": ("mesh", "length", each),
}
CARRIED = {"middle", "stretch", "unevenness"}
DENSE = "unevenness"


def problem_of(formulation: Formulation) -> Problem:
    return Problem(formulation.goal.n_variables, formulation.objectives, formulation.fixed)


def formulated(name: str, kind: str, design: inverse.Design | None = None, **keys: Any) -> Formulation:
    per, unit, function = TERMS[name]
    if kind == "objective":
        term = inverse.objective(name, per=per, unit=unit)(function)
        return formulate(task(**keys), given=Given.of(objectives=[(term, 0.7)], design=design))
    bounded = inverse.constraint(name, per=per, unit=unit)(function)
    return formulate(task(**keys), given=Given.of(constraints=[(bounded, -10, None)], design=design))


# ---- derivatives


@pytest.mark.parametrize("kind", ["objective", "constraint"])
@pytest.mark.parametrize("name", TERMS)
@pytest.mark.parametrize("mesh", [None, polygonal])
def test_derivatives(name: str, kind: str, mesh: Callable[[], inverse.Design] | None) -> None:
    """Remainders of first order shrink by four when steps are halved: of rows, objective and gradients."""
    formulation = formulated(name, kind, mesh() if mesh else None)
    problem, goal = problem_of(formulation), formulation.goal
    own_rows = np.concatenate([np.full(c.lower.size, c.name.startswith(name)) for c in problem.constraints])
    assert own_rows.any() == (kind == "constraint" or bool(goal.carried))
    if mesh is None:
        assert bool(goal.carried) == (kind == "objective" and name in CARRIED)
    rng, p = np.random.default_rng(3), problem.parameters()
    for k, objective in enumerate(problem.objectives):
        p[k] = 0.7 if objective.name.startswith(name) else 0.0
    x = goal.seed_variables + 0.05 * rng.standard_normal(problem.n_variables)
    along, multipliers = rng.standard_normal(x.size) / 3, np.where(own_rows, rng.standard_normal(problem.n_rows), 0.0)
    at = Point(problem, x, p)
    upper = problem.functions["hess_lag"](x, p, 1.0, multipliers).full()
    hessian = upper + np.triu(upper, 1).T

    def slope(y: np.ndarray) -> np.ndarray:
        there = Point(problem, y, p)
        return there.gradient + there.jacobian.T @ multipliers

    checks: list[tuple[Callable[[np.ndarray], Any], Any]] = [
        (lambda y: Point(problem, y, p).rows[own_rows], (at.jacobian @ along)[own_rows]),
        (lambda y: Point(problem, y, p).objective, at.gradient @ along),
    ]
    checks.append((slope, hessian @ along))  # so small a mesh has all of it
    for value, expected in checks:
        steps = 1e-3 * 0.5 ** np.arange(3)
        left = np.array([np.abs(value(x + s * along) - value(x) - s * expected).max(initial=0.0) for s in steps])
        size = np.abs(value(x)).max(initial=1.0)
        assert (left < 1e-12 * size).all() or ((left[:-1] / left[1:] > 3.7) & (left[:-1] / left[1:] < 4.3)).all(), left


def test_the_curvature_of_what_couples_all_vertices_is_left_out() -> None:
    formulation = formulated(DENSE, "objective", pattern={"size": [16, 16]})
    problem = problem_of(formulation)
    assert problem.functions["hess_lag"].sparsity_out(0).nnz() < 60 * problem.n_variables
    (equation,) = [c for c in problem.constraints if c.name.startswith(DENSE)]
    assert equation.elements.kernel.curvature.nnz_out(0) == 0


# ---- meaning


@pytest.mark.parametrize("name", ["height", "side", "spread", "stretch", "unevenness"])
def test_an_objective_is_the_mean_square_in_sixteenths_of_the_model(name: str) -> None:
    """Over vertices, edges, and facets of all numbers of sides, in the specification's coordinates."""
    formulation = formulated(name, "objective", polygonal())
    model = formulation.goal.model
    points, seed = (casadi.SX.sym(k, model.pattern.n_vertices, 3) for k in "ps")
    groups: dict[str, list[Any]] = {
        "vertex": [[v] for v in range(model.pattern.n_vertices)],
        "edge": model.pattern.edges_vertices.tolist(),
        "facet": [list(face) for face in model.pattern.faces_vertices],
        "mesh": [list(range(model.pattern.n_vertices))],
    }
    per, unit, function = TERMS[name]
    residuals = [casadi.vec(casadi.SX(function(points[group, :], seed[group, :]))) for group in groups[per]]
    moved = model.seed.vertices_coords + 0.01 * np.random.default_rng(1).standard_normal(seed.shape)
    values = casadi.Function("f", [points, seed], [casadi.vertcat(*residuals)])(moved, model.seed.vertices_coords)
    sixteenth = geometry.edge_lengths(model.pattern, model.seed.vertices_coords).mean() * model.refinement
    expected = 0.7 * np.mean((np.asarray(values) / sixteenth ** own.UNITS[unit]) ** 2)
    problem = problem_of(formulation)
    told = Point(problem, formulation.goal.start(moved), problem.parameters()).objective_terms
    assert sum(value for key, value in told.items() if key.startswith(name)) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("factor", [1e-3, 1e3])
@pytest.mark.parametrize("name", ["height", "middle"])
def test_an_objective_means_the_same_in_every_unit(name: str, factor: float) -> None:
    per, unit, function = TERMS[name]
    inverse.objective(name, per=per, unit=unit)(function)
    one, other = (inverse.solve(task(**sphere(size), objectives={name: 0.01})) for size in (1.0, factor))
    assert one.converged
    assert_close(other.design.vertices_coords / factor, one.design.vertices_coords, 1e-9)
    assert np.abs(one.design.vertices_coords - inverse.solve(task(**sphere(1.0))).design.vertices_coords).max() > 0.01


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_a_constraint_means_the_same_in_every_unit(factor: float) -> None:
    @inverse.constraint("area", per="facet", unit="length^2")
    def area(points: casadi.SX, _: casadi.SX) -> casadi.SX:
        return casadi.norm_2(casadi.cross(points[2, :] - points[0, :], points[3, :] - points[1, :])) / 2

    one, other = (
        inverse.solve(task(**sphere(size), constraints={"own": {"area": [None, 0.13 * size**2]}}))
        for size in (1.0, factor)
    )
    assert one.converged
    assert_close(other.design.vertices_coords / factor, one.design.vertices_coords, 1e-9)
    a, b, c, d = one.design.vertices_coords[np.array(one.design.pattern.faces_vertices)].transpose(1, 0, 2)
    assert (np.linalg.norm(np.cross(c - a, d - b), axis=1) / 2).max() <= 0.13 * (1 + 1e-6)


def sphere(radius: float) -> dict[str, Any]:
    half = 0.6 * radius
    target = {"height": f"sqrt({radius * radius!r} - x^2 - y^2)", "domain": [[-half, half], [-half, half]]}
    return {"target": target}


def test_bounds_are_degrees_in_specifications_and_radians_in_python() -> None:
    @inverse.constraint("tilt", per="facet", unit="angle", lower=0.1)
    def tilt(points: casadi.SX, _: casadi.SX) -> casadi.SX:
        normal = casadi.cross(points[2, :] - points[0, :], points[3, :] - points[1, :])
        return casadi.atan2(casadi.norm_2(normal[0, :2]), normal[0, 2])

    def limits(**given: Any) -> tuple[float, float]:
        keys = {"constraints": {"own": given.pop("own")}} if "own" in given else {}
        (found,) = [c for c in formulate(task(**keys), given=Given.of(**given)).fixed if c.name == "tilt"]
        assert (found.lower == found.lower[0]).all()
        return float(found.lower[0, 0]), float(found.upper[0, 0])

    assert limits(own={"tilt": None}) == (0.1, np.inf)
    assert limits(own={"tilt": [None, 45]}) == pytest.approx((-np.inf, np.pi / 4))
    assert limits(constraints=[tilt]) == (0.1, np.inf)
    assert limits(own={"tilt": [None, 45]}, constraints=[(tilt, 0.2, None)]) == (0.2, np.inf)


def test_rows_say_where_they_are() -> None:
    for per, label in (("vertex", "vertex 0"), ("edge", "edge 1-0"), ("facet", "facet 0"), ("mesh", "all vertices")):
        term = inverse.constraint(per, per=per, unit="length", lower=0)(lambda points, _: points[0, 2])  # type: ignore[arg-type]
        (found,) = [c for c in formulate(task(), given=Given.of(constraints=[term])).fixed if c.name == per]
        assert label in found.labels
        assert len(found.labels) == found.elements.count


# ---- values of the whole mesh


def test_packed_states_and_values_share_the_variables() -> None:
    keys = {"objectives": {"footprint": 0.01}}
    formulation = formulated("middle", "objective", **keys)
    goal = formulation.goal
    (packed,), (carried,) = goal.packed, goal.carried
    assert packed.first == goal.model.n_variables
    assert carried.first == packed.first + packed.n_variables
    assert goal.n_variables == carried.first + 3
    problem = problem_of(formulation)
    assert Point(problem, goal.seed_variables, problem.parameters()).violation < 1e-12
    result = inverse.solve(task(objectives={"footprint": 0.01, "middle": 1.0}))
    assert result.converged, result.status
    moved = (result.design.vertices_coords - result.seed.vertices_coords).mean(axis=0)
    assert np.abs(moved - 0.05 * result.seed.vertices_coords.mean(axis=0)).max() < 0.01


@pytest.mark.parametrize("name", sorted(CARRIED))
def test_values_of_the_whole_mesh_are_reached(name: str) -> None:
    """The approach, the polish and a start from the result all know the dense row."""
    per, unit, function = TERMS[name]
    inverse.objective(name, per=per, unit=unit)(function)
    weights = {name: 1.0} if name != DENSE else {name: 0.001}
    result = inverse.solve(task(objectives=weights))
    assert result.converged, result.status
    assert result.certified
    again = inverse.solve(task(objectives=weights), start=result)
    assert again.report["iterations"] <= 2
    assert_close(again.design.vertices_coords, result.design.vertices_coords, 1e-7)


def test_the_centroid_of_a_fine_mesh_leaves_the_hessian_sparse() -> None:
    """All pairs of 32 x 32 facets' coordinates would be five million nonzeros."""
    inverse.objective("middle", per="mesh", unit="length")(middle)
    plain, pulled = (
        problem_of(formulate(task(pattern={"size": [32, 32]}, objectives=weights))) for weights in ({}, {"middle": 1.0})
    )
    counts = [problem.functions["hess_lag"].sparsity_out(0).nnz() for problem in (plain, pulled)]
    assert counts[0] < counts[1] <= counts[0] + 9


def test_a_direct_formulation_gives_the_same_verdict() -> None:
    """The gradient by the vertices is that of the function without variables of its own."""
    formulation = formulated("middle", "objective")
    goal, problem = formulation.goal, problem_of(formulation)
    (carried,) = goal.carried
    n = goal.model.n_variables
    p = problem.parameters()
    p[: problem.layout.n_weights] = [0.7 * (o.name == "middle") for o in problem.objectives]

    def value(x: np.ndarray) -> float:
        return Point(problem, goal.start(goal.model.points(x)), p).objective

    x = goal.seed_variables
    along = np.random.default_rng(0).standard_normal(n)
    slope = (value(x[:n] + 1e-5 * along) - value(x[:n] - 1e-5 * along)) / 2e-5
    gradient = carried.brought_back(Point(problem, x, p).gradient, Point(problem, x, p))
    assert gradient[:n] @ along == pytest.approx(slope, rel=1e-7)
    assert not gradient[n:].any()


# ---- refusals


FAULTS: dict[str, tuple[Any, str]] = {
    "matrix": (lambda points, seed: points.T @ points, r"mine returns a matrix of shape \(3, 3\): an expression or a"),
    "empty": (lambda points, seed: casadi.SX(0, 1), r"mine returns a matrix of shape \(0, 1\)"),
    "list": (lambda points, seed: [points[0], points[1]], "mine returns a list of 2: an expression or a CasADi vector"),
    "tuple": (lambda points, seed: (points[0],), "mine returns a tuple of 1"),
    "number": (lambda points, seed: 3.0, "mine returns a constant: it must depend on the points"),
    "of the seed": (lambda points, seed: seed[0], "mine returns a constant: it must depend on the points"),
    "text": (lambda points, seed: "z", "mine returns a str: a CasADi expression is wanted"),
    "array": (lambda points, seed: np.array([points[0]]), "mine returns a ndarray: a CasADi expression is wanted"),
    "nothing": (lambda points, seed: None, "mine returns nothing"),
    "one argument": (lambda points: points[0], r"mine raised TypeError: .* takes 1 positional argument but 2 were"),
    "outside": (lambda points, seed: points[7, 0], "mine raised RuntimeError: .*[Oo]ut of bounds"),
    "exception": (lambda points, seed: 1 / 0, "mine raised ZeroDivisionError: division by zero"),
}


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("per", own.PER)
@pytest.mark.parametrize("kind", ["objective", "constraint"])
def test_what_a_function_may_not_return(fault: str, per: own.Per, kind: str) -> None:
    function, message = FAULTS[fault]
    if fault == "outside" and per == "mesh":
        return
    inverse.objective("mine", per=per)(function)
    inverse.constraint("mine", per=per, lower=0)(function)
    keys = {"objectives": {"mine": 1.0}} if kind == "objective" else {"constraints": {"own": {"mine": None}}}
    with pytest.raises(InputError, match=f"{kind} {message}") as caught:
        formulate(task(**keys))
    assert caught.value.where == ("specification:" + {"objective": "objectives.mine"}.get(kind, "constraints.own.mine"))
    if "raised" in message:
        assert type(caught.value.__cause__).__name__ in message


ARGUMENTS: list[tuple[dict[str, Any], str]] = [
    ({"per": "vertx"}, r"mine has per 'vertx': allowed are vertex, edge, facet, mesh\. Did you mean vertex\?"),
    ({"unit": "lenght"}, r"mine has unit 'lenght': allowed are 1, length, .* Did you mean length\?"),
    ({"unit": 1}, "mine has unit 1: allowed"),
]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [*ARGUMENTS, ({"weight": -1}, "is -1: it must be at least 0"), ({"weight": "1"}, "is '1': it must be a finite")],
)
def test_arguments_of_objectives(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=f"objective mine.*{message.removeprefix('mine')}"):
        inverse.objective("mine", **arguments)(height)
    assert "mine" not in objectives.OBJECTIVES


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        *ARGUMENTS,
        ({"lower": 2, "upper": 1}, "mine has the bounds 2 and 1: the lower one must not be above"),
        ({"lower": None}, "mine has the bound None: it must be a number, -inf or inf for none"),
        ({"upper": np.nan}, "mine has the bound nan"),
        ({"lower": np.inf}, "mine has the bounds inf and inf"),
    ],
)
def test_arguments_of_constraints(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=f"constraint {message}"):
        inverse.constraint("mine", **arguments)(height)
    assert "mine" not in CONSTRAINTS


def test_no_function() -> None:
    with pytest.raises(InputError, match="objective mine is no function"):
        inverse.objective("mine")(3)  # type: ignore[arg-type]


def test_terms_given_in_python() -> None:
    term = inverse.objective("up", unit="length")(height)
    bounded = inverse.constraint("up", unit="length")(height)
    wrong: list[tuple[dict[str, Any], str]] = [
        ({"objectives": [height]}, "height is no objective: a term that @inverse.objective made is wanted"),
        ({"objectives": [bounded]}, "constraint up is no objective"),
        ({"objectives": [term]}, r"objective up has the weight 0\n.*\(term, weight\)"),
        ({"objectives": [(term, -1)]}, "objective up has the weight -1"),
        ({"objectives": [(term, "1")]}, "the weight of objective up is '1': it must be a finite number"),
        ({"constraints": [term]}, "objective up is no constraint: a term that @inverse.constraint made is wanted"),
        ({"constraints": [bounded]}, "constraint up has no bounds"),
        ({"constraints": [(bounded, None, None)]}, "constraint up has no bounds"),
        ({"constraints": [(bounded, 1)]}, "constraint up is no constraint"),
        ({"constraints": [(bounded, 1, 0)]}, "constraint up has the bounds 1 and 0"),
        ({"target": 3}, "the target is a int: a Target is wanted"),
        ({"design": 3}, "the design is a int: a Design is wanted"),
    ]
    for keys, message in wrong:
        with pytest.raises(InputError, match=message):
            formulate(task(), given=Given.of(**keys))
    found = formulate(task(objectives={"up": 3.0}), given=Given.of(objectives=[(term, 2)]))
    assert [o.weight for o in found.objectives if o.name == "up"] == [2.0]
    assert height is term.function
    assert casadi.is_equal(*[f(casadi.SX(1, 3), casadi.SX(1, 3)) for f in (term, height)])


def test_names_that_are_not_registered() -> None:
    inverse.constraint("heights", lower=0)(height)
    with pytest.raises(InputError, match=r"constraints.own.hieghts: 'hieghts' is no constraint: .*mean heights\?"):
        formulate(task(constraints={"own": {"hieghts": [0, 1]}}))
    with pytest.raises(InputError, match=r"objectives.fitt: 'fitt' is no objective: .* Did you mean fit\?"):
        formulate(task(objectives={"fitt": 1}))


def test_no_value_at_the_seed_is_told_by_name() -> None:
    for name, (per, _, _) in (("a", TERMS["height"]), ("b", TERMS["middle"])):
        inverse.objective(name, per=per)(lambda points, _: casadi.sqrt(casadi.sum1(points[:, 2]) - 1e4))
        result = inverse.solve(task(objectives={name: 1.0}))
        assert result.ending == "not_a_number"
        assert f"{name} at vertex 0" in result.status or f"{name} of the mesh at all vertices" in result.status
        assert_close(result.design.vertices_coords, result.seed.vertices_coords, 1e-12)


def test_a_term_that_knows_only_the_fine_grid() -> None:
    """A coarser grid, which a fine one starts from, is left out then."""
    from inverse.policy.control import Control
    from inverse.policy.steps import Policy

    inverse.objective("corner", per="mesh", unit="length")(lambda points, _: points[34 * 34, 2])
    loaded = task(pattern={"size": [34, 34]}, objectives={"corner": 1e-3})
    policy = Policy(loaded, formulate(loaded), Control(np.inf, None))
    assert policy._from_coarse(loaded, policy.formulation.goal) is None


def test_a_design_and_a_target_in_place_of_those_named() -> None:
    seed, target = hybrid(2), formulate(task()).goal.target
    made = formulate(task(target={"mesh": "nowhere.obj"}), given=Given.of(target=target, design=seed))
    assert made.goal.target is target
    assert made.goal.model.pattern is seed.pattern
    assert_close(made.goal.model.seed.vertices_coords.mean(axis=0), target.frame.origin, 1e-12)
    assert formulate(task(), 0.5, made.given).goal.model.pattern is seed.pattern
