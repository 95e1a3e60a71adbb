"""Inverse design of rigid-foldable, bidirectionally flat-foldable planar quad meshes (BDFFPQ, Tachi 2010).

Names are loaded when they are first used, so that ``import inverse`` is fast.
"""

from __future__ import annotations

import os
import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from inverse.certify import Certificate as Certificate
    from inverse.certify import check as check
    from inverse.dragging import refine as refine
    from inverse.errors import InputError as InputError
    from inverse.files.fold_file import read as read
    from inverse.files.fold_file import write as write
    from inverse.objectives import objective as objective
    from inverse.origami import seeds as seeds
    from inverse.origami.families import pattern_family as pattern_family
    from inverse.origami.folding import fold as fold
    from inverse.origami.pattern import Design as Design
    from inverse.origami.pattern import Pattern as Pattern
    from inverse.origami.seeds import section as section
    from inverse.policy.measures import measure as measure
    from inverse.repair import Repair as Repair
    from inverse.repair import repair as repair
    from inverse.solve import Result as Result
    from inverse.solve import SolveError as SolveError
    from inverse.solve import solve as solve
    from inverse.spec import from_mapping as from_mapping
    from inverse.spec import load as load
    from inverse.surfaces import Target as Target
    from inverse.surfaces.named import target as target
    from inverse.terms.own_constraints import constraint as constraint

# Read by BLAS when casadi loads it: at these matrix sizes two threads are several times slower than one.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

__version__ = "0.1.0"

_HOMES = {
    "Certificate": "certify",
    "Design": "origami.pattern",
    "InputError": "errors",
    "Pattern": "origami.pattern",
    "Repair": "repair",
    "Result": "solve",
    "SolveError": "solve",
    "Target": "surfaces",
    "check": "certify",
    "constraint": "terms.own_constraints",
    "fold": "origami.folding",
    "from_mapping": "spec",
    "load": "spec",
    "measure": "policy.measures",
    "objective": "objectives",
    "pattern_family": "origami.families",
    "read": "files.fold_file",
    "refine": "dragging",
    "repair": "repair",
    "section": "origami.seeds",
    "solve": "solve",
    "target": "surfaces.named",
    "write": "files.fold_file",
}

__all__ = [*sorted(_HOMES), "__version__", "seeds"]


class _Package(ModuleType):
    """Keeps ``inverse.solve`` and others functions, although ``inverse/solve.py`` bears the same name."""

    def __setattr__(self, name: str, value: Any) -> None:
        if _HOMES.get(name) == name and isinstance(value, ModuleType):
            value = getattr(value, name)  # importing a submodule sets it as an attribute of its package
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package


def __getattr__(name: str) -> Any:
    if name == "seeds":
        return import_module("inverse.origami.seeds")
    if name in _HOMES:
        return getattr(import_module(f"inverse.{_HOMES[name]}"), name)
    raise AttributeError(f"module 'inverse' has no attribute {name!r}")
