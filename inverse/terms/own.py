"""Terms of users: functions of vertices, edges, facets or the whole mesh, as kernels on the elements they act on."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import casadi
import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.extending.loading import told
from inverse.model import DesignModel
from inverse.nlp.kernels import Elements, Kernel, Residual
from inverse.words import did_you_mean

Function = Callable[[casadi.SX, casadi.SX], Any]
Per = Literal["vertex", "edge", "facet", "mesh"]
PER = ("vertex", "edge", "facet", "mesh")
#: Units of residuals, with the power of a length that each is.
UNITS = {"1": 0, "length": 1, "length^2": 2, "length^3": 3, "1/length": -1, "angle": 0}

FEW = 32  # variables that a residual of the whole mesh may depend on to be taken like one of a single element
SPARSE = 64  # nonzeros of a Hessian per variable up to which it is used


@dataclass(frozen=True, eq=False)
class Own:
    """A function of a user that returns residuals of one element; calling it calls the function.

    Attributes:
        what: objective or constraint, for messages.
        name: under which it is registered.
        function: of the element's points and the placed seed's, both CasADi expressions (k, 3) in the specification's
            unit.
        per: the elements: every vertex (k = 1), every edge (2), every facet (its sides), or the mesh (V).
        unit: of what it returns, a word of ``UNITS``.
    """

    what: str
    name: str
    function: Function
    per: Per
    unit: str

    def __post_init__(self) -> None:
        if not callable(self.function):
            raise InputError(f"{self} is no function")
        for word, given, allowed in (("per", self.per, PER), ("unit", self.unit, UNITS)):
            if given not in allowed:
                near = did_you_mean(str(given), allowed)
                raise InputError(f"{self} has {word} {given!r}: allowed are {', '.join(allowed)}.{near}")

    def __call__(self, points: casadi.SX, seed: casadi.SX) -> Any:
        """What the function returns."""
        return self.function(points, seed)

    def __str__(self) -> str:
        return f"{self.what} {self.name}"

    def size(self, length: float) -> float:
        """The unit of the residuals, with its length measured by ``length``."""
        return float(length ** UNITS[self.unit])

    def elements(self, model: DesignModel, origin: FloatArray, length: float) -> list[Elements]:
        """The residuals over the elements, dimensionless; facets of each number of sides by themselves.

        Args:
            model: the model.
            origin: (3,) that the model's coordinates are relative to.
            length: that lengths are measured by, in the specification's unit.
        """
        found: list[Elements] = []
        for vertices in _groups(model, self.per):
            count, k = vertices.shape
            name = self.name if not found else f"{self.name} of {k} sides"
            if self.per == "mesh":
                kernel = self._of_the_mesh(model, origin, length)
                parameters = np.empty((1, 0))
            else:
                kernel = Kernel(f"own_{self.per}", self.residual(model, origin, length, k), 3 * k, 3 * k)
                parameters = model.seed_points[vertices].reshape(count, -1)
            found.append(Elements(name, kernel, model.variables_of(vertices), parameters))
        return found

    def residual(self, model: DesignModel, origin: FloatArray, length: float, k: int) -> Residual:
        """The function in dimensionless variables: of q (3k,) and the same of the seed.

        Raises:
            InputError: what it returns cannot be used, or it raised something.
        """
        centre = casadi.repmat(casadi.DM(model.centre + origin).T, k, 1)

        def points(q: casadi.SX) -> casadi.SX:
            return casadi.reshape(q, 3, k).T * model.scale + centre

        return lambda q, p: self._checked(points(q), points(p), q) / self.size(length)

    def is_coupled(self, model: DesignModel, origin: FloatArray) -> bool:
        """Whether some residual depends on so many vertices that its square has a dense Hessian."""
        if self.per != "mesh":
            return False
        q = casadi.SX.sym("q", 3 * model.pattern.n_vertices)
        return _most_in_a_row(casadi.jacobian_sparsity(self.of_all(model, origin, 1.0)(q), q)) > FEW

    def of_all(self, model: DesignModel, origin: FloatArray, length: float) -> Callable[[casadi.SX], casadi.SX]:
        """The function of all vertices (3V,), with the seed as numbers."""
        residual = self.residual(model, origin, length, model.pattern.n_vertices)
        seed = casadi.SX(casadi.DM(model.seed_points.ravel()))
        return lambda q: casadi.SX(residual(q, seed))

    def _of_the_mesh(self, model: DesignModel, origin: FloatArray, length: float) -> Kernel:
        residual, n = self.of_all(model, origin, length), model.n_variables
        return Kernel("own_mesh", lambda q, _: residual(q), n, is_curved=has_sparse_curvature(residual, n))

    def _checked(self, points: casadi.SX, seed: casadi.SX, q: casadi.SX) -> casadi.SX:
        """Residuals (r,) that the function returns for an element."""
        try:
            found = self.function(points, seed)
        except Exception as error:
            raise InputError(f"{self} raised {told(error)}") from error
        if found is None:
            raise InputError(f"{self} returns nothing", hint="Return a CasADi expression.")
        if isinstance(found, list | tuple):
            raise InputError(
                f"{self} returns a {type(found).__name__} of {len(found)}: an expression or a CasADi vector is wanted",
                hint="Join the entries by casadi.vertcat(*entries).",
            )
        if isinstance(found, casadi.SX):
            if 1 not in found.shape or found.numel() == 0:
                raise InputError(
                    f"{self} returns a matrix of shape {found.shape}: an expression or a vector is wanted",
                    hint="casadi.vec(matrix) is the vector of its entries.",
                )
            if casadi.depends_on(found, q):
                return casadi.vec(casadi.densify(found))
            raise InputError(f"{self} returns a constant: it must depend on the points")
        if isinstance(found, int | float | np.number | casadi.DM):
            raise InputError(f"{self} returns a constant: it must depend on the points")
        raise InputError(
            f"{self} returns a {type(found).__name__}: a CasADi expression is wanted",
            hint="Compute with casadi's functions, such as casadi.sqrt and casadi.vertcat.",
        )


def has_sparse_curvature(residual: Callable[[casadi.SX], casadi.SX], n: int) -> bool:
    """Whether the Hessian of a weighted sum of residuals of n variables has few nonzeros; found without making it."""
    q = casadi.SX.sym("q", n)
    found = residual(q)
    weight = casadi.SX.sym("weight", found.numel())
    slope = casadi.gradient(casadi.dot(weight, found), q)
    nonzeros, rows = 0, 64  # as many as CasADi follows at once
    for first in range(0, n, rows):
        nonzeros += casadi.jacobian_sparsity(slope[first : min(first + rows, n)], q).nnz()
        if nonzeros > SPARSE * n:
            return False
    return True


def finite(value: object, what: str) -> float:
    """A number as given by a caller.

    Raises:
        InputError: it is none, or not finite.
    """
    if isinstance(value, bool) or not isinstance(value, int | float | np.number) or not math.isfinite(value):
        raise InputError(f"{what} is {value!r}: it must be a finite number")
    return float(value)


def _groups(model: DesignModel, per: Per) -> list[IntArray]:
    """Vertices (N, k) of the elements, grouped by k."""
    pattern = model.pattern
    if per == "vertex":
        return [np.arange(pattern.n_vertices)[:, None]]
    if per == "edge":
        return [np.asarray(pattern.edges_vertices, np.int64)]
    if per == "mesh":
        return [np.arange(pattern.n_vertices)[None]]
    return [
        np.array([pattern.faces_vertices[f] for f in facets], np.int64) for facets in pattern.faces_by_sides.values()
    ]


def _most_in_a_row(sparsity: casadi.Sparsity) -> int:
    return int(np.bincount(np.array(sparsity.row(), np.int64), minlength=1).max()) if sparsity.nnz() else 0
