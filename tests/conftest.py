from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import pytest
from hypothesis import settings

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

    def judge(fold: dict[str, Any]) -> dict[str, Any]:
        done = subprocess.run(
            [node, NODE / "validate.mjs"], input=json.dumps(fold), capture_output=True, text=True, timeout=60
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return judge
