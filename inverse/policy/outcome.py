"""Where one step of the policy ended, polished, certified and judged."""

from __future__ import annotations

from dataclasses import dataclass

from inverse.certify import Certificate
from inverse.nlp.point import Point
from inverse.origami.pattern import Design
from inverse.policy import verdict
from inverse.policy.verdict import Judgement


@dataclass(frozen=True, eq=False)
class Outcome:
    """Where one step of the policy ended, polished and judged.

    Attributes:
        point: where.
        design: the design.
        certificate: its independent certificate.
        judgement: our own verdict.
        range_faults: what of an asked range of motion is not free, as sentences.
        raised: what a step raised that should not, as sentences.
        kept: where the design comes from, a sentence, if the step was ended early.
    """

    point: Point
    design: Design
    certificate: Certificate
    judgement: Judgement
    range_faults: tuple[str, ...]
    raised: tuple[str, ...] = ()
    kept: str | None = None

    @property
    def failed(self) -> tuple[str, ...]:
        """What fails of our own verdict, as sentences."""
        return self.raised + self.judgement.failed + self.range_faults

    @property
    def converged(self) -> bool:
        """Stationary and feasible by our own test."""
        return not self.failed

    @property
    def is_feasible(self) -> bool:
        """Whether all constraints hold."""
        return self.point.violation <= verdict.BOUND

    @property
    def is_solved(self) -> bool:
        """Certified and converged."""
        return self.converged and self.certificate.certified

    @property
    def _rank(self) -> tuple[bool, bool, float, float]:
        return (
            self.is_solved,
            self.certificate.certified,
            -max(self.point.violation, verdict.BOUND),
            -self.point.objective,
        )

    def better(self, other: Outcome | None) -> Outcome:
        """This one, unless the other is better."""
        return self if other is None or self._rank > other._rank else other


def reasons(outcome: Outcome) -> list[str]:
    """Why an outcome is not certified and converged, as sentences; empty if it is."""
    failed = [check.sentence for check in outcome.certificate.checks.values() if not check.passed]
    return [*failed, *outcome.failed]
