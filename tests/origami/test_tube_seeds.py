"""Tube seeds of any closed section fold without a gap and are certified, unless the section crosses itself."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from designs import assert_close
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from inverse.certify import check_frame
from inverse.crossing import crossing_facets
from inverse.errors import InputError
from inverse.files import fold_file
from inverse.files.fold_format import frame_of
from inverse.origami import folding, geometry, seeds
from inverse.origami.pattern import CFL, Design

SECTIONS = seeds.NAMED_SECTIONS


def assert_certified(design: Design) -> None:
    certificate = check_frame(frame_of(fold_file.document(design)))
    assert certificate.certified, [check.sentence for check in certificate.checks.values() if not check.passed]
    gap = folding.fold(design, np.linspace(0, np.pi, 17)).gap.max()
    assert gap < 1e-12 * geometry.diagonal(design.vertices_coords)


def outline(section: seeds.Section) -> list[tuple[int, int]]:
    """Every lattice point that a section of whole lengths passes, in units of its two directions."""
    place, found = (0, 0), []
    for n, a, length in section:
        # n == a is a step along the one direction, n == -a along the other.
        step = (n, 0) if n == a else (0, n)
        for _ in range(int(length)):
            place = (place[0] + step[0], place[1] + step[1])
            found.append(place)
    return found


lengths = st.integers(-3, 3).filter(bool)


@st.composite
def closed_sections(draw: Callable) -> list[tuple[int, int, float]]:
    """Steps along two directions in turn, of whole signed lengths that sum to zero in both."""
    half = draw(st.integers(2, 6))
    sides = [draw(st.lists(lengths, min_size=half - 1, max_size=half - 1)) for _ in range(2)]
    first, second = ([*side, -sum(side)] for side in sides)
    assume(first[-1] != 0)
    assume(second[-1] != 0)
    steps = []
    for x, y in zip(first, second, strict=True):
        steps += [(int(np.sign(x)), int(np.sign(x)), abs(x)), (int(np.sign(y)), -int(np.sign(y)), abs(y))]
    return steps


@settings(max_examples=60, deadline=None)
@given(
    closed_sections(),
    st.lists(st.floats(0.2, 3), min_size=2, max_size=4),
    st.floats(0.2, 0.8),
    st.floats(50, 80),
)
def test_any_section_is_certified_or_crosses_itself(
    section: list[tuple[int, int, float]], rows: list[float], fold_state: float, degrees: float
) -> None:
    points = outline(section)
    options = {"fold_state": fold_state, "sector_angle": np.radians(degrees), "lengths": rows}
    if len(set(points)) == len(points):
        assert_certified(seeds.tube(section, len(rows), **options))
    else:
        with pytest.raises(InputError, match=r"crosses itself: steps \d+ and \d+ meet"):
            seeds.tube(section, len(rows), **options)


@pytest.mark.parametrize("fold_state", [0.1, 0.55, 0.9])
@pytest.mark.parametrize("name", SECTIONS)
def test_built_in_sections_are_certified(name: str, fold_state: float) -> None:
    design = seeds.tube(SECTIONS[name], 3, fold_state=fold_state, sector_angle=np.radians(70), lengths=[1, 0.5, 2])
    assert_certified(design)
    assert len(crossing_facets(design.vertices_coords, design.pattern.faces_vertices)) == 0
    assert design.pattern.topology == "cylinder"


@pytest.mark.parametrize("name", SECTIONS)
def test_sections_turn_once_and_are_as_wide_as_deep(name: str) -> None:
    section = SECTIONS[name]
    x, y = np.array(outline(section)).T
    assert np.ptp(x) == np.ptp(y)
    turns = [p[0] * q[1] - p[1] * q[0] for p, q in zip(section, [*section[1:], section[0]], strict=True)]
    assert abs(sum(np.sign(turns))) == 4  # corners of a rectilinear outline, reflex ones counted negatively


def test_two_corners_that_touch_are_a_crossing() -> None:
    """Two squares that share a corner: the tube would touch itself along a line."""
    steps = [(1, 1, 1), (1, -1, 1), (1, 1, 1), (1, -1, 1), (-1, -1, 1), (-1, 1, 1), (-1, -1, 1), (-1, 1, 1)]
    with pytest.raises(InputError, match="crosses itself"):
        seeds.tube(steps, 2)


def test_a_plus_is_symmetric_and_an_l_is_not() -> None:
    """The facet centroids of a plus lie at two distances from its middle, those of the L at several."""
    for name, count in (("plus", 2), ("L", 3)):
        # Where the two directions of a section are square, its outline is the one drawn on paper.
        design = seeds.tube(seeds.NAMED_SECTIONS[name], 1, sector_angle=np.radians(70), fold_state=_square(70))
        centroids = geometry.facet_centroids(design.pattern, design.vertices_coords)[:, :2]
        radii = np.linalg.norm(centroids - centroids.mean(axis=0), axis=1)
        assert len(np.unique(radii.round(9))) >= count
        if name == "plus":
            assert len(np.unique(radii.round(9))) == count
            assert (np.array(seeds.section_types(seeds.NAMED_SECTIONS[name])) == CFL).sum() == 6


def _square(degrees: float) -> float:
    cosine = np.cos(np.radians(degrees))
    state = float((np.sqrt(0.5) - cosine) / (1 - cosine))
    assert_close(cosine + state * (1 - cosine), np.sqrt(0.5), 1e-15)
    return state
