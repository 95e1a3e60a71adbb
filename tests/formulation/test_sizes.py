"""Seeds that cannot become their target are refused before solving, and the advice helps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import inverse
from inverse.errors import InputError
from inverse.formulation.formulate import formulate

LARGE = {"height": "100 - 0.0001*x^2", "domain": [[0, 2000], [0, 1500]]}
SMALL = {"height": "1 - 0.1*x^2", "domain": [[-1, 1], [-1, 1]]}


def asked(target: dict[str, Any], pattern: dict[str, Any], **constraints: Any) -> dict[str, Any]:
    return {"name": "s", "pattern": pattern, "target": target, "constraints": constraints}


@pytest.mark.parametrize(
    ("specification", "key", "match"),
    [
        (asked(LARGE, {"size": [6, 6], "start_size": [1, 1]}), "pattern.start_size", "too small .* 2.53e.03"),
        (asked(SMALL, {"size": [6, 6], "start_size": [400, 400]}), "pattern.start_size", "too large .* only 2.8"),
        (asked(SMALL, {"size": [6, 6]}, edge_length=[1e-3, 1e-2]), "constraints.edge_length", "too small"),
        (asked(SMALL, {"size": [6, 6]}, edge_length=[50, 60]), "constraints.edge_length", "too large"),
    ],
)
def test_sizes(specification: dict[str, Any], key: str, match: str) -> None:
    with pytest.raises(InputError, match=match) as caught:
        inverse.solve(specification)
    assert str(caught.value.where).endswith(key)
    specification["pattern"].pop("start_size", None)  # what the advice says
    formulate(inverse.load(specification | {"constraints": {}}))


@pytest.mark.parametrize(("factor", "by", "match"), [(1, 990.0, "lies 9.* beside"), (1e-3, 0.0, "too small")])
def test_files_that_keep_their_position(factor: float, by: float, match: str, tmp_path: Path) -> None:
    seed = inverse.seeds.grid((4, 4))
    points = seed.vertices_coords
    placed = (points - points.mean(axis=0)) * factor * 2 / np.ptp(points[:, 0]) + [by, 0, 0]
    inverse.write(seed.moved_to(placed), tmp_path / "seed.fold")
    pattern: dict[str, Any] = {"kind": "file", "file": tmp_path / "seed.fold", "keep_position": True}
    with pytest.raises(InputError, match=match) as caught:
        formulate(inverse.load(asked(SMALL, pattern)))
    assert str(caught.value.where).endswith("pattern.keep_position")
    formulate(inverse.load(asked(SMALL, pattern | {"keep_position": False})))


def test_seeds_that_can_grow_are_left_alone() -> None:
    formulate(inverse.load(asked(SMALL, {"size": [6, 6], "start_size": [1, 1]})))
