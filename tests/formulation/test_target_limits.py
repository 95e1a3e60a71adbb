"""Targets that no arithmetic can hold are refused with their place, before anything is made of them."""

from __future__ import annotations

from typing import Any

import pytest

import inverse
from inverse.errors import InputError
from inverse.formulation.formulate import build_target

SIDES = [[[0, 0, 0], [0, 4, 0]], [[4, 0, 0], [4, 4, 0]]]


@pytest.mark.parametrize(
    ("target", "match"),
    [
        ({"height": "1e300*x*x", "domain": [[-1, 1], [-1, 1]]}, "beyond what a number can hold"),
        ({"height": "0", "domain": [[-1e11, 1e11], [-1, 1]]}, "the target is a line"),
        ({"height": "x*y", "domain": [[0, 1e-13], [0, 1e-13]]}, "at least 1e-12 is needed"),
        ({"height": "0", "domain": [[1e11, 1e11 + 10], [0, 10]]}, "10 wide, but 1e.11 away from the origin"),
        ({"between": SIDES, "rise": 1e11, "profile": "catenary"}, "the target is a line"),
        ({"axis": {"polyline": [[0, 0, 0], [0, 0, 1e11]]}, "radius": 1}, "cannot be made of facets"),
        ({"axis": {"spline": [[1e11, 0, 0], [1e11, 0, 9]]}, "radius": 1}, "away from the origin"),
    ],
)
def test_targets_beyond_all_measure(target: dict[str, Any], match: str) -> None:
    pattern = {"kind": "tube", "size": [6, 4]} if "axis" in target else {"size": [4, 4]}
    with pytest.raises(InputError, match=match) as caught:
        build_target(inverse.load({"name": "d", "pattern": pattern, "target": target}))
    assert str(caught.value.where).split(".")[0] == "specification:target"
