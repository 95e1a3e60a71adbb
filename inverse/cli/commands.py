"""The command line. Human words go to stderr, results to stdout; the exit code says how it went."""

from __future__ import annotations

import math
import sys
import threading
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import App, CycloptsError, Parameter, UnusedCliTokensError

from inverse import interrupts
from inverse.cli.draw import draw
from inverse.cli.export import export
from inverse.cli.fold import fold
from inverse.cli.output import made_before, told
from inverse.cli.terminal import ProgressLine
from inverse.errors import InputError
from inverse.files.atomic import json_text

if TYPE_CHECKING:
    from inverse.certify import Certificate
    from inverse.repair.repairing import Repair
    from inverse.results.result import Result
    from inverse.solvers.run import Progress
    from inverse.spec import Loaded

DONE, NOT_DONE, WRONG_INPUT, INTERRUPTED = 0, 1, 2, interrupts.EXIT_CODE
KEEPING = (
    "interrupted: the best design so far is brought within the constraints and written; "
    "interrupt once more to end without it"
)

app = App(
    name="inverse",
    default_parameter=Parameter(negative=(), show_default=False),
    help="Design rigid-foldable structures backwards: from a target surface to a certified pattern.",
    help_epilogue="Exit codes: 0 foldable, optimal and as asked, 1 ran but not all, 2 wrong input, 3 interrupted.",
    version_flags=["--version"],
    result_action="return_value",
    suppress_keyboard_interrupt=False,
)


@app.command
def solve(
    specification: Path,
    /,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    overrides: Annotated[tuple[str, ...], Parameter(name="--set", negative=())] = (),
    start: Path | None = None,
    extensions: Annotated[tuple[Path, ...], Parameter(name="--with", negative=())] = (),
    show: Literal["seed"] | None = None,
    as_json: Annotated[bool, Parameter(name="--json", negative=())] = False,
) -> int:
    """Design a mesh for a target surface and certify it.

    Args:
        specification: YAML file; `inverse schema` describes it.
        out: folder for the results; by default out/NAME, after the name in the specification.
        overrides: changes a value of the specification, as 'key.path=value'; may be repeated.
        start: output folder or FOLD file of a design of the same pattern, to go on from instead of the seed.
        extensions: Python file that is RUN first, with all your rights, and registers objectives, constraints,
            measures, targets or patterns of your own; may be repeated.
        show: seed draws the placed seed with its sides, the numbers of its vertices, anchors and keep-outs, seed.svg
            and seed.png in the output folder, and solves nothing.
        as_json: print the result as JSON.
    """
    stop = threading.Event()
    with interrupts.held(stop):
        from inverse import solve as run
        from inverse import spec
        from inverse.extending.loading import load_file
        from inverse.results import saving
        from inverse.results.folder import Results, check_same_design

        for file in extensions:
            load_file(file)
        loaded = spec.load(specification, overrides)
        folder = saving.output_folder(loaded.specification.name, out)
    if stop.is_set():
        return interrupts.told()
    if show is not None:
        return _show(loaded, folder, as_json=as_json)
    check_same_design(folder, loaded.specification.name)
    outdated = made_before(folder)
    with ExitStack() as folders:
        results = folders.enter_context(Results(folder))
        with interrupts.announced(KEEPING), _Watch() as watch:
            watch.phase(f"preparing {loaded.specification.name}")
            result = run(loaded, start=start, watch=watch)
        if saving.keeps_earlier(result, folder):
            outdated = None
            earlier, folder = folder, folder.absolute().with_name(f"{folder.absolute().name}.interrupted")
            print(f"{earlier} keeps its certified design; that of this run goes to {folder}", file=sys.stderr)
            results = folders.enter_context(Results(folder))
        with interrupts.announced("interrupted: the results are written without pictures"), ProgressLine() as line:
            written = saving.write(result, results, phase=line.phase)
    for note in (*written.notes, *([] if outdated is None else [outdated])):
        print(note, file=sys.stderr)
    if as_json:
        print(json_text(_summary(result, folder)))
    else:
        print("\n- ".join(_ending(result)), file=sys.stderr)
        for sentence in result.verdicts:
            print(sentence)
        if (whole := _whole_grid(result)) is not None:
            print(f"trimmed   to the target's outline: {result.size.facets} of {whole} facets")
        fit = result.fit
        print(f"fit       rms {fit.rms_relative:.4%}, max {fit.max_relative:.4%} of the diagonal "
              f"(placed seed: rms {fit.start_rms_relative:.2%})")  # fmt: skip
        covered = result.coverage
        print(
            f"coverage  {covered.covered:.1%} of the target, {covered.seen}; {covered.beyond_share:.1%} of the mesh "
            "lies beyond"
        )
        spent = sum(result.seconds[part] for part in ("start", "build", "solve"))
        print(f"solving   {spent:.1f} s, {result.iterations} iterations")
        for sentence in _motion(result.certificate):
            print(f"motion    {sentence}")
        for written_line in told(saving.files(folder)):
            print(written_line)
    if result.interrupted or written.interrupted:
        return INTERRUPTED
    return DONE if result.solved else NOT_DONE


@app.command
def check(design: Path, /, *, as_json: Annotated[bool, Parameter(name="--json", negative=())] = False) -> int:
    """Certify a design file independently, trusting no claim in it.

    Args:
        design: FOLD file.
        as_json: print the certificate as JSON.
    """
    from inverse.certify import check as certify
    from inverse.results.folder import settle

    settle(design.parent)
    with ProgressLine() as line:
        line.phase(f"certifying {design}")
        certificate = certify(design, lambda done, of: line.share("certifying, states of the motion", done, of))
    if as_json:
        print(json_text(certificate.document()))
    else:
        for one in certificate.checks.values():
            print(one.sentence)
        for sentence in (*_motion(certificate), *(loop.sentence for loop in certificate.loops)):
            print(sentence)
        print(certificate.sentence)
    return DONE if certificate.certified else NOT_DONE


@app.command
def repair(
    pattern: Path,
    /,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    u_lines: str | None = None,
    v_lines: str | None = None,
    far: Annotated[bool, Parameter(negative=())] = False,
    as_json: Annotated[bool, Parameter(name="--json", negative=())] = False,
) -> int:
    """Snap somebody's pattern to the exact set and say how far it moved.

    Args:
        pattern: FOLD or OBJ file of a semi-folded state, or of a flat crease pattern, which is folded first.
        out: folder for the results; by default out/NAME, after the name of the file.
        u_lines: for a grid, FL or CFL for all interior lines crossed by walking along u, or a word for each,
            separated by commas. Types are read from the file or deduced if neither is given.
        v_lines: the same along v.
        far: take a pattern although it is more than 0.1 rad off somewhere.
        as_json: print the result as JSON.
    """
    from inverse import repair as run
    from inverse.results import saving
    from inverse.results.folder import Results, check_same_design

    folder = saving.output_folder(pattern.stem, out)
    with Results(folder) as results, ProgressLine() as line:
        line.phase(f"repairing {pattern}")
        result = run(pattern, u_lines=u_lines, v_lines=v_lines, far=far)
        check_same_design(folder, result.design.name)
        written = saving.write(result, results, phase=line.phase)
    for note in written.notes:
        print(note, file=sys.stderr)
    if as_json:
        print(json_text(_repair_summary(result, folder)))
    else:
        done = result.certified and result.converged
        print(result.status if done else f"NOT REPAIRED: {result.status}", file=sys.stderr)
        for sentence in _repair_lines(result):
            print(sentence)
        for written_line in told(saving.files(folder)):
            print(written_line)
    if written.interrupted:
        return INTERRUPTED
    return DONE if result.certified and result.converged else NOT_DONE


app.command(fold)
app.command(export)
app.command(draw)


@app.command
def schema(file: Literal["spec", "report", "certificate"] = "spec", /) -> int:
    """Print a JSON schema, of specifications if nothing else is asked for.

    Args:
        file: spec, report (report.json) or certificate (certificate.json).
    """
    if file == "spec":
        from inverse.spec import Specification

        print(json_text(Specification.model_json_schema()))
    else:
        from inverse.results import schema as schemas

        print(json_text(schemas.report() if file == "report" else schemas.certificate()))
    return 0


def run(arguments: list[str]) -> int:
    """Run the command line; wrong input becomes a message and a code, never a traceback."""
    try:
        with interrupts.raised():
            result = app(arguments, exit_on_error=False, print_error=False)
    except UnusedCliTokensError as error:
        words = " ".join(error.unused_tokens or ())
        command = " ".join(["inverse", *(error.command_chain or ()), "--help"])
        print(f"error: no argument or option takes {words}", file=sys.stderr)
        print(f"What may be repeated is named anew for each value; `{command}` lists what there is.", file=sys.stderr)
        return WRONG_INPUT
    except CycloptsError as error:
        print(f"error: {error}", file=sys.stderr)
        return WRONG_INPUT
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return WRONG_INPUT
    except KeyboardInterrupt:
        return interrupts.told()
    return result if isinstance(result, int) else 0


def _show(loaded: Loaded, folder: Path, *, as_json: bool) -> int:
    """Draw the placed seed and tell its sides."""
    from inverse.cli.output import write_all
    from inverse.showing import shown

    seed = shown(loaded)
    paths = [folder / "seed.svg", folder / "seed.png"]
    write_all(dict(zip(paths, (seed.drawing.svg(), seed.drawing.png()), strict=True)))
    for note in seed.notes:
        print(note, file=sys.stderr)
    if as_json:
        print(json_text({"files": [str(path) for path in paths], "seed": seed.table, "notes": list(seed.notes)}))
    else:
        for line in [*seed.table, *(f"wrote {path}" for path in paths)]:
            print(line)
    return 0


def _whole_grid(result: Result) -> int | None:
    """Facets of the grid that a design was trimmed from, if it was."""
    pattern = result.specification["pattern"]
    whole = math.prod(pattern["size"]) if pattern["kind"] == "grid" else 0
    return whole if whole > result.size.facets else None


def _ending(result: Result) -> list[str]:
    """How a solve ended, and what of the brief is missed if that is all."""
    if result.ending != "not_as_asked":
        return [result.status if result.solved else f"NOT DONE: {result.status}"]
    missed = [one.told for one in result.asked if not one.met]
    return ["NOT DONE: certified and converged, but not as asked:", *missed]


def _summary(result: Result, folder: Path) -> dict[str, object]:
    return {
        "ending": result.ending,
        "status": result.status,
        "certified": result.certified,
        "converged": result.converged,
        "as_asked": result.as_asked,
        "asked": [asdict(one) for one in result.asked],
        "out": str(folder),
        "fit": result.fit.document(),
        "coverage": asdict(result.coverage),
    }


def _motion(certificate: Certificate) -> list[str]:
    """How far a design folds before facets cross, and which ones do then."""
    if certificate.free_range is None:
        return []
    low, high = certificate.free_range
    found = [f"free of crossings from t = {low:g} to {high:g} degrees (0 developed, 90 the design, 180 flat-folded)"]
    return found + [crossing.sentence for crossing in certificate.crossings]


def _repair_lines(result: Repair) -> list[str]:
    found = result.report
    before, after, moved, types = (found[key] for key in ("before", "after", "moved", "line_types"))
    unit = "" if result.design.unit == "unit" else f" {result.design.unit}"
    lines = [f"{key:9} c_dev {errors['developability']:.2g} rad, c_ff {errors['flat_foldability']:.2g} rad, "
             f"planarity {errors['planarity']:.2g} mean edges"
             for key, errors in (("before", before), ("after", after))]  # fmt: skip
    if found["state"] == "crease pattern":
        low, high = found["folded_to"].values()
        lines.append(f"folded    from {low:.0f} to {high:.0f} degrees, mountains and valleys "
                     f"{found['mountains_and_valleys']}")  # fmt: skip
    lines.append(f"moved     {moved['max']:.3g}{unit} at most, {moved['max_relative']:.2g} of the diagonal, at vertex "
                 f"{moved['worst_vertex']}; rms {moved['rms']:.3g}{unit}")  # fmt: skip
    numbers = [line["type"] for line in types["lines"]]
    lines.append(f"lines     {numbers.count('FL')} FL, {numbers.count('CFL')} CFL: {types['found']}")
    return lines


def _repair_summary(result: Repair, folder: Path) -> dict[str, object]:
    found = result.report
    return {
        "status": result.status,
        "certified": result.certified,
        "converged": result.converged,
        "out": str(folder),
        "before": found["before"],
        "after": found["after"],
        "moved": {key: value for key, value in found["moved"].items() if key != "vertices"},
        "line_types": found["line_types"],
    }


class _Watch(ProgressLine):
    """Shows the iterations on stderr."""

    def __call__(self, phase: str, progress: Progress) -> None:
        self.show(
            f"{phase}, iteration {progress.iteration}: objective {progress.objective:.3e}, "
            f"largest violation {progress.violation:.1e}"
        )
