"""What must hold to the letter, in lengths known by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import inverse
from inverse.brief import held
from inverse.formulation.formulate import formulate
from inverse.spec import PlaceKeys

POINTS = np.array([[0.0, 0, 3], [5, 0, 4], [1, 1, 0]])
PLACES: dict[str, tuple[dict[str, Any], list[float]]] = {
    "point": ({"point": [0, 0, 0]}, [3, 41**0.5, 2**0.5]),
    "plane": ({"plane": {"point": [0, 0, 1], "normal": [0, 0, -2]}}, [2, 3, 1]),
    "polyline": ({"polyline": [[0, 0, 0], [4, 0, 0], [4, 0, 4]]}, [3, 1, 1]),
    "polygon": ({"polygon": [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]]}, [3, 5, 1]),
    "circle": ({"circle": {"center": [0, 0, 0], "normal": [0, 0, 5], "radius": 2}}, [13**0.5, 5, 2 - 2**0.5]),
}


@pytest.mark.parametrize("name", PLACES)
def test_distances_from_every_kind_of_place(name: str) -> None:
    keys, wanted = PLACES[name]
    assert held.distances(POINTS, PlaceKeys.model_validate(keys)) == pytest.approx(wanted)


def requests(constraints: dict[str, Any], units: str = "m", target: float = 0.0) -> dict[str, Any]:
    """Of the placed seed of 4 x 4 facets over a square of 2 x 2 at a height."""
    loaded = inverse.load(
        {
            "name": "held",
            "units": units,
            "pattern": {"size": [4, 4]},
            "target": {"height": f"{target} + 0*x", "domain": [[-1, 1], [-1, 1]]},
            "constraints": constraints,
        }
    )
    formulation = formulate(loaded)
    seed = formulation.goal.model.seed
    return {one.name: one for one in held.requests(loaded, formulation, seed, [])}, seed.vertices_coords


@pytest.mark.parametrize("height", [0.0, 5000.0])
def test_a_keep_out_names_the_vertex_the_way_and_how_far(height: float) -> None:
    """Also where the task is solved near an origin of its own."""
    found, points = requests({"keep_out": [{"below": height + 0.5}, {"above": height + 3}]}, "mm", height)
    depth = 0.5 - points[:, 2].min() if height == 0 else None
    below, above = found["keep_out[0]"], found["keep_out[1]"]
    assert not below.met
    assert below.sentence.startswith(f"keep_out[0]: vertex {int(np.argmin(points[:, 2]))} is ")
    assert "mm too low" in below.sentence
    assert (below.reached == pytest.approx(depth)) if depth is not None else below.reached > 0.4
    assert above.met
    assert above.sentence == "keep_out[1]: held"


def test_a_plane_keeps_out_what_is_behind_it() -> None:
    found, points = requests({"keep_out": [{"plane": {"point": [0, 0, 0], "normal": [3, 0, 0]}}]})
    assert found["keep_out[0]"].reached == pytest.approx(-points[:, 0].min())
    assert "behind the plane" in found["keep_out[0]"].sentence


def test_an_anchor_names_the_vertex_that_is_farthest_from_its_place() -> None:
    found, points = requests(
        {"anchors": [{"vertices": [3, 7], "to": {"plane": {"point": [0, 0, 9], "normal": [0, 0, 1]}}}]}
    )
    one = found["anchors[0]"]
    worst = min((3, 7), key=lambda v: points[v, 2])
    assert one.reached == pytest.approx(9 - points[worst, 2])
    assert f"vertex {worst} is" in one.sentence
    assert not one.met


@pytest.mark.parametrize(("unit", "told"), [("1", "12.3%"), ("unit", "0.123"), ("mm", "0.123 mm")])
def test_lengths_are_told_in_the_unit_of_the_file(unit: str, told: str) -> None:
    assert held.length(0.123, unit) == told


def test_areas_and_places() -> None:
    assert held.length(2.5, "m", power=2) == "2.5 m2"
    assert held.length(2.5, "unit", power=2) == "2.5"
    assert held.place(np.array([1275.5, 340849.25, -1e-12])) == "(1275.5, 340849, 0)"


def test_a_limit_of_the_footprint() -> None:
    from inverse.origami import seeds

    design = seeds.grid((2, 2), unit="m")
    keys = {"state": "flat-folded", "measure": "width", "limit": 2.0}
    ok, much = (held._footprint(design, [keys | {"value": value}])[0] for value in (2.000001, 2.1))
    assert ok.met
    assert not much.met
    assert "the flat-folded width is 2.1 m, at most 2 m asked" in much.sentence
