"""`inverse solve --show seed`: the plan before solving, its numbers and its words."""

from __future__ import annotations

import io
import json
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from designs import holed
from PIL import Image
from ruamel.yaml import YAML

import inverse
from inverse.cli import commands
from inverse.pictures.plan import Line, Word
from inverse.showing import ANCHORS, SIDES, shown
from inverse.spec import Loaded, load

COURT = """\
name: court
pattern: {size: [4, 6]}
target: {height: "1 - 0.02*x^2 - 0.02*y^2", domain: [[-3, 3], [-2, 2]]}
constraints:
  keep_out: [{plane: {point: [0, 1.9, 0], normal: [0, -1, 0]}}]
  anchors:
    - {side: u0, every: 2, to: {plane: {point: [-3, 0, 0], normal: [1, 0, 0]}}}
    - {side: v0, every: 2, to: {polyline: [[-3, -2, 0.7], [3, -2, 0.7]]}}
    - {vertices: [17], to: {point: [0, 0, 1]}}
    - {vertices: [34], to: {circle: {center: [3, 2, 0.7], normal: [0, 0, 1], radius: 0.5}}}
"""
TUBE = """\
name: mast
pattern: {kind: tube, size: [4, 6]}
target: {axis: {polyline: [[0, 0, 0], [0, 0, 4]]}, radius: 1}
constraints: {anchors: [{side: v0, to: {circle: {center: [0, 0, 0], normal: [0, 0, 1], radius: 1}}}]}
"""
TABLE = [
    "side u0: vertices 0, 1, ... 6 (step 1)",
    "side u1: vertices 28, 29, ... 34 (step 1)",
    "side v0: vertices 0, 7, 14, 21, 28",
    "side v1: vertices 6, 13, 20, 27, 34",
    "anchor 0: u0 on a plane, holds 0, 2, 4, 6",
    "anchor 1: v0 on a polyline, holds 0, 14, 28",
    "anchor 2: vertices on a point, holds 17",
    "anchor 3: vertices on a circle, holds 34",
    "walls: 1, behind which no vertex may be",
]


def _loaded(text: str) -> Loaded:
    return load(YAML(typ="safe").load(text))


def file(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "task.yaml"
    path.write_text(text)
    return path


def test_the_command_writes_and_tells_and_does_not_solve(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    assert commands.run(["solve", str(file(tmp_path, COURT)), "--show", "seed", "-o", str(out)]) == 0
    told = capsys.readouterr()
    assert told.out.splitlines() == [*TABLE, f"wrote {out / 'seed.svg'}", f"wrote {out / 'seed.png'}"]
    assert told.err == "Vertex 0, which several anchors name, is held where their places meet.\n"
    assert sorted(path.name for path in out.iterdir()) == ["seed.png", "seed.svg"]
    svg = ET.parse(out / "seed.svg").getroot()
    with Image.open(out / "seed.png") as image:
        assert image.size == (int(svg.get("width", 0)), int(svg.get("height", 0)))
    assert commands.run(["solve", str(file(tmp_path, COURT)), "--show", "seed", "-o", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["seed"] == TABLE


def test_every_vertex_side_and_corner_has_its_name() -> None:
    drawing = shown(_loaded(COURT)).drawing
    words = {mark.text for mark in drawing.marks if isinstance(mark, Word)}
    assert {"u0", "u1", "v0", "v1", "0 = (0, 0)", "6 = (0, 6)", "28 = (4, 0)", "34 = (4, 6)"} <= words
    assert {str(v) for v in range(35)} - {"0", "6", "28", "34"} <= words
    assert {"court", "1 m"} <= words or {"court", "2 m"} <= words
    lines = [mark.colour for mark in drawing.marks if isinstance(mark, Line)]
    assert set(SIDES.values()) <= set(lines)
    assert set(ANCHORS[:4]) <= set(lines)


def test_the_same_task_gives_the_same_bytes() -> None:
    first, second = shown(_loaded(COURT)).drawing, shown(_loaded(COURT)).drawing
    assert first.svg() == second.svg()
    assert first.png() == second.png()


def test_places_are_drawn_where_they_are() -> None:
    """The wall x = -3 and the seed's side u0 are one line, and the target reaches from there to x = 3."""
    drawing = shown(_loaded(COURT)).drawing
    lines = [mark for mark in drawing.marks if isinstance(mark, Line)]
    side = next(mark for mark in lines if mark.colour == SIDES["u0"])
    wall = next(mark for mark in lines if mark.colour == ANCHORS[0])
    target = next(mark for mark in lines if mark.fill)
    np.testing.assert_allclose(wall.points[:, 0], side.points[:, 0].mean(), atol=1.0)
    np.testing.assert_allclose(target.points[:, 0].min(), wall.points[0, 0], atol=1.0)
    eave = next(mark for mark in lines if mark.colour == ANCHORS[1] and mark.dash)
    np.testing.assert_allclose(np.ptp(eave.points[:, 0]), np.ptp(target.points[:, 0]), atol=0.01)


def test_many_vertices_are_thinned() -> None:
    text = COURT.replace("size: [4, 6]", "size: [40, 60]").split("constraints:")[0]
    drawing = shown(_loaded(text)).drawing
    words = {mark.text for mark in drawing.marks if isinstance(mark, Word)}
    rim = {*range(61), *range(2440, 2501), *range(0, 2441, 61), *range(60, 2501, 61)}
    numbers = {int(word) for word in words if word.isdigit()}
    assert numbers <= rim
    assert len(numbers) > 0.4 * len(rim)


def test_tubes_and_patterns_of_files_are_drawn_too(tmp_path: Path) -> None:
    mast = shown(_loaded(TUBE))
    assert mast.table == [
        "side v0: vertices 0, 7, 14, 21",
        "side v1: vertices 6, 13, 20, 27",
        "anchor 0: v0 on a circle, holds 0, 7, 14, 21",
    ]
    inverse.write(holed(), tmp_path / "own.fold")
    (tmp_path / "own.yaml").write_text(
        'name: own\npattern: {kind: file, file: own.fold}\ntarget: {height: "0*x", domain: [[-3, 3], [-2, 2]]}\n'
    )
    own = shown(load(tmp_path / "own.yaml"))
    assert own.table[0].startswith("no sides; ")
    for found in (mast, own):
        assert Image.open(io.BytesIO(found.drawing.png())).size[0] == found.drawing.width


def test_what_solving_would_refuse_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = file(tmp_path, COURT.replace("vertices: [34]", "vertices: [35]"))
    assert commands.run(["solve", str(path), "--show", "seed", "-o", str(tmp_path / "out")]) == 2
    assert "vertex 35 is not there" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
