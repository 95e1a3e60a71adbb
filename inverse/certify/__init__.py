"""A second opinion on a design file, from the file alone.

Nothing a file says about itself is believed, and nothing is shared with the code that made it but the reader
of the file format and the exact predicates for crossing triangles: topology, signs, angles and the motion are
derived anew, by formulas other than those of :mod:`inverse.origami.folding`.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from inverse.certify import claims, coarse, collisions, loops, measures, mobility
from inverse.certify.certificate import LIMITS, NOT_MEASURED, Certificate, Check, Crossing, Loop, judge
from inverse.certify.measures import CFL, FL
from inverse.certify.motion import Motion
from inverse.certify.structure import examine
from inverse.files.fold_format import FoldFrame, read_frame

__all__ = ["Certificate", "Check", "Loop", "check", "check_frame"]


def check(path: Path | str, progress: Callable[[int, int], None] | None = None) -> Certificate:
    """Certify a design file.

    Args:
        path: a FOLD file with the keys of a design.
        progress: told how many states of how many of the motion are done; where facets cross, the rest is left out.

    Returns:
        The verdict; a design that is wrong in whatever way gets a certificate that says so.

    Raises:
        InputError: the file cannot be read as a design, see :func:`inverse.files.fold_format.read_frame`.
    """
    return check_frame(read_frame(Path(path)), progress)


def check_frame(frame: FoldFrame, progress: Callable[[int, int], None] | None = None) -> Certificate:
    """Certify what a design file says.

    Args:
        frame: keys of the right form, otherwise unverified.
        progress: as of :func:`check`.

    Returns:
        The verdict, checks in the order of the contract.
    """
    structure = examine(frame)
    faults = structure.faults + claims.faults(structure, frame)
    found = dict.fromkeys(LIMITS, NOT_MEASURED)
    free_range: tuple[float, float] | None = None
    closed: tuple[Loop, ...] = ()
    crossings: tuple[Crossing, ...] = ()

    mesh, points = structure.mesh, structure.points
    if mesh is not None and structure.halves is not None:
        sine, cosine = structure.halves
        found["planarity"] = measures.planarity(mesh, structure.given)
        found["fold_angle"] = measures.fold_angle(mesh, sine, cosine)
        found["crossing_design"] = collisions.design_crossings(frame.vertices_coords, mesh.facets)
        developed, folded = structure.signs
        if developed is not None:
            found["developability"] = measures.flatness(mesh, structure.given, structure.types, developed, FL)
        if folded is not None:
            found["flat_foldability"] = measures.flatness(mesh, structure.given, structure.types, folded, CFL)
        if structure.typed:
            motion = Motion(mesh, points, structure.types, sine, cosine)
            found["motion_gap"] = motion.gap()
            if mesh.n_holes is not None:
                strips = loops.shortest_strips(mesh)
                faults += mobility.faults(motion, strips)
                found["loop_closure"], closed = loops.closure(motion, strips)
            if all(judge(name, found[name]).passed for name in ("motion_gap", "crossing_design")):
                free_range, crossings = collisions.free_range(motion, progress)

    found["structure"] = float(len(faults)), faults[0] if faults else "no faults"
    checks = {name: judge(name, measured) for name, measured in coarse.explained(found, structure).items()}
    return Certificate(
        certified=all(item.passed for item in checks.values()),
        checks=checks,
        free_range=free_range,
        topology="unknown" if mesh is None else mesh.topology,
        n_holes=None if mesh is None else mesh.n_holes,
        faults=tuple(faults),
        loops=closed,
        crossings=crossings,
    )
