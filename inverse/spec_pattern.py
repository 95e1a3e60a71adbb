"""The part of a specification that names the pattern: a built-in grid or a file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, Discriminator, Field, Tag, model_validator

from inverse.fields import FileName, Integer, Model, Number, Positive, Switch, refusal, row, shown, word
from inverse.words import did_you_mean


def _tag_of_line_types(value: Any) -> str:
    return "<words>" if isinstance(value, list | tuple) else "<word>"


LineType = Annotated[Literal["FL", "CFL"], word("line type", {"FL": "foldline", "CFL": "complementary foldline"})]
LineTypes = Annotated[
    Annotated[LineType, Tag("<word>")] | Annotated[tuple[LineType, ...], Tag("<words>")],
    Discriminator(_tag_of_line_types),
]
Turn = Annotated[Literal[0, 90], word("turn of a pattern", {0: "", 90: ""})]
FacetCount = Annotated[Integer, Field(ge=1, le=512)]


class GridPattern(Model):
    """A grid of quads whose seed is a translation surface."""

    kind: Literal["grid"] = Field(default="grid", description="a built-in grid of quads")
    size: Annotated[tuple[FacetCount, FacetCount], row("m", "n")] = Field(
        description="numbers of facets along u and v, [m, n], each from 1 to 512"
    )
    u_lines: LineTypes = Field(
        default="FL",
        description="types of the m - 1 interior lines crossed by walking along u: FL (foldline) or CFL"
        " (complementary foldline), one word for all lines or a list",
    )
    v_lines: LineTypes = Field(
        default="FL",
        description="types of the n - 1 interior lines crossed by walking along v, like u_lines",
    )
    sector_angle: Annotated[Number, Field(gt=0, lt=90)] = Field(
        default=60.0, description="sector angle of the seed's facets, degrees between 0 and 90"
    )
    fold_state: Annotated[Number, Field(gt=0, lt=1)] = Field(
        default=0.5, description="how far the seed is folded, between 0 and 1"
    )
    lengths_u: tuple[Positive, ...] | None = Field(
        default=None, description="m relative lengths of the strips along u, all 1 if not given"
    )
    lengths_v: tuple[Positive, ...] | None = Field(
        default=None, description="n relative lengths of the strips along v, all 1 if not given"
    )
    turn: Turn = Field(default=0, description="turn of the placed seed in plan, 0 or 90 degrees")
    start_size: Annotated[tuple[Positive, Positive], row("a", "b")] | None = Field(
        default=None, description="size [a, b] of the placed seed in plan; it covers the target if not given"
    )

    @model_validator(mode="after")
    def _check_counts(self) -> Self:
        m, n = self.size
        for axis, lines, lengths, count in (
            ("u", self.u_lines, self.lengths_u, m),
            ("v", self.v_lines, self.lengths_v, n),
        ):
            grid = f"a {m} x {n} grid has"
            if not isinstance(lines, str) and len(lines) != count - 1:
                raise refusal(
                    f"{axis}_lines has {_counted(len(lines), 'word')}, but {grid} "
                    f"{_counted(count - 1, f'interior {axis} line')}",
                    f"Give one word for all lines, or a list of {_counted(count - 1, 'word')}.",
                    key=f"{axis}_lines",
                    at_key=True,
                )
            if lengths is not None and len(lengths) != count:
                raise refusal(
                    f"lengths_{axis} has {_counted(len(lengths), 'length')}, but {grid} "
                    f"{_counted(count, 'strip')} along {axis}",
                    key=f"lengths_{axis}",
                    at_key=True,
                )
        return self


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"


class FilePattern(Model):
    """A pattern that is read from a file, in a semi-folded state."""

    kind: Literal["file"] = Field(description="a pattern from a file")
    file: FileName = Field(description="FOLD file of the pattern, looked up beside the specification")
    turn: Turn = Field(default=0, description="turn of the placed pattern in plan, 0 or 90 degrees")
    keep_position: Switch = Field(
        default=False, description="true if the file's coordinates are the start, not to be placed"
    )


def _check_pattern(value: Any) -> Any:
    if isinstance(value, BaseModel):
        return value
    if not isinstance(value, Mapping):
        raise refusal(f"pattern is {shown(value)}: it must be a mapping of keys to values")
    kind = value.get("kind", "grid")
    if kind not in ("grid", "file"):
        suggestion = did_you_mean(kind, ("grid", "file")) if isinstance(kind, str) else ""
        message = f"{shown(kind)} is no kind of pattern: allowed are grid, file.{suggestion}"
        raise refusal(message, key="kind")
    return value


def _tag_of_pattern(value: Any) -> str:
    if isinstance(value, BaseModel):
        return f"<{type(value).__name__}>"
    return "<FilePattern>" if value.get("kind") == "file" else "<GridPattern>"


Pattern = Annotated[
    Annotated[GridPattern, Tag("<GridPattern>")] | Annotated[FilePattern, Tag("<FilePattern>")],
    Discriminator(_tag_of_pattern),
    BeforeValidator(_check_pattern),
]
