"""Every example runs and keeps what it asserts; pages of docs/extending/ show the examples as they are."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
PAGES = sorted(page for page in (ROOT / "docs" / "extending").glob("*.md") if page.name != "index.md")


@pytest.mark.usefixtures("registered")
@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_run(path: Path) -> None:
    runpy.run_path(str(path), run_name="__main__")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_pages_show_their_example(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    (name,) = set(re.findall(r"\(\.\./\.\./examples/(\w+\.py)\)", text))
    (shown,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert shown == (ROOT / "examples" / name).read_text(encoding="utf-8")


def test_every_example_has_a_page() -> None:
    pages = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs" / "extending").glob("*.md"))
    assert {path.name for path in EXAMPLES} == set(re.findall(r"examples/(\w+\.py)\)", pages))
    listed = (ROOT / "docs" / "extending" / "index.md").read_text(encoding="utf-8")
    assert all(f"({page.name})" in listed for page in PAGES)


def test_examples_use_public_names_only() -> None:
    for path in EXAMPLES:
        for module in re.findall(r"^(?:from|import) (inverse\S*)", path.read_text(encoding="utf-8"), re.MULTILINE):
            assert module in ("inverse", "inverse.surfaces.mesh")
