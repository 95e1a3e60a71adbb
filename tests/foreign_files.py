"""Pattern files as other programs would write them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from designs import perturbed

from inverse import constraints
from inverse.model import DesignModel
from inverse.nlp.point import Point
from inverse.nlp.problem import Problem
from inverse.origami import folding, geometry
from inverse.origami.pattern import B, Design
from inverse.solvers.projection import polish


def generic(design: Design, size: float = 0.05, seed: int = 1) -> Design:
    """An exact design without any symmetry, not far from a given one."""
    model = DesignModel(design)
    problem = Problem(model.n_variables, [], constraints.hard_constraints(model, {}))
    points = model.to_dimensionless(perturbed(design, size, seed).vertices_coords)
    x = polish(Point(problem, points.ravel(), problem.parameters()), steps=20).variables
    assert Point(problem, x, problem.parameters()).violation < 1e-14
    return model.design(x)


def assignments(design: Design) -> list[str]:
    angles = geometry.fold_angles(design.pattern, design.vertices_coords)
    return ["B" if t == B else "V" if a > 0 else "M" for t, a in zip(design.pattern.edges_type, angles, strict=True)]


def scrambled_facets(design: Design, seed: int = 0) -> list[list[int]]:
    """The facets, half of them turned the other way."""
    rng = np.random.default_rng(seed)
    return [list(face)[:: rng.choice([-1, 1])] for face in design.pattern.faces_vertices]


def crease_pattern(design: Design, noise: float = 0.0, seed: int = 0) -> dict[str, Any]:
    """The developed state: vertices in the plane, edges, mountains and valleys, nothing else."""
    flat = folding.flat_state(design, 0.0)[:, :2]
    flat = flat + noise * np.random.default_rng(seed).standard_normal(flat.shape)
    return {
        "vertices_coords": flat.tolist(),
        "edges_vertices": design.pattern.edges_vertices.tolist(),
        "edges_assignment": assignments(design),
    }


def write_fold(document: object, folder: Path, name: str = "pattern.fold") -> Path:
    path = folder / name
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    return path


def write_obj(points: np.ndarray, facets: list[list[int]], folder: Path) -> Path:
    lines = ["# a mesh", "mtllib none.mtl", "g first group"]
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()]
    lines += ["vn 0 0 1", "s off"]
    lines += ["f " + " ".join(f"{v + 1}//1" for v in facet) for facet in facets]
    path = folder / "pattern.obj"
    path.write_text("\n".join(lines) + "\n")
    return path
