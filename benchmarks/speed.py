"""Time and memory from a file to a certificate: a Miura sheet on a dome, 16 x 16 to 128 x 128, beside references.

    python -m benchmarks.speed                      prints the table and writes benchmarks/out/speed.json
    python -m benchmarks.speed --sizes 8 16         smaller and faster
    python -m benchmarks.speed --without-references

Every size runs in a process of its own, so that its peak memory is its own; all in one sitting. What a figure means
stands in docs/speed.md.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

DOME = "sqrt(1 - x^2 - y^2)"
SPECIFICATION = """name: dome
pattern: {{size: [{n}, {n}]}}
target: {{height: "{height}", domain: [[-0.6, 0.6], [-0.6, 0.6]]}}
"""
# The dome moved by one hundredth of the span of 1.2: sideways, up at the crown, and by a bump.
MOVED = {
    "sideways": "sqrt(1 - (x - 0.012)^2 - y^2)",
    "taller": "1.012*sqrt(1 - x^2 - y^2)",
    "bump": "sqrt(1 - x^2 - y^2) + 0.012*cos(2.5*x)*cos(2.5*y)",
}
LIMITS = {16: 3.0, 32: 8.0, 64: 45.0, 128: 360.0}  # seconds in all
DEFAULT_IPOPT_UP_TO, PAPER_UP_TO, MOVED_UP_TO = 32, 16, 64


def one(n: int, references: bool) -> dict[str, Any]:
    """The row of one size; to be called in a process that has imported nothing yet."""
    began = time.perf_counter()
    import inverse

    imported = time.perf_counter() - began
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "dome.yaml"
        path.write_text(SPECIFICATION.format(n=n, height=DOME))
        began = time.perf_counter()
        result = inverse.solve(inverse.load(path))
        inverse.write(result.design, Path(folder) / "dome.fold")
        total = time.perf_counter() - began
    report = result.report
    attempts, seconds = report["attempts"], report["seconds"]
    functions = sum(a["seconds_functions"] for a in attempts)
    row = {
        "problem": "Miura on a dome",
        "facets": n * n,
        "certified": result.certified,
        "converged": result.converged,
        "rms": report["fit"]["rms_relative"],
        "coverage": report["coverage"]["covered"],
        "import_s": imported,
        "build_s": seconds["build"],
        "functions_s": functions,
        "linear_algebra_s": sum(a["seconds"] for a in attempts) - functions,
        "iterations": sum(a["iterations"] for a in attempts if a["facets"] == n * n),
        "iterations_coarse": sum(a["iterations"] for a in attempts if a["facets"] < n * n),
        "start_s": seconds["start"],
        "solve_s": seconds["solve"],
        "polish_s": seconds["polish"],
        "certify_s": seconds["certify"],
        "total_s": total,
        "peak_bytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024),
    }
    if references:
        row["references"] = compared(row, result, attempts, n)
    return row


def compared(row: dict[str, Any], result: Any, attempts: list[dict[str, Any]], n: int) -> dict[str, Any]:
    """The references, and how many times slower they are (for moved targets: the fraction of the cold time)."""
    import inverse
    from benchmarks import references
    from inverse.formulation.formulate import formulate

    def task(size: int, height: str) -> Any:
        target = {"height": height, "domain": [[-0.6, 0.6], [-0.6, 0.6]]}
        return inverse.load({"name": "dome", "pattern": {"size": [size, size]}, "target": target})

    found: dict[str, Any] = {}
    solving = row["start_s"] + row["build_s"] + row["solve_s"]
    if n <= DEFAULT_IPOPT_UP_TO:
        found["default_ipopt"] = references.default_ipopt(formulate(task(n, DOME)))
        found["default_ipopt"]["ratio"] = found["default_ipopt"]["seconds"] / solving
    if n <= PAPER_UP_TO:
        found["paper"] = references.paper(formulate(task(n, DOME)), 5e-4)
        found["paper"]["ratio"] = found["paper"]["seconds"] / solving
    by_size = {facets: references.floor(formulate(task(round(facets**0.5), DOME))) for facets in
               {a["facets"] for a in attempts}}  # fmt: skip
    for library in [key for key in by_size[n * n] if key.startswith("seconds")]:
        least = sum(by_size[a["facets"]][library] * a["iterations"] for a in attempts)
        name = library.removeprefix("seconds").removeprefix("_") or "fastest"
        found[f"floor_{name}"] = {"seconds": least, "ratio": row["total_s"] / least, "solving_ratio": solving / least}
    found["floor_library"] = by_size[n * n]["library"]
    for name, height in MOVED.items() if n <= MOVED_UP_TO else ():
        began = time.perf_counter()
        again = inverse.solve(task(n, height), start=result)
        spent, report = time.perf_counter() - began, again.report
        found[f"moved_{name}"] = {
            "seconds": spent,
            "fraction": spent / row["total_s"],
            "solving_fraction": (report["seconds"]["build"] + report["seconds"]["solve"]) / solving,
            "iterations": report["iterations"],
            "certified": again.certified and again.converged,
        }
    return found


def show(row: dict[str, Any]) -> None:
    """A line of the table, and one for every reference."""
    limit = LIMITS.get(round(row["facets"] ** 0.5))
    sound = row["certified"] and row["converged"]
    verdict = "" if limit is None else f"  (limit {limit:g} s: {'met' if row['total_s'] <= limit else 'MISSED'})"
    print(
        f"{row['facets']:>6} {'yes' if sound else 'NO':>5} {row['rms']:>8.4%} {row['coverage']:>6.1%} "
        f"{row['import_s']:>7.3f} {row['build_s']:>6.2f} {row['functions_s']:>6.2f} {row['linear_algebra_s']:>8.2f} "
        f"{row['iterations_coarse']:>6} {row['iterations']:>5} {row['certify_s']:>8.2f} {row['total_s']:>8.2f} "
        f"{row['peak_bytes'] / 2**30:>6.2f}{verdict}",
        flush=True,
    )
    for name, reference in row.get("references", {}).items():
        if isinstance(reference, dict):
            shown = ", ".join(f"{k} {v:.3g}" if isinstance(v, float) else f"{k} {v}" for k, v in reference.items())
            print(f"       {name}: {shown}", flush=True)
        else:
            print(f"       {name}: {reference}", flush=True)


def main() -> int:
    """Print the table and write it."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[16, 32, 64, 128])
    parser.add_argument("--without-references", action="store_true")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "out" / "speed.json")
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one:
        print(json.dumps(one(given.one, not given.without_references)))
        return 0
    print("facets sound      rms  cover  import  build  funct  lin.alg coarse  iter  certify    total    GiB")
    rows = []
    for n in given.sizes:
        command = [sys.executable, "-m", "benchmarks.speed", "--one", str(n)]
        command += ["--without-references"] if given.without_references else []
        done = subprocess.run(command, check=True, capture_output=True, text=True, env=dict(os.environ))
        rows.append(json.loads(done.stdout.splitlines()[-1]))
        show(rows[-1])
    given.out.parent.mkdir(parents=True, exist_ok=True)
    machine = {"machine": platform.platform(), "python": platform.python_version(), "cpus": os.cpu_count()}
    given.out.write_text(json.dumps(machine | {"rows": rows}, indent=1))
    return 0 if all(row["certified"] and row["converged"] for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
