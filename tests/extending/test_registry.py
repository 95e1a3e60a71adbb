"""Names that users register."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

import inverse
from inverse import InputError
from inverse.extending.registry import Registry


def test_items_are_found_by_name() -> None:
    registry: Registry[int] = Registry("a number", {"one": 1})
    registry.add("two-b_3", 2)
    assert dict(registry) == {"one": 1, "two-b_3": 2}
    assert registry.find("two-b_3") == 2
    registry.remove("one")
    assert list(registry) == ["two-b_3"]


def test_a_name_is_taken_once() -> None:
    registry: Registry[int] = Registry("a number", {"one": 1})
    with pytest.raises(InputError, match=r"^'one' is a number already\n"):
        registry.add("one", 2)
    assert registry["one"] == 1


@pytest.mark.parametrize("name", ["", " ", "a b", "-a", "a-", "a--b", "a.b", "é", None, 3.5])
def test_a_name_is_a_word(name: Any) -> None:
    with pytest.raises(InputError, match="cannot name a number"):
        Registry("a number").add(name, 1)


def test_an_unknown_name_is_told_with_the_nearest() -> None:
    registry: Registry[int] = Registry("a number", {"seven": 7, "one": 1})
    with pytest.raises(InputError, match=r"^'sevn' is no number: registered are one, seven\. Did you mean seven\?$"):
        registry.find("sevn")
    with pytest.raises(InputError, match=r"^'x' is no thing: registered are none\.$"):
        Registry("a thing").find("x")


FRONTS: dict[str, Callable[[str], Any]] = {
    "objective": lambda name: inverse.objective(name)(lambda points, seed: points[0]),
    "constraint": lambda name: inverse.constraint(name, lower=0)(lambda points, seed: points[0]),
    "measure": lambda name: inverse.measure(name)(lambda design: 1.0),
    "target surface": lambda name: inverse.target(name)(lambda: None),  # type: ignore[arg-type, return-value]
    "pattern family": lambda name: inverse.pattern_family(name)(lambda m, n: None),  # type: ignore[arg-type, return-value]
    "section": lambda name: inverse.section(name, inverse.seeds.SECTIONS[4]),
}


@pytest.mark.parametrize("what", FRONTS)
def test_every_extension_point_has_a_registry(what: str, registered: tuple[Registry[Any], ...]) -> None:
    before = {registry.what: set(registry) for registry in registered}
    FRONTS[what]("mine")
    added = {registry.what: set(registry) - before[registry.what] for registry in registered}
    assert [kind for kind, names in added.items() if names] == [next(k for k in added if k.endswith(f" {what}"))]
    with pytest.raises(InputError, match=f"'mine' is an? {what} already"):
        FRONTS[what]("mine")
    with pytest.raises(InputError, match=f"'no word' cannot name an? {what}"):
        FRONTS[what]("no word")


def test_every_registry_has_an_extension_point(registered: tuple[Registry[Any], ...]) -> None:
    assert {registry.what.split(" ", 1)[1] for registry in registered} == set(FRONTS)
