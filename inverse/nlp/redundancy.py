"""Equations that follow from others: where a strip closes through the whole motion, three of every ring do.

Which strip comes next to a closed one is a matter of one free plane, so that three vertex conditions of every further
ring of vertices around the hole hold by themselves. A solver that is given all equations finds no multipliers there.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from inverse._types import FloatArray, IntArray
from inverse.nlp.problem import Problem

RANK = 1e-8  # pivots of rows that depend on others are 1e-14; the smallest of others 1e-4 at 8 x 24 facets


def redundant(problem: Problem, x: FloatArray, parameters: FloatArray) -> IntArray:
    """Rows that a solver can do without around x.

    Args:
        problem: the problem.
        x: (n,) variables.
        parameters: of the problem.

    Returns:
        (r,) int, equations whose gradients are combinations of the others'; none where no constraint implies others.
    """
    if not problem.has_redundant_equations:
        return np.empty(0, np.int64)
    equations = np.flatnonzero(problem.lower == problem.upper)
    _, jacobian = problem.rows_and_jacobian(x, parameters)
    return np.delete(equations, independent(jacobian[equations].toarray()))


def dependence(problem: Problem, x: FloatArray, parameters: FloatArray) -> dict[str, float]:
    """What is told about the equations at x, where some follow from others.

    Args:
        problem: the problem.
        x: (n,) variables.
        parameters: of the problem.

    Returns:
        ``rows`` of equations; their ``rank``; ``freedom``, how many variables they leave free, moves of the whole
        included; ``condition``, the ratio of the largest singular value of their Jacobian to the smallest but zero.
    """
    equations = np.flatnonzero(problem.lower == problem.upper)
    _, jacobian = problem.rows_and_jacobian(x, parameters)
    rank = len(independent(jacobian[equations].toarray()))
    sizes = np.linalg.svd(jacobian[equations].toarray(), compute_uv=False)
    return {
        "rows": len(equations),
        "rank": rank,
        "freedom": problem.n_variables - rank,
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
