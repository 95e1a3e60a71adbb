"""Scales of drawings: 1:100, or millimetres on paper for a unit that has no length."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from inverse.errors import InputError
from inverse.fabricate.units import METRES, millimetres

# Of usual scales, times powers of ten: 1:75 and 1:250, and for views that are not measured 1:30 and the like.
USUAL = (1.0, 1.5, 2.0, 2.5, 5.0, 7.5)
ANY = (1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.5)
_WORD = re.compile(r"\s*(\d+(?:\.\d+)?)\s*:\s*(\d+(?:\.\d+)?)\s*")
LEAST, MOST = 1e-6, 1e6


@dataclass(frozen=True)
class Scale:
    """A scale.

    Attributes:
        factor: millimetres on paper for one of the design's unit.
        words: how it is told, such as 1:100.
    """

    factor: float
    words: str


def read_scale(word: str, unit: str) -> Scale:
    """The scale that somebody asks for, such as 1:50.

    Args:
        word: what was given.
        unit: of the design.

    Raises:
        InputError: it is none, or the unit has no length.
    """
    found = _WORD.fullmatch(word)
    if found is None or not float(found[1]) or not float(found[2]):
        raise InputError(f"{word!r} is no scale", hint="Write it as 1:50.")
    if unit not in METRES:
        raise InputError(
            f"the design's unit is {unit!r}, which has no length, so it cannot be drawn {word}",
            hint=f"Leave --scale out, or give the file a frame_unit ({', '.join(METRES)}).",
        )
    paper, real = float(found[1]), float(found[2])
    if not LEAST <= paper / real <= MOST:
        raise InputError(f"the scale {word} is beyond 1:{MOST:.0f}", hint="Leave --scale out for one that fits.")
    return Scale(millimetres(unit) * paper / real, f"{paper:.10g}:{real:.10g}")


def largest_scale(most: float, unit: str, steps: tuple[float, ...] = USUAL) -> Scale:
    """The largest usual scale at which one unit is no more than ``most`` mm on paper, among ``steps``."""
    if unit not in METRES:
        nice = _below(most, steps)
        return Scale(nice, f"1 unit = {nice:.10g} mm")
    ratio = most / millimetres(unit) * (1 + 1e-9)
    if ratio >= 1:
        nice = _below(ratio, steps)
        return Scale(millimetres(unit) * nice, f"{nice:.10g}:1")
    nice = _above(1 / ratio, steps)
    return Scale(millimetres(unit) / nice, f"1:{nice:.10g}")


def round_length(most: float) -> float:
    """The largest of 1, 2, 5, 10, 20 ... (and 0.5, 0.2 ...) that is no more than ``most``."""
    power = 10.0 ** math.floor(math.log10(most))
    return float(f"{max(step for step in (1.0, 2.0, 5.0) if step <= most / power * (1 + 1e-9)) * power:.3g}")


def _below(value: float, steps: tuple[float, ...]) -> float:
    power = 10.0 ** math.floor(math.log10(value))
    return float(f"{max(step for step in steps if step <= value / power * (1 + 1e-9)) * power:.6g}")


def _above(value: float, steps: tuple[float, ...]) -> float:
    power = 10.0 ** math.floor(math.log10(value))
    return float(f"{min(step for step in (*steps, 10.0) if step >= value / power * (1 - 1e-9)) * power:.6g}")
