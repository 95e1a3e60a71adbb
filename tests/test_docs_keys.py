"""docs/specification.md, the page of all keys: up to date, and complete by what is registered and refused."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

from inverse.objectives import OBJECTIVES
from inverse.origami import seeds
from inverse.spec import Specification

DOCS = Path(__file__).parents[1] / "docs"


@pytest.fixture(scope="module")
def keys() -> ModuleType:
    found = importlib.util.spec_from_file_location("keys", DOCS / "keys.py")
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


def test_the_page_is_up_to_date(keys: ModuleType) -> None:
    assert keys.PAGE.read_text(encoding="utf-8") == keys.page(), "run `python docs/keys.py`"


def test_every_key_has_a_row_with_its_meaning(keys: ModuleType) -> None:
    """Counted over all parts, however they are reached."""
    schema = Specification.model_json_schema()
    expected = sorted(
        (name, " ".join(one.get("description", "").split()))
        for part in (schema, *schema["$defs"].values())
        for name, one in part["properties"].items()
    )
    before = keys.page().split("## Objectives")[0]
    rows = re.findall(r"^\| `(\w+)` \| (.*?) \| .* \| .* \|$", before, re.MULTILINE)
    assert sorted(rows) == expected
    assert all(meaning for _, meaning in rows)


def test_every_objective_and_section_has_a_row(keys: ModuleType) -> None:
    page = keys.page()
    for name, term in OBJECTIVES.items():
        assert f"| `{name}` | {term.weight:g} | " in page
    for name, steps in seeds.NAMED_SECTIONS.items():
        assert f"| `{name}` | {len(steps)} | " in page
