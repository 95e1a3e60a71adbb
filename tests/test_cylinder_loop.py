"""Closed strips: as many conditions as closure takes, none too few and none too many, against the certificate's own."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from designs import TUBES, assert_close, eggbox, holed, hybrid, miura, tube
from scipy.spatial.distance import pdist
from scipy.spatial.transform import Rotation

from inverse import constraints, cylinder_loop
from inverse.certify import Certificate, check_frame
from inverse.errors import InputError
from inverse.files import fold_file
from inverse.files.fold_format import frame_of
from inverse.model import DesignModel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.nlp.redundancy import dependence, independent, redundant
from inverse.origami import geometry
from inverse.origami.holes import hole_strips
from inverse.origami.pattern import FL, Design, FloatArray
from inverse.terms.fillings import fillings, quadrilaterals

HOLES: dict[str, Callable[[], Design]] = {
    "one facet of a Miura": lambda: holed(miura, 5),
    "one facet of an eggbox": lambda: holed(eggbox, 5),
    "one facet of a hybrid, between an FL and a CFL": lambda: holed(lambda m, _: hybrid(m), 9, ((2, 3),)),
    "two facets": lambda: holed(miura, 7, ((2, 2), (3, 2))),
    "four facets": lambda: holed(eggbox, 6, ((2, 2), (3, 2), (2, 3), (3, 3))),
    "two holes": lambda: holed(miura, 7, ((2, 2), (4, 4))),
}


def exact(design: Design, *, closed: bool = True) -> tuple[DesignModel, Problem]:
    """All equations of a design, with closure of one strip around every hole or without."""
    model = DesignModel(design)
    terms = [constraints.opposite_angles(model), *constraints.planarity(model)]
    if closed:
        terms += cylinder_loop.around_holes(model)
    return model, Problem(model.n_variables, [], [term for term in terms if term.elements.count])


def jacobian_of(problem: Problem, x: FloatArray) -> FloatArray:
    return np.asarray(Point(problem, x, problem.parameters()).jacobian.toarray())


def rank(jacobian: FloatArray) -> int:
    sizes = np.linalg.svd(jacobian, compute_uv=False)
    found = int((sizes > 1e-9 * sizes[0]).sum())
    assert found == len(sizes) or sizes[found] < 1e-3 * sizes[found - 1], "no gap between zero and what is not"
    return found


def generic(problem: Problem, x: FloatArray, amount: float = 0.02) -> FloatArray:
    """A point of all equations away from the seed, by Newton's method from a random place.

    There redundant equations contradict each other a little, and are no longer told by their rank.
    """
    kept = rank(jacobian_of(problem, x))
    x = x + amount * np.random.default_rng(0).standard_normal(x.size)
    for _ in range(12):
        u, sizes, v = np.linalg.svd(jacobian_of(problem, x), full_matrices=False)
        residual = Point(problem, x, problem.parameters()).rows - problem.lower
        x = x - v[:kept].T @ ((u.T @ residual)[:kept] / sizes[:kept])
    assert Point(problem, x, problem.parameters()).violation < 1e-12
    return x


def certificate_of(design: Design) -> Certificate:
    return check_frame(frame_of(fold_file.document(design)))


# ---- closed in every state


@pytest.mark.parametrize("name", [*TUBES, *HOLES])
def test_a_random_design_with_the_equations_stays_closed(name: str) -> None:
    model, problem = exact((TUBES | HOLES)[name]())
    design = model.design(generic(problem, model.seed_points.ravel()))
    certificate = certificate_of(design)
    assert certificate.checks["loop_closure"].passed
    assert certificate.checks["motion_gap"].passed
    assert certificate.checks["loop_closure"].value < 1e-12


@pytest.mark.parametrize("name", HOLES)
def test_a_random_design_without_them_opens(name: str) -> None:
    model, problem = exact(HOLES[name](), closed=False)
    opened = certificate_of(model.design(generic(problem, model.seed_points.ravel())))
    assert all(opened.checks[one].passed for one in ("planarity", "developability", "flat_foldability"))
    assert not opened.certified
    assert opened.checks["loop_closure"].value > 1e-4
    assert "at t = " in opened.checks["loop_closure"].sentence


@pytest.mark.parametrize("k", [4, 6, 8])
def test_every_filling_of_a_tube_closes(k: int) -> None:
    model = DesignModel(tube(k, 2))
    (strip,) = hole_strips(model.pattern)
    vertices = [constraints.opposite_angles(model), *constraints.planarity(model)]
    ends = []
    for filling in cylinder_loop.suited(model, strip):
        closed = cylinder_loop.exact(model, "loop", strip, filling)
        x = generic(Problem(model.n_variables, [], [*vertices, *closed]), model.seed_points.ravel())
        assert certificate_of(model.design(x)).checks["loop_closure"].value < 1e-12
        ends.append(x)
    assert len(ends) == {4: 1, 6: 3, 8: 12}[k]
    assert all(np.abs(a - b).max() > 1e-3 for i, a in enumerate(ends) for b in ends[:i]), "families of their own"


# ---- as few equations as possible


@pytest.mark.parametrize(("k", "rows"), [(4, 1), (4, 4), (6, 2), (6, 4), (8, 3)])
def test_dimension_of_tubes(k: int, rows: int) -> None:
    """3 R + 7 k / 2, at the seed as at a generic point; three equations of every ring follow from the others."""
    model, problem = exact(tube(k, rows))
    for x in (model.seed_points.ravel(), generic(problem, model.seed_points.ravel())):
        found = rank(jacobian_of(problem, x))
        assert problem.n_variables - found == 3 * rows + 7 * k // 2
        left_out = redundant(Point(problem, x, problem.parameters()))
        assert len(left_out) == problem.n_rows - found == 3 * (rows - 1)
        kept = np.setdiff1d(np.arange(problem.n_rows), left_out)
        assert rank(jacobian_of(problem, x)[kept]) == len(kept)
        told = dependence(Point(problem, x, problem.parameters()))
        assert (told["rows"], told["rank"], told["freedom"]) == (problem.n_rows, found, 3 * rows + 7 * k // 2)
        assert 1 < told["condition"] < 1e3


@pytest.mark.parametrize("name", HOLES)
def test_dimension_of_disks_with_holes(name: str) -> None:
    """Every hole with a strip of k facets costs 3 k / 2 - 3 freedoms, and no equation is redundant."""
    model, problem = exact(HOLES[name]())
    _, without = exact(HOLES[name](), closed=False)
    strips = hole_strips(model.pattern)
    for x in (model.seed_points.ravel(), generic(problem, model.seed_points.ravel())):
        assert rank(jacobian_of(problem, x)) == problem.n_rows
    assert problem.n_rows - without.n_rows == sum(3 * len(strip) // 2 - 3 for strip in strips)


@pytest.mark.parametrize("make", [lambda: tube(4, 2), lambda: tube(6, 2), HOLES["one facet of a Miura"]])
def test_no_equation_is_too_many(make: Callable[[], Design]) -> None:
    """What the equations forbid to first order at a generic point, closure itself forbids."""
    model, problem = exact(make())
    x = generic(problem, model.seed_points.ravel())
    _, without = exact(make(), closed=False)
    own = rank(jacobian_of(problem, x))

    h = 1e-5
    slopes = [(products(model.design(x + h * e)) - products(model.design(x - h * e))) / (2 * h) for e in np.eye(x.size)]
    assert np.abs(products(model.design(x))).max() < 1e-11
    stacked = np.vstack([jacobian_of(without, x), np.array(slopes).T])
    sizes = np.linalg.svd(stacked, compute_uv=False)
    assert int((sizes > 1e-6).sum()) == own, sizes[own - 3 : own + 3]


def products(design: Design) -> FloatArray:
    """Product of the hinge motions of a strip, less the identity, at more states than its degree."""
    pattern, points = design.pattern, design.vertices_coords
    (strip,) = hole_strips(pattern)
    folds = geometry.fold_angles(pattern, points)
    between = {frozenset(pair): e for e, pair in enumerate(pattern.edges_faces.tolist())}
    found = []
    for theta in np.pi / 4 + np.pi * np.arange(1, len(strip) + 2) / (len(strip) + 2):
        product = np.eye(4)
        for facet, onward in zip(strip, np.roll(strip, -1).tolist(), strict=True):
            edge = between[frozenset((facet, onward))]
            factor = np.tan(theta) if pattern.edges_type[edge] == FL else 1 / np.tan(theta)
            turn = 2 * np.arctan(np.tan(folds[edge] / 2) * factor) - folds[edge]
            a, b = points[pattern.edges_vertices[edge]]
            axis = (a - b) / np.linalg.norm(a - b)
            # A valley turns the facet on the right upwards, seen from the one on the left.
            sign = 1.0 if pattern.edges_faces[edge, 0] == facet else -1.0
            motion = np.eye(4)
            motion[:3, :3] = Rotation.from_rotvec(sign * turn * axis).as_matrix()
            motion[:3, 3] = a - motion[:3, :3] @ a
            product = product @ motion
        found.append(product[:3] - np.eye(4)[:3])
    return np.ravel(found)


# ---- bars


@pytest.mark.parametrize(("k", "freedom"), [(4, 10), (6, 12), (8, 14)])
def test_bars_keep_a_strip_as_it_is(k: int, freedom: int) -> None:
    model = DesignModel(tube(k, 4))
    strip = tuple(4 * i for i in range(k))
    terms = [constraints.opposite_angles(model), *constraints.planarity(model)]
    problem = Problem(model.n_variables, [], [*terms, cylinder_loop.bars(model, "loop", strip)])
    assert problem.constraints[-1].lower.size == 5 * k - 5
    x = generic(problem, model.seed_points.ravel(), 0.002)
    assert problem.n_variables - 6 - rank(jacobian_of(problem, x)) == freedom
    assert np.abs(x - model.seed_points.ravel()).max() > 1e-3
    vertices = np.unique([model.pattern.faces_vertices[f] for f in strip])
    before, after = (p.reshape(-1, 3)[vertices] for p in (model.seed_points, x))
    assert_close(pdist(after), pdist(before), 1e-12)
    assert certificate_of(model.design(x)).certified


# ---- fillings


def test_numbers_of_fillings() -> None:
    """Cuts of a polygon into quadrilaterals, 1, 3, 12, 55, ... (Fuss and Catalan)."""
    for k, number in ((4, 1), (6, 3), (8, 12), (10, 55), (12, 273)):
        found = fillings(k, set(quadrilaterals(k)))
        assert len(set(found)) == len(found) == number
        for filling in found:
            assert len(filling) == (k - 2) // 2
            sides: dict[frozenset[int], int] = {}
            for q in filling:
                for pair in zip(q, (*q[1:], q[0]), strict=True):
                    sides[frozenset(pair)] = sides.get(frozenset(pair), 0) + 1
            rim = {frozenset((i, (i + 1) % k)) for i in range(k)}
            assert {pair for pair, count in sides.items() if count == 1} == rim
            assert set(sides.values()) <= {1, 2}
    assert fillings(5, set(quadrilaterals(5))) == []
    assert fillings(6, {(0, 1, 2, 3), (0, 3, 4, 5)}) == [((0, 3, 4, 5), (0, 1, 2, 3))]


def test_the_best_conditioned_filling_comes_first() -> None:
    model = DesignModel(tube(8, 2))
    (strip,) = hole_strips(model.pattern)
    sizes = []
    for filling in cylinder_loop.suited(model, strip):
        (constraint,) = cylinder_loop.exact(model, "loop", strip, filling)
        problem = Problem(model.n_variables, [], [constraint])
        sizes.append(np.linalg.svd(jacobian_of(problem, model.seed_points.ravel()), compute_uv=False)[-1])
    assert sizes[0] > 1.2 * sizes[-1]
    assert (np.diff(sizes) < 1e-5 * sizes[0]).all()


@pytest.mark.parametrize("holes", [((2, 2), (2, 3), (2, 4)), ((2, 2), (2, 3), (3, 3))])
def test_a_strip_that_has_no_filling_is_refused(holes: tuple[tuple[int, int], ...]) -> None:
    model = DesignModel(holed(miura, 8, holes))
    (strip,) = hole_strips(model.pattern)
    with pytest.raises(InputError, match=rf"strip of 12 facets .* from facet {strip[0]}, cannot be kept closed"):
        cylinder_loop.exact(model, "loop", strip)


# ---- equations that follow from others


def test_independent_rows() -> None:
    rng = np.random.default_rng(3)
    few = rng.standard_normal((5, 9))
    mixed = np.vstack([1e3 * few, rng.standard_normal((4, 5)) @ few, np.zeros((1, 9))])[rng.permutation(10)]
    kept = independent(mixed)
    assert len(kept) == 5
    assert np.linalg.matrix_rank(mixed[kept]) == 5
    assert (np.diff(kept) > 0).all()


def test_disks_have_no_redundant_equations() -> None:
    model, problem = exact(miura())
    assert len(redundant(Point(problem, model.seed_points.ravel(), problem.parameters()))) == 0
