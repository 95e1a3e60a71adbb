"""Perforation as real dashes, since cutters ignore line styles."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from inverse.errors import InputError
from inverse.fabricate.cut.plan import FOLDS, Line, Plan

MOST_CUTS = 500_000  # a file of some 100 MB


def perforated(plan: Plan, dash: float, gap: float) -> Plan:
    """The same drawing with dashes in place of the lines that are folded.

    Dashes have the length that is asked for and lie evenly; gaps are made so much longer that both ends of a line have
    half a gap: no dash comes near a vertex, where the sheet would tear. A line too short for that has one dash of half
    its length in its middle.

    Args:
        plan: the drawing.
        dash: length of a cut in mm.
        gap: least length of what is left between cuts, in mm.

    Raises:
        InputError: a length that is not positive, or so short that there would be too many cuts.
    """
    for name, length in (("dashes", dash), ("gaps", gap)):
        if not (np.isfinite(length) and length > 0):
            raise InputError(f"the {name} are {length:g} mm long: more than 0 is needed")
    folded = np.array([line.ends for line in plan.lines if line.layer in FOLDS]).reshape(-1, 2, 2)
    cuts = float((np.linalg.norm(folded[:, 1] - folded[:, 0], axis=1) / (dash + gap)).sum())
    if cuts > MOST_CUTS:
        raise InputError(
            f"dashes of {dash:g} mm and gaps of {gap:g} mm make {cuts:.3g} cuts: at most {MOST_CUTS} are drawn",
            hint="Give longer ones, or a smaller scale.",
        )
    lines = [part for line in plan.lines for part in (_dashed(line, dash, gap) if line.layer in FOLDS else [line])]
    return replace(plan, lines=tuple(lines))


def _dashed(line: Line, dash: float, gap: float) -> list[Line]:
    length = float(np.linalg.norm(line.ends[1] - line.ends[0]))
    count = int(length / (dash + gap))
    cut = dash if count else length / 2
    period = length / max(count, 1)
    middles = (np.arange(max(count, 1)) + 0.5) * period
    shares = np.stack([middles - cut / 2, middles + cut / 2], axis=1) / length
    ends = line.ends[0] + shares[..., None] * (line.ends[1] - line.ends[0])
    return [replace(line, ends=own) for own in ends]
