"""Equations that follow from others: where a strip closes through the whole motion, three of every ring do.

Which strip comes next to a closed one is a matter of one free plane, so that three vertex conditions of every further
ring of vertices around the hole hold by themselves. A solver that is given all equations finds no multipliers there.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from inverse._types import FloatArray, IntArray
from inverse.nlp.point import Point

RANK = 1e-8  # pivots of rows that depend on others are 1e-14; the smallest of others 1e-4 at 8 x 24 facets


def redundant(point: Point) -> IntArray:
    """Rows that a solver can do without around a point.

    Returns:
        (r,) int, equations whose gradients are combinations of the others'; none where no constraint implies others.
    """
    equations = point.problem.equations
    if not point.problem.has_redundant_equations:
        return np.empty(0, np.int64)
    return np.delete(equations, independent(point.jacobian[equations].toarray()))


def dependence(point: Point) -> dict[str, float]:
    """What is told about the equations at a point, where some follow from others.

    Returns:
        ``rows`` of equations; their ``rank``; ``freedom``, how many variables they leave free, moves of the whole
        included; ``condition``, the ratio of the largest singular value of their Jacobian to the smallest but zero.
    """
    jacobian = point.jacobian[point.problem.equations].toarray()
    rank = len(independent(jacobian))
    sizes = np.linalg.svd(jacobian, compute_uv=False)
    return {
        "rows": len(jacobian),
        "rank": rank,
        "freedom": point.problem.n_variables - rank,
        "condition": float(sizes[0] / sizes[rank - 1]),
    }


def independent(jacobian: FloatArray) -> IntArray:
    """Rows of a Jacobian that span all of them, as far from dependent as a pivoted factorization finds.

    Args:
        jacobian: (R, n).

    Returns:
        (r,) int, ascending; r is the rank.
    """
    sizes = np.linalg.norm(jacobian, axis=1, keepdims=True)
    scaled = jacobian / np.where(sizes > 0, sizes, 1.0)
    triangle, order = scipy.linalg.qr(scaled.T, mode="r", pivoting=True)
    diagonal = np.abs(np.diag(triangle))
    return np.sort(order[: int((diagonal > RANK * diagonal[0]).sum())]).astype(np.int64)
