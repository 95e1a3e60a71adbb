"""Writes docs/specification.md, the page of all keys, from the schema: `python docs/keys.py`, or `make docs`."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from inverse.objectives import OBJECTIVES
from inverse.origami import seeds
from inverse.spec import Specification

MOST = 1e9  # limits beyond are those of every number
PAGE = Path(__file__).parent / "specification.md"
Schema = dict[str, Any]

INTRODUCTION = """\
# All keys of a specification

Made from the schema by `docs/keys.py`; `inverse schema` prints the same for programs. A key that is not here is
refused, with the one that may have been meant.

Lengths are in `units`, angles in degrees. A file that is named is looked up beside the specification. What is written
twice, such as an eave that is a side of the target and holds an anchor, can be marked with `&` and repeated with `*`:

```yaml
name: hall
units: m
pattern: {size: [8, 12], turn: 0}
target:
  between:
    - &west [[0, 0, 3], [0, 12, 3]]
    - &east [[8, 0, 3], [8, 12, 3]]
  rise: 2
  profile: catenary
objectives: {fairness: 1.0e-4, evenness: 1.0e-3}
constraints:
  fold_angle: [25, 155]
  anchors:
    - {side: u0, every: 2, to: {polyline: *west}}
    - {side: u1, every: 2, to: {polyline: *east}}
  keep_out: [{below: 2.4}]
require: {coverage: 0.85}      # between the supports the zigzag rim stays open
solver: {time_limit_s: 120}
```

On the command line `--set` changes a value. It is quoted, as shells would read brackets and stars:

    inverse solve hall.yaml --set 'pattern.size=[6, 8]' --set 'target.rise=2.5' -o out/lower

"""

OBJECTIVES_TEXT = """\
## Objectives

Under `objectives` a name has a weight; 0 leaves it out. What is not named has the weight below. Each is the mean of
squares, lengths in sixteenths of the design's size, so that a weight means the same at every size and number of facets.
Your own come by `--with FILE.py`: [objectives](extending/objective.md), [constraints](extending/constraint.md),
[measures](extending/measure.md), [targets](extending/target.md), [pattern families](extending/pattern_family.md) and
[sections](extending/section.md).

| name | weight | what it is about |
| --- | --- | --- |
"""

SECTIONS_TEXT = """\
## Sections of tubes

Words for `section`. A step `[n, a, length]` goes one way or the other along two directions; where n flips lies a fold,
where a flips an elbow. Both signed sums of the lengths are zero.

| word | facets around | steps |
| --- | --- | --- |
"""


def page() -> str:
    """The page, from what is registered and what the schema says."""
    schema = Specification.model_json_schema()
    parts = [INTRODUCTION, *(_section(title, names, part) for title, names, part in _walk(schema))]
    rows = []
    for name, term in OBJECTIVES.items():
        said = " ".join((term.build.__doc__ or "").split("\n\n")[0].split()).rstrip(".")
        said = re.sub(r" \(``.*?``\)", "", said)
        rows.append(f"| `{name}` | {term.weight:g} | {said} |")
    parts.append(OBJECTIVES_TEXT + "\n".join(rows) + "\n")
    rows = [
        f"| `{name}` | {len(steps)} | {', '.join(str(list(step)) for step in steps)} |"
        for name, steps in seeds.NAMED_SECTIONS.items()
    ]
    parts.append(SECTIONS_TEXT + "\n".join(rows) + "\n")
    return "\n".join(part.rstrip("\n") + "\n" for part in parts)


def _walk(schema: Schema) -> Iterator[tuple[str, list[str], Schema]]:
    """Every part of a specification once, before what is within it: its title, the paths it stands at, its schema."""
    definitions = schema["$defs"]
    paths: dict[str, list[str]] = {}

    def visit(path: str, part: Schema) -> None:
        for name, value in part.get("properties", {}).items():
            for reference, is_item in _references(value):
                own = f"{path}.{name}".lstrip(".") + ("[]" if is_item else "")
                is_new = reference not in paths
                paths.setdefault(reference, []).append(own)
                if is_new:
                    visit(own, definitions[reference])

    visit("", schema)
    yield "The whole", [], schema
    for reference, found in paths.items():
        part = definitions[reference]
        kind = part["properties"].get("kind", {}).get("const")
        title = f"`{found[0].removesuffix('[]')}`"
        if kind is not None:
            title += f" of kind `{kind}`"
        elif found[0] == "target":
            title += f" by `{part['required'][0]}`"
        yield title, found, part


def _references(value: Any, is_item: bool = False) -> Iterator[tuple[str, bool]]:
    """Parts that a value may be, and whether it is a list of them."""
    if isinstance(value, dict):
        if "$ref" in value:
            yield value["$ref"].rsplit("/", 1)[1], is_item
        for key, inner in value.items():
            if key in ("anyOf", "oneOf", "allOf", "items"):
                yield from _references(inner, is_item or key == "items")
    elif isinstance(value, list):
        for inner in value:
            yield from _references(inner, is_item)


def _section(title: str, paths: list[str], part: Schema) -> str:
    lines = [f"## {title}", "", part.get("description", "").split("\n")[0].replace("`", ""), ""]
    if len(paths) > 1:
        lines += ["It stands at " + " and ".join(f"`{path}`" for path in paths) + ".", ""]
    lines += ["| key | meaning | value | default |", "| --- | --- | --- | --- |"]
    required = part.get("required", [])
    for name, value in part.get("properties", {}).items():
        default = "**needed**" if name in required else _default(value)
        lines.append(f"| `{name}` | {_cell(value.get('description', ''))} | {_cell(_value(value))} | {default} |")
    return "\n".join(lines) + "\n"


def _value(value: Schema) -> str:
    """What is allowed, in words."""
    if "$ref" in value:
        return "keys, see below"
    if "const" in value:
        return f"`{value['const']}`"
    if "enum" in value:
        return " or ".join(f"`{one}`" for one in value["enum"])
    for choice in ("anyOf", "oneOf"):
        if choice in value:
            words = [_value(one) for one in value[choice] if one.get("type") != "null"]
            return ", or ".join(dict.fromkeys(words))
    kind = value.get("type")
    if kind == "array":
        if "prefixItems" in value:
            return "[" + ", ".join(_value(one) for one in value["prefixItems"]) + "]"
        least = value.get("minItems", 0)
        return f"list of {_value(value.get('items', {}))}" + (f", {least} or more" if least > 1 else "")
    if kind == "object":
        inner = value.get("additionalProperties")
        return f"names with a {_value(inner)}" if isinstance(inner, dict) else "keys"
    if kind in ("number", "integer"):
        return ("whole number" if kind == "integer" else "number") + _limits(value)
    return {"string": "text", "boolean": "`true` or `false`"}.get(str(kind), "any")


def _limits(value: Schema) -> str:
    """Limits that are more than what holds for every number, with a space before them."""
    names = ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum")
    low, high, above, below = (
        limit if limit is not None and abs(limit) < MOST else None for limit in map(value.get, names)
    )
    words = [
        f"{said} {limit:g}"
        for said, limit in (("more than", above), ("from", low), ("to", high), ("less than", below))
        if limit is not None
    ]
    return f" {' '.join(words)}".rstrip() if words else ""


def _default(value: Schema) -> str:
    default = value.get("default")
    if isinstance(default, dict) and default:
        return "see below"
    if default in (None, {}, []):
        return "none"
    return f"`{_plain(default)}`"


def _plain(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_plain, value))}]"
    return json.dumps(value).strip('"') if isinstance(value, bool | str) else f"{value:g}"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
