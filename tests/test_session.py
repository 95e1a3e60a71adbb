"""A session: every design starts the next, and ends where a solve from the seed ends or better."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from designs import assert_close

import inverse
from inverse.errors import InputError
from inverse.origami import geometry
from inverse.session import Session
from inverse.solvers.newton import METHOD
from inverse.surfaces import Target
from inverse.surfaces.parametric import HeightTarget


def dome(height: float = 1.0, aside: float = 0.01, **keys: Any) -> dict[str, Any]:
    expression = f"{height:.9f}*sqrt(1.02 - (x - {aside:.9f})^2 - y^2)"
    return {
        "name": "dome",
        "pattern": {"size": [8, 8]},
        "target": {"height": expression, "domain": [[-0.6, 0.6], [-0.6, 0.6]]},
        **keys,
    }


TUBE = {
    "name": "tube",
    "pattern": {"kind": "tube", "size": [6, 4]},
    "target": {"axis": {"polyline": [[0, 0, 0], [0, 0, 3]]}, "radius": [[0, 1.0], [1, 0.9]]},
}
# Rounds of tangent planes end where the slope is a millionth of what it was, which is not quite the same place.
ROUNDS = 1e-5
VAULT = {
    "name": "vault",
    "pattern": {"size": [6, 6]},
    "target": {"between": [[[0, 0, 0], [6, 0, 0]], [[0, 5, 0], [6, 5, 0.4]]], "rise": 1.5},
    "constraints": {
        "anchors": [{"side": "u0", "every": 2, "to": {"polyline": [[-1, 0, 0], [3, 0, 0], [7, 0, 0]]}}],
    },
}


def ends_like_a_solve(update: inverse.Update, keys: dict[str, Any], within: float = 1e-6, **given: Any) -> None:
    """Certified and converged, and where a solve from the seed ends (to a share of the diagonal), or better."""
    result, cold = update.result, inverse.solve(keys, **given)
    assert result.certified
    assert result.converged
    assert_close(result.design.vertices_coords, update.design.vertices_coords, 0)
    objectives = [sum(one.objective.values()) for one in (result, cold)]
    if objectives[0] > (1 - 1e-6) * objectives[1]:
        size = geometry.diagonal(cold.design.vertices_coords)
        assert_close(update.design.vertices_coords, cold.design.vertices_coords, within * size)


def test_a_target_that_moves_is_followed() -> None:
    session = Session(dome())
    first = session.latest
    assert first.converged
    for k in range(1, 7):
        keys = dome(1 + 0.01 * k, 0.012 * np.sin(k))
        update = session.update(target=keys["target"])
        assert update is session.latest
        assert update.converged
        ends_like_a_solve(update, keys)
        methods = [attempt.method for attempt in update.result.attempts]
        assert methods == [f"ipopt, {METHOD}"]
    assert session.result is update.result


def test_weights_and_bounds_are_followed() -> None:
    session = Session(dome(constraints={"fold_angle": [60, 160], "edge_length": [0.8, 1.3]}))
    update = session.update(weights={"fairness": 4e-4, "evenness": 1e-4})
    keys = dome(
        constraints={"fold_angle": [60, 160], "edge_length": [0.8, 1.3]},
        objectives={"fairness": 4e-4, "evenness": 1e-4},
    )
    ends_like_a_solve(update, keys)
    # Those that are not named keep what they have.
    ends_like_a_solve(session.update(weights={"evenness": 6e-5}), keys | {"objectives": {"fairness": 4e-4}})


def test_a_tube_is_followed() -> None:
    session = Session(TUBE)
    for k in range(1, 4):
        target = {"axis": {"spline": [[0, 0, 0], [0.02 * k, 0, 1.5], [0, 0, 3]]}, "radius": [[0, 1.0], [1, 0.9]]}
        ends_like_a_solve(session.update(target=target), TUBE | {"target": target})


def test_anchors_and_a_rise_are_followed() -> None:
    session = Session(VAULT)
    rise = session.update(target={"rise": 1.6})
    higher = VAULT | {"target": VAULT["target"] | {"rise": 1.6}}
    ends_like_a_solve(rise, higher, ROUNDS)
    anchors = [{"side": "u0", "every": 2, "to": {"polyline": [[-1, 0, 0.02], [3, 0, 0.02], [7, 0, 0]]}}]
    moved = session.update(anchors=anchors)
    assert moved.converged
    ends_like_a_solve(moved, higher | {"constraints": {"anchors": anchors}}, ROUNDS)
    points = moved.design.vertices_coords[:7:2]
    assert np.abs(points[:, 1]).max() < 1e-6


def test_a_target_far_away_is_told_in_its_own_coordinates() -> None:
    def task(height: float) -> dict[str, Any]:
        domain = [[1e5 - 0.6, 1e5 + 0.6], [-0.6, 0.6]]
        expression = f"{height}*cos(x - 100000)*cos(y)"
        return {"name": "far", "pattern": {"size": [4, 4]}, "target": {"height": expression, "domain": domain}}

    session = Session(task(1.01))
    update = session.update(target=task(1.02)["target"])
    assert update.converged
    assert np.abs(update.design.vertices_coords[:, 0] - 1e5).max() < 1
    assert_close(update.result.design.vertices_coords, update.design.vertices_coords, 0)


def test_a_surface_of_ones_own_is_followed_and_given_up_again() -> None:
    class Lifted(HeightTarget):
        def __init__(self, height: float) -> None:
            super().__init__(f"{height}*cos(x)*cos(y)", [[-0.6, 0.6], [-0.6, 0.6]])

    def given(height: float) -> Target:
        return Lifted(height)

    session = Session(dome(), target=given(1.0))
    assert session.update(target=given(1.01)).converged
    ends_like_a_solve(session.latest, dome(), target=given(1.01))
    ends_like_a_solve(session.update(target=dome()["target"]), dome())


def test_what_cannot_be_used_leaves_the_session_as_it_was() -> None:
    session = Session(dome())
    before = session.latest
    with pytest.raises(InputError, match="rise"):
        session.update(target={"rise": 3.0})
    with pytest.raises(InputError, match="fairnes"):
        session.update(weights={"fairnes": 1.0})
    with pytest.raises(InputError, match="side"):
        session.update(anchors=[{"side": "w0", "to": {"point": [0, 0, 0]}}])
    assert session.latest is before
    assert session.update(target={"height": dome(1.01)["target"]["height"]}).converged


def test_a_key_that_is_none_goes() -> None:
    session = Session(VAULT)
    update = session.update(target={"between": None, "rise": None, **dome()["target"]}, anchors=[])
    ends_like_a_solve(update, VAULT | {"target": dome()["target"], "constraints": {"anchors": []}})


def test_a_jump_is_solved_anew() -> None:
    """From a dome to a saddle no path of one step leads: the answer is that of a solve from the seed."""
    session = Session(dome())
    target = {"height": "0.4*x*y - 0.3", "domain": [[-0.6, 0.6], [-0.6, 0.6]]}
    update = session.update(target=target)
    assert update.converged
    ends_like_a_solve(update, dome() | {"target": target})
    assert session.update(target=dome()["target"]).converged


def test_what_does_not_converge_is_told_and_not_gone_on_from() -> None:
    few = {"solver": {"max_iterations": 4}}
    session = Session(dome(**few))
    for update in (session.latest, session.update(target=dome(1.01)["target"])):
        assert not update.converged
        assert "iterations" in update.result.status
        assert update.result.attempts[0].method != f"ipopt, {METHOD}"
        assert not update.result.solved


def test_the_same_moves_give_the_same_bits() -> None:
    def designs() -> list[np.ndarray]:
        session = Session(dome())
        moves = (dome(1.01), dome(1.02, 0.03), dome(1.0, -0.02))
        return [session.update(target=keys["target"]).design.vertices_coords for keys in moves]

    for one, other in zip(designs(), designs(), strict=True):
        assert (one == other).all()


@pytest.mark.slow
def test_two_hundred_moves_stay_on_the_way() -> None:
    """Along a closed path: each is certified, and one in 25 ends where a solve from the seed ends or better."""
    session = Session(dome())
    for k in range(1, 201):
        t = 2 * np.pi * k / 200
        keys = dome(1.05 - 0.05 * np.cos(t), 0.01 + 0.1 * np.sin(2 * t))
        update = session.update(target=keys["target"])
        assert update.converged
        assert update.result.certified
        if k % 25 == 0:
            ends_like_a_solve(update, keys)
