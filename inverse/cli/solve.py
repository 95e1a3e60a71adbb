"""`inverse solve`: what is asked, what is told on the way and at the end."""

from __future__ import annotations

import math
import sys
import threading
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from inverse import interrupts
from inverse.cli.output import DONE, INTERRUPTED, NOT_DONE, made_before, motion, told, write_all
from inverse.cli.terminal import ProgressLine
from inverse.files.atomic import json_text

if TYPE_CHECKING:
    from inverse.results.result import Result
    from inverse.solvers.run import Progress
    from inverse.spec import Loaded


KEEPING = (
    "interrupted: the best design so far is brought within the constraints and written; "
    "interrupt once more to end without it"
)


def solve(
    specification: Path,
    /,
    *,
    out: Annotated[Path | None, Parameter(name=["--out", "-o"])] = None,
    overrides: Annotated[tuple[str, ...], Parameter(name="--set", negative=())] = (),
    start: Path | None = None,
    extensions: Annotated[tuple[Path, ...], Parameter(name="--with", negative=())] = (),
    pictures: Literal["none", "svg", "all"] | None = None,
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
        pictures: none, svg (crease patterns only) or all (the 3D views too), in place of what the specification says.
        show: seed draws the placed seed with its sides, the numbers of its vertices, anchors and keep-outs, seed.svg
            and seed.png in the output folder, and solves nothing.
        as_json: print the result as JSON.
    """
    stop = threading.Event()
    with interrupts.held(stop):
        from inverse import solve as run
        from inverse import spec
        from inverse.extending.loading import load_file
        from inverse.pictures.rendering import Renderer
        from inverse.results.folder import Results, check_same_design, files, output_folder

        for file in extensions:
            load_file(file)
        loaded = spec.load(specification, overrides)
        folder = output_folder(loaded.specification.name, out)
    if stop.is_set():
        return interrupts.told()
    if show is not None:
        return _show(loaded, folder, as_json=as_json)
    check_same_design(folder, loaded.specification.name)
    outdated = made_before(folder)
    with ExitStack() as folders:
        results = folders.enter_context(Results(folder))
        wanted = pictures or loaded.specification.pictures
        renderer = folders.enter_context(Renderer()) if wanted == "all" else None  # gets ready meanwhile
        from inverse.results import saving

        with interrupts.announced(KEEPING), _Watch() as watch:
            watch.phase(f"preparing {loaded.specification.name}")
            result = run(loaded, start=start, watch=watch)
        if saving.keeps_earlier(result, folder):
            outdated = None
            earlier, folder = folder, folder.absolute().with_name(f"{folder.absolute().name}.interrupted")
            print(f"{earlier} keeps its certified design; that of this run goes to {folder}", file=sys.stderr)
            results = folders.enter_context(Results(folder))
        with interrupts.announced("interrupted: the results are written without pictures"), ProgressLine() as line:
            written = saving.write(result, results, pictures=wanted, renderer=renderer, phase=line.phase)
    for note in (*written.notes, *([] if outdated is None else [outdated])):
        print(note, file=sys.stderr)
    if as_json:
        print(json_text(_summary(result, folder)))
    else:
        print("\n- ".join(_ending(result)), file=sys.stderr)
        for sentence in _told(result):
            print(sentence)
        for written_line in told(files(folder)):
            print(written_line)
    if result.interrupted or written.interrupted:
        return INTERRUPTED
    return DONE if result.solved else NOT_DONE


def _show(loaded: Loaded, folder: Path, *, as_json: bool) -> int:
    """Draw the placed seed and tell its sides."""
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


def _told(result: Result) -> list[str]:
    """The verdicts, and the figures that a person looks for first."""
    fit, covered = result.fit, result.coverage
    spent = sum(result.seconds[part] for part in ("start", "build", "solve"))
    whole = _whole_grid(result)
    trimmed = f"trimmed   to the target's outline: {result.size.facets} of {whole} facets"
    return [
        *result.verdicts,
        *([] if whole is None else [trimmed]),
        f"fit       rms {fit.rms_relative:.4%}, max {fit.max_relative:.4%} of the diagonal "
        f"(placed seed: rms {fit.start_rms_relative:.2%})",
        f"coverage  {covered.covered:.1%} of the target, {covered.seen}; {covered.beyond_share:.1%} of the mesh lies "
        "beyond",
        f"solving   {spent:.1f} s, {result.iterations} iterations",
        *(f"motion    {sentence}" for sentence in motion(result.certificate)),
    ]


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


class _Watch(ProgressLine):
    """Shows the iterations on stderr."""

    def __call__(self, phase: str, progress: Progress) -> None:
        self.show(
            f"{phase}, iteration {progress.iteration}: objective {progress.objective:.3e}, "
            f"largest violation {progress.violation:.1e}"
        )
