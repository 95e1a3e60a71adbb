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
        sentence: the same for people.
        advice: what to do about it; empty where it is met.
    """

    name: str
    asked: float
    reached: float
    unit: str
    met: bool
    sentence: str
    advice: str = ""

    @property
    def told(self) -> str:
        """The sentence, and after it the advice if there is one."""
        return f"{self.sentence}. {self.advice}" if self.advice else self.sentence
