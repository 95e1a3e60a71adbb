"""What a case of a sweep costs beside a cold one, and what a move costs while somebody drags the target.

    python -m benchmarks.live                               prints the figures and writes benchmarks/out/live.json
    python -m benchmarks.live --cases 4 --moves 6 --path 4  smaller and faster

**sweep**: 16 x 16 facets on a dome; cases differ in the weights and in the height of the target. *cold*: a process of
its own, from the start of Python to the result with its certificate; *solving alone*: without starting Python and
loading libraries. *from the seed*, *from the neighbour*: a case in a process that has solved one, certificate, verdict
on the brief and all other figures included. Growth: resident memory per 500 cases.

**moves**: the target is moved by a hundredth of its span (at random: aside, higher, with a bump; a tube's axis by that
much, its radius by a hundredth of itself) and followed by a session: milliseconds to the light verdict, and from
there to the full result.

**path**: moves along a closed curve: how many are certified, and how far every tenth is from what a solve from the seed
gives, in diagonals, and by which share its objective is larger.
"""

from __future__ import annotations

import argparse
import json
import platform
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

SIZE = 16
ONE = """
import time
import json
import inverse
task = json.loads({task!r})
import inverse.results.making, casadi, igl
loaded = time.perf_counter()
result = inverse.solve(task)
assert result.solved, result.status
print(time.perf_counter() - loaded)
"""


def dome(size: int, higher: float = 0.0, aside: float = 0.0, bump: float = 0.0, **keys: Any) -> dict[str, Any]:
    """A Miura sheet on a dome of span 1.2; lengths by which it is higher, moved aside, and swollen in the middle."""
    cap = f"{1.01 + higher:.9f}*sqrt(1.02 - (x - {0.001 + aside:.9f})^2 - y^2)"
    height = f"{cap} + {0.001 + bump:.9f}*cos(2.5*x)*cos(2.5*y)"
    target = {"height": height, "domain": [[-0.6, 0.6], [-0.6, 0.6]]}
    return {"name": "dome", "pattern": {"size": [size, size]}, "target": target, **keys}


def tube(higher: float = 0.0, aside: float = 0.0, bump: float = 0.0) -> dict[str, Any]:
    """A tube of 8 x 12 facets along an arc of about 6; its radius changes by shares of itself where lengths move."""
    axis = {"arc": [[0, 0, 0], [0.5 + aside, 0, 3], [2, 0, 5.5 + higher]]}
    target = {"axis": axis, "radius": [[0, 1.0], [1, 0.8 * (1 + bump / 6)]]}
    return {"name": "tube", "pattern": {"kind": "tube", "size": [8, 12]}, "target": target}


def resident() -> float:
    """Resident memory now, in MiB; NaN where the system does not tell."""
    status = Path("/proc/self/status")
    if not status.exists():
        return float("nan")
    line = next(line for line in status.read_text().splitlines() if line.startswith("VmRSS"))
    return int(line.split()[1]) / 1024


def sweep(cases: int) -> dict[str, float]:
    """Seconds of a case."""
    import inverse

    rng = np.random.default_rng(0)

    def task(k: int) -> dict[str, Any]:
        weights = {"fairness": 5e-5 * float(rng.uniform(0.5, 2)), "coverage": 5e-4 * float(rng.uniform(0.5, 2))}
        return dome(SIZE, higher=0.1 * k / cases, objectives=weights)

    cold, again = [], []
    for k in range(3):
        began = time.perf_counter()
        command = [sys.executable, "-c", ONE.format(task=json.dumps(task(k)))]
        again.append(float(subprocess.run(command, capture_output=True, text=True, check=True).stdout))
        cold.append(time.perf_counter() - began)
    result = inverse.solve(task(0))
    seconds: dict[str, list[float]] = {"from the seed": [], "from the neighbour": []}
    for name, start in (("from the seed", None), ("from the neighbour", result)):
        for k in range(cases):
            began = time.perf_counter()
            found = inverse.solve(task(k), start=start)
            seconds[name].append(time.perf_counter() - began)
            assert found.certified, found.status
            assert found.converged, found.status
            start = found if start is not None else None
            if (name, k) == ("from the seed", cases // 5):
                before, measured_from = resident(), cases - 1 - k
            if (name, k) == ("from the seed", cases - 1):
                growth = (resident() - before) / max(measured_from, 1) * 500
    told = {"cold": float(np.median(cold)), "cold, solving alone": float(np.median(again))}
    told |= {name: float(np.median(some)) for name, some in seconds.items()}
    for name in seconds:
        told[f"{name}, share of cold"] = told[name] / told["cold"]
        told[f"{name}, share of cold, solving alone"] = told[name] / told["cold, solving alone"]
    return told | {"MiB per 500 cases": growth}


def moves(base: Any, span: float, count: int) -> dict[str, float]:
    """Milliseconds of moves by a hundredth of the span."""
    import inverse

    rng, session = np.random.default_rng(1), inverse.Session(base())
    light, full, place = [], [], np.zeros(3)
    for k in range(count + 1):
        step = rng.standard_normal(3)
        step *= 0.01 * span / np.linalg.norm(step)
        place = place + step if np.abs(place + step).max() < 0.05 * span else place - step
        keys = base(*place)
        began = time.perf_counter()
        update = session.update(target=keys["target"])
        done = time.perf_counter()
        result = update.result
        if k:  # the first may meet functions that are not made yet
            light.append(1000 * (done - began))
            full.append(1000 * (time.perf_counter() - done))
        assert update.converged, update.failed
        assert result.certified, result.status
    return {
        "light, median": float(np.median(light)), "light, 95 %": float(np.percentile(light, 95)),
        "full, more": float(np.median(full)), "full, more, 95 %": float(np.percentile(full, 95)),
    }  # fmt: skip


def path(count: int, size: int) -> dict[str, float]:
    """A closed curve of moves beside solves from the seed."""
    import inverse
    from inverse.origami.geometry import diagonal

    session = inverse.Session(dome(size))
    certified, apart, worse = 0, [0.0], [0.0]
    for k in range(1, count + 1):
        t = 2 * np.pi * k / count
        keys = dome(size, 0.1 * (1 - np.cos(t)), 0.1 * np.sin(2 * t), 0.02 * np.sin(t))
        update = session.update(target=keys["target"])
        certified += update.result.certified and update.converged
        if k % 10 == 0 or k == count:
            cold = inverse.solve(keys)
            mine, other = (sum(one.objective.values()) for one in (update.result, cold))
            worse.append(mine / other - 1)
            distance = np.abs(cold.design.vertices_coords - update.design.vertices_coords).max()
            if mine > (1 - 1e-6) * other:
                apart.append(float(distance) / diagonal(cold.design.vertices_coords))
    return {"moves": count, "certified": certified, "apart, of the diagonal": max(apart), "worse by": max(worse)}


def main() -> int:
    """Print the figures and write them."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--cases", type=int, default=50)
    parser.add_argument("--moves", type=int, default=60)
    parser.add_argument("--path", type=int, default=200)
    parser.add_argument("--size", type=int, default=SIZE, help="of the path")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "out" / "live.json")
    given = parser.parse_args()
    found: dict[str, Any] = {}

    def told(name: str, figures: dict[str, float]) -> None:
        found[name] = figures
        print(f"{name}: " + ", ".join(f"{key} {value:.3g}" for key, value in figures.items()), flush=True)

    told("sweep", sweep(given.cases))
    for size in (8, 16):
        told(f"moves, dome {size} x {size}", moves(lambda *k, size=size: dome(size, *k), 1.2, given.moves))
    told("moves, tube 8 x 12", moves(tube, 6.0, given.moves))
    told("path", path(given.path, given.size))
    given.out.parent.mkdir(parents=True, exist_ok=True)
    machine = {"machine": platform.platform(), "python": platform.python_version()}
    given.out.write_text(json.dumps(machine | found, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
