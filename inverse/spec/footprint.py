"""The parts of a specification about the size of the developed or flat-folded state, or of one in between."""

from __future__ import annotations

import itertools
import math
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from inverse.spec.fields import Model, Number, Positive, refusal, shown, word
from inverse.words import did_you_mean

_WORDS = ("developed", "flat-folded")


def _check_state(value: Any) -> Any:
    is_number = type(value) in (int, float) and math.isfinite(value)
    if value in _WORDS or (is_number and 0 < value < 180):
        return value
    suggestion = did_you_mean(value, _WORDS) if isinstance(value, str) else ""
    if is_number and value in (0, 180):
        suggestion = f" Write {_WORDS[value > 0]}."
    allowed = f"{', '.join(_WORDS)} or degrees between 0 and 180"
    raise refusal(f"{shown(value)} is no state: allowed are {allowed}.{suggestion}")


State = Annotated[Literal["developed", "flat-folded"] | Number, BeforeValidator(_check_state)]
_DESCRIPTION = "state: developed, flat-folded or degrees between 0 and 180, of which 90 is the design state"


def radians(state: str | float) -> float:
    """The folding amount t of a state."""
    return {"developed": 0.0, "flat-folded": math.pi}[state] if isinstance(state, str) else math.radians(state)


class FootprintKeys(Model):
    """What the objective ``footprint`` makes small."""

    state: State = Field(default="flat-folded", description=_DESCRIPTION)
    measure: Annotated[
        Literal["extent", "area"],
        word("measure", {"extent": "mean square of the box's extents", "area": "of the rectangle, in flat states"}),
    ] = Field(
        default="extent", description="extent (mean square of the box's extents) or area (of a flat state's rectangle)"
    )

    @model_validator(mode="after")
    def _check_area(self) -> Self:
        if self.measure == "area" and not isinstance(self.state, str):
            raise refusal("measure: area is for flat states, developed and flat-folded", key="measure")
        return self


class FootprintLimits(Model):
    """The box that a state has to fit into."""

    what: ClassVar[str] = "a footprint"

    state: State = Field(default="flat-folded", description=_DESCRIPTION)
    length: Positive | None = Field(default=None, description="limit of the box's extent that is longest in the seed")
    width: Positive | None = Field(default=None, description="limit of its other extent in the plane, or the next one")
    height: Positive | None = Field(default=None, description="limit of its shortest extent, in a state in between")
    area: Positive | None = Field(default=None, description="limit of length times width, in flat states")

    @model_validator(mode="after")
    def _check_limits(self) -> Self:
        flat = isinstance(self.state, str)
        given = {name: getattr(self, name) for name in ("length", "width", "height", "area")}
        if not any(given.values()):
            raise refusal(f"a footprint needs at least one of {', '.join(given)}")
        if flat and self.height is not None:
            raise refusal(f"the {self.state} state is flat and has no height", key="height", at_key=True)
        if not flat and self.area is not None:
            raise refusal("area is for flat states, developed and flat-folded", key="area", at_key=True)
        sides = [(name, given[name]) for name in ("length", "width", "height") if given[name] is not None]
        for (longer, most), (shorter, size) in itertools.pairwise(sides):
            if size > most:
                raise refusal(f"{shorter} {size:g} is more than {longer} {most:g}: exchange them", key=shorter)
        return self
