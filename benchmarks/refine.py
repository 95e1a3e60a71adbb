"""Equation (9): seconds of a projected step with its Newton correction, and a corner dragged in 100 steps.

python -m benchmarks.refine              prints the table and writes benchmarks/out/refine.json
python -m benchmarks.refine --sizes 32   only these numbers of facets per side

Steps of 0.4 edges, then 0.01 edges: as far as a pointer goes between two pictures, where factors are kept.
"""

from __future__ import annotations

import argparse
import json
import platform
import time
from pathlib import Path
from typing import Any

import numpy as np

import inverse
from inverse import constraints
from inverse.certify import check_frame
from inverse.dragging import LIMITS
from inverse.files import fold_file
from inverse.files.fold_format import frame_of
from inverse.model import DesignModel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import geometry
from inverse.solvers.projection import Projection

SIZES = (16, 32, 64, 100)
WAYS = ((0.4, 10), (0.01, 40))  # edges that a corner is wished to move in a step, and steps
SECONDS = {16: 0.006, 32: 0.020, 100: 1.5}  # wanted of a step, the median


def step(size: int, edges: float = 0.4, steps: int = 10) -> dict[str, Any]:
    """Seconds of steps in which a corner of a Miura sheet is wished to move by some edges, and others to follow."""
    design = inverse.seeds.grid((size, size))
    began = time.perf_counter()
    model = DesignModel(design)
    problem = Problem(model.n_variables, [], constraints.hard_constraints(model, LIMITS))
    projection = Projection()
    at = Point(problem, model.seed_points.ravel(), problem.parameters())
    at.jacobian  # noqa: B018  builds the functions
    built = time.perf_counter() - began
    points = model.seed_points
    weights = np.exp(-((np.linalg.norm(points - points[0], axis=1) / (geometry.diagonal(points) / 4)) ** 2))
    direction = np.array([0.3, -0.5, 0.8])
    wish = edges / np.linalg.norm(direction) * (weights[:, None] * direction).ravel()
    seconds, residuals = [], []
    equations = problem.lower == problem.upper
    for _ in range(steps):
        began = time.perf_counter()
        moved = projection.moved(at, wish)
        seconds.append(time.perf_counter() - began)
        if moved is None:
            raise RuntimeError("a step was too long")
        at = moved
        residuals.append(float(np.abs(at.rows[equations]).max()))
    return {
        "facets": size * size,
        "edges": edges,
        "build": built,
        "factorizations": projection.factorizations,
        "steps": steps,
        "mean": float(np.mean(seconds[1:])),
        "seconds": float(np.median(seconds)),
        "largest": max(seconds),
        "residual": max(residuals),
    }


def drag(size: int, lines: tuple[str, str]) -> dict[str, Any]:
    """A corner moved by 30 % of the diagonal in 100 steps."""
    design = inverse.seeds.grid((size, size), *lines)
    direction = np.array([0.3, -0.5, 0.8])
    way = 0.3 * geometry.diagonal(design.vertices_coords) * direction / np.linalg.norm(direction)
    began = time.perf_counter()
    refined = inverse.refine(design, {0: way}, steps=100)
    seconds = time.perf_counter() - began
    lengths = geometry.edge_lengths(design.pattern, refined.design.vertices_coords)
    ratio = lengths / geometry.edge_lengths(design.pattern, design.vertices_coords)
    certificate = check_frame(frame_of(fold_file.document(refined.design)))
    return {
        "lines": lines,
        "facets": size * size,
        "certified": certificate.certified,
        "remaining": float(refined.remaining[0]),
        "residual": refined.residual,
        "steps": refined.steps,
        "seconds": seconds,
        "edges": (float(ratio.min()), float(ratio.max())),
    }


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--sizes", type=int, nargs="*", default=list(SIZES))
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "out" / "refine.json")
    given = parser.parse_args()
    titles = f"{'build s':>8} {'step s':>8} {'mean':>8} {'largest':>8} {'factors':>8} {'residual':>9}"
    print(f"{'facets':>7} {'edges':>6} {titles}")
    steps = []
    for size in given.sizes:
        for edges, count in WAYS:
            row = step(size, edges, count)
            steps.append(row)
            wanted = SECONDS.get(size)
            met = "" if wanted is None else "  ok" if row["seconds"] <= wanted else f"  over {wanted} s"
            factors = f"{row['factorizations']}/{row['steps']}"
            print(
                f"{row['facets']:>7} {edges:>6.2f} {row['build']:>8.2f} {row['seconds']:>8.4f} {row['mean']:>8.4f} "
                f"{row['largest']:>8.3f} {factors:>8} {row['residual']:>9.0e}{met}",
                flush=True,
            )
    print(f"\n{'drag':>16} {'cert':>5} {'steps':>6} {'rest':>8} {'residual':>9} {'edges':>12} {'s':>6}")
    drags = [drag(16, lines) for lines in (("FL", "FL"), ("CFL", "FL"))]
    for row in drags:
        low, high = row["edges"]
        print(
            f"{'/'.join(row['lines']) + ' 16 x 16':>16} {'yes' if row['certified'] else 'NO':>5} {row['steps']:>6} "
            f"{row['remaining']:>8.0e} {row['residual']:>9.0e} {f'{low:.2f} - {high:.2f}':>12} {row['seconds']:>6.1f}"
        )
    given.out.parent.mkdir(exist_ok=True)
    document = {"machine": platform.platform(), "python": platform.python_version(), "steps": steps, "drags": drags}
    given.out.write_text(json.dumps(document, indent=1))


if __name__ == "__main__":
    main()
