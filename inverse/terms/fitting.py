"""How a mesh is fitted to its target: what is measured of it, pulled and told. A target's kind decides it once."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from inverse._types import FloatArray
from inverse.model import DesignModel
from inverse.nlp.kernels import Elements
from inverse.surfaces import Target


@dataclass(frozen=True, eq=False)
class Fitting(ABC):
    """A model and its target, with what the objectives and the report ask of them.

    Attributes:
        model: the model.
        target: the target.
    """

    #: Default weights that differ from the terms' own, by name.
    weights: ClassVar[Mapping[str, float]] = {}

    model: DesignModel
    target: Target

    @property
    @abstractmethod
    def points(self) -> str:
        """The word for what is fitted, for reports."""

    @property
    @abstractmethod
    def is_exact(self) -> bool:
        """Whether the target enters by its own expression; else closest points must be refreshed."""

    @abstractmethod
    def elements(self) -> list[Elements]:
        """The objective ``fit``: distances of the fitted points in sixteenths of the model."""

    @abstractmethod
    def refreshed(self, points: FloatArray) -> dict[str, FloatArray]:
        """New closest points for vertices (V, 3), by name of the fit's elements; empty for exact targets."""

    @abstractmethod
    def covering(self) -> list[Elements]:
        """The objective ``coverage``: the mesh reaches over the whole target."""

    @abstractmethod
    def fair_points(self) -> FloatArray:
        """(V, 3) dimensionless vertices that a fair design is displaced from evenly."""

    def followed(self, points: FloatArray, before: Fitting) -> FloatArray:
        """Where vertices (V, 3) of a design go when a target has changed: (V, 3), as a fair design goes.

        Args:
            points: of a design that was fitted before.
            before: how that was fitted, by the same pattern.
        """
        after, fair = (one.model.to_lengths(one.fair_points()) for one in (self, before))
        return points + (after - fair)

    @abstractmethod
    def distances(self, points: FloatArray) -> FloatArray:
        """Distances (N,) of the fitted points of vertices (V, 3) from the target, border included."""

    def told(self, points: FloatArray) -> Any:
        """What reports tell of vertices (V, 3) besides the distances: a dataclass, or None for nothing."""
        return None
