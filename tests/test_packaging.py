"""What is declared, what the built packages hold, and that they work where nothing else of the checkout is."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import zipfile
from collections.abc import Iterator
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

import inverse

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
HOMES = packages_distributions()  # but for single compiled modules, which bear the name of their distribution
SPECIFICATION = """\
name: tiny
pattern: {size: [4, 4]}
target: {height: "sqrt(4 - x^2 - y^2)", domain: [[-1, 1], [-1, 1]]}
"""


def canonical(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def declared(requirements: list[str]) -> set[str]:
    return {canonical(re.split(r"[^\w.-]", requirement)[0]) for requirement in requirements}


def imported(node: ast.AST) -> Iterator[str]:
    """Modules that run-time code imports, also by ``needed`` of the extra and by ``import_module``."""
    if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
        return
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom) and node.module:
        yield node.module
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in {"needed", "import_module"}:
        yield from (one.value for one in node.args if isinstance(one, ast.Constant))
    for child in ast.iter_child_nodes(node):
        yield from imported(child)


@cache
def modules_of(path: Path) -> frozenset[str]:
    return frozenset(name.split(".")[0] for name in imported(ast.parse(path.read_text(encoding="utf-8"))))


def distributions(paths: list[Path]) -> set[str]:
    """What has to be installed for these files."""
    modules = frozenset().union(*map(modules_of, paths)) - sys.stdlib_module_names - {"inverse"}
    return {canonical(HOMES.get(module, [module])[0]) for module in modules}


def test_what_is_imported_is_declared_and_nothing_else() -> None:
    files = list((ROOT / "inverse").rglob("*.py"))
    building = [path for path in files if {"fabricate", "boards"} & set(path.parts)]
    required = declared(PROJECT["dependencies"])
    extra = declared(PROJECT["optional-dependencies"]["fabricate"])
    assert distributions([path for path in files if path not in building]) - required == set()
    assert distributions(files) == required | extra
    assert required & extra == set()


def test_the_lower_bounds_are_what_the_oldest_libraries_are() -> None:
    locked = dict(re.findall(r"^(\S+)==(\S+)", (ROOT / "requirements-oldest.lock").read_text(), re.MULTILINE))
    for requirement in PROJECT["dependencies"] + PROJECT["optional-dependencies"]["fabricate"]:
        name, bound = requirement.split(">=")
        assert re.fullmatch(rf"{re.escape(bound)}(\.0)*", locked[canonical(name)]), requirement


def test_the_version_is_one() -> None:
    assert PROJECT["version"] == inverse.__version__


def test_the_pythons_that_are_claimed_are_the_same_everywhere() -> None:
    newest = max(int(line.split("3.")[1]) for line in PROJECT["classifiers"] if "Python :: 3." in line)
    assert PROJECT["requires-python"] == f">=3.11,<3.{newest + 1}"
    assert f"Python 3.11 to 3.{newest}" in (ROOT / "README.md").read_text(encoding="utf-8")
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert f"< (3, {newest + 1})" in makefile
    assert f"3.11 to 3.{newest}" in makefile


def build(source: Path, target: str, folder: Path) -> Path:
    command = [sys.executable, "-m", "hatchling", "build", "-t", target, "-d", folder]
    subprocess.run(command, cwd=source, check=True, capture_output=True)
    (made,) = folder.glob("*.whl" if target == "wheel" else "*.tar.gz")
    return made


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build(ROOT, "wheel", tmp_path_factory.mktemp("wheel"))


def test_wheel_holds_the_package_and_nothing_else(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    assert {name.split("/")[0].split("-")[0] for name in names} == {"inverse"}
    assert {"inverse/py.typed", "inverse/pictures/worker.py", "inverse/fabricate/film/page.html"} <= set(names)


def test_the_source_makes_the_same_wheel(wheel: Path, tmp_path: Path) -> None:
    archive = build(ROOT, "sdist", tmp_path)
    with tarfile.open(archive) as file:
        file.extractall(tmp_path / "source", filter="data")
    (source,) = (tmp_path / "source").iterdir()
    again = build(source, "wheel", tmp_path)
    first, second = (zipfile.ZipFile(path) for path in (wheel, again))
    assert first.namelist() == second.namelist()
    assert all(first.read(name) == second.read(name) for name in first.namelist())


@pytest.mark.slow
def test_an_installed_wheel_solves(wheel: Path, tmp_path: Path) -> None:
    """In an environment of its own, which only borrows the libraries of this one."""
    environment = tmp_path / "environment"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", environment], check=True)
    python, script = environment / "bin" / "python", environment / "bin" / "inverse"
    (packages,) = environment.glob("lib/python*/site-packages")
    (packages / "borrowed.pth").write_text(f"{sysconfig.get_path('purelib')}\n{sysconfig.get_path('platlib')}\n")
    install = ["install", "--quiet", "--disable-pip-version-check", "--no-deps", "--no-index", wheel]
    subprocess.run([sys.executable, "-m", "pip", "--python", python, *install], check=True)

    clean = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}

    def run(*command: str | Path) -> str:
        done = subprocess.run(command, cwd=tmp_path, env=clean, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout.strip()

    assert run(python, "-c", "import inverse; print(inverse.__file__)") == str(packages / "inverse" / "__init__.py")
    assert run(script, "--version") == inverse.__version__
    (tmp_path / "tiny.yaml").write_text(SPECIFICATION)
    run(script, "solve", "tiny.yaml")
    assert (tmp_path / "out" / "tiny" / "design.fold").exists()
    run(script, "check", "out/tiny/design.fold")
    run(script, "fold", "out/tiny/design.fold")  # a page, which is a file of the package
