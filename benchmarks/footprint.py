"""What a small flat-folded state costs in fit: the vault of targets/vault.yaml under bounds and weights.

    python -m benchmarks.footprint                     prints the table and writes benchmarks/out/footprint.json
    python -m benchmarks.footprint --only width area   only these groups of rows
    python -m benchmarks.footprint --size 8 12         fewer facets

Bounds are fractions of the flat-folded rectangle (least area) of the design without any. Extents are those of the
flat-folded state, found by folding the design.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import inverse

ROOT = Path(__file__).parents[1]
VAULT = ROOT / "targets" / "vault.yaml"
FRACTIONS = {"width": (0.9, 0.8, 0.7, 0.6), "length": (0.9, 0.8, 0.7), "both": (0.9, 0.8, 0.7), "area": (0.7,)}
WEIGHTS = (1e-4, 1e-3, 1e-2)


def bound(group: str, fraction: float, length: float, width: float) -> dict[str, float]:
    """The specification's limits; a length alone would let the box stand across a diagonal, so the width is kept."""
    return {
        "width": {"width": fraction * width},
        "length": {"length": fraction * length, "width": width},
        "both": {"length": fraction * length, "width": fraction * width},
        "area": {"area": fraction * length * width},
    }[group]


def measure(name: str, overrides: list[str], size: list[int] | None) -> dict[str, Any]:
    """Solve the vault with a few keys changed."""
    began = time.perf_counter()
    sized = [f"pattern.size={size}"] if size else []
    result = inverse.solve(inverse.load(VAULT, [*overrides, *sized]))
    footprint = result.report["footprint"]
    length, width = footprint["flat-folded"]["extents"]
    row = {
        "name": name,
        "certified": result.certified,
        "converged": result.converged,
        "rms": result.report["fit"]["rms_relative"],
        "max": result.report["fit"]["max_relative"],
        "coverage": result.coverage.covered,
        "length": length,
        "width": width,
        "deployed_to_packed": footprint["deployed_to_packed"]["flat-folded"],
        "iterations": result.report["iterations"],
        "seconds": time.perf_counter() - began,
    }
    print(
        f"{name:<18} {'yes' if row['certified'] else 'NO':>4} {'yes' if row['converged'] else 'NO':>4} "
        f"{row['rms']:>9.3%} {row['max']:>9.3%} {length:>8.2f} {width:>7.2f} {length * width:>7.1f} "
        f"{row['deployed_to_packed']['area']:>7.2f} {row['iterations']:>5} {row['seconds']:>6.1f}",
        flush=True,
    )
    return row


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--only", nargs="*", choices=[*FRACTIONS, "weight"], default=[*FRACTIONS, "weight"])
    parser.add_argument("--size", type=int, nargs=2)
    given = parser.parse_args()
    print(
        f"{'flat-folded':<18} {'cert':>4} {'conv':>4} {'fit rms':>9} {'fit max':>9} {'length':>8} {'width':>7} "
        f"{'area':>7} {'d/p':>7} {'iter':>5} {'s':>6}"
    )
    free = measure("free", [], given.size)
    rows = [free]
    for group, fractions in FRACTIONS.items():
        for fraction in fractions if group in given.only else ():
            limits = bound(group, fraction, free["length"], free["width"])
            override = f"constraints.footprint={json.dumps(limits)}"
            rows.append(measure(f"{group} {fraction - 1:+.0%}", [override], given.size))
    for weight in WEIGHTS if "weight" in given.only else ():
        rows.append(measure(f"weight {weight:g}", [f"objectives.footprint={weight}"], given.size))
    out = Path(__file__).parent / "out"
    out.mkdir(exist_ok=True)
    (out / "footprint.json").write_text(json.dumps(rows, indent=1))
    return 0 if all(row["certified"] and row["converged"] for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
