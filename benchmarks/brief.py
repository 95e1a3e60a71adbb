"""How many designs are as asked, why the rest are not, and whether an independent measure agrees.

    python -m benchmarks.brief                        200 random tasks and the fit table: a line each, then a summary
    python -m benchmarks.brief --first 20 --count 5   only some of the random tasks, without the fit table

The tasks are those of `benchmarks.robustness` and `benchmarks.fit`. What is called as asked is measured again with VTK,
which shares no code with the verdict: vertical lines from random places of the target, which are to meet the mesh, and
from random places of the mesh, which are to meet the target; distances of places of each from the other. A design that
is called as asked and misses a request by more than sampling explains counts as wrong, and the exit code is then 1.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyvista

import inverse
from benchmarks import fit, robustness
from inverse.crossing import triangles_of

RAYS = 400
CHANCE = 3.0  # standard deviations of a share that so many lines find
CHORD = 1e-3  # of the design's diagonal: places are compared with other triangles of the same surface


def random_places(mesh: pyvista.PolyData, random: np.random.Generator) -> np.ndarray:
    """Places of a triangle mesh, (RAYS, 3), all as likely in plan."""
    corners = mesh.points[mesh.regular_faces]
    plan = np.abs(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2])
    a, b, c = corners[random.choice(len(corners), RAYS, p=plan / plan.sum())].transpose(1, 0, 2)
    u, v = random.random((2, RAYS, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return np.asarray(a + u * (b - a) + v * (c - a))


def met(places: np.ndarray, mesh: pyvista.PolyData) -> float:
    """Share of vertical lines through places that meet a mesh."""
    far = np.array([0, 0, 10 * mesh.length + np.abs(mesh.points).max()])
    return float(np.mean([len(mesh.ray_trace(place - far, place + far)[0]) > 0 for place in places]))


def off(places: np.ndarray, mesh: pyvista.PolyData) -> float:
    """Largest distance of places from a mesh."""
    _, feet = mesh.find_closest_cell(places, return_closest_point=True)
    return float(np.linalg.norm(places - feet, axis=1).max())


def disagreements(result: inverse.Result) -> list[str]:
    """Requests that are called met and are not, by the independent measure."""
    random = np.random.default_rng(0)
    points = result.design.vertices_coords
    faces = triangles_of(result.design.pattern.faces_vertices)[0]
    mesh = pyvista.PolyData.from_regular_faces(points, faces)
    target = pyvista.PolyData.from_regular_faces(*result.target)
    on_mesh, on_target = random_places(mesh, random), random_places(target, random)
    asked = {one.name: one.asked for one in result.asked}
    slack = CHANCE * 0.5 / np.sqrt(RAYS)
    size = CHORD * float(np.linalg.norm(np.ptp(points, axis=0)))
    found = {
        "coverage": met(on_target, mesh) >= asked["coverage"] - slack,
        "beyond": 1 - met(on_mesh, target) <= asked["beyond"] + slack,
        "surface": off(np.vstack([on_mesh, points]), target) <= asked["surface"] + size,
        "missed": off(on_target, mesh) <= asked["missed"] + size,
    }
    return [name for name, holds in found.items() if not holds]


def random_tasks(first: int, count: int, folder: Path) -> Iterator[dict[str, Any]]:
    """Specifications of `benchmarks.robustness`, their targets written beside them where they are meshes."""
    for number in range(first, first + count):
        _, specification, (expression, domain, _, is_mesh) = robustness.problem(number, robustness.SIZES)
        specification["target"] = {"height": expression, "domain": domain}
        if is_mesh:
            robustness.mesh_of(expression, domain, folder / f"{number}.obj")
            specification["target"] = {"mesh": f"{number}.obj"}
        yield specification


def fit_table() -> Iterator[dict[str, Any]]:
    """Specifications of `benchmarks.fit` at 16 x 16."""
    for family, (u_lines, v_lines, _) in fit.FAMILIES.items():
        for name, target in fit.SURFACES.items():
            pattern = {"size": [16, 16], "u_lines": u_lines(15), "v_lines": v_lines(15)}
            yield {"name": f"{family} {name}", "pattern": pattern, "target": target}


def main() -> int:
    """Print a line for every design, and the summary."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int)
    given = parser.parse_args()
    missed: Counter[str] = Counter()
    endings: Counter[str] = Counter()
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        tasks = list(random_tasks(given.first, given.count or robustness.COUNT, Path(folder)))
        for specification in [*tasks, *([] if given.count else fit_table())]:
            result = inverse.solve(inverse.load(specification, folder=folder))
            names = [one.name for one in result.asked if not one.met]
            endings[result.ending] += 1
            missed.update(names)
            against = disagreements(result) if result.as_asked else []
            wrong += bool(against)
            said = ", ".join([*names, *(f"WRONG: {name}" for name in against)])
            print(
                f"{result.name:34} {result.ending:16} covered {result.coverage.covered:6.1%} beyond "
                f"{result.coverage.beyond_share:6.1%}  {said}",
                flush=True,
            )
    print("endings:", dict(endings), "missed:", dict(missed), "called as asked and not:", wrong)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
