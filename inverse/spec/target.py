"""The part of a specification that names the target surface: mesh, height, span between curves, tube around an axis."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag

from inverse.errors import InputError
from inverse.spec.fields import (
    FileName,
    Interval,
    Model,
    Number,
    Point,
    Polyline,
    Positive,
    exactly_one,
    refusal,
    row,
    word,
)


class MeshKeys(Model):
    """A target surface from a file."""

    mesh: FileName = Field(description="mesh file of the target, looked up beside the specification")


def _check_height(text: str) -> str:
    from inverse.surfaces.expression import parse  # casadi is loaded where it is needed

    try:
        parse(text)
    except InputError as error:
        raise refusal(error.message, error.hint) from None
    return text


Corner = Annotated[tuple[Number, Number], row("x", "y")]


def _check_outline(polygon: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    from inverse.surfaces.polygon import checked

    try:
        checked(np.array(polygon), "the domain")
    except InputError as error:
        raise refusal(error.message, error.hint) from None
    return polygon


Outline = Annotated[tuple[Corner, ...], Field(min_length=3), AfterValidator(_check_outline)]


def _tag_of_domain(value: Any) -> str:
    return "<polygon>" if isinstance(value, list | tuple) and len(value) > 2 else "<rectangle>"


class HeightKeys(Model):
    """A target surface z(x, y)."""

    height: Annotated[str, AfterValidator(_check_height)] = Field(
        description="height as an expression in x and y, such as 0.45 - 0.3*(x^2 + y^2)"
    )
    domain: Annotated[
        Annotated[tuple[Interval, Interval], row("[x0, x1]", "[y0, y1]"), Tag("<rectangle>")]
        | Annotated[Outline, Tag("<polygon>")],
        Discriminator(_tag_of_domain),
    ] = Field(
        description="where the height is taken: a rectangle [[x0, x1], [y0, y1]], or three or more corners [x, y] of a"
        " polygon, the first not repeated"
    )

    @property
    def polygon(self) -> tuple[tuple[float, float], ...] | None:
        """Corners of the domain where it is given by them."""
        return self.domain if len(self.domain) > 2 else None


class BetweenKeys(Model):
    """A target surface that spans between two curves."""

    between: Annotated[tuple[Polyline, Polyline], row("polyline", "polyline")] = Field(
        description="two polylines, each a list of at least two points [x, y, z]"
    )
    rise: Number = Field(description="rise of the surface above the straight span between the curves")
    profile: Annotated[
        Literal["arc", "parabola", "catenary"], word("profile", {"arc": "", "parabola": "", "catenary": ""})
    ] = Field(default="arc", description="section from curve to curve: arc, parabola or catenary")


class AxisKeys(Model):
    """The centre line of a tube."""

    one_of: ClassVar[tuple[str, ...]] = ("polyline", "spline", "arc")
    what: ClassVar[str] = "an axis"

    polyline: Polyline | None = Field(default=None, description="two or more points [x, y, z] joined by straight lines")
    spline: Polyline | None = Field(default=None, description="two or more points [x, y, z] that a smooth curve meets")
    arc: Annotated[tuple[Point, Point, Point], row("start", "on the way", "end")] | None = Field(
        default=None, description="three points [x, y, z] of a circular arc: its start, one on the way, its end"
    )


Share = Annotated[Number, Field(ge=0, le=1)]
Profile = tuple[Annotated[tuple[Share, Positive], row("fraction", "radius")], ...]


def _tag_of_radius(value: Any) -> str:
    return "<profile>" if isinstance(value, list | tuple) else "<number>"


def _check_profile(radius: float | tuple[tuple[float, float], ...]) -> float | tuple[tuple[float, float], ...]:
    if not isinstance(radius, tuple):
        return radius
    fractions = [pair[0] for pair in radius]
    if len(fractions) < 2:
        raise refusal("a profile needs two or more pairs [fraction, radius]", "Write one number for the same radius.")
    for a, b in itertools.pairwise(fractions):
        if b <= a:
            raise refusal(f"the fractions of the profile must increase, but {b:g} follows {a:g}")
    return radius


Section = Annotated[tuple[Corner, ...], Field(min_length=3)]
SectionProfile = Annotated[
    tuple[Annotated[tuple[Share, Section], row("fraction", "polygon")], ...], Field(min_length=1)
]


def _tag_of_section(value: Any) -> str:
    first = value[0] if isinstance(value, list | tuple) and len(value) else None
    behind = first[-1] if isinstance(first, list | tuple) and len(first) else None
    return "<profile>" if isinstance(behind, list | tuple) else "<polygon>"


def _check_sections(section: tuple[Any, ...]) -> tuple[Any, ...]:
    from inverse.surfaces.section import check_sections  # casadi is loaded where it is needed

    try:
        check_sections(as_sections(section))
    except InputError as error:
        raise refusal(error.message, error.hint) from None
    return section


def as_sections(section: tuple[Any, ...]) -> list[tuple[float, Any]]:
    """Pairs of a fraction of the length and a polygon, from the polygon alone or from such pairs."""
    return [(0.0, section)] if isinstance(section[0][1], float | int) else [(t, polygon) for t, polygon in section]


def _check_implicit(text: str) -> str:
    from inverse.surfaces.expression import SPACE, parse  # casadi is loaded where it is needed

    try:
        parse(text, SPACE, "implicit expression")
    except InputError as error:
        raise refusal(error.message, error.hint) from None
    return text


class TubeKeys(Model):
    """A tube around an axis, by its radius or by a surface whose mean distance from the axis is the radius."""

    one_of: ClassVar[tuple[str, ...]] = ("radius", "section", "mesh", "implicit")
    what: ClassVar[str] = "a target around an axis"

    axis: AxisKeys = Field(description="the centre line of the tube, by exactly one of polyline, spline and arc")
    radius: (
        Annotated[
            Annotated[Positive, Tag("<number>")] | Annotated[Profile, Tag("<profile>")],
            Discriminator(_tag_of_radius),
            AfterValidator(_check_profile),
        ]
        | None
    ) = Field(
        default=None,
        description="rms distance of a ring's facet centroids from the axis, one number or [[fraction of the length,"
        " radius], ...]",
    )
    section: (
        Annotated[
            Annotated[Section, Tag("<polygon>")] | Annotated[SectionProfile, Tag("<profile>")],
            Discriminator(_tag_of_section),
            AfterValidator(_check_sections),
        ]
        | None
    ) = Field(
        default=None,
        description="closed polygon across the axis that the tube follows, three or more corners [x, y], the first not"
        " repeated, or [[fraction of the length, polygon], ...]; y is up (of a vertical axis the y of space), x to the"
        " right seen from the end of the axis, and [0, 0] lies on it",
    )
    mesh: FileName | None = Field(
        default=None, description="mesh file of a surface around the axis, looked up beside the specification"
    )
    implicit: Annotated[str, AfterValidator(_check_implicit)] | None = Field(
        default=None, description="surface around the axis where an expression in x, y and z is zero, x^2 + y^2 - 1"
    )

    @property
    def sections(self) -> list[tuple[float, Any]]:
        """Pairs of a fraction of the length and a polygon of [x, y]."""
        return as_sections(self.section) if self.section else []


class SurfaceKeys(Model):
    """A target surface that a registered function makes; further keys are its parameters."""

    model_config = ConfigDict(extra="allow", frozen=True)

    surface: Annotated[str, Field(min_length=1)] = Field(
        description="name of a target surface that @inverse.target registered; further keys are its parameters"
    )

    @property
    def parameters(self) -> dict[str, Any]:
        """Those of the function, by name."""
        return dict(self.model_extra or {})


_TARGETS: dict[str, type[Model]] = {
    "mesh": MeshKeys,
    "height": HeightKeys,
    "between": BetweenKeys,
    "axis": TubeKeys,
    "surface": SurfaceKeys,
}


def _check_target(value: Any) -> Any:
    if isinstance(value, BaseModel):
        return value
    if isinstance(value, Mapping) and (value.get("axis") is not None or value.get("surface") is not None):
        return value  # their own models know what else they take
    others = {name for model in _TARGETS.values() for name in model.model_fields} - set(_TARGETS)
    return exactly_one(value, "target", tuple(_TARGETS), tuple(sorted(others)))


def _tag_of_target(value: Any) -> str:
    if isinstance(value, BaseModel):
        return f"<{type(value).__name__}>"
    if value.get("surface") is not None:
        return "<SurfaceKeys>"
    if "axis" in value:
        return "<TubeKeys>"
    return next(f"<{model.__name__}>" for key, model in _TARGETS.items() if key in value)


TargetKeys = Annotated[
    Annotated[MeshKeys, Tag("<MeshKeys>")]
    | Annotated[HeightKeys, Tag("<HeightKeys>")]
    | Annotated[BetweenKeys, Tag("<BetweenKeys>")]
    | Annotated[TubeKeys, Tag("<TubeKeys>")]
    | Annotated[SurfaceKeys, Tag("<SurfaceKeys>")],
    Discriminator(_tag_of_target),
    BeforeValidator(_check_target),
]
