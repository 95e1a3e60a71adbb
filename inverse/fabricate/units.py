"""Length units of a design in files that know units of their own."""

from __future__ import annotations

# A design without a unit, or with one that is not listed, is taken as it is.
METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "in": 0.0254, "pt": 0.0254 / 72}


def metres(unit: str) -> float:
    """Metres in a unit of FOLD's ``frame_unit``; 1 where it is not known."""
    return METRES.get(unit, 1.0)


def millimetres(unit: str) -> float:
    """Millimetres in a unit; 1 where it is not known."""
    return METRES.get(unit, 1e-3) * 1e3
