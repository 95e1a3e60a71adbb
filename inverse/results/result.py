"""What a solve found, as plain data that can be pickled, saved and gone on from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

from inverse._types import FloatArray
from inverse.brief.asked import Asked
from inverse.brief.covering import Coverage
from inverse.certify import Certificate
from inverse.files.atomic import finite
from inverse.origami.pattern import Design
from inverse.pictures.design_state import Surface
from inverse.policy.attempts import Attempt
from inverse.policy.measures import Fit
from inverse.policy.verdict import Judgement


@dataclass(frozen=True)
class Size:
    """How large the program was.

    Attributes:
        facets: of the design.
        variables: of the program.
        rows: of its constraints.
        degrees_of_freedom: of the pattern.
    """

    facets: int
    variables: int
    rows: int
    degrees_of_freedom: int


@dataclass(frozen=True, eq=False)
class Result:
    """What a solve found, whether or not it is any good.

    Attributes:
        ending: a word of :data:`inverse.policy.endings.ENDINGS`: ``solved``, or why not.
        status: the same as a sentence: how it ended and, unless solved, what to do next.
        converged: stationary and feasible by our own test.
        certified: the independent certificate passes.
        interrupted: stopped by the user, the time limit or a broken watch; the design is the best so far.
        design: the design.
        seed: the placed seed.
        multipliers: (R,) of all constraint rows, which make the result a start for a task like it.
        certificate: the independent certificate of the design.
        fit: distances of the fitted points from the target.
        coverage: what of the target the mesh covers, and what of the mesh lies beyond.
        asked: what the specification asks, and what the design has to show for it.
        footprint: extents of the flat states and of others that were asked for, as in ``report.json``.
        measures: values of measures of one's own (:func:`inverse.measure`) by name; NaN where one failed.
        failed_measures: why, as sentences.
        notes: sentences about how the specification was understood, such as who holds a corner.
        objective: weighted value of every term.
        judgement: how near the design is to a solution.
        failed: what fails of our own verdict, as sentences.
        attempts: everything that was tried.
        reached: share of the target's heights that a path from the seed reached, where one was needed.
        equations: rows, rank, freedom and condition of the equations where some follow from others, else None.
        size: of the program.
        seconds: spent on parts of the work.
        specification: the whole specification, defaults included, as JSON.
        target: vertices (V, 3) and triangles (T, 3) of the target, for pictures.
        context: the same of the buildings around, or None.
    """

    ending: str
    status: str
    converged: bool
    certified: bool
    interrupted: bool
    design: Design
    seed: Design
    multipliers: FloatArray
    certificate: Certificate
    fit: Fit
    coverage: Coverage
    asked: tuple[Asked, ...]
    footprint: Mapping[str, Any]
    measures: Mapping[str, float]
    failed_measures: tuple[str, ...]
    notes: tuple[str, ...]
    objective: Mapping[str, float]
    judgement: Judgement
    failed: tuple[str, ...]
    attempts: tuple[Attempt, ...]
    reached: float | None
    equations: Mapping[str, float] | None
    size: Size
    seconds: Mapping[str, float]
    specification: Mapping[str, Any]
    target: Surface
    context: Surface | None

    @property
    def name(self) -> str:
        """The name of the specification."""
        return self.design.name

    @property
    def as_asked(self) -> bool:
        """Whether the design is what the specification asks for."""
        return all(one.met for one in self.asked)

    @property
    def solved(self) -> bool:
        """Certified, converged and as asked."""
        return self.certified and self.converged and self.as_asked

    @property
    def verdicts(self) -> tuple[str, str, str]:
        """Three sentences: whether the design is foldable, optimal and as asked."""
        optimal = "stationary, and all constraints hold" if self.converged else "; ".join(self.failed)
        failing = "; ".join(one.sentence for one in self.asked if not one.met)
        asked = failing if failing else f"all {len(self.asked)} requests are met"
        return (
            self.certificate.sentence,
            f"optimal   {'yes' if self.converged else 'NO'}: {optimal}",
            f"as asked  {'NO' if failing else 'yes'}: {asked}",
        )

    @property
    def caption(self) -> str:
        """The verdicts in a few words, for pictures."""
        missed = ", ".join(dict.fromkeys(one.name for one in self.asked if not one.met))
        said = {"foldable": self.certified, "optimal": self.converged, "as asked": self.as_asked}
        words = [f"{name}: {'yes' if is_so else 'NO'}" for name, is_so in said.items()]
        return "   ".join(words) + (f" ({missed})" if missed else "")

    @property
    def iterations(self) -> int:
        """Iterations of all runs."""
        return sum(attempt.iterations for attempt in self.attempts)

    @property
    def report(self) -> dict[str, Any]:
        """Everything that ``report.json`` tells of the solve; None stands for what is no finite number."""
        told = {
            "name": self.name,
            "status": self.status,
            "converged": self.converged,
            "certified": self.certified,
            "as_asked": self.as_asked,
            "asked": [asdict(one) for one in self.asked],
            "fit": self.fit.document(),
            "coverage": asdict(self.coverage),
            "footprint": self.footprint,
            "measures": self.measures,
            "failed_measures": self.failed_measures,
            "objective": self.objective,
            "verdict": self.judgement.document() | {"failed": list(self.failed)},
            "iterations": self.iterations,
            "attempts": [attempt.document() for attempt in self.attempts],
            "reached": self.reached,
            "equations": self.equations,
            "size": asdict(self.size),
            "ending": self.ending,
            "seconds": self.seconds,
            "specification": self.specification,
        }
        return {key: finite(value) for key, value in told.items()}

    def save(self, folder: Path | str, *, pictures: Literal["none", "svg", "all"] | None = None) -> list[str]:
        """Write design, certificate, report and pictures, as the command line does.

        Args:
            folder: where; made if missing. Files of an earlier result there are replaced, others stay.
            pictures: none, svg (crease patterns) or all; by default what the specification says.

        Returns:
            The notes, and sentences about pictures that could not be drawn.

        Raises:
            InputError: the folder cannot be written to, or another run is writing to it; what was there is still there.
        """
        from inverse.results.saving import save

        return save(self, Path(folder), pictures=pictures)


class SolveError(RuntimeError):
    """A solve that was to raise where its design is not certified, converged and as asked.

    Args:
        result: what it found nevertheless; its status says how it ended and what to do next.
    """

    def __init__(self, result: Result) -> None:
        self.result = result
        super().__init__(result.status)
