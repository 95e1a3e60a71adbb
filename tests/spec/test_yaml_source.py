from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inverse.errors import InputError
from inverse.spec import yaml_source
from inverse.spec.yaml_source import Source, from_mapping

TEXT = """\
# A comment.
name: vault
pattern:
  size: [16, 24]
  "u_lines": FL     # behind a value
constraints:
  anchors:
    - side: u0
      to: {point: [0, 1.5, 2]}
    - {side: u1}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "vault.yaml"
    path.write_text(TEXT)
    return path


def read(path: Path, overrides: Sequence[str] = ()) -> tuple[dict[str, Any], Source]:
    """The data of a file after overrides, one after the other."""
    data, source = yaml_source.read(path)
    for override in overrides:
        source.override(data, override)
    return data, source


def refusal(path: Path, *overrides: str) -> InputError:
    with pytest.raises(InputError) as caught:
        read(path, overrides)
    return caught.value


def test_plain_data(file: Path) -> None:
    data, _ = read(file)
    assert data == {
        "name": "vault",
        "pattern": {"size": [16, 24], "u_lines": "FL"},
        "constraints": {
            "anchors": [{"side": "u0", "to": {"point": [0, 1.5, 2]}}, {"side": "u1"}],
        },
    }
    assert type(data) is dict
    assert type(data["pattern"]["size"][0]) is int
    assert type(data["name"]) is str


@pytest.mark.parametrize(
    ("path", "key", "value"),
    [
        ((), "2:1", "2:1"),
        (("name",), "2:1", "2:7"),
        (("pattern",), "3:1", "4:3"),
        (("pattern", "size"), "4:3", "4:9"),
        (("pattern", "size", 1), "4:14", "4:14"),
        (("pattern", "u_lines"), "5:3", "5:14"),
        (("constraints", "anchors", 0), "8:7", "8:7"),
        (("constraints", "anchors", 0, "to", "point"), "9:12", "9:19"),
        (("constraints", "anchors", 0, "to", "point", 1), "9:23", "9:23"),
        (("constraints", "anchors", 1, "side"), "10:8", "10:14"),
    ],
)
def test_positions(file: Path, path: tuple[str | int, ...], key: str, value: str) -> None:
    _, source = read(file)
    assert source.error(path, "no").where == f"{file}:{value}"
    assert source.error(path, "no", at_key=True).where == f"{file}:{key}"


@pytest.mark.parametrize(
    ("path", "where"),
    [
        (("nmae",), "2:1"),
        (("pattern", "turn"), "3:1"),
        (("constraints", "anchors", 1, "to", "point"), "10:7"),
    ],
)
def test_what_is_missing_is_sought_at_the_nearest_key_above(
    file: Path, path: tuple[str | int, ...], where: str
) -> None:
    _, source = read(file)
    assert source.error(path, "missing").where == f"{file}:{where}"


def test_an_error_shows_the_line_and_a_caret(file: Path) -> None:
    _, source = read(file)
    error = source.error(("pattern", "size", 1), "too many", "Take fewer.")
    assert str(error) == f"{file}:4:14: too many\n    size: [16, 24]\n               ^\nTake fewer."


def test_a_long_line_is_cut_around_the_caret(tmp_path: Path) -> None:
    path = tmp_path / "long.yaml"
    path.write_text(f"numbers: [{', '.join(map(str, range(1000, 1200)))}]\n")
    _, source = read(path)
    _, shown, caret = str(source.error(("numbers", 150), "no")).split("\n")
    assert len(shown) < 120
    assert shown[caret.index("^") :].startswith("1150,")


def test_lines_are_counted_for_every_line_break_and_behind_a_byte_order_mark(tmp_path: Path) -> None:
    path = tmp_path / "breaks.yaml"
    path.write_bytes(b"\xef\xbb\xbfa: 1\r\nb: 2\rc: 3\n")
    data, source = read(path)
    assert data == {"a": 1, "b": 2, "c": 3}
    assert [source.error((key,), "no").where for key in "abc"] == [f"{path}:{k}:4" for k in (1, 2, 3)]
    assert "c: 3\n" in str(source.error(("c",), "no"))


def test_rank_follows_the_file_and_overrides_come_last(file: Path) -> None:
    _, source = read(file, ["name=dome"])
    paths = [("constraints",), ("pattern", "u_lines"), ("name",), ("pattern", "size", 0), ()]
    assert sorted(paths, key=source.rank) == [(), paths[3], paths[1], paths[0], ("name",)]


def test_a_file_that_is_not_there(tmp_path: Path, file: Path) -> None:
    assert refusal(tmp_path / "valt.yaml").message == "there is no such file. Did you mean vault.yaml?"
    assert refusal(tmp_path / "none" / "a.yaml").message == "there is no such file."
    assert refusal(tmp_path).message == "this is a folder, not a file"
    assert refusal(file / "below").where == f"{file / 'below'}"
    assert refusal(Path("a\0b")).message.startswith("the file cannot be read")


@pytest.mark.parametrize(
    ("override", "keys", "expected"),
    [
        ("name=dome", ("name",), "dome"),
        (" name = dome ", ("name",), "dome"),
        ("pattern.size=[4, 6]", ("pattern", "size"), [4, 6]),
        ("pattern.size.1=7", ("pattern", "size"), [16, 7]),
        ("constraints.anchors.1.every=3", ("constraints", "anchors", 1), {"side": "u1", "every": 3}),
        ("solver.tolerance=1e-9", ("solver",), {"tolerance": 1e-9}),
        ("name=", None, None),
        ("name=a=b", ("name",), "a=b"),
        ("context=null", ("context",), None),
        ("name='12'", ("name",), "12"),
    ],
)
def test_overrides(file: Path, override: str, keys: tuple[str | int, ...] | None, expected: object) -> None:
    if keys is None:
        assert "an equals sign and a value" in refusal(file, override).message
        return
    data, source = read(file, [override])
    value: Any = data
    for key in keys:
        value = value[key]
    assert value == expected
    path = tuple(int(k) if k.isdigit() else k for k in override.partition("=")[0].strip().split("."))
    assert source.error(path, "no").where == f"--set {override}"
    assert source.error((*path, "below", 3), "no").where == f"--set {override}"


def test_overrides_leave_the_places_around_them(file: Path) -> None:
    _, source = read(file, ["pattern.size=[1, 2]", "pattern.turn=90"])
    assert source.error(("pattern", "u_lines"), "no").where == f"{file}:5:14"
    assert source.error(("pattern",), "no", at_key=True).where == f"{file}:3:1"
    assert source.error(("pattern", "size", 1), "no").where == "--set pattern.size=[1, 2]"


def test_later_overrides_win_and_can_go_into_earlier_ones(file: Path) -> None:
    data, source = read(file, ["pattern={size: [1, 2]}", "pattern.size.0=5"])
    assert data["pattern"] == {"size": [5, 2]}
    assert source.error(("pattern", "size", 0), "no").where == "--set pattern.size.0=5"
    assert source.error(("pattern", "size", 1), "no").where == "--set pattern={size: [1, 2]}"


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("name", "an override is a key path, an equals sign and a value"),
        ("=3", "an override is a key path"),
        ("a..b=3", "an override is a key path"),
        ("name.first=3", 'name is a single value and has no "first"'),
        ("constraints.anchors.2.every=3", 'constraints.anchors is a list with entries 0 to 1, given "2"'),
        ("constraints.anchors.-1.every=3", 'constraints.anchors is a list with entries 0 to 1, given "-1"'),
        ("pattern.size.m=3", 'pattern.size is a list with entries 0 to 1, given "m"'),
        ("pattern.size=[1", "this is no valid YAML"),
        ("pattern.size=*x", "the alias *x stands for nothing"),
        ("name=\x07", "the character U+0007 is not allowed"),
    ],
)
def test_overrides_that_do_not_fit(file: Path, override: str, message: str) -> None:
    error = refusal(file, override)
    assert error.where == f"--set {override}"
    assert error.message.startswith(message)


def test_from_mapping_copies_to_plain_data() -> None:
    mine: dict[Any, Any] = {
        "a": (1, 2),
        "b": np.array([[1.5, 2.0]]),
        "c": np.float64(3.5),
        "d": Path("x.obj"),
        5: None,
    }
    data, source = from_mapping(mine, "specification")
    assert data == {"a": [1, 2], "b": [[1.5, 2.0]], "c": 3.5, "d": "x.obj", "5": None}
    assert type(data["c"]) is float
    assert str(source.error(("b", 0, 1), "too large")) == "specification:b.0.1: too large"
    assert source.error((), "no").where == "specification"
    assert source.rank(("a",)) < source.rank(("c",))


def test_from_mapping_refuses_what_is_no_mapping_or_holds_itself() -> None:
    circle: dict[str, Any] = {}
    circle["a"] = circle
    with pytest.raises(InputError, match="nested more than"):
        from_mapping(circle, "specification")
    with pytest.raises(InputError, match="a specification is a mapping"):
        from_mapping([1], "specification")  # type: ignore[arg-type]


signs = [*":-,&*!|>'\"#%?\\~@[]{}ab1\n\t\r\ufeff\u2028\x85", "*a", "&a", "---", "...", "<<", ": ", "- ", "  "]


@settings(max_examples=400, deadline=None)
@given(
    st.one_of(
        st.text(max_size=80).map(lambda text: text.encode("utf-8", "surrogatepass")),
        st.binary(max_size=80),
        st.lists(st.sampled_from(signs), max_size=30).map(lambda parts: "".join(parts).encode()),
    ),
    st.lists(st.text(max_size=20), max_size=2),
)
def test_any_file_is_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, content: bytes, overrides: list[str]
) -> None:
    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_bytes(content)
    try:
        data, _ = read(path, overrides)
    except InputError as error:
        refused_at = error.where or ""
    else:
        assert isinstance(data, dict)
        return
    assert refused_at.startswith((str(path), "--set "))
