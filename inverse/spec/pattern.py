"""The part of a specification that names the pattern: a built-in grid, a built-in tube or a file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag, model_validator

from inverse.errors import InputError
from inverse.origami import seeds
from inverse.spec.fields import FileName, Integer, Model, Number, Positive, Switch, refusal, row, shown, word
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
    trim: Annotated[
        Literal["auto", "outline", "none"],
        word(
            "way to trim a grid",
            {
                "auto": "outline, where the target fills less than 85 % of the rectangle around its plan",
                "outline": "without the facets outside the target's plan",
                "none": "the whole grid",
            },
        ),
    ] = Field(
        default="auto",
        description="whether facets outside the outline of a mesh target are left out: outline, none, or"
        " auto (where it fills less than 85 % of the rectangle around its plan)",
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


def _listed(words: Iterable[object]) -> str:
    *most, last = map(str, words)
    return f"{', '.join(most)} or {last}" if most else last


def _section_hint(around: int) -> str:
    """What to write for a tube of so many facets around: a word if there is one, else steps."""
    words = [name for name, steps in seeds.NAMED_SECTIONS.items() if len(steps) == around]
    if words:
        return f"Write section: {_listed(words)}."
    return "Choose another number of facets around, or give the section as steps [n, a, length]."


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"


Sign = Annotated[Literal[1, -1], word("sign", {1: "", -1: ""})]
SectionSteps = tuple[Annotated[tuple[Sign, Sign, Positive], row("n", "a", "length")], ...]


def _check_section_word(name: str) -> str:
    try:
        seeds.NAMED_SECTIONS.find(name)
    except InputError as error:
        raise refusal(error.message, error.hint) from error
    return name


SectionWord = Annotated[str, AfterValidator(_check_section_word)]
TubeSection = Annotated[
    Annotated[SectionWord, Tag("<word>")] | Annotated[SectionSteps, Tag("<words>")],
    Discriminator(_tag_of_line_types),
]


class TubePattern(Model):
    """A tube of quads whose seed is an isotropic cylinder: a closed section swept along rows that zigzag."""

    kind: Literal["tube"] = Field(description="a built-in tube of quads")
    size: Annotated[
        tuple[Annotated[Integer, Field(ge=4, le=512)], Annotated[Integer, Field(ge=2, le=512)]], row("around", "along")
    ] = Field(description="numbers of facets around, from 4 to 512, and along, from 2 (one row has several motions)")
    section: TubeSection | None = Field(
        default=None,
        description="steps [n, a, length] of the closed section, n and a each 1 or -1: where n flips lies a fold, where"
        " a flips an elbow; or one of the words "
        + ", ".join(f"{name} ({len(steps)} around)" for name, steps in seeds.NAMED_SECTIONS.items())
        + f"; built-in for {', '.join(map(str, seeds.SECTIONS))} around if not given",
    )
    sector_angle: Annotated[Number, Field(gt=0, lt=90)] = Field(
        default=70.0, description="sector angle of the seed's facets, degrees between 0 and 90"
    )
    fold_state: Annotated[Number, Field(gt=0, lt=1)] = Field(
        default=0.55, description="how far the seed is folded, between 0 and 1"
    )
    lengths_v: tuple[Positive, ...] | None = Field(
        default=None, description="relative lengths of the rows along the tube, all 1 if not given"
    )
    turn: Number = Field(default=0.0, description="turn of the placed seed about its axis, degrees")

    @property
    def steps(self) -> seeds.Section:
        """Steps (n, a, length) of the section, whichever way it is given."""
        if self.section is None:
            return seeds.SECTIONS[self.size[0]]
        return seeds.NAMED_SECTIONS[self.section] if isinstance(self.section, str) else self.section

    @model_validator(mode="after")
    def _check_section(self) -> Self:
        around, along = self.size
        if self.section is None and around not in seeds.SECTIONS:
            raise refusal(
                f"a tube of {_counted(around, 'facet')} around needs a section: without one there are tubes of "
                f"{_listed(seeds.SECTIONS)} around",
                _section_hint(around),
                key="size",
            )
        if len(self.steps) != around:
            raise refusal(
                f"the section has {_counted(len(self.steps), 'step')}, but the tube has "
                f"{_counted(around, 'facet')} around",
                f"Write size: [{len(self.steps)}, {along}], or give another section.",
                key="section",
            )
        if self.lengths_v is not None and len(self.lengths_v) != along:
            raise refusal(
                f"lengths_v has {_counted(len(self.lengths_v), 'length')}, but the tube has {_counted(along, 'row')}",
                key="lengths_v",
                at_key=True,
            )
        try:
            seeds.tube(self.steps, 1)
        except InputError as error:
            raise refusal(error.message, error.hint, key="section") from None
        return self


class FilePattern(Model):
    """A pattern that is read from a file, in a semi-folded state."""

    kind: Literal["file"] = Field(description="a pattern from a file")
    file: FileName = Field(description="FOLD file of the pattern, looked up beside the specification")
    turn: Turn = Field(default=0, description="turn of the placed pattern in plan, 0 or 90 degrees")
    keep_position: Switch = Field(
        default=False, description="true if the file's coordinates are the start, not to be placed"
    )


class FamilyPattern(Model):
    """A pattern that a registered function makes; further keys are its parameters."""

    model_config = ConfigDict(extra="allow", frozen=True)

    kind: Literal["family"] = Field(description="a pattern that a registered function makes")
    family: Annotated[str, Field(min_length=1)] = Field(
        description="name of a pattern family that @inverse.pattern_family registered; further keys are its parameters"
    )
    size: Annotated[tuple[FacetCount, FacetCount], row("m", "n")] = Field(
        description="size [m, n] that the function is given, each from 1 to 512"
    )
    turn: Turn = Field(default=0, description="turn of the placed pattern in plan, 0 or 90 degrees")

    @property
    def parameters(self) -> dict[str, Any]:
        """Those of the function, by name."""
        return dict(self.model_extra or {})


_KINDS: dict[str, type[Model]] = {
    "grid": GridPattern,
    "tube": TubePattern,
    "file": FilePattern,
    "family": FamilyPattern,
}


def _check_pattern(value: Any) -> Any:
    if isinstance(value, BaseModel):
        return value
    if not isinstance(value, Mapping):
        raise refusal(f"pattern is {shown(value)}: it must be a mapping of keys to values")
    kind = value.get("kind", "grid")
    if not isinstance(kind, str) or kind not in _KINDS:
        suggestion = did_you_mean(kind, _KINDS) if isinstance(kind, str) else ""
        message = f"{shown(kind)} is no kind of pattern: allowed are {', '.join(_KINDS)}.{suggestion}"
        raise refusal(message, key="kind")
    return value


def _tag_of_pattern(value: Any) -> str:
    if isinstance(value, BaseModel):
        return f"<{type(value).__name__}>"
    return f"<{_KINDS[value.get('kind', 'grid')].__name__}>"


PatternKeys = Annotated[
    Annotated[GridPattern, Tag("<GridPattern>")]
    | Annotated[TubePattern, Tag("<TubePattern>")]
    | Annotated[FilePattern, Tag("<FilePattern>")]
    | Annotated[FamilyPattern, Tag("<FamilyPattern>")],
    Discriminator(_tag_of_pattern),
    BeforeValidator(_check_pattern),
]
