"""What a design is to reach: a fitting and the states whose size matters, with the layout of all variables."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from inverse._types import FloatArray
from inverse.model import DesignModel
from inverse.surfaces import Target
from inverse.terms.carried import Carried
from inverse.terms.fitting import Fitting
from inverse.terms.packed import Packed


@dataclass(frozen=True, eq=False)
class Goal:
    """What objectives may look at.

    Attributes:
        fitting: model and target.
        packed: states whose extents are measured or limited, with variables of their own.
        origin: (3,) point of the specification's coordinates that those of model and target are relative to.
        carried: functions of all vertices whose values have variables of their own.
    """

    fitting: Fitting
    packed: tuple[Packed, ...] = ()
    origin: FloatArray = field(default_factory=lambda: np.zeros(3))
    carried: tuple[Carried, ...] = ()

    @property
    def model(self) -> DesignModel:
        """The model."""
        return self.fitting.model

    @property
    def target(self) -> Target:
        """The target."""
        return self.fitting.target

    @property
    def _blocks(self) -> list[Packed | Carried]:
        """What has variables after the model's, in their order."""
        return [*self.packed, *self.carried]

    @property
    def n_variables(self) -> int:
        """Length of the vector of variables: the model's, those of the packed states, then values carried."""
        return self.model.n_variables + sum(block.n_variables for block in self._blocks)

    @cached_property
    def seed_variables(self) -> FloatArray:
        """Variables (n_variables,) of the placed seed."""
        return self.start(self.model.seed.vertices_coords)

    def start(self, points: FloatArray) -> FloatArray:
        """Variables (n_variables,) of a design with vertices (V, 3) in the seed's unit; packed states are folded."""
        own = self.model.to_dimensionless(points)
        return np.concatenate([own.ravel(), *(block.start(own) for block in self._blocks)])
