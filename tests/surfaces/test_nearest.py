"""Trees, edges and merged vertices of targets, against slow ways to the same."""

from __future__ import annotations

import pickle
import subprocess
import sys

import igl
import numpy as np
import pytest

from inverse.surfaces.axis import arc
from inverse.surfaces.edges import edges_of
from inverse.surfaces.mesh import without_repetitions
from inverse.surfaces.parametric import BetweenTarget, HeightTarget
from inverse.surfaces.tube import TubeTarget


def soup(seed: int, count: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of few places, named by more vertices than there are."""
    random = np.random.default_rng(seed)
    places = random.normal(size=(20, 3))
    return np.vstack([places, places[::-1], places]), random.integers(0, 60, (count, 3))


@pytest.mark.parametrize("seed", range(5))
def test_edges_are_those_of_sorted_pairs(seed: int) -> None:
    _, triangles = soup(seed)
    pairs = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    _, number, count = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
    edge, counts = edges_of(triangles)
    np.testing.assert_array_equal(edge.ravel(), number.ravel())
    np.testing.assert_array_equal(counts, count)
    assert [len(k) for k in edges_of(np.empty((0, 3), np.int64))] == [0, 0]


@pytest.mark.parametrize("seed", range(5))
def test_repeated_vertices_are_merged_onto_the_first(seed: int) -> None:
    vertices, triangles = soup(seed)
    used = vertices[triangles.ravel()]
    size = np.linalg.norm(np.ptp(used, axis=0))
    rows = np.round((used - used.mean(axis=0)) / (1e-9 * size))
    _, first, merged = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    found, cells, normals = without_repetitions(vertices, triangles)
    np.testing.assert_array_equal(found, used[first])
    wanted = merged.reshape(-1, 3)
    has_area = np.array([len(set(row)) == 3 for row in wanted.tolist()])
    np.testing.assert_array_equal(cells, wanted[has_area])
    a, b, c = found[cells].transpose(1, 0, 2)
    np.testing.assert_allclose(np.einsum("ij,ij->i", normals, b - a), 0, atol=1e-14)
    np.testing.assert_allclose(np.einsum("ij,ij->i", normals, c - a), 0, atol=1e-14)


def test_a_tree_answers_as_a_search_and_is_not_pickled() -> None:
    target = HeightTarget("sqrt(1 - x^2 - y^2)", [[-0.6, 0.6], [-0.6, 0.6]])
    points = np.random.default_rng(0).normal(size=(50, 3))
    wanted = igl.point_mesh_squared_distance(points, *target.triangles())
    for nearest in (target.nearest, pickle.loads(pickle.dumps(target.nearest))):
        for found, one in zip(nearest.find(points), wanted, strict=True):
            np.testing.assert_array_equal(found, np.asarray(one).reshape(found.shape))
    assert target.nearest is target.nearest


@pytest.mark.parametrize(
    "target",
    [
        HeightTarget("sqrt(1 - x^2 - y^2)", [[-0.6, 0.6], [-0.6, 0.6]]),
        HeightTarget("abs(x)*sin(3*y)", [[-1, 1], [-1, 1]]),
        BetweenTarget([np.array([[0, 0, 0], [0, 6, 0]]), np.array([[4, 0.5, 0], [4.5, 5, 0]])], 1.0, "arc"),
    ],
)
def test_distances_are_those_from_closest_points(target: HeightTarget) -> None:
    vertices, _ = target.triangles()
    random = np.random.default_rng(1)
    for spread in (1e-6, 0.1, 2.0):
        points = vertices[::97] + spread * random.normal(size=vertices[::97].shape)
        wanted = np.linalg.norm(points - target.closest(points).feet, axis=1)
        np.testing.assert_allclose(target.distances(points), wanted, rtol=1e-9, atol=1e-13)


def test_gaps_along_a_tube_are_those_from_its_circles() -> None:
    tube = TubeTarget(arc([0, 0, 0], [1, 0, 3], [0, 0, 6]), np.array([[0, 1.0], [1, 0.6]]))
    points = np.random.default_rng(2).normal(scale=2, size=(30, 3))
    t = np.linspace(0, 1, 17)
    wanted = [np.linalg.norm(points - tube._on_circle(points, np.full(30, k)), axis=1) for k in t]
    np.testing.assert_allclose(tube._gaps(points, t), wanted, rtol=1e-12)


def test_a_script_that_ends_with_a_tree_says_nothing() -> None:
    """The library of the trees complains of those that are alive when Python ends."""
    script = (
        "import numpy as np; from inverse.surfaces.nearest import Nearest; "
        "one = Nearest(np.eye(3), np.array([[0, 1, 2]])); one.find(np.ones((1, 3)))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("", "")
