"""The part of a specification that names the target surface: a mesh, a height or a span between curves."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, Discriminator, Field, Tag

from inverse.errors import InputError
from inverse.fields import FileName, Interval, Model, Number, Polyline, exactly_one, refusal, row, word


class MeshTarget(Model):
    """A target surface from a file."""

    mesh: FileName = Field(description="mesh file of the target, looked up beside the specification")


def _check_height(text: str) -> str:
    from inverse.target.expression import parse  # casadi is loaded where it is needed

    try:
        parse(text)
    except InputError as error:
        raise refusal(error.message, error.hint) from None
    return text


class HeightTarget(Model):
    """A target surface z(x, y)."""

    height: Annotated[str, AfterValidator(_check_height)] = Field(
        description="height as an expression in x and y, such as 0.45 - 0.3*(x^2 + y^2)"
    )
    domain: Annotated[tuple[Interval, Interval], row("[x0, x1]", "[y0, y1]")] = Field(
        description="where the height is taken, [[x0, x1], [y0, y1]]"
    )


class BetweenTarget(Model):
    """A target surface that spans between two curves."""

    between: Annotated[tuple[Polyline, Polyline], row("polyline", "polyline")] = Field(
        description="two polylines, each a list of at least two points [x, y, z]"
    )
    rise: Number = Field(description="rise of the surface above the straight span between the curves")
    profile: Annotated[
        Literal["arc", "parabola", "catenary"], word("profile", {"arc": "", "parabola": "", "catenary": ""})
    ] = Field(default="arc", description="section from curve to curve: arc, parabola or catenary")


_TARGETS: dict[str, type[Model]] = {"mesh": MeshTarget, "height": HeightTarget, "between": BetweenTarget}


def _check_target(value: Any) -> Any:
    if isinstance(value, BaseModel):
        return value
    others = {name for model in _TARGETS.values() for name in model.model_fields} - set(_TARGETS)
    return exactly_one(value, "target", tuple(_TARGETS), tuple(sorted(others)))


def _tag_of_target(value: Any) -> str:
    if isinstance(value, BaseModel):
        return f"<{type(value).__name__}>"
    return next(f"<{model.__name__}>" for key, model in _TARGETS.items() if key in value)


Target = Annotated[
    Annotated[MeshTarget, Tag("<MeshTarget>")]
    | Annotated[HeightTarget, Tag("<HeightTarget>")]
    | Annotated[BetweenTarget, Tag("<BetweenTarget>")],
    Discriminator(_tag_of_target),
    BeforeValidator(_check_target),
]
