"""Meshes that no sheet can follow are refused, with numbers and with advice that helps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from shapes import COURT, Mesh, block, box, joined, moved, rings, squares, triangles, write

import inverse
from inverse.errors import InputError
from inverse.formulation.formulate import formulate
from inverse.surfaces.mesh import MeshTarget
from inverse.surfaces.sheet import borders_of, check_sheet, hole_loops

PLATE = squares(block(8, 8), 1.0)
FIN = PLATE[0][[1, 10, 10]] + [[0, 0, 0], [0, 0, 0], [0, 0, 3]], [(0, 1, 2)]


def ball(radius: float = 2.0, count: int = 16) -> Mesh:
    """A sphere of rings, closed at both poles."""
    angle = np.pi * np.arange(1, count) / count
    upper, faces = rings(list(np.sin(angle)), 2 * count)
    points = radius * upper
    points[0, 2] = radius
    points[1:, 2] = radius * np.repeat(np.cos(angle), 2 * count)
    last, k = 1 + (count - 2) * 2 * count, np.arange(2 * count)
    caps = [(len(points), last + b, last + a) for a, b in zip(k, np.roll(k, -1), strict=True)]
    return np.vstack([points, [0, 0, -radius]]), [*faces, *caps]


def target(mesh: Mesh) -> MeshTarget:
    return MeshTarget(mesh[0], triangles(mesh[1]))


def specification(path: Path, **more: object) -> dict[str, object]:
    return {"name": "sheet", "pattern": {"size": [6, 6]}, "target": {"mesh": path}, **more}


@pytest.mark.parametrize(
    ("mesh", "match"),
    [
        (box([4, 3, 2]), "closed: it has no border"),
        (ball(), "closed: it has no border"),
        (joined(PLATE, moved(PLATE, [38, 0, 0])), "2 parts 30 apart, of 50, 50 % of its area"),
        (joined(PLATE, moved(PLATE, [8.9, 0, 0])), "2 parts 0.9 apart"),
        (squares(block(8, 8, (0, 4, 4, 8), (4, 8, 0, 4))), "2 parts that only touch"),
        (joined(PLATE, moved(ball(), [4, 4, 5])), "2 parts 3 apart, of 56.2, 43.8 %"),
        (squares(COURT), r"a hole around \(6, 5, 0\), 5 from corner to corner"),
        (joined(PLATE, FIN), "3 facets .* of 1 edges"),
    ],
    ids=["box", "ball", "far", "near", "corner", "bodies", "court", "fin"],
)  # fmt: skip
def test_refusals(mesh: Mesh, match: str) -> None:
    with pytest.raises(InputError, match=match) as caught:
        check_sheet(target(mesh), 0.7)
    assert caught.value.hint


def test_what_a_sheet_can_follow_passes() -> None:
    for mesh in (PLATE, box([4, 3, 2], bottom=False), joined(PLATE, moved(PLATE, [8.1, 0, 0]))):
        check_sheet(target(mesh), 1.0)
    check_sheet(target(squares(COURT)), 1.0, may_have_holes=True)
    check_sheet(target(squares(block(9, 9, (4, 5, 4, 5)))), 1.0)  # smaller than a facet


def test_parts_and_borders() -> None:
    two = joined(squares(COURT), moved(PLATE, [20, 0, 0]))
    borders = borders_of(target(two).triangles()[1])
    assert borders.part.max() == 1
    assert borders.loop.max() == 2
    vertices = target(two).triangles()[0]
    (hole,) = hole_loops(vertices, borders)
    assert np.ptp(vertices[borders.edges[borders.loop == hole]].reshape(-1, 3), axis=0) == pytest.approx([4, 3, 0])


def test_a_refusal_has_its_place_and_nothing_is_solved(tmp_path: Path) -> None:
    path = tmp_path / "sheet.yaml"
    write(tmp_path / "box.obj", box([4, 3, 2]))
    path.write_text("name: sheet\npattern: {size: [6, 6]}\ntarget: {mesh: box.obj}\n")
    with pytest.raises(InputError, match="closed") as caught:
        inverse.solve(path)
    assert caught.value.where == f"{path}:3:16"


def test_the_advice_for_closed_meshes_helps(tmp_path: Path) -> None:
    """Without its bottom a box is a sheet, and a ball is a tube around an axis."""
    opened = write(tmp_path / "open.obj", box([4, 3, 1], bottom=False))
    assert formulate(inverse.load(specification(opened))).goal.target.frame.extent == pytest.approx((4, 3))
    axis = {"polyline": [[0, 0, -1.5], [0, 0, 1.5]]}
    around = {"axis": axis, "mesh": write(tmp_path / "ball.obj", ball())}
    result = inverse.solve({"name": "ball", "pattern": {"kind": "tube", "size": [4, 6]}, "target": around})
    assert result.certified
    assert result.converged


def test_the_advice_for_parts_helps(tmp_path: Path) -> None:
    apart = write(tmp_path / "apart.obj", joined(PLATE, moved(PLATE, [12, 0, 0])))
    with pytest.raises(InputError, match="2 parts 4 apart"):
        formulate(inverse.load(specification(apart)))
    bridge = write(tmp_path / "bridge.obj", squares(block(20, 8, (8, 12, 0, 2), (8, 12, 6, 8)), 1.0))
    alone = write(tmp_path / "alone.obj", PLATE)
    for path in (bridge, alone):
        formulate(inverse.load(specification(path, pattern={"size": [20, 8]})))


def test_patterns_without_a_hole_refuse_one(tmp_path: Path) -> None:
    path = write(tmp_path / "court.obj", squares(COURT))
    with pytest.raises(InputError, match="this pattern has none"):
        formulate(inverse.load(specification(path, pattern={"size": [12, 12], "trim": "none"})))
    formulate(inverse.load(specification(path, pattern={"size": [12, 12]})))
