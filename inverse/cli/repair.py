"""`inverse repair`: what is asked, and what is told of the snapped pattern."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from inverse.cli.output import DONE, INTERRUPTED, NOT_DONE, told
from inverse.cli.terminal import ProgressLine
from inverse.files.atomic import json_text

if TYPE_CHECKING:
    from inverse.repair.repairing import Repair


def repair(
    pattern: Path,
    /,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    u_lines: str | None = None,
    v_lines: str | None = None,
    far: Annotated[bool, Parameter(negative=())] = False,
    pictures: Literal["none", "svg", "all"] = "all",
    as_json: Annotated[bool, Parameter(name="--json", negative=())] = False,
) -> int:
    """Snap somebody's pattern to the exact set and say how far it moved.

    Args:
        pattern: FOLD or OBJ file of a semi-folded state, or of a flat crease pattern, which is folded first.
        out: folder for the results; by default out/NAME, after the name of the file.
        u_lines: for a grid, FL or CFL for all interior lines crossed by walking along u, or a word for each,
            separated by commas. Types are read from the file or deduced if neither is given.
        v_lines: the same along v.
        far: take a pattern although it is more than 0.1 rad off somewhere.
        pictures: none, svg (crease patterns only) or all (the 3D views too), all by default.
        as_json: print the result as JSON.
    """
    from inverse import repair as run
    from inverse.results import saving
    from inverse.results.folder import Results, check_same_design, files, output_folder

    folder = output_folder(pattern.stem, out)
    with Results(folder) as results, ProgressLine() as line:
        line.phase(f"repairing {pattern}")
        result = run(pattern, u_lines=u_lines, v_lines=v_lines, far=far)
        check_same_design(folder, result.design.name)
        written = saving.write(result, results, pictures=pictures, phase=line.phase)
    for note in written.notes:
        print(note, file=sys.stderr)
    if as_json:
        print(json_text(_repair_summary(result, folder)))
    else:
        done = result.certified and result.converged
        print(result.status if done else f"NOT REPAIRED: {result.status}", file=sys.stderr)
        for sentence in _repair_lines(result):
            print(sentence)
        for written_line in told(files(folder)):
            print(written_line)
    if written.interrupted:
        return INTERRUPTED
    return DONE if result.certified and result.converged else NOT_DONE


def _repair_lines(result: Repair) -> list[str]:
    found = result.report
    before, after, moved, types = (found[key] for key in ("before", "after", "moved", "line_types"))
    unit = "" if result.design.unit == "unit" else f" {result.design.unit}"
    lines = [f"{key:9} c_dev {errors['developability']:.2g} rad, c_ff {errors['flat_foldability']:.2g} rad, "
             f"planarity {errors['planarity']:.2g} mean edges"
             for key, errors in (("before", before), ("after", after))]  # fmt: skip
    if found["state"] == "crease pattern":
        low, high = found["folded_to"].values()
        lines.append(f"folded    from {low:.0f} to {high:.0f} degrees, mountains and valleys "
                     f"{found['mountains_and_valleys']}")  # fmt: skip
    lines.append(f"moved     {moved['max']:.3g}{unit} at most, {moved['max_relative']:.2g} of the diagonal, at vertex "
                 f"{moved['worst_vertex']}; rms {moved['rms']:.3g}{unit}")  # fmt: skip
    numbers = [line["type"] for line in types["lines"]]
    lines.append(f"lines     {numbers.count('FL')} FL, {numbers.count('CFL')} CFL: {types['found']}")
    return lines


def _repair_summary(result: Repair, folder: Path) -> dict[str, object]:
    found = result.report
    return {
        "status": result.status,
        "certified": result.certified,
        "converged": result.converged,
        "out": str(folder),
        "before": found["before"],
        "after": found["after"],
        "moved": {key: value for key, value in found["moved"].items() if key != "vertices"},
        "line_types": found["line_types"],
    }
