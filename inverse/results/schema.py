"""JSON schemas of the files beside a design, made from the types whose values are written there."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Mapping
from dataclasses import fields
from typing import Any, get_type_hints

from pydantic import TypeAdapter

from inverse.brief.asked import Asked
from inverse.brief.covering import Coverage, Part
from inverse.certify.certificate import LIMITS, Certificate, Check, Crossing, Loop
from inverse.policy.attempts import Attempt
from inverse.policy.endings import ENDINGS
from inverse.policy.measures import Fit
from inverse.policy.verdict import Judgement
from inverse.repair.measures import Residuals
from inverse.repair.repairing import Repair
from inverse.results.result import Result, Size
from inverse.spec import Specification
from inverse.terms.packed import SIDES
from inverse.terms.tube_fit import RingFit

Schema = dict[str, Any]
DRAFT = "https://json-schema.org/draft/2020-12/schema"

TEXT: Schema = {"type": "string"}
TRUTH: Schema = {"type": "boolean"}
COUNT: Schema = {"type": "integer", "minimum": 0}
NUMBER: Schema = {"type": ["number", "null"]}  # null where there is no finite one
TYPES: Schema = {"enum": ["FL", "CFL"]}


def certificate() -> Schema:
    """The schema of ``certificate.json``."""
    pair = {**_list(COUNT), "minItems": 2, "maxItems": 2}
    shape = _told(
        Certificate,
        checks=_object({name: _check(limit, unit) for name, (limit, unit) in LIMITS.items()}),
        loops=_list(_told(Loop, gap={**NUMBER, "description": "largest gap of all"})),
        crossings=_list(_told(Crossing, facets=_list(pair))),
    )
    return {"$schema": DRAFT, "title": "certificate.json", **shape}


def report() -> Schema:
    """The schema of ``report.json``, of a solve or of a repair."""
    specification = Specification.model_json_schema(mode="serialization")
    parts = specification.pop("$defs")
    return {
        "$schema": DRAFT,
        "title": "report.json",
        "oneOf": [{"$ref": "#/$defs/Solve"}, {"$ref": "#/$defs/Repair"}],
        "$defs": parts | {"Specification": specification, "Solve": _solve(), "Repair": _repair()},
    }


def _solve() -> Schema:
    """What a solve reports."""
    told = {
        "name": TEXT,
        "status": TEXT,
        "ending": {"enum": list(ENDINGS)},
        "converged": TRUTH,
        "certified": TRUTH,
        "as_asked": {**TRUTH, "description": "whether the design is what the specification asks for"},
        "asked": _list(_told(Asked)),
        "fit": _fit(),
        "coverage": _told(Coverage, parts=_list(_told(Part))),
        "footprint": _footprint(),
        "measures": _mapping(NUMBER),
        "failed_measures": _list(TEXT),
        "objective": _mapping(NUMBER),
        "verdict": _told(Judgement, violations=_mapping(_object({"value": NUMBER, "worst": TEXT}))),
        "iterations": COUNT,
        "attempts": _list(_told(Attempt, optional=_with_default(Attempt) - {"iterations"})),
        "reached": NUMBER,
        "equations": {
            "anyOf": [
                _object({"rows": COUNT, "rank": COUNT, "freedom": COUNT, "condition": NUMBER}),
                {"type": "null"},
            ]
        },
        "size": _told(Size),
        "seconds": _mapping({"type": "number", "minimum": 0}),
        "specification": {"$ref": "#/$defs/Specification"},
    }
    return _object(_described(told, Result) | _written())


def _repair() -> Schema:
    """What a repair reports."""
    errors = _object(dict.fromkeys(_attributes(Residuals), NUMBER))
    told = {
        "name": TEXT,
        "status": TEXT,
        "converged": TRUTH,
        "certified": TRUTH,
        "state": {"enum": ["crease pattern", "semi-folded"]},
        "before": errors,
        "after": errors,
        "moved": _object(
            {
                **dict.fromkeys(("max", "max_relative", "rms", "rms_relative"), NUMBER),
                "worst_vertex": COUNT,
                "vertices": _list(NUMBER),
            }
        ),
        "line_types": _object(
            {
                "found": TEXT,
                "FL": COUNT,
                "CFL": COUNT,
                "lines": _list(_object({"type": TYPES, "vertices": _list(COUNT)})),
            }
        ),
        "size": _object({"vertices": COUNT, "facets": COUNT, "degrees_of_freedom": COUNT}),
        # Of a crease pattern, and where vertices were left out.
        "mountains_and_valleys": {"enum": ["from the file", "searched"]},
        "folded_to": _object({"least_degrees": NUMBER, "largest_degrees": NUMBER}),
        "largest_disagreement": NUMBER,
        "file_vertices": _list(COUNT),
        "seconds": _object({"pictures": {"type": "number", "minimum": 0}}),
    }
    optional = ("mountains_and_valleys", "folded_to", "largest_disagreement", "file_vertices", "seconds")
    return _object(_described(told, Repair) | _written(), optional)


def _written() -> Schema:
    """What is told when a report is written."""
    return {
        "versions": {**_mapping(TEXT), "description": "of the packages at work, and of Python"},
        "notes": {**_list(TEXT), "description": "sentences about pictures that could not be drawn"},
    }


def _fit() -> Schema:
    """The figures of every fit; those of tubes stand beside them."""
    shape, rings = _told(Fit, without={"rings"}), _told(RingFit)
    return _object(shape["properties"] | rings["properties"], rings["required"])


def _footprint() -> Schema:
    """Flat states, further ones by their names, and what was limited."""
    entry = _object({"extents": {**_list(NUMBER), "minItems": 2, "maxItems": 3}, "area": NUMBER})
    ratio = _object({"length": NUMBER, "width": NUMBER, "area": NUMBER})
    limit = _object({"state": TEXT, "measure": {"enum": [*SIDES, "area"]}, "value": NUMBER, "limit": NUMBER})
    told = {"deployed": entry, "developed": entry, "flat-folded": entry}
    shape = _object(told | {"deployed_to_packed": _mapping(ratio), "limits": _list(limit)})
    return shape | {"additionalProperties": entry}


def _check(limit: float, unit: str) -> Schema:
    """One check, under the names of the file."""
    shape = _told(Check, without={"name"}, limit={"const": limit}, unit={"const": unit})["properties"]
    return _object({"pass" if name == "passed" else name: one for name, one in shape.items()})


def _told(kind: type, *, without: Iterable[str] = (), optional: Iterable[str] = (), **other: Schema) -> Schema:
    """A dataclass as an object: its fields by their types, described as its docstring does.

    Args:
        kind: the dataclass.
        without: fields that are not told.
        optional: fields that may be missing.
        other: what is told in another form than its field has, or besides.
    """
    hints = get_type_hints(kind)
    own = {one.name: _of_type(hints[one.name]) for one in fields(kind) if one.name not in {*without, *other}}
    order = [*(one.name for one in fields(kind) if one.name not in set(without)), *other]
    return _object(_described({name: (own | other)[name] for name in order}, kind), optional)


def _of_type(hint: Any) -> Schema:
    """The schema of a type, where every number may be null."""
    shape: Schema = _nullable(TypeAdapter(hint).json_schema(mode="serialization"))
    return shape


def _nullable(shape: Any) -> Any:
    if isinstance(shape, dict):
        return NUMBER if shape == {"type": "number"} else {key: _nullable(one) for key, one in shape.items()}
    return [_nullable(one) for one in shape] if isinstance(shape, list) else shape


def _with_default(kind: type) -> set[str]:
    """Fields of a dataclass that need not be given."""
    required = {name for name, one in inspect.signature(kind).parameters.items() if one.default is one.empty}
    return {one.name for one in fields(kind)} - required


def _described(shapes: Mapping[str, Schema], kind: type) -> Schema:
    said = _attributes(kind)
    return {name: {"description": said[name], **one} if name in said else one for name, one in shapes.items()}


def _attributes(kind: type) -> dict[str, str]:
    """Names and descriptions of the section Attributes in a docstring."""
    _, _, section = (inspect.getdoc(kind) or "").partition("Attributes:\n")
    entries = re.findall(r"^    (\w+): (.*(?:\n {5,}.*)*)", section, re.MULTILINE)
    return {name: " ".join(text.split()) for name, text in entries}


def _object(properties: Mapping[str, Schema], optional: Iterable[str] = ()) -> Schema:
    required = [name for name in properties if name not in set(optional)]
    return {"type": "object", "properties": dict(properties), "required": required, "additionalProperties": False}


def _mapping(values: Schema) -> Schema:
    return {"type": "object", "additionalProperties": values}


def _list(items: Schema) -> Schema:
    return {"type": "array", "items": items}
