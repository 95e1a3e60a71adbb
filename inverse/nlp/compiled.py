"""CasADi functions of a problem, made once for all problems of the same structure in a process."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Sequence
from hashlib import blake2b
from typing import Any

import casadi
import numpy as np

from inverse.nlp.evaluation import Evaluations
from inverse.nlp.kernels import Elements

# Problems are kept while all of them together have no more constraint rows than this; 64 x 64 facets have 37,000.
KEPT_ROWS = 40_000

Functions = dict[str, casadi.Function]


class Compiled:
    """The functions of a problem, with their sparsity and whatever else depends on the structure alone.

    Args:
        functions: in the form that ``nlpsol`` takes: nlp, grad_f, jac_g, hess_lag.

    Attributes:
        functions: the same.
        evaluations: the same for arrays.
        kept: room for others to keep what they derive from the structure, such as orders of elimination.
    """

    def __init__(self, functions: Functions) -> None:
        self.functions = functions
        self.evaluations = Evaluations(functions)
        self.kept: dict[Any, Any] = {}


_kept: OrderedDict[bytes, tuple[int, Compiled]] = OrderedDict()


def compiled(key: bytes, n_rows: int, make: Callable[[], Functions]) -> Compiled:
    """What was made for this structure before, or is made now.

    Args:
        key: of the structure, see :func:`structure`.
        n_rows: of the problem, which tells how large it is.
        make: makes the functions.
    """
    if key not in _kept:
        _kept[key] = n_rows, Compiled(make())
        while len(_kept) > 1 and sum(rows for rows, _ in _kept.values()) > KEPT_ROWS:
            _kept.popitem(last=False)
    _kept.move_to_end(key)
    return _kept[key][1]


def structure(n_variables: int, objectives: Sequence[Elements], constraints: Sequence[Elements]) -> bytes:
    """A key that problems share whose functions are the same: all numbers that differ are parameters."""
    digest = blake2b(f"{n_variables} {len(objectives)}".encode())
    for elements in (*objectives, *constraints):
        kernel = elements.kernel
        digest.update(f"|{kernel.form}|{elements.variables.shape}|".encode())
        digest.update(np.ascontiguousarray(elements.variables, np.int64).tobytes())
    return digest.digest()
