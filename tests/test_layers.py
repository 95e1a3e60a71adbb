"""The arrows between the modules of inverse/: who may import whom, read from the sources."""

from __future__ import annotations

import ast
import graphlib
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "inverse"
FRONT = {"__init__", "__main__", "cli"}  # these may take public names from the package itself

# Room -> the rooms it may import. A room is a module or a folder of inverse/; in `fabricate`, which has folders of its
# own, each of these and each file beside them. Inside a room all may import all.
GROUND = {"_types", "errors", "words", "crossing", "limits", "interrupts", "extending"}
ARROWS: dict[str, set[str]] = {
    "_types": set(),
    "errors": set(),
    "words": set(),
    "interrupts": set(),
    "crossing": {"_types"},
    "limits": {"errors"},
    "extending": {"errors", "words"},
    "origami": GROUND,
    "nlp": GROUND,
    "files": GROUND | {"origami"},
    "surfaces": GROUND | {"files"},
    # A second opinion: nothing that the optimizer computes with.
    "certify": GROUND | {"files"},
    "spec": GROUND | {"origami", "files", "surfaces"},
    "model": GROUND | {"origami"},
    "constraints": GROUND | {"origami", "nlp", "model"},
    "terms": GROUND | {"origami", "nlp", "surfaces", "model"},
    "cylinder_loop": GROUND | {"origami", "nlp", "model", "constraints", "terms"},
    "objectives": GROUND | {"origami", "nlp", "terms"},
    "solvers": GROUND | {"nlp"},
    "context": GROUND | {"files"},
    "pictures": GROUND | {"origami", "files"},
    "dragging": GROUND | {"origami", "nlp", "model", "constraints", "cylinder_loop", "solvers"},
    "repair": GROUND | {"origami", "nlp", "files", "model", "constraints", "solvers", "certify"},
    "formulation": GROUND
    | {
        "origami",
        "nlp",
        "files",
        "surfaces",
        "spec",
        "model",
        "constraints",
        "terms",
        "cylinder_loop",
        "objectives",
        "context",
    },
    "brief": GROUND | {"origami", "surfaces", "certify", "spec", "formulation"},
    "policy": GROUND | {"origami", "nlp", "files", "spec", "terms", "solvers", "formulation", "certify"},
    "results": GROUND
    | {
        "origami",
        "nlp",
        "files",
        "spec",
        "terms",
        "formulation",
        "certify",
        "policy",
        "brief",
        "context",
        "pictures",
        "repair",
    },
    "solve": {"origami", "files", "surfaces", "spec", "formulation", "certify", "policy", "results"},
    "session": GROUND | {"origami", "nlp", "surfaces", "spec", "formulation", "policy", "results"},
    "showing": {"_types", "origami", "spec", "formulation", "pictures"},
    # Leaves and front doors: no room above imports them.
    "fabricate/units": set(),
    "fabricate/extras": GROUND,
    "fabricate/dxf_file": {"fabricate/extras"},
    "fabricate/cut": GROUND | {"origami", "pictures", "fabricate/units", "fabricate/extras", "fabricate/dxf_file"},
    "fabricate/panels": GROUND
    | {"origami", "files", "certify", "fabricate/units", "fabricate/extras", "fabricate/dxf_file"},
    "fabricate/parts": GROUND | {"origami", "fabricate/panels"},
    "fabricate/meshes": GROUND
    | {"origami", "pictures", "fabricate/units", "fabricate/extras", "fabricate/panels", "fabricate/parts"},
    "fabricate/rhino": GROUND
    | {"origami", "pictures", "fabricate/extras", "fabricate/panels", "fabricate/parts", "fabricate/meshes"},
    "fabricate/picture": GROUND | {"origami", "pictures", "fabricate/panels", "fabricate/parts", "fabricate/meshes"},
    "fabricate/film": GROUND
    | {
        "origami",
        "files",
        "surfaces",
        "spec",
        "formulation",
        "context",
        "pictures",
        "fabricate/units",
        "fabricate/panels",
        "fabricate/picture",
    },
    "fabricate/formats": GROUND
    | {
        "origami",
        "fabricate/units",
        "fabricate/cut",
        "fabricate/panels",
        "fabricate/meshes",
        "fabricate/rhino",
        "fabricate/film",
    },
    "fabricate/__init__": set(),
    "boards": GROUND | {"origami", "pictures", "fabricate/units", "fabricate/extras", "fabricate/film"},
    "cli": GROUND
    | {
        "origami",
        "files",
        "spec",
        "solvers",
        "repair",
        "pictures",
        "results",
        "solve",
        "showing",
        "certify",
        "fabricate/units",
        "fabricate/panels",
        "fabricate/film",
        "fabricate/formats",
        "boards",
    },
    "__main__": GROUND | {"cli"},
    "__init__": GROUND
    | {
        "origami",
        "files",
        "surfaces",
        "spec",
        "terms",
        "objectives",
        "solvers",
        "certify",
        "policy",
        "dragging",
        "repair",
        "results",
        "solve",
        "session",
    },
}

# Heavy libraries and who may import them.
LIBRARIES = {
    "casadi": {"nlp", "surfaces", "model", "terms", "constraints", "objectives", "cylinder_loop", "solvers"},
    "nlopt": {"solvers"},
    "pydantic": {"spec", "results"},
    "ruamel": {"spec"},
    "cyclopts": {"cli"},
    "pyvista": {"pictures"},
    "vtk": {"pictures"},
    "vtkmodules": {"pictures"},
    "matplotlib": set(),
    "trimesh": {"fabricate/meshes"},
    "imageio_ffmpeg": {"fabricate/film"},
    "pygltflib": {"fabricate/film"},
    "ezdxf": {"fabricate/dxf_file", "fabricate/cut", "fabricate/panels"},
    "reportlab": {"fabricate/cut", "boards"},
}

FILES = sorted(PACKAGE.rglob("*.py"))


def room_of(parts: Sequence[str]) -> str:
    """The room that a path or a dotted name below inverse/ belongs to."""
    own = [parts[0].removesuffix(".py"), *(part.removesuffix(".py") for part in parts[1:2])]
    return "/".join(own) if own[0] == "fabricate" and len(own) > 1 else own[0]


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


def wrong_imports(room: str, imports: list[tuple[int, str]]) -> list[str]:
    """What of the imports of a file in a room goes against the arrows, as sentences."""
    wrong = []
    for line, name in imports:
        library, _, rest = name.partition(".")
        if library != "inverse":
            if room not in LIBRARIES.get(library, {room}):
                wrong.append(f"line {line}: {room} may not import {library}, only {sorted(LIBRARIES[library])} may")
            continue
        other = room_of(rest.split(".")) if rest else ""
        known = other in ARROWS or (PACKAGE / f"{other}.py").is_file() or (PACKAGE / other).is_dir()
        if not other or not known:
            if room not in FRONT:
                wrong.append(f"line {line}: import {name} from its module, not from the package")
        elif other != room and other not in ARROWS[room]:
            wrong.append(f"line {line}: {room} may not import {other}, only {sorted(ARROWS[room])}")
    return wrong


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(PACKAGE).as_posix())
def test_imports_follow_the_arrows(path: Path):
    room = room_of(path.relative_to(PACKAGE).parts)
    if room not in ARROWS:
        pytest.fail(
            f"inverse/{room} is new: add it to ARROWS in tests/test_layers.py with the rooms it may import.",
            pytrace=False,
        )
    wrong = wrong_imports(room, imports_of(path))
    if wrong:
        pytest.fail("\n".join([path.relative_to(PACKAGE.parent).as_posix(), *dict.fromkeys(wrong)]), pytrace=False)


@pytest.mark.parametrize("room", sorted(ARROWS))
def test_every_spoiled_arrow_is_noticed(room: str):
    """Rooms that may not be imported are refused, leaves and the front door included."""
    for other in ARROWS.keys() - ARROWS[room] - {room, "__init__"}:
        name = "inverse." + other.replace("/", ".") + ".something"
        assert wrong_imports(room, [(1, name)]) == [
            f"line 1: {room} may not import {other}, only {sorted(ARROWS[room])}"
        ]


def test_every_arrow_is_used():
    """A room that may import what it never does is a door left open."""
    used: dict[str, set[str]] = {room: set() for room in ARROWS}
    for path in FILES:
        room = room_of(path.relative_to(PACKAGE).parts)
        used[room] |= {room_of(name.split(".")[1:]) for _, name in imports_of(path) if name.startswith("inverse.")}
    idle = {room: sorted(ARROWS[room] - GROUND - used[room]) for room in ARROWS}
    assert {room: rest for room, rest in idle.items() if rest} == {}


def test_one_file_speaks_to_nlopt():
    users = [path for path in FILES if "nlopt" in {name.split(".")[0] for _, name in imports_of(path)}]
    assert len(users) <= 1, users


def test_importing_inverse_loads_nothing_heavy():
    heavy = ["casadi", "matplotlib", "pydantic", "pyvista", "vtk", "vtkmodules"]
    code = f"import sys, inverse; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=PACKAGE.parent)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[]"


def test_the_certificate_shares_the_file_format_alone():
    names = {name for path in (PACKAGE / "certify").glob("*.py") for _, name in imports_of(path)}
    shared = {name.rsplit(".", 1)[0] for name in names if name.startswith("inverse.files")}
    assert shared <= {"inverse.files", "inverse.files.fold_format"}


def test_the_tree_in_the_readme_names_every_room():
    text = (PACKAGE.parent / "README.md").read_text(encoding="utf-8")
    tree = text[text.index("inverse/\n") : text.index("targets/   ")]
    for path in sorted(PACKAGE.iterdir()):
        if path.is_dir() and path.name != "__pycache__":
            assert f"  {path.name}/ " in tree, path.name
        elif path.suffix == ".py" and not path.name.startswith("__"):
            assert path.stem in tree, path.name
