"""The part of a specification that says what a design must come up to, to be as asked."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from inverse.spec.fields import Model, Number, Positive, word

Share = Annotated[Number, Field(ge=0, le=1)]
MOTIONS = {
    "either": "from the design state to one flat state at least",
    "developed": "to the developed state",
    "flat-folded": "to the flat-folded state",
    "both": "all the way",
    "any": "no matter how far",
}


class RequireKeys(Model):
    """What a design must come up to; lengths are in the unit of the specification."""

    fit: Positive | None = Field(
        default=None,
        description="largest rms distance of the fitted points from the target; 1 % of the design's diagonal",
    )
    fit_max: Positive | None = Field(
        default=None, description="largest distance of any of them; 3 % of the design's diagonal"
    )
    surface: Positive | None = Field(
        default=None,
        description="largest distance of any place of the mesh from the target, half the depth of its corrugation"
        " included; two thirds of the largest diameter of a facet of the placed seed",
    )
    missed: Positive | None = Field(
        default=None,
        description="largest distance of any place of the target from the mesh; as much",
    )
    coverage: Share = Field(
        default=0.9,
        description="least share of the target's area, and of that of each of its parts, that the mesh covers, open to"
        " sky or along the normal",
    )
    beyond: Share = Field(
        default=0.15,
        description="largest share of the mesh's area that lies outside the target's rim or over its holes",
    )
    slenderness: Share = Field(default=0.05, description="least width of any facet, over its length")
    motion: Annotated[Literal["either", "developed", "flat-folded", "both", "any"], word("motion", MOTIONS)] = Field(
        default="either",
        description="how far the motion is free of crossing facets: "
        + ", ".join(f"{k} ({v})" for k, v in MOTIONS.items()),
    )
