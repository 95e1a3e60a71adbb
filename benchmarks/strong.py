"""Strong deformations: how far a flat seed can be bent onto a half-cylinder, a hemisphere and a deep dome.

    python -m benchmarks.strong      prints the table and writes benchmarks/out/strong.json

`height` is the share of the target's height that the centroids of rim facets come down to (half a facet is missing
by nature), `path` how the design was come by: straight, or on a path of flatter targets.
"""

from __future__ import annotations

import argparse
import json
import platform
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import inverse
from inverse.origami import geometry
from inverse.origami.pattern import B

FAMILIES = {"Miura": ("FL", "FL"), "eggbox": ("CFL", "FL")}
HALF_CYLINDER = {"between": [[[-1, -1, 0], [-1, 1, 0]], [[1, -1, 0], [1, 1, 0]]], "rise": 1.0}
DEEP_DOME = {"height": "sqrt(0.25 - x^2 - y^2)", "domain": [[-0.3, 0.3], [-0.3, 0.3]]}
RINGS, AROUND = 30, 96


def cap(degrees: float, path: Path) -> dict[str, str]:
    """Write a cap of the unit sphere, down to an angle from its pole, as OBJ."""
    theta = np.radians(degrees) * np.arange(1, RINGS + 1)[:, None] / RINGS
    phi = 2 * np.pi * np.arange(AROUND) / AROUND
    rings = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta) + 0 * phi], axis=-1)
    number = 2 + np.arange(RINGS * AROUND).reshape(RINGS, AROUND)
    onward = np.roll(number, -1, axis=1)
    quads = np.stack([number[:-1], number[1:], onward[1:], onward[:-1]], axis=-1).reshape(-1, 4)
    lines = ["v 0 0 1", *(f"v {x!r} {y!r} {z!r}" for x, y, z in rings.reshape(-1, 3).tolist())]
    lines += [f"f 1 {a} {b}" for a, b in zip(number[0].tolist(), onward[0].tolist(), strict=True)]
    lines += ["f {} {} {} {}".format(*q) for q in quads.tolist()]
    path.write_text("\n".join(lines) + "\n")
    return {"mesh": str(path)}


def measure(name: str, target: dict[str, Any], lines: tuple[str, str], size: int) -> dict[str, Any]:
    """Solve one task."""
    pattern = {"size": [size, size], "u_lines": lines[0], "v_lines": lines[1]}
    began = time.perf_counter()
    result = inverse.solve(inverse.load({"name": name, "pattern": pattern, "target": target}))
    seconds = time.perf_counter() - began
    design, fit = result.design, result.report["fit"]
    heights = result.target[0][:, 2]
    rim = np.unique(design.pattern.edges_faces[design.pattern.edges_type == B, 0])
    lowest = float(np.percentile(geometry.facet_centroids(design.pattern, design.vertices_coords)[rim, 2], 5))
    return {
        "name": name,
        "certified": result.certified,
        "converged": result.converged,
        "rms": fit["rms_relative"],
        "gain": fit["rms"] / fit["start_rms"],
        "coverage": result.coverage.covered,
        "height": (heights.max() - lowest) / np.ptp(heights),
        "reached": result.report["reached"],
        "iterations": result.report["iterations"],
        "seconds": seconds,
        "status": result.status,
    }


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "out" / "strong.json")
    given = parser.parse_args()
    print(
        f"{'task':<24} {'cert':>4} {'conv':>4} {'fit rms':>9} {'of seed':>8} {'cover':>7} {'height':>7} {'path':>9} "
        f"{'iter':>5} {'s':>6}"
    )
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        targets: dict[str, tuple[dict[str, Any], int]] = {
            "deep dome 32": (DEEP_DOME, 32),
            "half-cylinder 16": (HALF_CYLINDER, 16),
            "half-cylinder 32": (HALF_CYLINDER, 32),
        }
        for degrees in (50, 70, 90):
            targets[f"cap {degrees} 16"] = cap(degrees, Path(folder) / f"cap{degrees}.obj"), 16
        for name, (target, size) in targets.items():
            for family, lines in FAMILIES.items():
                row = measure(f"{family} {name}", target, lines, size)
                rows.append(row)
                path = "straight" if row["reached"] is None else f"{row['reached']:.3g}"
                print(
                    f"{row['name']:<24} {'yes' if row['certified'] else 'NO':>4} "
                    f"{'yes' if row['converged'] else 'NO':>4} {row['rms']:>9.4%} {row['gain']:>8.2%} "
                    f"{row['coverage']:>7.1%} {row['height']:>7.1%} {path:>9} {row['iterations']:>5} "
                    f"{row['seconds']:>6.1f}{'' if row['converged'] and row['certified'] else '  ' + row['status']}",
                    flush=True,
                )
    given.out.parent.mkdir(exist_ok=True)
    document = {"machine": platform.platform(), "python": platform.python_version(), "rows": rows}
    given.out.write_text(json.dumps(document, indent=1))


if __name__ == "__main__":
    main()
