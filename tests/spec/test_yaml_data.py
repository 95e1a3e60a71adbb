import io
import math
import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

from inverse.errors import InputError
from inverse.spec.yaml_data import MAX_COPIED, MAX_DEPTH
from inverse.spec.yaml_source import MAX_BYTES, read


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        *[(text, None) for text in ("null", "~", "", "Null")],
        *[("true", True), ("False", False)],
        *[(text, text) for text in ("nULL", "yes", "off", "1_000", "1e", ".", "2020-01-01", "1:30", "x^2 - 1")],
        *[("'true'", "true"), ('"12"', "12"), ("'it''s'", "it's")],
        *[("12", 12), ("-3", -3), ("+3", 3), ("012", 12), ("0o17", 15), ("0x1F", 31)],
        *[("1.5", 1.5), (".5", 0.5), ("1.", 1.0), ("1e-9", 1e-9), ("-1.0E+3", -1000.0)],
        *[(".inf", math.inf), ("-.INF", -math.inf), ("9" * 400, math.inf)],
    ],
)
def test_scalars_are_those_of_yaml_1_2(tmp_path: Path, text: str, expected: object) -> None:
    path = tmp_path / "scalar.yaml"
    path.write_text(f"key: {text}\n")
    value = read(path)[0]["key"]
    assert value == expected
    assert type(value) is type(expected)


def test_nan(tmp_path: Path) -> None:
    path = tmp_path / "nan.yaml"
    path.write_text("key: .nan\n")
    assert math.isnan(read(path)[0]["key"])


keys = st.text("abcxyz_", min_size=1, max_size=6)
# Not "?": ruamel.yaml writes [?0] without quotes and reads it as a key.
letters = st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"], exclude_characters="?")
floats = st.floats(allow_nan=False, allow_infinity=False)
integers = st.integers(-(10**12), 10**12)
scalars = st.one_of(st.none(), st.booleans(), integers, floats, st.text(letters, max_size=12))
trees = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(keys, inner, max_size=4),
    max_leaves=15,
)


@settings(max_examples=150, deadline=None)
@given(st.dictionaries(keys, trees, min_size=1, max_size=4), st.booleans())
def test_what_another_program_writes_is_read_back(
    tmp_path_factory: pytest.TempPathFactory, data: dict[str, Any], flow: bool
) -> None:
    writer = YAML(typ="safe", pure=True)
    writer.default_flow_style = flow
    text = io.StringIO()
    writer.dump(data, text)
    path = tmp_path_factory.getbasetemp() / "dumped.yaml"
    path.write_bytes(text.getvalue().encode())
    assert read(path)[0] == data


numbers = st.recursive(
    st.just(0),
    lambda inner: st.lists(inner, min_size=1, max_size=4) | st.dictionaries(keys, inner, min_size=1),
    max_leaves=12,
)


def leaves(data: Any, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    """The paths of all numbers."""
    if isinstance(data, int):
        return [path]
    pairs = data.items() if isinstance(data, dict) else enumerate(data)
    return [leaf for key, item in pairs for leaf in leaves(item, (*path, key))]


@settings(max_examples=100, deadline=None)
@given(st.dictionaries(keys, numbers, min_size=1, max_size=3), st.booleans())
def test_every_value_is_found_where_it_stands(
    tmp_path_factory: pytest.TempPathFactory, data: dict[str, Any], flow: bool
) -> None:
    paths = leaves(data)
    for k, path in enumerate(paths):
        holder: Any = data
        for key in path[:-1]:
            holder = holder[key]
        holder[path[-1]] = 1000 + k
    writer = YAML(typ="safe", pure=True)
    writer.default_flow_style = flow
    text = io.StringIO()
    writer.dump(data, text)
    file = tmp_path_factory.getbasetemp() / "places.yaml"
    file.write_text(text.getvalue())
    _, source = read(file)
    lines = text.getvalue().split("\n")
    for k, path in enumerate(paths):
        line, column = map(int, str(source.error(path, "no").where).split(":")[-2:])
        assert re.match(rf"{1000 + k}\b", lines[line - 1][column - 1 :])


@pytest.mark.parametrize(
    ("content", "where", "message"),
    [
        ("", "", "the file is empty"),
        ("# only a comment\n", "", "the file is empty"),
        ("---\n...\n", "", "the file is empty"),
        ("- a\n- b\n", ":1:1", "the file must hold a mapping of keys to values at its top level\n  - a\n  ^"),
        ("\n\ntext\n", ":3:1", "the file must hold a mapping"),
        ("name: a\nunits: m\nname: b\n", ":3:1", '"name" is given twice, first in line 1\n  name: b\n  ^'),
        (
            "a: {b: 1, b: 2}\n",
            ":1:11",
            '"b" is given twice, first in line 1\n  a: {b: 1, b: 2}\n            ^',
        ),
        ("b: *x\na: &x [1]\n", ":1:4", "the alias *x stands for nothing: no value before it is marked &x"),
        ("a: &x [1, *x]\n", ":1:11", "the alias *x stands within the value that it stands for"),
        (
            "a: &a0 [0]\n" + "".join(f"b{k}: &a{k + 1} [*a{k}, *a{k}, *a{k}]\n" for k in range(20)),
            ":11:11",
            f"aliases stand for more than {MAX_COPIED} values",
        ),
        (
            "a: &x " + "[" * 30 + "]" * 30 + "\nb: " + "[" * 30 + "*x" + "]" * 30 + "\n",
            ":2:34",
            f"this is nested more than {MAX_DEPTH} deep",
        ),
        ("a: &x 1\n*x : 2\n", ":2:1", "a key must be a word"),
        ("a: !!python/object:os.system 1\n", ":1:4", "the tag tag:yaml.org,2002:python/object:os.system"),
        ("a: !mine {b: 1}\n", ":1:4", "the tag !mine is not allowed"),
        ("? [1, 2]\n: 3\n", ":1:3", "a key must be a word"),
        ("a: 1\n---\nb: 1\n", ":2:1", "a second document starts here"),
        ("%YAML 1.1\n---\na: yes\n", ":2:1", "the file asks for an older YAML"),
        ("a: [1, 2\nb: 3\n", ":2:2", "this is no valid YAML: expected ',' or ']', but got ':'"),
        (
            "a: b: c\n",
            ":1:5",
            "this is no valid YAML: mapping values are not allowed here\n  a: b: c\n      ^",
        ),
        ("a: 1\n\tb: 2\n", ":2:1", "this is no valid YAML"),
        ("a: [1\n", ":2:1", "this is no valid YAML: expected ',' or ']'"),
        ("a: 1\nb: \x07\n", ":2:4", "the character U+0007 is not allowed in YAML"),
        ('a: "\\UFFFFFFFF"\n', ":1:1", "this is no valid YAML"),
        ("a: " + "[" * 60 + "]" * 60, f":1:{4 + MAX_DEPTH}", f"this is nested more than {MAX_DEPTH} deep"),
        ("a: " + "[" * 5000, f":1:{4 + MAX_DEPTH}", f"this is nested more than {MAX_DEPTH} deep"),
        (b"a: 1\nb: \xc3\xa9 \xff\n", ":2:6", "the byte 0xff is not valid UTF-8"),
        ("a: 1\n".encode("utf-16"), ":1:1", "the byte 0xff is not valid UTF-8"),
        (b"#" * (MAX_BYTES + 1), "", "the file is larger than 10 MB"),
    ],
)
def test_refusals(tmp_path: Path, content: str | bytes, where: str, message: str) -> None:
    path = tmp_path / "bad.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError) as caught:
        read(path)
    error = caught.value
    assert error.where == f"{path}{where}"
    assert error.message.startswith(message)


ALIASED = """\
target:
  between: [&west [[0, 0, 3], [0, 9, 3]], &east [[5, 0, 3], [5, 9, 4]]]
anchors:
  - {side: u0, to: {polyline: *west}}
  - {side: u1, to: {polyline: *east}}
"""


def test_an_alias_is_the_value_again(tmp_path: Path) -> None:
    path = tmp_path / "aliased.yaml"
    path.write_text(ALIASED)
    data, source = read(path)
    west, east = data["target"]["between"]
    assert [anchor["to"]["polyline"] for anchor in data["anchors"]] == [west, east]
    # The alias is where a wrong kind of value is to be mended, what is marked where a number in it is.
    assert source.error(("anchors", 0, "to", "polyline"), "no").where == f"{path}:4:31"
    assert source.error(("anchors", 1, "to", "polyline", 1, 2), "no").where == f"{path}:2:68"
    # One that is changed leaves the other as it is.
    source.override(data, "anchors.0.to.polyline.0.2=7")
    assert data["anchors"][0]["to"]["polyline"][0] == [0, 0, 7]
    assert data["target"]["between"][0][0] == [0, 0, 3]
