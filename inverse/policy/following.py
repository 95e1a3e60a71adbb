"""Closest points of a target that follow a design from round to round."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from inverse._types import FloatArray
from inverse.nlp.point import Point
from inverse.terms.goal import Goal

GAIN = 1e-2  # on a target with kinks they end when two rounds together lower the fit's rms by less than this

Step = tuple[FloatArray, FloatArray]  # points of a design, and how far they are from where closest points were taken


@dataclass
class Following:
    """Where closest points are taken next.

    Attributes:
        goal: what is fitted.
        aim: (V, 3) vertices that closest points are taken for.
    """

    goal: Goal
    aim: FloatArray
    _before: Step | None = None
    _history: list[tuple[float, Point]] = field(default_factory=list)

    def seen(self, point: Point, rms: float) -> None:
        """Remember where a round ended, and its fit."""
        self._history.append((rms, point))

    def go_on(self, points: FloatArray) -> None:
        """Aim further on, from the vertices (V, 3) that a round came to."""
        step = points, points - self.aim
        self.aim = points if self.goal.target.has_kinks else _ahead(step, self._before)
        self._before = step

    @property
    def is_to_and_fro(self) -> bool:
        """Whether closest points jump between the facets of a target mesh, which they would do for ever."""
        return self.goal.target.has_kinks and len(self._history) > 3 and _no_gain([rms for rms, _ in self._history])

    @property
    def best(self) -> Point:
        """The best round: stationary for the tangent planes that it was solved with."""
        return min(self._history, key=lambda entry: entry[0])[1]


def _ahead(step: Step, before: Step | None) -> FloatArray:
    """Where closest points are taken next, from the designs of two rounds and how far each went from its aim.

    Tangent planes know nothing of the target's curvature, so that rounds go past the solution and back again, or
    come nearer slowly. The line through two rounds shows where they lead (Anderson's method of depth one).
    """
    points, change = step
    if before is None:
        return points
    earlier, change_before = before
    turn = change - change_before
    share = float(np.sum(change * turn) / max(np.sum(turn * turn), np.finfo(float).tiny))
    share = min(max(share, -2.0), 0.5)  # no leaps while rounds still differ much
    return np.asarray((1 - share) * points + share * earlier)


def _no_gain(rms: list[float]) -> bool:
    return min(rms[-2:]) > (1 - GAIN) * min(rms[:-2])
