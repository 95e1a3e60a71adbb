"""Time and memory of everyday commands as whole processes, and where the time goes.

    python -m benchmarks.commands                       five runs of each, about two minutes
    python -m benchmarks.commands --runs 1 --only check fold

Seconds are medians, from the start of Python to the end of the process. ``cpu`` is that of all its processes, ``MiB``
the peak of the largest one of them. What a command waits for: ``load`` is Python's importing of libraries, whenever
they are needed, in one more run that measures it; the other phases are those of ``report.json``, and the rest is
reading, writing and starting. Pictures are rendered by another process, which gets ready while this one solves:
``pictures`` is the time until they are there, after that.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
SIZE = 16  # facets along both sides of the design that is checked, folded and drawn
# Seconds and MiB that a command may take.
LIMITS = {"tube": (2.0, 450), "vault": (4.5, 600), "check": (0.5, None), "fold": (1.0, None)}
PHASES = ("formulate", "build", "solve", "certify", "brief", "pictures")


def commands(design: Path, out: Path, facets: int) -> dict[str, list[str]]:
    """The arguments of `inverse` by the names of what is measured."""
    small = [] if facets == SIZE else ["--set", f"pattern.size=[{facets}, {facets}]"]
    tube, vault = (str(ROOT / "targets" / f"{name}.yaml") for name in ("tube", "vault"))
    return {
        "tube": ["solve", tube, "-o", str(out / "tube")],
        "tube-bare": ["solve", tube, "-o", str(out / "tube"), "--pictures", "none"],
        "vault": ["solve", vault, "-o", str(out / "vault"), *small],
        "vault-bare": ["solve", vault, "-o", str(out / "vault"), "--pictures", "none", *small],
        "check": ["check", str(design)],
        "fold": ["fold", str(design), "--to", "html", "-o", str(out / "motion.html")],
        "film": ["fold", str(design), "--to", "mp4", "--frames", "25", "-o", str(out / "motion.mp4")],
        "draw": ["draw", str(design), "-o", str(out / "drawings")],
    }


def measured(arguments: list[str], environment: dict[str, str]) -> tuple[float, float, float]:
    """Seconds, seconds of all processors, and MiB of the largest process of one run."""
    began = time.perf_counter()
    command = [sys.executable, "-m", "inverse", *arguments]
    process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    assert process.stderr is not None
    said = process.stderr.read().decode()
    _, status, used = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - began
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, 1):  # 1 is a verdict, as of a vault that was made smaller
        raise SystemExit(f"inverse {' '.join(arguments)} ended with code {process.returncode}:\n{said}")
    unit = 1 if sys.platform == "darwin" else 1024
    return seconds, used.ru_utime + used.ru_stime, used.ru_maxrss * unit / 2**20


def loading(arguments: list[str], environment: dict[str, str]) -> float:
    """Seconds that importing takes, the other processes' left out."""
    command = [sys.executable, "-X", "importtime", "-m", "inverse", *arguments]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    own = re.findall(r"^import time: +(\d+) \|", done.stderr, re.MULTILINE)
    return sum(map(int, own)) / 1e6


def row(name: str, arguments: list[str], runs: int, environment: dict[str, str]) -> dict[str, Any]:
    """The medians of a command, and its phases."""
    measured(arguments, environment)  # once unmeasured, so that all files are at hand
    seconds, cpu, peak = (statistics.median(values) for values in zip(
        *(measured(arguments, environment) for _ in range(runs)), strict=True
    ))  # fmt: skip
    told: dict[str, float] = {}
    if arguments[0] == "solve":
        told = json.loads((Path(arguments[3]) / "report.json").read_text())["seconds"]
    phases = {phase: told[phase] for phase in PHASES if phase in told}
    return {
        "command": name, "seconds": seconds, "cpu": cpu, "MiB": peak, "load": loading(arguments, environment),
        "phases": phases,
    }  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--facets", type=int, default=SIZE, help="along both sides of designs, for a quick trial")
    parser.add_argument("--only", nargs="+", default=None, help="some of the commands, by their names in the table")
    parser.add_argument("--out", type=Path, default=None, help="JSON file of the rows")
    options = parser.parse_args()

    import inverse

    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    print(f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    print(f"{'command':12}{'seconds':>8}{'cpu':>7}{'MiB':>6}{'load':>7}" + "".join(f"{one:>10}" for one in PHASES))
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        design = Path(folder) / "design.fold"
        inverse.write(inverse.seeds.grid((options.facets, options.facets), "CFL", "FL"), design)
        for name, arguments in commands(design, Path(folder), options.facets).items():
            if options.only is not None and name not in options.only:
                continue
            one = row(name, arguments, options.runs, environment)
            rows.append(one)
            phases = "".join(f"{one['phases'][k]:10.2f}" if k in one["phases"] else f"{'':10}" for k in PHASES)
            limits = [] if name not in LIMITS else [f"{LIMITS[name][0]:g} s", f"{LIMITS[name][1]} MiB"]
            told = ", ".join(limit for limit in limits if "None" not in limit)
            print(
                f"{name:12}{one['seconds']:8.2f}{one['cpu']:7.2f}{one['MiB']:6.0f}{one['load']:7.2f}{phases}"
                + (f"  (at most {told})" if told else ""),
                flush=True,
            )
    if options.out is not None:
        options.out.write_text(json.dumps({"rows": rows, "limits": LIMITS}, indent=1) + "\n")


if __name__ == "__main__":
    main()
