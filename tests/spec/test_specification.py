import copy
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError
from specifications import TEXT

from inverse.errors import InputError
from inverse.spec import (
    BetweenKeys,
    FilePattern,
    GridPattern,
    HeightKeys,
    MeshKeys,
    Specification,
    load,
)


def test_a_full_specification(tmp_path: Path) -> None:
    path = tmp_path / "vault.yaml"
    path.write_text(TEXT)
    loaded = load(path)
    specification = loaded.specification
    assert specification.name == "vault"
    assert isinstance(specification.pattern, GridPattern)
    assert specification.pattern.size == (16, 24)
    assert specification.pattern.sector_angle == 60.0
    assert specification.target == HeightKeys(height="0.45 - 0.3*(x^2 + y^2)", domain=((-1, 1), (-1, 1)))
    assert specification.objectives == {"fit": 1.0, "fairness": 1e-4, "footprint": 0.0}
    first, second = specification.constraints.anchors
    assert (first.side, first.vertices, first.every) == ("u0", None, 2)
    assert first.to.polyline == ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    assert (second.side, second.vertices, second.every) == (None, (0, 3), 1)
    assert second.to.plane is not None
    assert second.to.plane.normal == (0.0, 0.0, 1.0)
    assert specification.constraints.keep_out[0].below == 2.4
    assert loaded.folder == tmp_path
    assert loaded.source.error(("objectives", "fairness"), "no", at_key=True).where == f"{path}:11:24"


MINIMAL: dict[str, Any] = {"name": "a", "pattern": {"size": [3, 4]}, "target": {"mesh": "a.obj"}}


def test_only_three_keys_are_required_and_the_rest_has_defaults() -> None:
    assert load(MINIMAL).specification.model_dump(mode="json") == {
        "name": "a",
        "units": "m",
        "pattern": {
            "kind": "grid",
            "size": [3, 4],
            "u_lines": "FL",
            "v_lines": "FL",
            "sector_angle": 60.0,
            "fold_state": 0.5,
            "lengths_u": None,
            "lengths_v": None,
            "turn": 0,
            "start_size": None,
            "trim": "auto",
        },
        "context": None,
        "target": {"mesh": "a.obj"},
        "fit": {"points": "facets"},
        "objectives": {},
        "constraints": {
            "fold_angle": [20.0, 160.0],
            "sector_angle": [14.0, 166.0],
            "edge_length": [0.3, 3.0],
            "anchors": [],
            "loop": None,
            "own": {},
            "free_range": None,
            "keep_out": [],
            "footprint": None,
        },
        "footprint": {"state": "flat-folded", "measure": "extent"},
        "require": {
            "fit": None,
            "fit_max": None,
            "surface": None,
            "missed": None,
            "coverage": 0.9,
            "beyond": 0.15,
            "slenderness": 0.05,
            "motion": "either",
        },
        "solver": {"method": "ipopt", "tolerance": 1e-9, "max_iterations": 500, "time_limit_s": None},
        "pictures": "all",
    }
    for name in MINIMAL:
        with pytest.raises(InputError, match=f'the key "{name}" is missing from the top level'):
            load({key: value for key, value in MINIMAL.items() if key != name})


def test_overrides_that_fit(tmp_path: Path) -> None:
    path = tmp_path / "vault.yaml"
    path.write_text(TEXT)
    overrides = ["target.height=null", "target={mesh: a.obj}", "constraints.anchors.0.every=3", "name=b"]
    specification = load(path, overrides).specification
    assert specification.target == MeshKeys(mesh="a.obj")
    assert specification.constraints.anchors[0].every == 3
    assert specification.name == "b"


def test_scripts_are_told_the_key_path() -> None:
    with pytest.raises(InputError) as caught:
        load({**MINIMAL, "pattern": {"size": (3, 4), "sector_angle": 95}})
    assert caught.value.where == "specification:pattern.sector_angle"
    with pytest.raises(InputError, match="it must be at most 512"):
        load({**MINIMAL, "pattern": {"size": (10**30, 4)}})


PLANE = {"point": [0, 0, 1], "normal": [0, 1e-3, 0]}
CURVE = [[0, 0, 0], [1, 2, 3], [4, 5, 6.5]]
FULL: list[dict[str, Any]] = [
    MINIMAL,
    {
        "name": "Eggbox_2-b c",
        "units": "unit",
        "pattern": {
            "size": [3, 4], "u_lines": ["CFL", "FL"], "v_lines": "CFL", "sector_angle": 89.5,
            "fold_state": 0.1, "lengths_u": [1, 2, 3], "lengths_v": [1, 1, 1, 0.5], "turn": 90,
            "start_size": [10, 12.5],
        },
        "context": {"file": "a.city.jsonl", "origin": [1275, 340849, 30]},
        "target": {"between": [CURVE, CURVE[::-1]], "rise": -3, "profile": "catenary"},
        "fit": {"points": "layer"},
        "objectives": {"fit": 1, "my_own": 0.0},
        "constraints": {
            "fold_angle": [1, 179], "sector_angle": [0.5, 179.5], "edge_length": [0.1, 20],
            "anchors": [
                {"side": "ends", "to": {"circle": {"center": [0, 0, 0], "normal": [0, 0, -2], "radius": 3}}},
                {"vertices": [4, 2], "every": 2, "to": {"point": [1, 2, 3]}},
                {"side": "v1", "to": {"plane": PLANE}},
                {"side": "u1", "to": {"polyline": CURVE}},
            ],
            "keep_out": [{"below": 0}, {"above": 12}, {"plane": PLANE}],
        },
        "solver": {"method": "ipopt", "tolerance": 1e-14, "max_iterations": 1, "time_limit_s": 0.5},
    },
    {
        "name": "from_file",
        "pattern": {"kind": "file", "file": "x.fold", "turn": 90, "keep_position": True},
        "target": {"height": "x + y", "domain": [[0, 1], [0, 2]]},
    },
    {
        "name": "tube",
        "pattern": {
            "kind": "tube", "size": [4, 3], "section": [[1, 1, 2], [1, -1, 1.5], [-1, -1, 2], [-1, 1, 1.5]],
            "lengths_v": [1, 2, 1], "turn": -30,
        },
        "target": {"axis": {"polyline": [[0, 0, 0], [0, 0, 4]]}, "radius": 1},
        "constraints": {"loop": "bars"},
    },
    {
        "name": "plus",
        "pattern": {"kind": "tube", "size": [12, 8], "section": "plus", "sector_angle": 65, "fold_state": 0.5},
        "target": {"axis": {"arc": [[0, 0, 0], [1, 0, 1], [2, 0, 0]]}, "radius": [[0, 1], [0.5, 1.2], [1, 1]]},
        "constraints": {"loop": "exact"},
    },
]  # fmt: skip


@pytest.mark.parametrize("mapping", FULL, ids=lambda mapping: mapping["name"])
def test_dumps_can_be_read_back(mapping: dict[str, Any], tmp_path: Path) -> None:
    specification = load(mapping).specification
    for options in ({}, {"exclude_none": True}, {"exclude_defaults": True}):
        dumped = json.dumps(specification.model_dump(mode="json", **options))
        assert load(json.loads(dumped)).specification == specification
        path = tmp_path / "dump.yaml"  # JSON is YAML
        path.write_text(dumped)
        assert load(path).specification == specification
    assert Specification.model_validate(specification.model_dump()) == specification
    parts = {name: getattr(specification, name) for name in Specification.model_fields}
    assert Specification(**parts) == specification


def test_members_of_unions() -> None:
    _, second, third, *_ = (load(mapping).specification for mapping in FULL)
    assert isinstance(second.target, BetweenKeys)
    assert isinstance(third.pattern, FilePattern)
    assert third.pattern.keep_position is True


def test_a_specification_does_not_change() -> None:
    specification = load(MINIMAL).specification
    with pytest.raises(ValidationError, match="frozen"):
        specification.name = "b"
    with pytest.raises(ValidationError, match="frozen"):
        specification.pattern.turn = 90


def test_the_schema_describes_every_key() -> None:
    schema = json.loads(json.dumps(Specification.model_json_schema()))
    tables = {"Specification": schema, **schema["$defs"]}
    assert len(tables) > 12
    for name, table in tables.items():
        has_parameters = name in ("FamilyPattern", "SurfaceKeys")  # of a user's function
        assert table["additionalProperties"] is has_parameters, name
        for key, entry in table["properties"].items():
            assert entry.get("description"), f"{name}.{key}"
    assert schema["required"] == ["name", "pattern", "target"]
    assert schema["properties"]["units"]["default"] == "m"


def places(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    yield path
    pairs = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, item in pairs:
        yield from places(item, (*path, key))


PLACES_OF_FULL = [(mapping, path) for mapping in FULL for path in places(mapping) if path]
words = st.sampled_from(["FL", "kind", "file", "grid", "mesh", "size", "point", "<word>", "<GridPattern>", "a.b", ""])
odd = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=5),
    words,
    st.just(10**400),
    st.binary(),
)
junk = st.recursive(
    odd,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(words | st.text(max_size=3), inner, max_size=3),
    max_leaves=8,
)


@settings(max_examples=400, deadline=None)
@given(
    st.sampled_from(PLACES_OF_FULL),
    junk,
    words | st.text(max_size=4),
    st.sampled_from(["set", "add", "drop"]),
)
def test_any_change_of_a_specification_is_read_or_refused(
    chosen: tuple[dict[str, Any], tuple[Any, ...]], value: Any, new_key: str, change: str
) -> None:
    mapping, path = chosen
    data = copy.deepcopy(mapping)
    holder: Any = data
    for key in path[:-1]:
        holder = holder[key]
    if change == "drop":
        del holder[path[-1]]
    elif change == "add" and isinstance(holder, dict):
        holder[new_key] = value
    else:
        holder[path[-1]] = value
    try:
        loaded = load(data)
    except InputError as error:
        where = error.where or ""
    else:
        assert isinstance(loaded.specification, Specification)
        return
    assert where.startswith("specification")


@settings(max_examples=100, deadline=None)
@given(st.lists(st.sampled_from(TEXT.splitlines(keepends=True)), max_size=20).map("".join), st.text(max_size=20))
def test_any_text_is_read_or_refused(tmp_path_factory: pytest.TempPathFactory, text: str, override: str) -> None:
    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_bytes(text.encode())
    try:
        load(path, [f"name={override}"])
    except InputError as error:
        where = error.where or ""
    else:
        return
    assert where.startswith((str(path), "--set "))


def test_buildings_are_in_metres(tmp_path: Path) -> None:
    path = tmp_path / "hall.yaml"
    path.write_text(
        "name: hall\npattern: {size: [4, 4]}\ncontext: {file: site.city.json}\n"
        "target: {height: '1 - x^2', domain: [[-1, 1], [-1, 1]]}\n"
    )
    with pytest.raises(InputError, match="units is mm, but the buildings of context are in metres") as caught:
        load(path, ["units=mm"])
    assert caught.value.where == "--set units=mm"
    for unit in ("m", "unit"):
        load(path, [f"units={unit}"])
