"""Somebody else's pattern, snapped to the exact set: how far it was off, how far it moved, and a certificate."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from inverse._types import IntArray
from inverse.certify import Certificate, check_frame
from inverse.errors import InputError
from inverse.files import fold_file
from inverse.origami.pattern import CFL, FL, Design
from inverse.repair import grid, line_types
from inverse.repair.assignments import foldings
from inverse.repair.crease_pattern import angle_range, check_all_foldlines, folded, laid_out, snapped_at_best_state
from inverse.repair.foreign import read_foreign
from inverse.repair.measures import Residuals, moved, residuals
from inverse.repair.network import Network, build_network
from inverse.repair.snap import Snapped, snapped

OFF = 0.1  # radians at a vertex, or mean edges off a facet's plane: a pattern further off is another pattern


@dataclass(frozen=True, eq=False)
class Repair:
    """A repaired pattern.

    Attributes:
        status: one sentence; what fails, if anything.
        converged: the equations hold to rounding and the mesh is still one: facets convex, mountains mountains.
        certified: verdict of the independent certificate.
        design: the exact design in an intermediate state.
        original: the pattern as given, vertices in the same order; flat where the file holds a crease pattern.
        certificate: of the design.
        report: JSON-safe: residuals before and after, what moved how far, line types.
    """

    status: str
    converged: bool
    certified: bool
    design: Design
    original: Design
    certificate: Certificate
    report: dict[str, Any]


def repaired(pattern: Path | str | Design, u_lines: str | None, v_lines: str | None, *, far: bool) -> Repair:
    """See :func:`inverse.repair`."""
    if isinstance(pattern, Design):
        where = pattern.name
        network = Network(pattern, False, {}, {}, np.arange(pattern.pattern.n_vertices))
    else:
        where = str(pattern)
        network = build_network(read_foreign(Path(pattern)), Path(pattern))
    try:
        return _repaired(network, isinstance(pattern, Design), (u_lines, v_lines), far)
    except InputError as error:
        raise InputError(error.message, where=where, hint=error.hint) from None


def _repaired(network: Network, is_design: bool, words: tuple[str | None, str | None], far: bool) -> Repair:
    original, how = _typed(network, is_design, words)
    before = residuals(original)
    _check_near(original, before, network, how, far)
    report: dict[str, Any] = {"state": "crease pattern" if network.is_flat else "semi-folded"}
    if network.is_flat:
        motion = foldings(original, network.assignments, network.file_vertices)
        if not far:
            _check_folded(folded(original, motion), network)
        result = snapped_at_best_state(original, motion)
        comparable = laid_out(result.design, original).vertices_coords
        low, high = angle_range(result.design)
        report |= {
            "mountains_and_valleys": "searched" if motion.searched else "from the file",
            "folded_to": {"least_degrees": low, "largest_degrees": high},
            "largest_disagreement": float(motion.disagreement.max(initial=0.0)),
        }
    else:
        result = snapped(original)
        comparable = result.design.vertices_coords
    design = result.design
    certificate = check_frame(fold_file.frame(design))
    inner = design.pattern.edges_type[design.pattern.interior_edges]
    report |= {
        "converged": not result.faults,
        "certified": certificate.certified,
        "before": before.document(),
        "after": residuals(design).document(),
        "moved": _by_file_number(moved(original.vertices_coords, comparable), network.file_vertices),
        "line_types": {
            "found": how,
            "FL": int((inner == FL).sum()),
            "CFL": int((inner == CFL).sum()),
            "lines": _lines(design, network.file_vertices),
        },
        "size": {
            "vertices": design.pattern.n_vertices,
            "facets": len(design.pattern.faces_vertices),
            "degrees_of_freedom": design.pattern.degrees_of_freedom,
        },
    }
    if not np.array_equal(network.file_vertices, np.arange(len(network.file_vertices))):
        report["file_vertices"] = network.file_vertices.tolist()
    return Repair(_status(result, certificate), not result.faults, certificate.certified, design, original,
                  certificate, report)  # fmt: skip


def _typed(network: Network, is_design: bool, words: tuple[str | None, str | None]) -> tuple[Design, str]:
    """The pattern with its line types, and how they were found."""
    design, pattern = network.design, network.design.pattern
    if words != (None, None):
        types, how = grid.types_of_words(pattern, words[0] or "FL", words[1] or "FL"), "given"
    elif is_design:
        return design, "of the design"
    elif (given := line_types.from_file(pattern, network.types)) is not None:
        types, how = given, "bdffpq:edges_type of the file"
    elif network.is_flat:
        types, how = pattern.edges_type.astype(np.int64), "all FL, as in every crease pattern of one layer"
    else:
        types, how = line_types.deduced(design), "deduced from sector angles and folds"
    pattern = replace(line_types.typed(pattern, types), grid=grid.numbered_size(pattern))
    if network.is_flat:
        check_all_foldlines(pattern)
    return replace(design, pattern=pattern), how


def _check_near(design: Design, before: Residuals, network: Network, how: str, far: bool) -> None:
    """Refuse what is no slightly inexact pattern."""
    if far:
        return
    angles, pattern = before.angles, design.pattern
    if angles.max(initial=0.0) > OFF:
        k = int(np.argmax(angles))
        vertex = network.file_vertices[pattern.interior_vertices[k]]
        reason = _other_reading(design, k) if how.startswith("deduced") else ""
        count = int((angles > OFF).sum())
        others = f" ({count} vertices are off by more than that)" if count > 1 else ""
        raise InputError(
            f"the sector angles at vertex {vertex} are off by {angles[k]:.3g} rad{reason}: "
            f"{OFF:g} rad is allowed{others}",
            hint="Correct the pattern there, give the line types if they are misread, or repair it nevertheless with "
            "--far.",
        )
    if before.planarity.max(initial=0.0) > OFF:
        f = int(np.argmax(before.planarity))
        corners = network.file_vertices[list(pattern.faces_vertices[f])].tolist()
        raise InputError(
            f"the facet with vertices {corners} is off its plane by {before.planarity[f]:.3g} mean edges: "
            f"{OFF:g} is allowed",
            hint="Correct the pattern there, or repair it nevertheless with --far.",
        )


def _other_reading(design: Design, k: int) -> str:
    """What a vertex says by itself about the types of its two lines, where the others overrule it."""
    pattern = design.pattern
    types = pattern.edges_type.astype(np.int64)
    line_of = line_types.lines_of_edges(pattern)
    first, second = line_of[pattern.ring_edges[k, :2]]
    if first == second:
        return ""
    line = line_of == first
    types[line] = np.where(types[line] == FL, CFL, FL)
    exchanged = replace(pattern, edges_type=types.astype(np.int8))
    error = float(residuals(replace(design, pattern=exchanged)).angles[k])
    if error > OFF:
        return ""
    one, other = ("one type", "two") if pattern.is_miura_vertex[k] else ("two types", "one")
    return f" if its lines are of {one} as the others want ({error:.3g} rad if of {other})"


def _check_folded(start: Design, network: Network) -> None:
    """Refuse a crease pattern that tears when it folds."""
    torn = residuals(start)
    if torn.angles.max(initial=0.0) > OFF:
        k = int(np.argmax(torn.angles))
        vertex = network.file_vertices[start.pattern.interior_vertices[k]]
        raise InputError(
            f"the crease pattern tears when it is folded: the sector angles at vertex {vertex} change by "
            f"{torn.angles[k]:.3g} rad, {OFF:g} is allowed",
            hint="Its lines of creases do not open and close together: correct it, or repair it nevertheless with "
            "--far.",
        )


def _by_file_number(distances: dict[str, Any], file_vertices: IntArray) -> dict[str, Any]:
    return distances | {"worst_vertex": int(file_vertices[distances["worst_vertex"]])}


def _lines(design: Design, file_vertices: IntArray) -> list[dict[str, Any]]:
    """Type of every line, by the file's numbers of its vertices."""
    pattern = design.pattern
    line_of: IntArray = line_types.lines_of_edges(pattern)
    kind = {int(n): int(t) for n, t in zip(line_of, pattern.edges_type, strict=True)}
    return [
        {"type": "FL" if kind[n] == FL else "CFL", "vertices": file_vertices[list(line)].tolist()}
        for n, line in enumerate(pattern.lines)
    ]


def _status(result: Snapped, certificate: Certificate) -> str:
    failed = [*result.faults, *(check.sentence for check in certificate.checks.values() if not check.passed)]
    if not failed:
        return "exact and certified"
    if certificate.n_holes:
        failed.append("a repair imposes the equations of vertices and facets only, not closure around holes")
    return "; ".join(failed)
