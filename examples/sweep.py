"""A sweep: domes of growing height, each solved from the one before it, into a table."""

import csv
import sys
from pathlib import Path

import casadi
import numpy as np

import inverse


@inverse.constraint("slope", per="facet", unit="1", lower=0.3)
def slope(points, seed):
    """Vertical part of a facet's normal (4, 3): water runs off, but nobody slides."""
    normal = casadi.cross(points[2, :] - points[0, :], points[3, :] - points[1, :])
    return normal[0, 2] / casadi.norm_2(normal)


@inverse.measure("longest_edge", unit="m")
def longest_edge(design):
    a, b = design.vertices_coords[np.array(design.pattern.edges_vertices)].transpose(1, 0, 2)
    return np.linalg.norm(b - a, axis=1).max()


def sweep(heights):
    result = None
    for height in heights:
        target = f'target.height="{height} * (sqrt(1 - x^2 - y^2) - 0.5)"'
        task = inverse.load(Path(__file__).with_name("dome.yaml"), [target, "constraints.own.slope=null"])
        result = inverse.solve(task, start=result)
        row = {"height": height, "ending": result.ending, "iterations": result.iterations, "rms": result.fit.rms}
        yield row | dict(result.measures)


if __name__ == "__main__":
    rows = list(sweep([0.6, 0.7, 0.8, 0.9]))
    table = csv.DictWriter(sys.stdout, rows[0])
    table.writeheader()
    table.writerows(rows)
    assert all(row["ending"] == "solved" for row in rows)
