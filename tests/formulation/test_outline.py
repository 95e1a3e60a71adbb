"""Grids over targets whose plan is no rectangle: lines along its borders, facets within it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapes import COURT, CROSS, ELL, YOU, block, bow, covered, rings, squares, triangles, write

import inverse
from inverse.errors import InputError
from inverse.formulation.formulate import Formulation, formulate
from inverse.formulation.outline import Outline
from inverse.surfaces.mesh import MeshTarget

OUTLINES = {"ell": ELL, "cross": CROSS, "you": YOU, "court": COURT}


def formulated(path: Path, **pattern: Any) -> Formulation:
    asked = {"name": "o", "pattern": {"size": [16, 16], **pattern}, "target": {"mesh": path}}
    return formulate(inverse.load(asked))


def plan_of(formulation: Formulation) -> tuple[float, float]:
    """How much of the target's plan the seed covers, and how much of it lies beside."""
    design = formulation.goal.model.design(formulation.goal.seed_variables)
    mesh = design.vertices_coords, triangles(design.pattern.faces_vertices)
    return covered(mesh, formulation.goal.target.triangles(), 50)


@pytest.mark.parametrize("pattern", [{}, {"turn": 90}, {"u_lines": "CFL"}, {"sector_angle": 75, "size": [12, 20]}])
@pytest.mark.parametrize("name", OUTLINES)
def test_seeds_cover_the_outline_and_little_else(name: str, pattern: dict[str, Any], tmp_path: Path) -> None:
    path = write(tmp_path / "a.obj", squares(OUTLINES[name], height=bow))
    within, beside = plan_of(formulated(path, **pattern))
    assert within > 0.88
    assert beside < 0.12
    _, whole = plan_of(formulated(path, trim="none")) if name != "court" else (1.0, 1.0)
    assert whole > 2 * beside


def test_lines_run_along_the_borders() -> None:
    vertices, faces = squares(ELL)
    outline = Outline.of(MeshTarget(vertices, triangles(faces)), always=False)
    assert outline is not None
    assert sorted(outline.frame.extent) == pytest.approx([10, 12])
    for turn in (0, 90):
        for size in ((16, 16), (11, 7), (5, 5)):
            for k, strips in enumerate(outline.strips(size, turn)):
                assert len(strips) == size[k]
                assert strips.sum() == pytest.approx(1)
                # The inner corner is at 5 of 12 and 4 of 10, from one end or the other.
                lines = np.cumsum(strips)
                assert min(np.abs(lines - share).min() for share in (5 / 12, 7 / 12, 0.4, 0.6)) < 1e-9
                assert strips.max() < 1.7 * strips.min()


def test_a_cross_is_laid_along_its_arms() -> None:
    """The smallest rectangle around it is turned."""
    vertices, faces = squares(CROSS)
    target = MeshTarget(vertices, triangles(faces))
    outline = Outline.of(target, always=False)
    assert outline is not None
    assert np.abs(outline.frame.axes).max(axis=1) == pytest.approx(1, abs=1e-3)
    assert np.prod(target.frame.extent) < np.prod(outline.frame.extent)


def test_full_rectangles_are_left_whole(tmp_path: Path) -> None:
    path = write(tmp_path / "a.obj", squares(block(12, 10), height=bow))
    assert formulated(path).goal.model.pattern.grid == (16, 16)
    most = write(tmp_path / "b.obj", squares(block(12, 10, (9, 12, 8, 10)), height=bow))
    assert formulated(most).goal.model.pattern.grid == (16, 16)
    assert formulated(most, trim="outline").goal.model.pattern.grid is None


def test_round_targets_are_trimmed(tmp_path: Path) -> None:
    path = write(tmp_path / "a.obj", rings(list(np.linspace(0.5, 5, 10)), 40))
    facets = len(formulated(path).goal.model.pattern.faces_vertices)
    assert facets / 256 == pytest.approx(np.pi / 4, abs=0.05)


def test_what_is_too_narrow_is_refused_and_more_facets_help(tmp_path: Path) -> None:
    mask = block(24, 24, (8, 24, 3, 24))
    path = write(tmp_path / "a.obj", squares(mask))
    with pytest.raises(InputError, match=r"too narrow somewhere .* would hang on others") as caught:
        formulated(path, size=[8, 8])
    assert str(caught.value.where).endswith("pattern")
    formulated(path, size=[24, 24])


def test_a_court_keeps_the_sides_of_its_grid(tmp_path: Path) -> None:
    model = formulated(write(tmp_path / "a.obj", squares(COURT, height=bow))).goal.model
    assert model.pattern.grid == (16, 16)
    design = model.design(model.seed_points.ravel())
    assert design.pattern.n_holes == 1
    assert len(design.pattern.faces_vertices) == 256 - len(model.left_out) < 256
    assert len(model.whole(model.seed_points.ravel()).pattern.faces_vertices) == 256


def test_anchors_of_a_trimmed_grid_name_vertices(tmp_path: Path) -> None:
    path = write(tmp_path / "a.obj", squares(ELL, height=bow))
    anchors = [{"side": "u0", "to": {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}}]
    asked = {"name": "o", "pattern": {"size": [8, 8]}, "target": {"mesh": path}}
    with pytest.raises(InputError, match="'u0' names no side: the grid is trimmed") as caught:
        formulate(inverse.load(asked | {"constraints": {"anchors": anchors}}))
    assert str(caught.value.where).endswith("anchors.0.side")
    by_number = [{"vertices": [0, 1], "to": anchors[0]["to"]}]
    formulate(inverse.load(asked | {"constraints": {"anchors": by_number}}))
    whole = {"size": [8, 8], "trim": "none"}
    formulate(inverse.load(asked | {"pattern": whole, "constraints": {"anchors": anchors}}))


def test_anchors_within_a_hole_are_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "a.obj", squares(COURT, height=bow))
    middle = {"vertices": [8 * 17 + 8], "to": {"point": [6, 5, 1]}}
    asked = {"name": "o", "pattern": {"size": [16, 16]}, "target": {"mesh": path}}
    with pytest.raises(InputError, match="vertex 144 lies over a hole"):
        formulate(inverse.load(asked | {"constraints": {"anchors": [middle]}}))
