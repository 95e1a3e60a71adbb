"""Target surfaces: what a design is fitted to."""

from __future__ import annotations

from inverse.surfaces.base import ClosestPoints, Frame, Target

__all__ = ["ClosestPoints", "Frame", "Target"]
