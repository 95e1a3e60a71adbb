"""Removing what is left of the residual: Newton steps of least norm, the inner half of equation (9)."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from scipy.sparse.linalg import splu

from inverse.assembly import Problem
from inverse.pattern import FloatArray


def polish(problem: Problem, variables: FloatArray, parameters: FloatArray, *, steps: int = 8) -> FloatArray:
    """Move variables to the nearest point where all equations hold to rounding.

    Each step is the least move that removes the linearized residual, J^T (J J^T + e I)^-1 of it. The tiny e keeps
    redundant equations (tubes, anchors that repeat each other) solvable and costs nothing, since Newton's next step
    takes care of it. J J^T is positive definite, so it is factorized in a symmetric order without pivoting, four
    times faster than the system of moves and multipliers together.

    Args:
        problem: gives rows and Jacobian; inequalities are left alone.
        variables: (n,) near a solution.
        parameters: parameter vector of the problem.
        steps: at most so many steps.

    Returns:
        (n,) variables; the given ones if no step made the residual smaller.
    """
    equations = np.flatnonzero(problem.lower == problem.upper)
    if len(equations) == 0:
        return variables
    best, best_size = variables, np.inf
    x = variables
    for _ in range(steps + 1):  # the last step is looked at too
        rows, jacobian = problem.rows_and_jacobian(x, parameters)
        residual = rows[equations] - problem.lower[equations]
        size = float(np.abs(residual).max())
        if size >= best_size:
            break
        best, best_size = x, size
        if size < 1e-15:
            break
        j = jacobian[equations]
        system = (j @ j.T + 1e-12 * sparse.identity(len(equations))).tocsc()
        factors = splu(system, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
        x = x - j.T @ factors.solve(residual)
    return best
