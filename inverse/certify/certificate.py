"""What a certificate holds and how it is told to people and to programs."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

# Names, limits and units of the checks, in the order in which they are reported. Every value must stay at or
# below its limit, but for the fold angle, which must reach it.
LIMITS: dict[str, tuple[float, str]] = {
    "structure": (0.0, "faults"),
    "planarity": (1e-9, "edge lengths"),
    "developability": (1e-9, "rad"),
    "flat_foldability": (1e-9, "rad"),
    "fold_angle": (1.0, "degrees"),
    "motion_gap": (1e-9, "diagonals"),
    "loop_closure": (1e-9, "diagonals"),
    "crossing_design": (0.0, "pairs"),
}
AT_LEAST = frozenset({"fold_angle"})
MAX_LISTED_FAULTS = 50

# A measured value and where it was found; the value None says that it could not be measured.
Measured = tuple[float | None, str]
NOT_MEASURED: Measured = (None, "not measured: structure")


@dataclass(frozen=True)
class Check:
    """One measured number and its limit.

    Attributes:
        name: key of :data:`LIMITS`.
        value: what was measured, in ``unit``; None if it could not be.
        limit: what is allowed.
        unit: unit of value and limit; a diagonal is that of the design's bounding box.
        worst: where the value was found, or why nothing was measured.
        passed: whether the value keeps the limit.
    """

    name: str
    value: float | None
    limit: float
    unit: str
    worst: str
    passed: bool

    @property
    def sentence(self) -> str:
        """The check as a sentence for people."""
        verdict = "passed" if self.passed else "FAILED"
        if self.value is None:
            return f"{self.name}: {verdict}, {self.worst}"
        bound = "at least" if self.name in AT_LEAST else "at most"
        return (
            f"{self.name}: {verdict}, {told_apart(self.value, self.limit)} {self.unit}"
            f" ({bound} {self.limit:g} allowed), worst: {self.worst}"
        )


def told_apart(value: float, limit: float) -> str:
    """A value with three digits, or as many more as show that it is not its limit."""
    for digits in range(3, 17):
        text = f"{value:.{digits}g}"
        if float(text) != limit or value == limit:
            return text
    return repr(value)


def judge(name: str, measured: Measured) -> Check:
    """Hold a measured value against the limit of its check; what is not a finite number fails."""
    limit, unit = LIMITS[name]
    value, worst = measured
    if value is None or not math.isfinite(value):
        return Check(name, None, limit, unit, worst, passed=False)
    passed = value >= limit if name in AT_LEAST else value <= limit
    return Check(name, float(value), limit, unit, worst, passed)


@dataclass(frozen=True)
class Loop:
    """A closed strip of facets around a hole, on which closure was measured.

    Attributes:
        facets: the facets in order, k of them; the last shares an edge with the first.
        states: k + 1, the states at which the strip must be closed to be so in all.
        gap_at_states: largest gap there, relative to the diagonal.
        gap_between: largest gap at other states, which check the argument.
        conditioning: factor by which gaps at the k + 1 states may grow between them.
    """

    facets: tuple[int, ...]
    states: int
    gap_at_states: float
    gap_between: float
    conditioning: float

    @property
    def gap(self) -> float:
        """Largest gap of all."""
        return max(self.gap_at_states, self.gap_between)

    @property
    def sentence(self) -> str:
        """For messages."""
        return (
            f"strip of {len(self.facets)} facets from facet {self.facets[0]}: opens by {self.gap_at_states:.2g}"
            f" diagonals at {self.states} states (conditioning {self.conditioning:.2g}),"
            f" by {self.gap_between:.2g} at others"
        )


@dataclass(frozen=True)
class Crossing:
    """Where the motion away from the design state first brings facets through each other.

    Attributes:
        t: the last state without, in degrees.
        facets: pairs of facets that cross just beyond.
    """

    t: float
    facets: tuple[tuple[int, int], ...]

    @property
    def sentence(self) -> str:
        """For messages."""
        a, b = self.facets[0]
        more = f" and {len(self.facets) - 1} more pairs" if len(self.facets) > 1 else ""
        return f"facets {a} and {b}{more} cross beyond t = {self.t:.2f} degrees"


@dataclass(frozen=True)
class Certificate:
    """The verdict on one design file.

    Attributes:
        certified: every check passed.
        checks: by name, in the order of :data:`LIMITS`.
        free_range: (t_min, t_max) in degrees, the sampled part of the motion around the design state
            (t = 90) in which no facets cross; None if the motion or the design state itself is at fault.
        topology: ``disk``, ``cylinder``, ``holes:<n>`` or ``unknown``, derived from the facets.
        n_holes: number of holes; None if the surface is no disk with or without holes.
        faults: what the structure check found, one sentence each.
        loops: one strip per hole.
        crossings: what ends the free range before a flat state.
    """

    certified: bool
    checks: dict[str, Check]
    free_range: tuple[float, float] | None
    topology: str
    n_holes: int | None
    faults: tuple[str, ...]
    loops: tuple[Loop, ...]
    crossings: tuple[Crossing, ...]

    @property
    def sentence(self) -> str:
        """The verdict as a sentence: whether the design is foldable."""
        if not self.certified:
            failed = "; ".join(check.sentence for check in self.checks.values() if not check.passed)
            return f"foldable  NO: not certified: {failed}"
        low, high = self.free_range or (90.0, 90.0)
        return f"foldable  yes: certified, facets cross nowhere from t = {low:g} to {high:g} degrees"

    def document(self) -> dict[str, Any]:
        """The certificate as JSON-safe data, the form of ``certificate.json``."""
        return {
            "certified": self.certified,
            "checks": {
                name: {
                    "value": check.value,
                    "limit": check.limit,
                    "unit": check.unit,
                    "worst": check.worst,
                    "pass": check.passed,
                }
                for name, check in self.checks.items()
            },
            "free_range": None if self.free_range is None else list(self.free_range),
            "topology": self.topology,
            "n_holes": self.n_holes,
            "faults": list(self.faults[:MAX_LISTED_FAULTS]),
            "loops": [asdict(loop) | {"facets": list(loop.facets), "gap": loop.gap} for loop in self.loops],
            "crossings": [{"t": end.t, "facets": [list(pair) for pair in end.facets]} for end in self.crossings],
        }
