"""The arrows between the modules of inverse/: who may import whom, read from the sources."""

from __future__ import annotations

import ast
import graphlib
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "inverse"

# Module or folder of inverse/ -> the others it may import. Inside a folder all may import all.
# A module may be named before it exists.
ARROWS: dict[str, set[str]] = {
    "errors": set(),
    "words": set(),
    "limits": {"errors"},
    "files": {"errors", "words"},
    "mesh_files": {"errors", "limits", "files"},
    "crossing": set(),
    "fold_format": {"errors", "limits", "files"},
    "interrupts": set(),
    "pattern": {"errors"},
    "geometry": {"pattern"},
    "holes": {"pattern"},
    "strips": {"pattern"},
    "folding": {"pattern", "geometry"},
    "fold_file": {"errors", "limits", "files", "fold_format", "pattern", "geometry", "holes", "folding"},
    "seeds": {"errors", "crossing", "pattern", "geometry"},
    # A second opinion: nothing that the optimizer computes with.
    "certify": {"errors", "crossing", "fold_format"},
    "target": {"errors", "words", "mesh_files"},
    "placement": {"errors", "pattern", "geometry", "seeds", "target"},
    "fields": {"limits", "words"},
    "yaml_data": {"errors"},
    "yaml_source": {"errors", "files", "yaml_data"},
    "validation": {"errors", "words", "fields", "yaml_data", "yaml_source"},
    "spec_pattern": {"errors", "words", "fields", "seeds"},
    "spec_target": {"errors", "fields", "target"},
    "spec_footprint": {"words", "fields"},
    "spec": {"errors", "words", "fields", "validation", "yaml_source", "spec_footprint", "spec_pattern", "spec_target"},
    "kernels": {"pattern"},
    "model": {"pattern", "geometry", "kernels"},
    "footprint": {"pattern", "geometry", "folding"},
    "packed_state": {"pattern", "folding", "kernels", "model"},
    "packed": {"pattern", "footprint", "kernels", "model", "packed_state"},
    "constraints": {"errors", "pattern", "geometry", "kernels", "model", "target"},
    "separation": {"pattern", "folding", "kernels", "model", "packed_state"},
    "tube_fit": {"pattern", "geometry", "kernels", "model", "target"},
    "objectives": {"errors", "pattern", "geometry", "kernels", "model", "packed", "target", "placement", "tube_fit"},
    "fillings": set(),
    "cylinder_loop": {"errors", "pattern", "geometry", "holes", "fillings", "kernels", "model", "constraints"},
    "assembly": {"errors", "pattern", "kernels", "model"},
    "attempt": {"pattern"},
    "control": {"attempt", "interrupts"},
    "redundancy": {"pattern", "assembly"},
    "ipopt": {"errors", "pattern", "assembly", "attempt", "redundancy"},
    "projection": {"pattern", "assembly"},
    "refine": {
        *(
            "errors",
            "pattern",
            "geometry",
            "kernels",
            "model",
            "constraints",
            "cylinder_loop",
            "assembly",
            "projection",
        ),
    },
    "chart": {"pattern", "assembly"},
    "nlopt_solver": {"pattern", "assembly", "attempt", "chart"},
    "relaxation": {"pattern", "assembly", "attempt", "ipopt"},
    "verdict": {
        "pattern",
        "geometry",
        "crossing",
        "footprint",
        "packed",
        "objectives",
        "assembly",
        "target",
        "tube_fit",
        "certify",
    },
    "anchors": {"errors", "pattern", "model", "constraints", "spec"},
}
# What a specification means, then how it is solved: these stand on everything above.
ARROWS["formulate"] = set(ARROWS) - {
    "assembly",
    "redundancy",
    "ipopt",
    "chart",
    "nlopt_solver",
    "refine",
    "verdict",
    "certify",
}
ARROWS["coarse"] = {"pattern", "spec"}
ARROWS["runs"] = set(ARROWS) - {"certify"}
ARROWS["rounds"] = set(ARROWS) - {"certify"}
ARROWS["statuses"] = set()
ARROWS["policy"] = set(ARROWS)
ARROWS["solve"] = set(ARROWS)
ARROWS["repair"] = {
    *("errors", "fold_format", "fold_file", "pattern", "geometry", "folding", "crossing", "certify"),
    *("limits", "mesh_files", "model", "constraints", "assembly", "projection"),
}
ARROWS["context"] = {"errors", "files", "words", "pattern"}

# Leaves import what they like, and nothing above imports them.
LEAVES = {
    "__init__",
    "__main__",
    "app",
    "cli",
    "cli_export",
    "cli_fold",
    "cli_output",
    "fabricate",
    "pictures",
    "report",
    "results",
    "study",
    "terminal",
}

# Heavy libraries and who may import them.
LIBRARIES = {
    "casadi": {
        *(
            "kernels",
            "model",
            "target",
            "packed",
            "packed_state",
            "constraints",
            "objectives",
            "cylinder_loop",
            "separation",
            "tube_fit",
        ),
        *("assembly", "ipopt", "solve", "refine"),
    },
    "nlopt": {"nlopt_solver"},
    "pyvista": {"pictures", "report", "target", "context"},
    "vtk": {"pictures", "report"},
    "vtkmodules": {"pictures", "report"},
    "matplotlib": {"pictures", "report", "target", "context"},
    "imageio_ffmpeg": {"fabricate"},
    "pygltflib": {"fabricate"},
}

FILES = sorted(PACKAGE.rglob("*.py"))


def unit_of(path: Path) -> str:
    """The module or folder directly under inverse/ that a file belongs to."""
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


def imports_of(path: Path) -> list[tuple[int, str]]:
    """(line, dotted name) of everything a file imports, wherever in the file it does so."""
    found = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            folder = ["inverse", *path.relative_to(PACKAGE).parent.parts]
            base = folder[: len(folder) + 1 - node.level] if node.level else []
            base += node.module.split(".") if node.module else []
            found += [(node.lineno, ".".join([*base, alias.name])) for alias in node.names]
    return found


def test_arrows_form_no_circle():
    graphlib.TopologicalSorter(ARROWS).prepare()


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(PACKAGE).as_posix())
def test_imports_follow_the_arrows(path: Path):
    unit = unit_of(path)
    if unit not in ARROWS.keys() | LEAVES:
        pytest.fail(
            f"inverse/{unit} is new: add it to ARROWS in tests/test_layers.py with the modules it may "
            "import, or to LEAVES if nothing in the core will ever import it.",
            pytrace=False,
        )
    wrong = []
    for line, name in imports_of(path):
        library, _, rest = name.partition(".")
        other = rest.split(".")[0]
        if library != "inverse":
            allowed = LIBRARIES.get(library, {unit})
            if unit not in allowed:
                wrong.append(f"line {line}: {unit} may not import {library}, only {sorted(allowed)} may")
        elif unit not in LEAVES and other != unit:
            if not other or not ((PACKAGE / other).is_dir() or (PACKAGE / f"{other}.py").is_file()):
                wrong.append(f"line {line}: import {name} from its module, not from the package")
            elif other not in ARROWS[unit]:
                wrong.append(f"line {line}: {unit} may not import {other}, only {sorted(ARROWS[unit])}")
    if wrong:
        pytest.fail("\n".join([path.relative_to(PACKAGE.parent).as_posix(), *dict.fromkeys(wrong)]), pytrace=False)


def test_one_file_speaks_to_nlopt():
    users = [path for path in FILES if "nlopt" in {name.split(".")[0] for _, name in imports_of(path)}]
    assert len(users) <= 1, users


def test_importing_inverse_loads_nothing_heavy():
    heavy = ["casadi", "matplotlib", "pydantic", "pyvista", "vtk", "vtkmodules"]
    code = f"import sys, inverse; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=PACKAGE.parent)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[]"
