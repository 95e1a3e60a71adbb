"""What a case pays besides its solver, in milliseconds within one process that has solved such a task before.

    python -m benchmarks.verdicts                       prints the table and writes benchmarks/out/verdicts.json
    python -m benchmarks.verdicts --sizes 8 --repeats 3 smaller and faster

Rows are a dome at several sizes, a tube and a vault. Every repetition has another target, as in a sweep: the task is
formulated anew, and the design that was solved first is certified, measured and held against what is asked.

**formulate**: from a loaded specification to the terms of the program. **certify**: the certificate, the file's
document included. **brief**: what is asked, with the coverage. **fit**: distances of design and seed from the target.
**footprint**: both flat states. Medians; least in the JSON file.
"""

from __future__ import annotations

import argparse
import json
import platform
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import inverse
from inverse.brief.brief import Brief
from inverse.certify import check_frame
from inverse.files import fold_file
from inverse.formulation.formulate import formulate
from inverse.policy import measures

TARGETS = Path(__file__).parents[1] / "targets"
PARTS = ("formulate", "certify", "brief", "fit", "footprint")
STEP = 1e-3  # by how much more a target is changed from one repetition to the next

# A task from its number, 0 for the one that is solved.
Task = Callable[[int], Any]


def dome(size: int) -> Task:
    """A Miura sheet on a dome, its height changed."""

    def task(k: int) -> Any:
        target = {"height": f"{1 + k * STEP}*sqrt(1 - x^2 - y^2)", "domain": [[-0.6, 0.6], [-0.6, 0.6]]}
        return inverse.load({"name": "dome", "pattern": {"size": [size, size]}, "target": target})

    return task


def tube(size: tuple[int, int]) -> Task:
    """The tube among the targets at a size, its radius at the beginning changed."""
    return lambda k: inverse.load(
        TARGETS / "tube.yaml",
        [f"target.radius=[[0, {1 + k * STEP}], [1, 0.6]]", f"pattern.size=[{size[0]}, {size[1]}]"],
    )


def vault() -> Task:
    """The vault among the targets, its rise changed."""
    return lambda k: inverse.load(TARGETS / "vault.yaml", [f"target.rise={3 + k * STEP}"])


def measured(task: Task, repeats: int) -> dict[str, Any]:
    """Median and least milliseconds of every part."""
    solved = inverse.solve(task(0))
    times: dict[str, list[float]] = {part: [] for part in PARTS}

    def timed(part: str, call: Callable[[], Any]) -> Any:
        began = time.perf_counter()
        found = call()
        times[part].append(1000 * (time.perf_counter() - began))
        return found

    for k in range(1, repeats + 1):
        loaded = task(k)
        formulation = timed("formulate", lambda loaded=loaded: formulate(loaded))
        goal = formulation.goal
        design = solved.design.moved_to(solved.design.vertices_coords - goal.origin)
        certificate = timed("certify", lambda design=design: check_frame(fold_file.frame(design)))
        variables = goal.start(design.vertices_coords)
        footprint = timed("footprint", lambda goal=goal, x=variables: measures.footprint(goal, x))
        brief = Brief(loaded, formulation, design, certificate, footprint["limits"])
        timed("brief", lambda brief=brief: (brief.asked, brief.coverage))
        timed("fit", lambda goal=goal, design=design: measures.fit(goal, design))
    return {
        "certified": solved.certified,
        "median_ms": {part: float(np.median(some)) for part, some in times.items()},
        "least_ms": {part: min(some) for part, some in times.items()},
    }


def main() -> None:
    """Print the table and write the JSON file."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--sizes", type=int, nargs="*", default=[8, 16, 32], help="of the dome")
    parser.add_argument("--only-domes", action="store_true", help="leave tubes and vault out")
    parser.add_argument("--repeats", type=int, default=9)
    parser.add_argument("--out", type=Path, default=Path("benchmarks/out/verdicts.json"))
    given = parser.parse_args()
    tasks = {f"dome {size} x {size}": dome(size) for size in given.sizes}
    if not given.only_domes:
        tasks |= {"tube 6 x 10": tube((6, 10)), "tube 8 x 12": tube((8, 12)), "vault 16 x 24": vault()}
    rows = {}
    print(f"{'milliseconds':16}" + "".join(f"{part:>11}" for part in PARTS))
    for name, task in tasks.items():
        rows[name] = measured(task, given.repeats)
        told = "".join(f"{rows[name]['median_ms'][part]:11.1f}" for part in PARTS)
        print(f"{name:16}{told}" + ("" if rows[name]["certified"] else "  not certified"), flush=True)
    given.out.parent.mkdir(parents=True, exist_ok=True)
    machine = f"CPython {platform.python_version()}, {platform.machine()}"
    given.out.write_text(json.dumps({"machine": machine, "rows": rows}, indent=2) + "\n")


if __name__ == "__main__":
    main()
