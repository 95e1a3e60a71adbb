"""One closed strip of facets around each hole, checked by winding numbers in plan."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from designs import GENERAL, TUBES, assert_close, holed, miura, relabelled, tube, without

from inverse.origami import folding
from inverse.origami.geometry import facet_centroids
from inverse.origami.holes import hole_strips
from inverse.origami.pattern import Design, Pattern

DISKS = {
    "one": (holed, [(2, 2)]),
    "two": (GENERAL["two_holes"], [(2, 2), (4, 4)]),
    "three": (lambda: holed(miura, 8, ((2, 2), (5, 2), (4, 5))), [(2, 2), (5, 2), (4, 5)]),
}


def assert_closed_strip(pattern: Pattern, strip: tuple[int, ...]) -> None:
    assert len(set(strip)) == len(strip) > 2
    neighbours = {frozenset(pair) for pair in pattern.edges_faces[pattern.interior_edges].tolist()}
    assert all(frozenset(pair) in neighbours for pair in pairwise([*strip, strip[0]]))


def winding(design: Design, strip: tuple[int, ...], around: np.ndarray) -> float:
    """Turns of the strip around a point of the developed sheet."""
    flat = folding.flat_state(design, 0.0)
    x, y = (facet_centroids(design.pattern, flat)[[*strip, strip[0]]] - around)[:, :2].T
    return float(np.sum(np.mod(np.diff(np.arctan2(y, x)) + np.pi, 2 * np.pi) - np.pi) / (2 * np.pi))


@pytest.mark.parametrize("name", DISKS)
def test_each_strip_goes_once_around_its_hole_and_around_no_other(name: str) -> None:
    make, holes = DISKS[name]
    design = make()
    strips = hole_strips(design.pattern)
    assert len(strips) == design.pattern.n_holes == len(holes)
    flat = folding.flat_state(design, 0.0)
    loops = boundary_loops(design.pattern)
    centres = [flat[loop].mean(axis=0) for loop in sorted(loops, key=len)[:-1]]
    assert len(centres) == len(holes)
    for strip in strips:
        assert_closed_strip(design.pattern, strip)
        assert len(strip) == 8  # the ring of facets around one facet
    turns = np.array([[winding(design, strip, centre) for centre in centres] for strip in strips])
    assert_close(np.sort(np.abs(turns), axis=1)[:, :-1], 0, 1e-9)
    assert_close(np.abs(turns).sum(axis=0), 1, 1e-9)


def boundary_loops(pattern: Pattern) -> list[list[int]]:
    onward = dict(pattern.edges_vertices[pattern.edges_faces[:, 1] < 0].tolist())
    loops = []
    while onward:
        loop = [next(iter(onward))]
        while loop[-1] in onward:
            loop.append(onward.pop(loop[-1]))
        loops.append(loop[1:])
    return loops


@pytest.mark.parametrize("name", TUBES)
def test_the_strip_of_a_tube_is_one_row(name: str) -> None:
    design = TUBES[name]()
    k, rows = design.pattern.grid
    (strip,) = hole_strips(design.pattern)
    assert_closed_strip(design.pattern, strip)
    assert len(strip) == k
    assert len({f % rows for f in strip}) == 1


@pytest.mark.parametrize("seed", range(4))
def test_strips_do_not_depend_on_numbers(seed: int) -> None:
    design = DISKS["three"][0]()
    other, _, facet = relabelled(design, seed)
    strips = {frozenset(facet[list(strip)].tolist()) for strip in hole_strips(design.pattern)}
    assert {frozenset(strip) for strip in hole_strips(other.pattern)} == strips


def test_a_long_hole() -> None:
    """Three facets in a row are cut out; the shortest strip around them has twelve facets."""
    design = without(miura(5, 7), [2 * 7 + j for j in (2, 3, 4)])
    (strip,) = hole_strips(design.pattern)
    assert_closed_strip(design.pattern, strip)
    assert len(strip) == 12


def test_a_disk_has_no_strips() -> None:
    assert hole_strips(GENERAL["staircase"]().pattern) == ()
    assert len(hole_strips(tube(4, 1).pattern)) == 1
