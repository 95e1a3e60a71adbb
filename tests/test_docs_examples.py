"""Every block of code in README and docs runs, page by page, each page in a folder of its own with targets/ in it."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pytest
from designs import eggbox, tube
from markdown_it import MarkdownIt
from ruamel.yaml import YAML

import inverse
from inverse.cli import commands
from inverse.pictures import rendering

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "targets" / "README.md", *ROOT.glob("docs/**/*.md")]

# Commands that do not run here, by how they begin, and why.
NOT_RUN = {
    "make ": "sets up an environment and runs these tests, or takes long",
    ".venv/bin/pre-commit ": "changes the checkout",
    "npm ": "needs the network",
    "apt-get ": "needs the network and rights",
    ".venv/bin/python -m studies.": "runs in test_studies.py",
    "inverse repair PATTERN.fold|PATTERN.obj ": "a synopsis",
}
# Runs that would take long, and what is run instead.
SMALL = "--frames 2 --size 160 90"
SHORTER = {
    "--frames 150": SMALL,
    "-o site.mp4": f"-o site.mp4 {SMALL}",
    "--to gif --to glb": f"--to gif --to glb {SMALL}",
    "frames=60,": "frames=2, size=(160, 90),",
}
SLOW = {"README.md", "docs/motion.md", "docs/panels.md", "docs/tubes.md"}
DRAWN = {"docs/motion.md"}  # pages with films

GRID = {"name": "given", "pattern": {"size": [4, 4]}, "target": {"height": "1 - x^2", "domain": [[-1, 1], [-1, 1]]}}
TUBE = {
    "name": "given",
    "pattern": {"kind": "tube", "size": [6, 10]},
    "target": {"axis": {"polyline": [[0, 0, 0], [0, 0, 6]]}, "radius": 1},
}


@dataclass(frozen=True)
class Block:
    """A block of a page: its language, its text and the line where it begins."""

    language: str
    text: str
    line: int


def blocks(page: Path) -> Iterator[Block]:
    for token in MarkdownIt().parse(page.read_text(encoding="utf-8")):
        if token.type in {"fence", "code_block"}:
            assert token.map is not None
            language = token.info.split(" ")[0] if token.type == "fence" else "console"
            yield Block(language, token.content, token.map[0] + 1)


def name(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def parameters() -> list[Any]:
    return [
        pytest.param(page, id=name(page), marks=[pytest.mark.slow] if name(page) in SLOW else [])
        for page in PAGES
        if any(block.language in RUN for block in blocks(page))
    ]


def run_python(block: Block, page: Path, names: dict[str, Any]) -> None:
    # Empty lines before it, so that a traceback names the page's line.
    exec(compile("\n" * block.line + block.text, page, "exec"), names)


def run_commands(block: Block, page: Path, _: dict[str, Any]) -> None:
    for line in block.text.splitlines():
        command = line.split(" # ")[0].rstrip()
        if any(f"{command} ".startswith(beginning) for beginning in NOT_RUN):
            continue
        program, *arguments = shlex.split(command, comments=True)
        assert program in {"inverse", ".venv/bin/inverse"}, f"{name(page)}: cannot run {line}; say why in NOT_RUN"
        assert commands.run(arguments) == 0, f"{name(page)}: {line}"


def read_specification(block: Block, page: Path, _: dict[str, Any]) -> None:
    """A whole specification becomes a file, for the commands that follow; of a part the rest is given."""
    keys = YAML(typ="safe").load(block.text)
    about_tubes = "axis" in keys.get("target", {}) or page.stem == "tubes"
    whole = keys if {"name", "pattern", "target"} <= keys.keys() else (TUBE if about_tubes else GRID) | keys
    path = Path(f"{whole['name']}.yaml")
    if whole is keys:
        path.write_text(block.text)
    else:
        with path.open("w") as file:
            YAML(typ="safe").dump(whole, file)
    inverse.load(path)


RUN = {"python": run_python, "console": run_commands, "yaml": read_specification}


@pytest.mark.parametrize("page", parameters())
def test_what_a_page_shows_runs(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, lacking: Callable[[str], NoReturn], registered: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "targets").symlink_to(ROOT / "targets")
    files_at_hand()
    if name(page) in DRAWN:
        if (reason := rendering.can_render()) is not None:
            lacking(reason)
    else:
        monkeypatch.setattr(rendering, "lacking", lambda: "no pictures here")
    names: dict[str, Any] = {}
    for block in blocks(page):
        if block.language in RUN:
            text = block.text
            for shown, shorter in SHORTER.items():
                text = text.replace(shown, shorter)
            RUN[block.language](Block(block.language, text, block.line), page, names)


def files_at_hand() -> None:
    """The designs and patterns that pages speak of."""
    sheet = eggbox(4, 6)
    for path, design in {"DESIGN.fold": sheet, "out/vault/design.fold": sheet, "out/tube/design.fold": tube()}.items():
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        inverse.write(design, path)
    off = sheet.moved_to(sheet.vertices_coords + 1e-4 * np.random.default_rng(0).standard_normal((35, 3)))
    inverse.write(off, "somebodys_pattern.fold")
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in off.vertices_coords.tolist()]
    lines += ["f " + " ".join(str(v + 1) for v in face) for face in off.pattern.faces_vertices]
    Path("somebodys_pattern.obj").write_text("\n".join(lines) + "\n")


def test_languages_of_blocks_are_known() -> None:
    """A block in a language that nothing runs is a mistake, or needs a line in RUN."""
    for page in PAGES:
        for block in blocks(page):
            assert block.language in {*RUN, "", "text", "toml", "{include}", "{toctree}", "{eval-rst}"}, (
                page,
                block.line,
            )
