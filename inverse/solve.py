"""The front door: from what somebody asks to a result, and a second opinion on any design.

Everything behind it is loaded when it is first used, so that the package itself imports fast.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from inverse.certify import Certificate
    from inverse.formulation.given import GivenConstraint, GivenObjective
    from inverse.origami.pattern import Design
    from inverse.policy.control import Watch
    from inverse.results.result import Result
    from inverse.spec import Loaded
    from inverse.surfaces import Target


def solve(
    spec: Path | str | Mapping[str, Any] | Loaded,
    *,
    start: Result | Design | Path | str | None = None,
    target: Target | None = None,
    design: Design | None = None,
    constraints: Sequence[GivenConstraint] = (),
    objectives: Sequence[GivenObjective] = (),
    watch: Watch | None = None,
    throw: bool = False,
) -> Result:
    """Design a mesh for a specification.

    Args:
        spec: a YAML file, a mapping with the same keys, or what :func:`inverse.load` made of one.
        start: what to go on from instead of the seed: the result of a task like this one, such as the same with its
            target moved a little; a design, an output folder or a FOLD file of the same pattern.
        target: a surface in place of what the specification names, in its unit.
        design: a pattern's seed in place of what the specification names, placed over the target like a file's.
        constraints: constraints of one's own (:func:`inverse.constraint`) besides those of the specification, each by
            itself or with its bounds: ``(term, lower, upper)``.
        objectives: the same of objectives (:func:`inverse.objective`): ``term`` or ``(term, weight)``.
        watch: told every iteration: a phrase and an :class:`inverse.Progress`.
        throw: raise where the design is not certified, converged and as asked.

    Returns:
        The result; without ``throw``, read ``certified``, ``converged`` and ``as_asked`` before using its design.

    Raises:
        InputError: the specification, or a file that it names, cannot be used; the start has another pattern.
        SolveError: with ``throw``, for every ending but ``solved``; it carries the result.
        KeyboardInterrupt: at Ctrl-C or SIGTERM before there is a design to keep, and at a second one at any time.
    """
    from inverse.formulation.given import Given
    from inverse.results.making import made
    from inverse.spec import load

    return made(load(spec), Given.of(objectives, constraints, target, design), start, watch, throw=throw)


def check(design: Path | str | Design) -> Certificate:
    """Certify a design independently of how it was made.

    Args:
        design: a FOLD file with the keys of a design, or a design as it would be written to one.

    Returns:
        The verdict; a design that is wrong in whatever way gets a certificate that says so.

    Raises:
        InputError: the file cannot be read as a design.
    """
    from inverse import certify
    from inverse.files import fold_file

    if isinstance(design, Path | str):
        return certify.check(design)
    return certify.check_frame(fold_file.frame(design))
