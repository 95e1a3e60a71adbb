"""How often a solve succeeds: 200 generated problems of random families, sizes and smooth targets.

    python -m benchmarks.robustness                   prints the table, writes benchmarks/out/robustness.json
    python -m benchmarks.robustness --method nlopt    the same problems up to 10 x 10, with IPOPT disabled
    python -m benchmarks.robustness --first 20 --count 5   only some of them

Success is: certified, converged, and a fit whose rms is at most a tenth of the placed seed's. Every design is
written, read back and certified from its file; a result that claims to be certified and is refused there is counted
apart. Returning the seed is no success, since its fit is the seed's own.

A target is a random polynomial of degree 4 or less over a rectangle, its coefficients falling with the degree. Its
amplitude, half the height from its lowest to its highest point, is up to half of the shorter side. One in five is given
as a mesh. Hybrids have pairs of CFL lines at random places; a third of all grids has strips of unequal lengths.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import platform
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import inverse

COUNT = 200
SIZES = (6, 20)
SIZES_WITHOUT_IPOPT = (6, 10)
TENTH = 0.1
FAMILIES = ("Miura", "Miura", "eggbox", "eggbox across", "CFL Miura", "hybrid")


def hybrid_word(random: np.random.Generator, lines: int) -> list[str]:
    """FL with adjacent pairs of CFL at random places, such that a seed of that word does not double back."""
    while True:
        word = ["FL"]
        while len(word) < lines - 2:
            word += ["CFL", "CFL", "FL"] if random.random() < 0.35 else ["FL"]
        word = [*word, *["FL"] * (lines - len(word))]
        try:
            inverse.seeds.grid((2, lines + 1), "FL", word)
        except inverse.InputError:
            continue
        if "CFL" in word:
            return word


def problem(number: int, sizes: tuple[int, int]) -> tuple[str, dict[str, Any], tuple[Any, ...]]:
    """A name, a specification without its target, and that target: the same for the same number.

    Args:
        number: seed of the random numbers.
        sizes: least and largest number of facets along u and along v.

    Returns:
        The name; the specification; height expression, domain, and whether it is to be given as a mesh.
    """
    random = np.random.default_rng(number)
    family = FAMILIES[random.integers(len(FAMILIES))]
    m, n = (int(k) for k in random.integers(sizes[0], sizes[1] + 1, 2))
    words: dict[str, tuple[Any, Any]] = {
        "Miura": ("FL", "FL"),
        "CFL Miura": ("CFL", "CFL"),
        "eggbox": ("CFL", "FL"),
        "eggbox across": ("FL", "CFL"),
        "hybrid": ("FL", hybrid_word(random, n - 1)),
    }
    u_lines, v_lines = words[family]
    side = 10 ** random.uniform(-2, 3) * np.array([1.0, (n / m) * random.uniform(0.7, 1.4)])
    powers = [(i, j) for i in range(5) for j in range(5) if 1 <= i + j <= 4]
    weights = random.normal(size=len(powers)) / np.array([(i + j) ** 1.5 for i, j in powers])
    a, b = np.meshgrid(np.linspace(-1, 1, 41), np.linspace(-1, 1, 41), indexing="ij")
    heights = sum(w * a**i * b**j for w, (i, j) in zip(weights, powers, strict=True))
    amplitude = random.uniform(0.05, 0.5) * side.min()
    weights *= 2 * amplitude / np.ptp(heights)
    # In plan coordinates, so that the expression is what a user would write.
    half = side / 2
    terms = [f"({w / half[0] ** i / half[1] ** j:.17g})*x^{i}*y^{j}" for w, (i, j) in zip(weights, powers, strict=True)]
    domain = [[-float(h), float(h)] for h in half]
    specification: dict[str, Any] = {
        "name": f"{number} {family} {m} x {n}",
        "pattern": {
            "size": [m, n],
            "u_lines": u_lines,
            "v_lines": v_lines,
            "sector_angle": float(random.uniform(50, 75)),
            "fold_state": float(random.uniform(0.3, 0.7)),
            "turn": int(random.choice([0, 90])),
        },
    }
    if random.random() < 1 / 3:
        for key, count in (("lengths_u", m), ("lengths_v", n)):
            specification["pattern"][key] = random.uniform(0.7, 1.4, count).tolist()
    return str(specification["name"]), specification, (" + ".join(terms), domain, amplitude, random.random() < 0.2)


def mesh_of(expression: str, domain: list[list[float]], path: Path) -> None:
    """Write a height as an OBJ of 40 x 40 quads."""
    from inverse.surfaces.parametric import HeightTarget

    target = HeightTarget(expression, domain)
    x, y = (np.linspace(lo, hi, 41) for lo, hi in domain)
    points = target.point(np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2))
    first = (np.arange(40)[:, None] * 41 + np.arange(40)).ravel() + 1
    quads = np.stack([first, first + 41, first + 42, first + 1], axis=1)
    lines = [f"v {p[0]!r} {p[1]!r} {p[2]!r}" for p in points.tolist()]
    path.write_text("\n".join(lines + ["f {} {} {} {}".format(*q) for q in quads.tolist()]) + "\n")


def measure(task: tuple[int, tuple[int, int], str]) -> dict[str, Any]:
    """Solve one problem, write it, read it back, certify it."""
    number, sizes, method = task
    name, specification, (expression, domain, amplitude, is_mesh) = problem(number, sizes)
    specification["solver"] = {"method": method}
    row: dict[str, Any] = {"number": number, "name": name, "mesh": is_mesh}
    row["amplitude"] = amplitude / min(hi - lo for lo, hi in domain)
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        if is_mesh:
            mesh_of(expression, domain, Path(folder) / "target.obj")
            specification["target"] = {"mesh": "target.obj"}
        else:
            specification["target"] = {"height": expression, "domain": domain}
        try:
            result = inverse.solve(inverse.load(specification, folder=folder))
        except inverse.InputError as error:  # a generated problem is no wrong input: the table shows it
            return row | {"error": str(error), "success": False, "seconds": time.perf_counter() - began}
        row["seconds"] = time.perf_counter() - began
        path = Path(folder) / "design.fold"
        inverse.write(result.design, path)
        checked = inverse.check(path).certified
    fit = result.report["fit"]
    return row | {
        "certified": result.certified,
        "refused": result.certified and not checked,
        "converged": result.converged,
        "fit": fit["rms_relative"],
        "gain": fit["rms"] / fit["start_rms"],
        "success": bool(result.certified and checked and result.converged and fit["rms"] <= TENTH * fit["start_rms"]),
        "iterations": result.report["iterations"],
        "attempts": [f"{a['method']}: {a['ended']}" for a in result.report["attempts"]],
        "status": result.status,
    }


def main() -> int:
    """Print a line for every problem, then the totals."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--method", default="ipopt", choices=["ipopt", "nlopt"])
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--jobs", type=int, default=1, help="problems solved at once; seconds are fair with 1")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    sizes = SIZES if given.method == "ipopt" else SIZES_WITHOUT_IPOPT
    tasks = [(k, sizes, given.method) for k in range(given.first, given.first + given.count)]
    rows = []
    print(f"{'problem':<30} {'ampl':>5} {'cert':>4} {'conv':>4} {'fit rms':>9} {'of seed':>8} {'iter':>5} {'s':>6}")
    with multiprocessing.get_context("spawn").Pool(given.jobs, maxtasksperchild=20) as pool:
        for row in pool.imap(measure, tasks):
            rows.append(row)
            if "error" in row:
                print(f"{row['name']:<30} refused: {row['error']}", flush=True)
                continue
            print(
                f"{row['name'] + (' mesh' if row['mesh'] else ''):<30} {row['amplitude']:>5.2f} "
                f"{'yes' if row['certified'] else 'NO':>4} {'yes' if row['converged'] else 'NO':>4} "
                f"{row['fit']:>9.4%} {row['gain']:>8.2%} {row['iterations']:>5} {row['seconds']:>6.1f}"
                f"{'' if row['success'] else '  ' + row['status']}",
                flush=True,
            )
    seconds = np.array([row["seconds"] for row in rows])
    succeeded = sum(row["success"] for row in rows)
    refused = sum(row.get("refused", False) for row in rows)
    print(
        f"\n{succeeded} of {len(rows)} succeed ({succeeded / len(rows):.1%}); {refused} claims refused; "
        f"seconds: median {np.median(seconds):.1f}, 95th percentile {np.percentile(seconds, 95):.1f}, "
        f"largest {seconds.max():.1f}"
    )
    document = {"machine": platform.platform(), "python": platform.python_version(), "rows": rows}
    name = "robustness.json" if given.method == "ipopt" else "robustness_nlopt.json"
    out = given.out or Path(__file__).parent / "out" / name
    out.parent.mkdir(exist_ok=True)
    out.write_text(json.dumps(document, indent=1))
    return 0 if refused == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
