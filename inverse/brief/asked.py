"""One thing that a specification asks of a design, and whether the design has it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Asked:
    """A request, and what a design has to show for it.

    Attributes:
        name: of the request, the key of ``require`` where there is one.
        asked: the limit.
        reached: what was measured.
        unit: of both; ``1`` for shares.
        met: whether the design does what is asked.
        sentence: the same for people, with what to do where it is not met.
    """

    name: str
    asked: float
    reached: float
    unit: str
    met: bool
    sentence: str
