"""The YAML specification of a design: every key, its meaning and its limits. Angles are in degrees here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from inverse.spec import yaml_source
from inverse.spec.fields import (
    Circle,
    FileName,
    Increasing,
    Integer,
    Model,
    Number,
    Plane,
    Point,
    Polygon,
    Polyline,
    Positive,
    Switch,
    refusal,
    row,
    word,
)
from inverse.spec.footprint import FootprintKeys, FootprintLimits
from inverse.spec.pattern import FamilyPattern, FilePattern, GridPattern, PatternKeys, TubePattern
from inverse.spec.require import RequireKeys
from inverse.spec.target import BetweenKeys, HeightKeys, MeshKeys, SurfaceKeys, TargetKeys, TubeKeys
from inverse.spec.validation import validate
from inverse.spec.yaml_source import Source

__all__ = [
    "Anchor",
    "BetweenKeys",
    "Circle",
    "Constraints",
    "ContextKeys",
    "FamilyPattern",
    "FilePattern",
    "FitKeys",
    "FootprintKeys",
    "FootprintLimits",
    "GridPattern",
    "HeightKeys",
    "KeepOut",
    "Loaded",
    "MeshKeys",
    "PlaceKeys",
    "Plane",
    "RequireKeys",
    "SolverKeys",
    "Specification",
    "SurfaceKeys",
    "TubeKeys",
    "TubePattern",
    "load",
]


class ContextKeys(Model):
    """The buildings that the design stands beside."""

    file: FileName = Field(description="file of the building context, looked up beside the specification")
    origin: Point | None = Field(default=None, description="point [x, y, z] of that file to be the origin")


class FitKeys(Model):
    """What is fitted to the target."""

    points: Annotated[
        Literal["facets", "layer", "vertices"],
        word(
            "set of points",
            {
                "facets": "their centroids",
                "layer": "every second vertex both ways",
                "vertices": "all of them",
            },
        ),
    ] = Field(
        default="facets",
        description="facets (their centroids; of tubes the rings of facets), layer (every second vertex both ways) or"
        " vertices (all)",
    )


class PlaceKeys(Model):
    """Where anchored vertices are held."""

    one_of: ClassVar[tuple[str, ...]] = ("point", "polyline", "polygon", "plane", "circle")
    what: ClassVar[str] = "an anchor's place"

    point: Point | None = Field(default=None, description="one point [x, y, z] for all")
    polyline: Polyline | None = Field(default=None, description="two or more points [x, y, z]")
    polygon: Polygon | None = Field(
        default=None, description="three or more points [x, y, z] of a closed polyline, the first not repeated"
    )
    plane: Plane | None = Field(default=None, description="a plane, by point and normal")
    circle: Circle | None = Field(default=None, description="a circle, by center, normal and radius")


def _different(numbers: tuple[int, ...]) -> tuple[int, ...]:
    if len(set(numbers)) < len(numbers):
        twice = next(v for k, v in enumerate(numbers) if v in numbers[:k])
        raise refusal(f"vertex {twice} is named twice: an anchor holds a vertex once")
    return numbers


class Anchor(Model):
    """Vertices that are held somewhere: a side's, or those named."""

    one_of: ClassVar[tuple[str, ...]] = ("side", "vertices")
    what: ClassVar[str] = "an anchor"

    side: (
        Annotated[
            Literal["u0", "u1", "v0", "v1", "ends"],
            word("side", {"u0": "", "u1": "", "v0": "", "v1": "", "ends": ""}),
        ]
        | None
    ) = Field(default=None, description="side whose vertices are held: u0, u1, v0, v1; of a tube v0, v1 or ends (both)")
    vertices: (
        Annotated[tuple[Annotated[Integer, Field(ge=0)], ...], Field(min_length=1), AfterValidator(_different)] | None
    ) = Field(default=None, description="numbers of the vertices that are held, counted from 0")
    every: Annotated[Integer, Field(ge=1)] = Field(
        default=1, description="1 to hold all of them, 2 to hold every second, and so on"
    )
    to: PlaceKeys = Field(description="where they are held: point, polyline, polygon, plane or circle")
    within: Switch | None = Field(
        default=None,
        description="whether the place is a wall that the whole design stays within: a plane, or the upright planes "
        "through a polyline or polygon; if not given, yes for a side on an upright plane, and for polylines and "
        "polygons where all four sides of a grid are held; else no",
    )

    @model_validator(mode="after")
    def _check_within(self) -> Self:
        if self.within and (self.to.point is not None or self.to.circle is not None):
            raise refusal(
                "a point or a circle is no wall, so that nothing can stay within it",
                "Leave `within` out, or give a plane, polyline or polygon.",
                key="within",
            )
        return self


class KeepOut(Model):
    """A half-space that the design stays out of."""

    one_of: ClassVar[tuple[str, ...]] = ("below", "above", "plane")
    what: ClassVar[str] = "a keep-out"

    below: Number | None = Field(default=None, description="a height z: the design stays above it")
    above: Number | None = Field(default=None, description="a height z: the design stays below it")
    plane: Plane | None = Field(
        default=None, description="a plane: the design stays on the side that its normal points to"
    )


FoldAngle = Annotated[Number, Field(ge=1, le=179)]
SectorAngle = Annotated[Number, Field(gt=0, lt=180)]


class Constraints(Model):
    """What a design must keep to, besides developability, flat-foldability and planarity."""

    fold_angle: Annotated[tuple[FoldAngle, FoldAngle], row("low", "high"), Increasing] = Field(
        default=(20.0, 160.0), description="limits [low, high] of every fold, degrees from 1 to 179"
    )
    sector_angle: Annotated[tuple[SectorAngle, SectorAngle], row("low", "high"), Increasing] = Field(
        default=(14.0, 166.0), description="limits [low, high] of every sector angle, degrees in (0, 180)"
    )
    edge_length: Annotated[tuple[Positive, Positive], row("low", "high"), Increasing] = Field(
        default=(0.3, 3.0),
        description="limits [low, high] of every edge, as factors of its length in the seed",
    )
    anchors: tuple[Anchor, ...] = Field(default=(), description="vertices that are held somewhere")
    loop: (
        Annotated[
            Literal["exact", "bars"],
            word("loop", {"exact": "closes through the motion", "bars": "one strip keeps its shape"}),
        ]
        | None
    ) = Field(
        default=None,
        description="how a tube is kept closed: exact (one strip closes through the whole motion; the default) or bars"
        " (one strip keeps the seed's shape)",
    )
    free_range: (
        Annotated[
            tuple[
                Annotated[Number, Field(ge=1, lt=90)],
                Annotated[Number, Field(gt=90, le=179)],
            ],
            row("low", "high"),
        ]
        | None
    ) = Field(
        default=None,
        description="part [low, high] of the motion, degrees from 1 to 179 around the design state's 90, in which no"
        " facets may cross",
    )
    keep_out: tuple[KeepOut, ...] = Field(default=(), description="half-spaces that the design stays out of")
    footprint: FootprintLimits | None = Field(default=None, description="the box that a state has to fit into")
    own: dict[str, Annotated[tuple[Number | None, Number | None], row("low", "high")] | None] = Field(
        default_factory=dict,
        description="constraints that @inverse.constraint registered, by name: bounds [low, high], null for none on a"
        " side, angles in degrees; null instead for those they were registered with",
    )


class SolverKeys(Model):
    """How the problem is solved."""

    method: Annotated[Literal["ipopt", "nlopt"], word("method", {"ipopt": "", "nlopt": ""})] = Field(
        default="ipopt", description="the solver: ipopt, or nlopt for some hundred facets"
    )
    tolerance: Annotated[Number, Field(ge=1e-14, le=1e-3)] = Field(
        default=1e-9, description="the solver's tolerance, from 1e-14 to 1e-3"
    )
    max_iterations: Annotated[Integer, Field(ge=1)] = Field(default=500, description="largest number in a round")
    time_limit_s: Positive | None = Field(default=None, description="time limit in seconds, none if not given")


class Specification(Model):
    """One design task: a pattern to start from, a target to reach and what must hold on the way."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9_]([A-Za-z0-9_ -]*[A-Za-z0-9_-])?$", max_length=100)] = Field(
        description="letters, digits, _, - and spaces within; the folder of the results is named so"
    )
    units: Annotated[
        Literal["unit", "m", "cm", "mm", "um", "nm", "in"],
        word("unit", {"unit": "none", "m": "", "cm": "", "mm": "", "um": "", "nm": "", "in": "inches"}),
    ] = Field(default="m", description="unit of every length: unit (none), m, cm, mm, um, nm or in")
    pattern: PatternKeys = Field(description="the pattern and its seed, of kind grid, tube, file or family")
    context: ContextKeys | None = Field(default=None, description="the buildings around, if there are any")
    target: TargetKeys = Field(description="the target, by exactly one of mesh, height, between, axis and surface")
    fit: FitKeys = Field(default=FitKeys(), description="what is fitted to the target")
    objectives: dict[str, Annotated[Number, Field(ge=0)]] = Field(
        default_factory=dict, description="weights of objective terms by their names, each at least 0"
    )
    footprint: FootprintKeys = Field(default=FootprintKeys(), description="what the objective footprint makes small")
    constraints: Constraints = Field(default=Constraints(), description="what must hold")
    require: RequireKeys = Field(default=RequireKeys(), description="what the design must come up to, to be as asked")
    solver: SolverKeys = Field(default=SolverKeys(), description="how the problem is solved")
    pictures: Annotated[
        Literal["none", "svg", "all"], word("choice of pictures", {"none": "", "svg": "crease patterns", "all": ""})
    ] = Field(
        default="all",
        description="what is drawn: none, svg (crease_pattern.svg, layers.svg) or all (design.png and states.png too)",
    )

    @model_validator(mode="after")
    def _check_units(self) -> Self:
        if self.context is not None and self.units not in ("m", "unit"):
            raise refusal(
                f"units is {self.units}, but the buildings of context are in metres",
                "Write units: m, and all lengths in metres; or leave the context out.",
                key="units",
            )
        return self

    @model_validator(mode="after")
    def _check_tube(self) -> Self:
        has_axis = isinstance(self.target, TubeKeys)
        if isinstance(self.pattern, TubePattern) and not has_axis:
            raise refusal(
                "a tube needs a target around an axis",
                "For example axis: {polyline: [[0, 0, 0], [0, 0, 10]]} with radius: 1.",
                key="target",
            )
        if isinstance(self.pattern, GridPattern) and has_axis:
            raise refusal("a grid has no rings to lie around an axis", "Write kind: tube.", key="pattern")
        if has_axis and self.fit.points != "facets":
            raise refusal("of a tube the rings of facets are fitted, so the points are facets", key="fit")
        return self

    @property
    def packs(self) -> bool:
        """Whether the size of a packed state is an objective or limited."""
        return self.objectives.get("footprint", 0.0) > 0 or self.constraints.footprint is not None


@dataclass(frozen=True)
class Loaded:
    """A specification and where it came from.

    Attributes:
        specification: the validated values, angles in degrees.
        source: where the values stand, to refuse them later: ``raise loaded.source.error(("fit",), ...)``.
        folder: where the files that it names are looked up.
    """

    specification: Specification
    source: Source
    folder: Path


def load(
    spec: Path | str | Mapping[str, Any] | Loaded, overrides: Sequence[str] = (), folder: Path | str | None = None
) -> Loaded:
    """Read and validate a specification.

    Args:
        spec: a YAML file, or a mapping with the same keys; what was loaded before comes back as it is.
        overrides: ``key.path=value`` texts that replace or add values.
        folder: where the files that it names are looked up: beside the file, or for a mapping in the working folder,
            if None.

    Returns:
        The validated specification, with its source for messages.

    Raises:
        InputError: for the first fault in the file or mapping, or else in the overrides, with its place.
    """
    if isinstance(spec, Loaded):
        return spec
    if isinstance(spec, Mapping):
        data, source = yaml_source.from_mapping(spec, "specification")
        beside = Path()
    else:
        data, source = yaml_source.read(Path(spec))
        beside = Path(spec).parent
    for override in overrides:
        source.override(data, override)
    return Loaded(validate(Specification, data, source), source, beside if folder is None else Path(folder))
