"""Length units of a design in files that know units of their own."""

from __future__ import annotations

import math

# A design without a unit, or with one that is not listed, is taken as it is.
METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "in": 0.0254, "pt": 0.0254 / 72}


def metres(unit: str) -> float:
    """Metres in a unit of FOLD's ``frame_unit``; 1 where it is not known."""
    return METRES.get(unit, 1.0)


def millimetres(unit: str) -> float:
    """Millimetres in a unit; 1 where it is not known."""
    return METRES.get(unit, 1e-3) * 1e3


def scale_in_words(scale: float, unit: str) -> str:
    """The scale of a model as it is written on a drawing, such as "1:50, 1 m = 20 mm".

    Args:
        scale: 0.02 for 1:50.
        unit: of the design.
    """
    ratio = f"1:{1 / scale:.4g}" if scale <= 1 else f"{scale:.4g}:1"
    return f"{ratio}, 1 {unit} = {scale * millimetres(unit):.4g} mm" if unit in METRES else ratio


def ratio_below(scale: float) -> str:
    """The scale, or a little less, in few digits as it is given: 1:53 or 2.4."""
    if scale > 1:
        step = 10.0 ** (math.floor(math.log10(scale)) - 2)
        return f"{math.floor(scale / step) * step:.3g}"
    step = 10.0 ** (math.floor(math.log10(1 / scale)) - 2)
    return f"1:{math.ceil(1 / scale / step) * step:.10g}"


def scale_of(words: str) -> float:
    """The number of a scale that is written as 1:50, 1/50 or 0.02.

    Raises:
        ValueError: it is none; the message says what is.
    """
    model, _, real = words.replace("/", ":").partition(":")
    try:
        scale = float(model) / (float(real) if ":" in words.replace("/", ":") else 1.0)
    except (ValueError, ZeroDivisionError):
        raise ValueError(f"{words} is no scale, such as 1:50 or 0.02") from None
    return scale
