"""Inverse design of rigid-foldable, bidirectionally flat-foldable planar quad meshes (BDFFPQ, Tachi 2010).

Names are loaded when they are first used, so that ``import inverse`` is fast.
"""

from __future__ import annotations

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any

# Modules of the same names: taken at once, so that importing them later does not put a module in a function's place.
from inverse.repair import repair as repair
from inverse.solve import check as check
from inverse.solve import solve as solve

if TYPE_CHECKING:
    from inverse.certify import Certificate as Certificate
    from inverse.dragging import Drag as Drag
    from inverse.dragging import refine as refine
    from inverse.errors import InputError as InputError
    from inverse.files.fold_file import read as read
    from inverse.files.fold_file import write as write
    from inverse.objectives import objective as objective
    from inverse.origami import seeds as seeds
    from inverse.origami.families import pattern_family as pattern_family
    from inverse.origami.folding import Motion as Motion
    from inverse.origami.folding import fold as fold
    from inverse.origami.pattern import Design as Design
    from inverse.origami.pattern import Pattern as Pattern
    from inverse.origami.seeds import section as section
    from inverse.policy.measures import measure as measure
    from inverse.repair.repairing import Repair as Repair
    from inverse.results.result import Result as Result
    from inverse.results.result import SolveError as SolveError
    from inverse.session import Session as Session
    from inverse.session import Update as Update
    from inverse.solvers.run import Progress as Progress
    from inverse.spec import load as load
    from inverse.surfaces import Target as Target
    from inverse.surfaces.named import target as target
    from inverse.terms.own_constraints import constraint as constraint

# Read by BLAS when casadi loads it: at these matrix sizes two threads are several times slower than one.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

__version__ = "0.1.0"

# Public name -> its module and its name there.
_HOMES = {
    "Certificate": ("certify", "Certificate"),
    "Design": ("origami.pattern", "Design"),
    "Drag": ("dragging", "Drag"),
    "InputError": ("errors", "InputError"),
    "Motion": ("origami.folding", "Motion"),
    "Pattern": ("origami.pattern", "Pattern"),
    "Progress": ("solvers.run", "Progress"),
    "Repair": ("repair.repairing", "Repair"),
    "Result": ("results.result", "Result"),
    "Session": ("session", "Session"),
    "SolveError": ("results.result", "SolveError"),
    "Target": ("surfaces", "Target"),
    "Update": ("session", "Update"),
    "constraint": ("terms.own_constraints", "constraint"),
    "fold": ("origami.folding", "fold"),
    "load": ("spec", "load"),
    "measure": ("policy.measures", "measure"),
    "objective": ("objectives", "objective"),
    "pattern_family": ("origami.families", "pattern_family"),
    "read": ("files.fold_file", "read"),
    "refine": ("dragging", "refine"),
    "section": ("origami.seeds", "section"),
    "target": ("surfaces.named", "target"),
    "write": ("files.fold_file", "write"),
}

__all__ = [*sorted(_HOMES), "__version__", "check", "repair", "seeds", "solve"]


def __getattr__(name: str) -> Any:
    if name == "seeds":
        return import_module("inverse.origami.seeds")
    if name in _HOMES:
        module, own = _HOMES[name]
        return getattr(import_module(f"inverse.{module}"), own)
    raise AttributeError(f"module 'inverse' has no attribute {name!r}")
