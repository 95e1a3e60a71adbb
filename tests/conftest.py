from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NoReturn

import pytest
from hypothesis import settings

from inverse import objectives
from inverse.extending.registry import Registry
from inverse.origami import families, seeds
from inverse.policy import measures
from inverse.surfaces import named
from inverse.terms import own_constraints

# The same input gives the same verdict: property tests draw the same examples in every run.
settings.register_profile("repeatable", derandomize=True)
settings.load_profile("repeatable")

NODE = Path(__file__).parent / "node"


@pytest.fixture(scope="session")
def lacking() -> Callable[[str], NoReturn]:
    """Says in a sentence what a test needs and does not find: a skip, or a failure under REQUIRE_ALL=1."""

    def report(sentence: str) -> NoReturn:
        if os.environ.get("REQUIRE_ALL") == "1":
            pytest.fail(sentence, pytrace=False)
        pytest.skip(sentence)

    return report


@pytest.fixture(scope="session")
def rabbit_ear(lacking: Callable[[str], NoReturn]) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """Rabbit-ear's findings on a flat crease pattern, see tests/node/validate.mjs. Mark users as `node`."""
    node = shutil.which("node")
    if node is None:
        lacking("node is not installed.")
    if not (NODE / "node_modules" / "rabbit-ear").is_dir():
        lacking("rabbit-ear is not installed: run `npm ci` in tests/node.")

    return lambda fold: _answer(node, "validate.mjs", json.dumps(fold).encode())


@pytest.fixture(scope="session")
def gltf_issues(lacking: Callable[[str], NoReturn]) -> Callable[[bytes], list[str]]:
    """Errors and warnings of the Khronos validator on a glTF file. Mark users as `node`."""
    node = shutil.which("node")
    if node is None:
        lacking("node is not installed.")
    if not (NODE / "node_modules" / "gltf-validator").is_dir():
        lacking("gltf-validator is not installed: run `npm ci` in tests/node.")
    return lambda content: _answer(node, "gltf.mjs", content)


def _answer(node: str, program: str, question: bytes) -> Any:
    done = subprocess.run([node, NODE / program], input=question, capture_output=True, timeout=60)
    assert done.returncode == 0, done.stderr.decode()
    return json.loads(done.stdout)


# Without a graphics card, and without calling home.
CHROMIUM = [
    *("--no-sandbox", "--use-gl=angle", "--use-angle=gl-egl", "--ignore-gpu-blocklist", "--no-first-run"),
    *("--disable-quic", "--disable-background-networking", "--disable-component-update", "--disable-sync"),
]


@pytest.fixture(scope="session")
def browser(lacking: Callable[[str], NoReturn]) -> Iterator[Any]:
    """Debian's chromium under playwright. Mark users as `browser`."""
    chromium = shutil.which("chromium")
    if chromium is None:
        lacking("chromium is not installed: on Debian, `apt-get install chromium`.")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=chromium, args=CHROMIUM)
        yield running
        running.close()


REGISTRIES: tuple[Registry[Any], ...] = (
    *(objectives.OBJECTIVES, own_constraints.CONSTRAINTS, measures.MEASURES),
    *(named.TARGETS, families.PATTERN_FAMILIES, seeds.NAMED_SECTIONS),
)


@pytest.fixture
def registered() -> Iterator[tuple[Registry[Any], ...]]:
    """All registries; what a test adds to them goes with it."""
    before = [set(registry) for registry in REGISTRIES]
    yield REGISTRIES
    for registry, names in zip(REGISTRIES, before, strict=True):
        for name in set(registry) - names:
            registry.remove(name)
