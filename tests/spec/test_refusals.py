from pathlib import Path
from typing import Any

import pytest
from specifications import TEXT

from inverse.errors import InputError
from inverse.spec import load


def changed(old: str, new: str) -> str:
    assert TEXT.count(old) == 1
    return TEXT.replace(old, new)


@pytest.fixture
def refusal(tmp_path: Path) -> Any:
    """The refusal of a text, its ``where`` without the name of the file."""

    def refuse(text: str, *overrides: str) -> tuple[str, str]:
        path = tmp_path / "vault.yaml"
        path.write_text(text)
        with pytest.raises(InputError) as caught:
            load(path, overrides)
        return (caught.value.where or "").removeprefix(f"{path}:"), str(caught.value)

    return refuse


LINES = "is no line type: allowed are FL (foldline), CFL (complementary foldline)."
TARGETS = "mesh, height, between, axis, surface"
PLACES = "point, polyline, polygon, plane, circle"
UNITS = "unit (none), m, cm, mm, um, nm, in (inches)"
TO = "{polyline: [[0, 0, 0], [1, 0, 0]]}"
TARGET = '{height: "0.45 - 0.3*(x^2 + y^2)", domain: [[-1, 1], [-1, 1]]}'
HEIGHT = '"0.45 - 0.3*(x^2 + y^2)"'
DOMAIN = "[[-1, 1], [-1, 1]]"
NAME_CHARACTERS = "it must consist of the allowed characters"

# What is replaced in TEXT, by what, with a | where the refusal must point, and how its message begins.
UNKNOWN_KEYS = [
    (
        "pattern:",
        "|pattrn:",
        '"pattrn" is no key of the top level: allowed are name, units, pattern, context, target, fit, '
        "objectives, footprint, constraints, require, solver, pictures. Did you mean pattern? (and 1 more)",
    ),
    (
        "sector_angle: 60",
        "|sector_angel: 60",
        '"sector_angel" is no key of pattern: allowed are kind, size, u_lines, v_lines, sector_angle, '
        "fold_state, lengths_u, lengths_v, turn, start_size, trim. Did you mean sector_angle?",
    ),
    (
        "domain:",
        "|domian:",
        '"domian" is no key of target: allowed are height, domain. Did you mean domain? (and 1 more)',
    ),
    (
        "{height:",
        "{|hieght:",
        f'"hieght" is no key of target: allowed are {TARGETS}, domain, implicit, profile, radius, rise, section. ',
    ),
    (
        "side: u0,",
        "|sied: u0,",
        '"sied" is no key of an anchor: allowed are side, vertices, every, to, within. Did you mean side?',
    ),
    (
        "normal:",
        "|normel:",
        '"normel" is no key of constraints.anchors.1.to.plane: allowed are point, normal. '
        "Did you mean normal? (and 1 more)",
    ),
    (
        "tolerance:",
        "|limit:",
        '"limit" is no key of solver: allowed are method, tolerance, max_iterations, time_limit_s. '
        "Did you mean time_limit_s?",
    ),
    ("units: m", "|12: m", '"12" is no key of the top level'),
    ("fold_angle: [20, 160]", "|<word>: 3", '"<word>" is no key of constraints: allowed are fold_angle, '),
]
WORDS = [
    ("u_lines: FL", "u_lines: |LF", f'"LF" {LINES} Did you mean FL?\n'),
    ("u_lines: FL", "u_lines: [FL, |CLF]", f'"CLF" {LINES} Did you mean CFL?\n'),
    ("u_lines: FL", "u_lines: |3", f"3 {LINES}\n"),
    ("kind: grid", "kind: |gird", '"gird" is no kind of pattern: allowed are grid, tube, file, family. Did you'),
    ("kind: grid", "kind: |[grid]", '["grid"] is no kind of pattern: allowed are grid, tube, file, family.\n'),
    ("kind: grid", "kind: grid\n  turn: |45", "45 is no turn of a pattern: allowed are 0, 90.\n"),
    ("kind: grid", "kind: grid\n  turn: |true", "true is no turn of a pattern"),
    ("units: m", "units: |pt", f'"pt" is no unit: allowed are {UNITS}.\n'),
    ("points: facets", "points: |facet", '"facet" is no set of points'),
    ("side: u0", "side: |u9", '"u9" is no side: allowed are u0, u1, v0, v1, ends.'),
    ("ipopt", "|iptop", '"iptop" is no method: allowed are ipopt, nlopt. Did you mean ipopt?'),
]
COUNTS = [
    (
        "u_lines: FL",
        "|u_lines: [FL, CFL, FL]",
        "u_lines has 3 words, but a 16 x 24 grid has 15 interior u lines",
    ),
    ("v_lines: FL", "|v_lines: []", "v_lines has 0 words, but a 16 x 24 grid has 23 interior v lines"),
    ("v_lines: FL", "|lengths_v: [1]", "lengths_v has 1 length, but a 16 x 24 grid has 24 strips along v"),
    ("[16, 24]", "|[16]", "[16] should be a list of 2: [m, n]"),
    ("[16, 24]", "|16", "16 should be a list of 2: [m, n]"),
    (DOMAIN, "[|-1, 1]", "-1 should be a list of 2: [low, high] (and 1 more)"),
    (
        TO,
        "{polyline: |[[0, 0, 0]]}",
        "constraints.anchors.0.to.polyline is [[0, 0, 0]]: it must have at least 2",
    ),
    (TO, "{point: |[0, 0]}", "[0, 0] should be a list of 3: [x, y, z]"),
    ("[0, 3]", "|[]", "constraints.anchors.1.vertices is []: it must have at least 1 entries"),
]
RANGES = [
    ("[16, 24]", "[|0, 24]", "pattern.size.0 is 0: it must be at least 1"),
    ("[16, 24]", "[16, |513]", "pattern.size.1 is 513: it must be at most 512"),
    ("sector_angle: 60", "sector_angle: |95", "pattern.sector_angle is 95: it must be less than 90"),
    ("sector_angle: 60", "sector_angle: |90", "pattern.sector_angle is 90: it must be less than 90"),
    ("sector_angle: 60", "sector_angle: |0", "pattern.sector_angle is 0: it must be greater than 0"),
    ("sector_angle: 60", "fold_state: |1", "pattern.fold_state is 1: it must be less than 1"),
    ("sector_angle: 60", "start_size: [1, |0]", "pattern.start_size.1 is 0: it must be greater than 0"),
    ("[20, 160]", "[|0.5, 160]", "constraints.fold_angle.0 is 0.5: it must be at least 1"),
    ("[20, 160]", "[20, |180]", "constraints.fold_angle.1 is 180: it must be at most 179"),
    ("[20, 160]", "|[160, 20]", "[160, 20] should be [low, high] with low below high"),
    (DOMAIN, "[|[1, 1], [-1, 1]]", "[1, 1] should be [low, high] with low below high"),
    ("footprint: 0", "footprint: |-1", "objectives.footprint is -1: it must be at least 0"),
    ("every: 2", "every: |0", "constraints.anchors.0.every is 0: it must be at least 1"),
    ("1.0e-9", "|0.1", "solver.tolerance is 0.1: it must be at most 0.001"),
    ("[0, 3]", "[0, |-3]", "constraints.anchors.1.vertices.1 is -3: it must be at least 0"),
    ("below: 2.4", "below: |1e300", "constraints.keep_out.0.below is 1e+300: it must be at most 1e+12"),
    (
        TO,
        "{polyline: [[0, 0, 0], [|1e20, 0, 0]]}",
        "constraints.anchors.0.to.polyline.1.0 is 1e+20: it must be at most",
    ),
    (
        TO,
        "{circle: {center: [0, 0, 0], normal: [0, 0, 1], radius: |1e-300}}",
        "1e-300 is too small: it must be at least",
    ),
    ("ipopt", f"ipopt, max_iterations: |{10**30}", f"solver.max_iterations is {10**30}: it must be at most 1e+09"),
    ("vault", "|" + 300 * "a", 'name is "aaa'),
]
KINDS = [
    ("sector_angle: 60", 'sector_angle: |"60"', 'pattern.sector_angle is "60": it must be a number'),
    ("sector_angle: 60", "sector_angle: |true", "pattern.sector_angle is true: it must be a number"),
    ("sector_angle: 60", "sector_angle: |.nan", "pattern.sector_angle is NaN: it must be finite"),
    ("[16, 24]", "[16, |24.0]", "pattern.size.1 is 24.0: it must be a whole number"),
    ("below: 2.4", "below: |.inf", "constraints.keep_out.0.below is Infinity: it must be finite"),
    ("name: vault", "name: |12", "name is 12: it must be text"),
    ("name: vault", "name: |a/b", f'name is "a/b": {NAME_CHARACTERS}'),
    ("name: vault", 'name: |"a\\n"', f'name is "a\\n": {NAME_CHARACTERS}'),
    ("name: vault", "name: |..", f'name is "..": {NAME_CHARACTERS}'),
    ("{points: facets}", "|facets", 'fit is "facets": it must be a mapping of keys to values'),
    (
        "[{below: 2.4}]",
        "|{below: 2.4}",
        "constraints.keep_out is a mapping with the keys below: it must be a list",
    ),
    ("{fit: 1.0, fairness: 1.0e-4, footprint: 0}", "|[fit]", 'objectives is ["fit"]: it must be a mapping'),
]
ONE_OF = [
    ("{height:", "{mesh: a.obj, |height:", f"target needs exactly one of {TARGETS}; given mesh and height\n"),
    (TARGET, "|{}", f"target needs exactly one of {TARGETS}; given none of them"),
    (TARGET, "|{domain: [[0, 1], [0, 1]]}", f"target needs exactly one of {TARGETS}; given none of them"),
    (TARGET, "|a.obj", f'target should be a mapping with exactly one of {TARGETS}; given "a.obj"'),
    (
        "side: u0,",
        "side: u0, |vertices: [1],",
        "an anchor needs exactly one of side, vertices; given side and vertices\n",
    ),
    ("{side: u0, ", "|{", "an anchor needs exactly one of side, vertices; given none of them"),
    (
        TO,
        "{point: [0, 0, 0], |plane: {point: [0, 0, 0], normal: [0, 0, 1]}}",
        f"an anchor's place needs exactly one of {PLACES}; given point and plane",
    ),
    (TO, "|{}", f"an anchor's place needs exactly one of {PLACES}; given none of them"),
    (
        "{below: 2.4}",
        "{below: 2.4, |above: 3}",
        "a keep-out needs exactly one of below, above, plane; given below and above",
    ),
]
GEOMETRY = [
    (TARGET, '{mesh: |""}', 'target.mesh is "": it must not be empty'),
    (
        TARGET,
        "{between: |[[[0, 0, 0], [1, 0, 0]]], rise: 3}",
        "[[[0, 0, 0], [1, 0, 0]]] should be a list of 2: [polyline, polyline]",
    ),
    (
        TARGET,
        "{between: [[[0, 0, 0], [1, 0, 0]], |[[1, 0, 0], [1, 1, 0], [1, 1, 0]]], rise: 3}",
        "points 1 and 2 of this polyline (counted from 0) are the same: [1, 1, 0]",
    ),
    (
        HEIGHT,
        "|__import__('os')",
        "`__import__` at position 1 of the height expression is no mathematical function: allowed are sqrt, ",
    ),
    (HEIGHT, "|1 + sine(x)", "`sine` at position 5 of the height expression is no mathematical function"),
    (HEIGHT, "|3", "target.height is 3: it must be text"),
    ("[0, 3]", "|[0, 3, 0]", "vertex 0 is named twice"),
    ("normal: [0, 0, 1]", "normal: |[0, 0, 0.0]", "the normal [0, 0, 0] has no length"),
    (
        TO,
        "{circle: {center: [0, 0, 0], normal: [0, 0, 1], radius: |0}}",
        "constraints.anchors.0.to.circle.radius is 0: it must be greater than 0",
    ),
]
STATES = "allowed are developed, flat-folded or degrees between 0 and 180."


def footprint(keys: str) -> str:
    return f"[{{below: 2.4}}]\n  footprint: {keys}"


SOLVER = "solver:"
FOOTPRINT = [
    (SOLVER, "footprint: {state: |folded}\nsolver:", f'"folded" is no state: {STATES} Did you mean flat-folded?'),
    (SOLVER, "footprint: {state: |180}\nsolver:", f"180 is no state: {STATES} Write flat-folded."),
    (SOLVER, "footprint: {state: |0}\nsolver:", f"0 is no state: {STATES} Write developed."),
    (SOLVER, "footprint: {state: |-3.5}\nsolver:", f"-3.5 is no state: {STATES}\n"),
    (SOLVER, "footprint: {state: |.nan}\nsolver:", f"NaN is no state: {STATES}\n"),
    (SOLVER, "footprint: {state: |true}\nsolver:", f"true is no state: {STATES}\n"),
    (
        SOLVER,
        "footprint: {measure: |size}\nsolver:",
        '"size" is no measure: allowed are extent (mean square of the box',
    ),
    (SOLVER, "footprint: {state: 40, measure: |area}\nsolver:", "measure: area is for flat states, developed and"),
    (SOLVER, "footprint: {|stat: 40}\nsolver:", '"stat" is no key of footprint: allowed are state, measure.'),
    ("[{below: 2.4}]", footprint("|{}"), "a footprint needs at least one of length, width, height, area"),
    (
        "[{below: 2.4}]",
        footprint("|{state: developed}"),
        "a footprint needs at least one of length, width, height, area",
    ),
    ("[{below: 2.4}]", footprint("{width: |0}"), "constraints.footprint.width is 0: it must be greater than 0"),
    ("[{below: 2.4}]", footprint("{width: 2, |height: 1}"), "the flat-folded state is flat and has no height"),
    ("[{below: 2.4}]", footprint("{state: 40, |area: 1}"), "area is for flat states, developed and flat-folded"),
    ("[{below: 2.4}]", footprint("{width: |3, length: 2}"), "width 3 is more than length 2: exchange them"),
    ("[{below: 2.4}]", footprint("{state: 40, height: |3, length: 2}"), "height 3 is more than length 2"),
    (
        "[{below: 2.4}]",
        footprint("{|widht: 2}"),
        '"widht" is no key of constraints.footprint: allowed are state, length, ',
    ),
]


@pytest.mark.parametrize(
    ("old", "new", "message"), [*UNKNOWN_KEYS, *WORDS, *COUNTS, *RANGES, *KINDS, *ONE_OF, *GEOMETRY, *FOOTPRINT]
)
def test_refusals(refusal: Any, old: str, new: str, message: str) -> None:
    before, _, _ = changed(old, new).partition("|")
    expected = f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"
    where, text = refusal(changed(old, new.replace("|", "", 1)))
    assert where == expected
    assert text.split(f":{where}: ", 1)[1].startswith(message)


@pytest.mark.parametrize(
    ("old", "where", "message"),
    [
        ("name: vault\n", "1:1", 'the key "name" is missing from the top level'),
        ("  size: [16, 24]\n", "3:1", 'the key "size" is missing from pattern'),
        (f", domain: {DOMAIN}", "9:1", 'the key "domain" is missing from target'),
        (", normal: [0, 0, 1]", "16:31", 'the key "normal" is missing from constraints.anchors.1.to.plane'),
        (f", to: {TO}", "15:7", 'the key "to" is missing from constraints.anchors.0'),
    ],
)
def test_missing_keys(refusal: Any, old: str, where: str, message: str) -> None:
    position, text = refusal(changed(old, ""))
    assert position == where
    assert message in text


def test_a_refusal_in_full(refusal: Any) -> None:
    _, text = refusal(changed("sector_angle: 60", "sector_angle: 95"))
    lines = text.split("\n")
    assert lines[1] == "    sector_angle: 95"
    assert lines[2] == "                  ^"
    assert lines[3] == "sector_angle: sector angle of the seed's facets, degrees between 0 and 90"
    _, text = refusal(changed("u_lines: FL", "u_lines: [FL, CFL, FL]"))
    assert text.endswith("    ^\nGive one word for all lines, or a list of 15 words.")
    _, text = refusal(changed("name: vault", "name: 12"))
    assert text.endswith("\nPut it in quotes.")


def test_the_first_fault_in_the_file_is_told_and_the_others_counted(refusal: Any) -> None:
    faulty = changed("[16, 24]", "[0, 24]").replace("every: 2", "every: 0").replace("units: m", "units: x")
    where, text = refusal(faulty.replace("name: vault\n", ""))
    assert where == "1:8"
    assert '"x" is no unit' in text
    assert "(and 3 more)" in text


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("pattern.sector_angle=95", "pattern.sector_angle is 95: it must be less than 90"),
        ("pattern.size=[16, 0]", "pattern.size.1 is 0: it must be at least 1"),
        ("constraints.anchors.0.every=0", "constraints.anchors.0.every is 0: it must be at least 1"),
        (
            "constraints.anchors.0.vertices=[1]",
            "an anchor needs exactly one of side, vertices; given side and",
        ),
        ("target.mesh=a.obj", f"target needs exactly one of {TARGETS}; given height and mesh"),
        (
            "solver.methd=ipopt",
            '"methd" is no key of solver: allowed are method, tolerance, max_iterations, ',
        ),
        ("pattern.u_lines=LF", f'"LF" {LINES} Did you mean FL?'),
        ("units='", "this is no valid YAML"),
    ],
)
def test_refusals_of_overrides(refusal: Any, override: str, message: str) -> None:
    where, text = refusal(TEXT, override)
    assert where == f"--set {override}"
    assert text.startswith(f"--set {override}: {message}")
