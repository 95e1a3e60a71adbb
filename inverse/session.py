"""A task that is solved again and again while its target, anchors and weights move: every design starts the next."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from inverse.crossing import crossing_facets
from inverse.formulation.formulate import formulate
from inverse.formulation.given import Given, GivenConstraint, GivenObjective
from inverse.nlp.point import Point
from inverse.origami.pattern import Design
from inverse.policy import verdict
from inverse.policy.control import Watch
from inverse.policy.outcome import Outcome
from inverse.policy.steps import Policy
from inverse.results.making import controlled, solved, surroundings, told
from inverse.results.result import Result
from inverse.spec import Loaded, load
from inverse.surfaces import Target


@dataclass(eq=False)
class Update:
    """What a session came to: the light verdict at once, everything else when it is first asked for.

    Attributes:
        design: the design, in the coordinates of the specification.
        failed: what is wrong with it by our own test, as sentences: stationarity, constraints, facets that cross.
        iterations: of all runs.
        seconds: until here.
        made: makes the result.
    """

    design: Design
    failed: tuple[str, ...]
    iterations: int
    seconds: float
    made: Callable[[], Result]

    @property
    def converged(self) -> bool:
        """Whether nothing is wrong: the light verdict."""
        return not self.failed

    @cached_property
    def result(self) -> Result:
        """Everything that :func:`inverse.solve` tells, certificate and brief included."""
        return self.made()


class Session:
    """A task whose design follows while its target, anchors and weights move.

    The first design is solved for as :func:`inverse.solve` does; every other starts from the one before. Where that
    does not lead to a design that is converged, the task is solved anew from its seed.

    Args:
        spec: a YAML file, a mapping with the same keys, or what :func:`inverse.load` made of one.
        target: as of :func:`inverse.solve`, like all that follow.
        design: the same.
        constraints: the same.
        objectives: the same.
        watch: the same; told of all solves of the session.

    Attributes:
        latest: what the latest update came to; at first the design of the task as it was given.

    Raises:
        InputError: as :func:`inverse.solve`.
    """

    def __init__(
        self,
        spec: Path | str | Mapping[str, Any] | Loaded,
        *,
        target: Target | None = None,
        design: Design | None = None,
        constraints: Sequence[GivenConstraint] = (),
        objectives: Sequence[GivenObjective] = (),
        watch: Watch | None = None,
    ) -> None:
        began, loaded = time.perf_counter(), load(spec)
        self._given, self._watch = Given.of(objectives, constraints, target, design), watch
        self._keys, self._folder = loaded.specification.model_dump(mode="json", exclude_unset=True), loaded.folder
        self._context = surroundings(loaded)
        self._policy: Policy | None = None  # of the last design that converged, and where it is
        self._point: Point | None = None
        self.latest = self._anew(loaded, self._given, began)

    @property
    def result(self) -> Result:
        """Everything that is told of the latest design."""
        return self.latest.result

    def update(
        self,
        *,
        target: Mapping[str, Any] | Target | None = None,
        anchors: Sequence[Mapping[str, Any]] | None = None,
        weights: Mapping[str, float] | None = None,
    ) -> Update:
        """Solve the task with something of it changed, starting from the design before.

        Args:
            target: keys of the specification's target that change, None for those that go; or a surface in its place.
            anchors: all anchors, as in the specification, in place of those before.
            weights: of the objectives that change, by name.

        Returns:
            What it came to. Its certificate is made when ``result`` is first asked for.

        Raises:
            InputError: the changed specification cannot be used; the session is as it was.
        """
        began, keys, given = time.perf_counter(), dict(self._keys), self._given
        if isinstance(target, Target):
            given = replace(given, target=target)
        elif target is not None:
            own = {**keys["target"], **target}
            keys["target"] = {key: value for key, value in own.items() if value is not None}
            given = replace(given, target=None)
        if anchors is not None:
            keys["constraints"] = {**keys.get("constraints", {}), "anchors": [dict(anchor) for anchor in anchors]}
        if weights is not None:
            keys["objectives"] = {**keys.get("objectives", {}), **weights}
        loaded = load(keys, folder=self._folder)
        found = self._followed(loaded, given, began) or self._anew(loaded, given, began)
        self._keys, self._given, self.latest = keys, given, found
        return found

    def _followed(self, loaded: Loaded, given: Given, began: float) -> Update | None:
        """From the last design that converged; None where that comes to none."""
        if self._policy is None or self._point is None or self._policy.rounds is None:
            return None
        control = controlled(loaded, self._watch)
        with control.interruptible():
            policy = Policy(loaded, formulate(loaded, given=given), control)
            policy.seconds["formulate"] = time.perf_counter() - began
            before, goal = self._policy.formulation.goal, policy.formulation.goal
            moved = goal.fitting.followed(before.model.points(self._point.variables), before.fitting)
            point = policy.follow(goal.start(moved), self._point.balance, self._policy.rounds)
            control.check()
            found = self._told(policy, point, lambda: policy.outcome(point), began)
        if not found.converged:
            return None
        self._policy, self._point = policy, point
        return found

    def _anew(self, loaded: Loaded, given: Given, began: float) -> Update:
        """From the seed, as :func:`inverse.solve` does."""
        control = controlled(loaded, self._watch)
        with control.interruptible():
            policy, outcome = solved(loaded, given, None, control)
            found = self._told(policy, outcome.point, lambda: outcome, began)
        if found.converged:
            self._policy, self._point = policy, outcome.point
        return found

    def _told(self, policy: Policy, point: Point, outcome: Callable[[], Outcome], began: float) -> Update:
        """What is told of a point."""
        goal = policy.formulation.goal
        design = goal.model.design(point.variables)
        judgement = verdict.judge(point, goal, policy.loaded.specification.constraints)
        crossing = len(crossing_facets(design.vertices_coords, design.pattern.faces_vertices))
        failed = (*judgement.failed, *([f"{crossing} pairs of facets cross"] if crossing else []))
        iterations = sum(attempt.iterations for attempt in policy.attempts)
        design = design.moved_to(design.vertices_coords + goal.origin)
        seconds = time.perf_counter() - began
        return Update(design, failed, iterations, seconds, lambda: told(policy, outcome(), self._context))
