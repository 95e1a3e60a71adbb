"""The first of many states with crossing facets is the one that exact predicates find state by state."""

from __future__ import annotations

import designs
import numpy as np
import pytest
from certify_cases import SEEDS, document, four_facets, generic, hinged, motion_of

from inverse.crossing import apart, crossing_facets, first_crossing
from inverse.crossing import states as states_module
from inverse.crossing.neighbours import neighbours
from inverse.files import fold_file

HALF = np.radians(np.r_[0.005, np.linspace(1, 89, 45), 89.995])  # of the folding amount


def _faces(faces):
    return tuple(map(tuple, faces))


def _expected(states, faces):
    """One after the other, every facet against every other."""
    for k, points in enumerate(states):
        if len(pairs := crossing_facets(points, faces)):
            return k, pairs.tolist()
    return None


def _found(states, faces):
    found = first_crossing(states, faces)
    return None if found is None else (found[0], found[1].tolist())


def _nothing_is_missed(states, faces):
    """Every crossing of two facets is among the doubtful ones, in every state."""
    known, faces = neighbours(_faces(faces)), _faces(faces)
    state, pairs = apart.doubtful_pairs(states, states_module._corners(faces), known)
    hinges = apart.doubtful_hinges(states, known)
    for k, points in enumerate(states):
        doubtful = {tuple(sorted(pair)) for pair in pairs[state == k].tolist()}
        doubtful |= {tuple(pair) for pair in known.at_edge[hinges[k]].tolist()}
        doubtful |= {tuple(pair) for pair in [*known.same_way.tolist(), *known.overlapping.tolist()]}
        at_vertex = {tuple(pair) for pair in known.at_vertex.tolist()}
        crossing = {tuple(pair) for pair in crossing_facets(points, faces).tolist()}
        assert crossing - at_vertex <= doubtful, k


@pytest.mark.parametrize("name", SEEDS)
def test_motions_of_seeds(name):
    motion = motion_of(document(name))
    states = motion.vertices(HALF)
    assert _found(states, motion.mesh.facets) == _expected(states, motion.mesh.facets)
    _nothing_is_missed(states, motion.mesh.facets)


@pytest.mark.parametrize("seed", range(6))
def test_motions_that_run_into_themselves(seed):
    # Strips that roll up, with facets as unequal as they come.
    rng = np.random.default_rng(seed)
    count = int(rng.integers(5, 30))
    motion = motion_of(hinged(rng.uniform(-0.2, 1.2, count - 1), rng.uniform(0.2, 2, count)))
    states = motion.vertices(HALF[len(HALF) // 2 :])
    _nothing_is_missed(states, motion.mesh.facets)
    assert _found(states, motion.mesh.facets) == _expected(states, motion.mesh.facets)


@pytest.mark.parametrize("make", [designs.miura, designs.eggbox])
@pytest.mark.parametrize("noise", [0.0, 0.03, 0.3, 1.0])
def test_crumpled_meshes_of_polygons(make, noise):
    # Facets that are not even planar, some of them in each other.
    design = designs.polygonal(make)
    rng = np.random.default_rng(3)
    states = design.vertices_coords + noise * rng.normal(size=(7, *design.vertices_coords.shape))
    _nothing_is_missed(states, design.pattern.faces_vertices)
    assert _found(states, design.pattern.faces_vertices) == _expected(states, design.pattern.faces_vertices)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("far", [0.0, 1e6])
def test_triangles_anywhere(seed, far):
    # Whole numbers: many touch in a vertex, an edge or a plane without having it in common.
    rng = np.random.default_rng(seed)
    count = 40
    corners = rng.integers(0, 9, (5, 2 * count, 3, 3)).astype(float)
    has_area = np.cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0]).any(axis=2)
    states = np.array([some[area][:count].reshape(-1, 3) for some, area in zip(corners, has_area, strict=True)]) + far
    faces = [[3 * k, 3 * k + 1, 3 * k + 2] for k in range(count)]
    _nothing_is_missed(states, faces)
    assert _found(states, faces) == _expected(states, faces)


@pytest.mark.parametrize("sides", [3, 4])
def test_the_state_that_crosses_is_found_among_others(sides):
    (sound, faces), (crossed, _) = four_facets(crossed=False, sides=sides), four_facets(crossed=True, sides=sides)
    for k in range(5):
        states = np.array([crossed if k == place else sound for place in range(4)])
        assert _found(states, faces) == _expected(states, faces)
        assert (_found(states, faces) is None) == (k == 4)


@pytest.mark.parametrize("gap", [1e-3, 1e-9, 1e-13, 0.0, -1e-13])
def test_facets_that_all_but_touch_are_told_exactly(gap):
    # A square beside and above another one; a margin may only make them doubtful.
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    for turned in range(5):
        above = np.vstack([square, square + np.array([0.3, 0.4, gap])])
        beside = np.vstack([square, square + np.array([1 + gap, 0.2, 0])])
        upright = np.vstack([square, square[:, [2, 0, 1]] * np.array([1, 0.5, 0.5]) + np.array([0.5, 0.2, gap])])
        states = np.array([above, beside, upright]) @ (designs.rotation(turned).T if turned else np.eye(3))
        for state in states:
            faces = [[0, 1, 2, 3], [4, 5, 6, 7]]
            assert _found(state[None], faces) == _expected([state], faces)


@pytest.mark.parametrize("angle", [1e-9, 1e-8, 1e-7, 1e-6, 1e-4, -1e-6, 3.0, 0.0])
@pytest.mark.parametrize("slender", [1.0, 1e-3, 1e-7])
def test_facets_folded_onto_each_other_are_told_as_before(angle, slender):
    flat = np.array([[0, 0, 0], [0, 1, 0], [slender, 0.9, 0], [slender, 0.2, 0]])
    turned = np.array([[0.7 * slender * np.cos(angle), y, 0.7 * slender * np.sin(angle)] for y in (0.3, 0.7)])
    points = np.vstack([flat, turned])
    for faces in ([[0, 1, 2, 3], [1, 0, 4, 5]], [[0, 1, 2, 3], [0, 1, 5, 4]], [[3, 0, 1, 2], [1, 0, 4, 5]]):
        _nothing_is_missed(points[None], faces)
        assert _found(points[None], faces) == _expected([points], faces)


def test_what_is_no_number_is_left_to_the_predicates():
    design = designs.miura()
    states = np.array([design.vertices_coords] * 2)
    states[1, 0, 0] = np.nan
    known = neighbours(_faces(design.pattern.faces_vertices))
    state, pairs = apart.doubtful_pairs(states, np.array(design.pattern.faces_vertices), known)
    with_it = {f for f, face in enumerate(design.pattern.faces_vertices) if 0 in face}
    assert {f for pair in pairs[state == 1].tolist() for f in pair} >= with_it
    assert apart.doubtful_hinges(states, known)[1][np.isin(known.at_edge, list(with_it)).any(axis=1)].all()


def test_much_is_filtered_out():
    design = generic(designs.miura(6, 6), 0.02)
    motion = motion_of(fold_file.document(design))
    states = motion.vertices(HALF)
    known = neighbours(motion.mesh.facets)
    state, _ = apart.doubtful_pairs(states, states_module._corners(motion.mesh.facets), known)
    assert len(state) < 0.01 * len(states) * len(motion.mesh.facets)
    assert not apart.doubtful_hinges(states, known).any()


def test_many_facets_are_looked_at_in_parts(monkeypatch):
    motion = motion_of(document("miura"))
    states = motion.vertices(HALF)
    states[20] = -states[20][::-1]
    whole, told = _found(states, motion.mesh.facets), []
    monkeypatch.setattr(states_module, "AT_ONCE", 3 * len(motion.mesh.facets))
    assert _found(states, motion.mesh.facets) == whole
    found = first_crossing(states, motion.mesh.facets, told.append)
    assert told == list(range(1, 1 + (len(states) if found is None else found[0])))
