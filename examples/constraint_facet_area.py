"""A constraint: no facet is larger than what a sheet of metal gives."""

from pathlib import Path

import casadi
import numpy as np

import inverse


@inverse.constraint("facet_area", per="facet", unit="length^2", upper=0.135)
def facet_area(points, seed):
    """Area of a quad (4, 3): half the cross product of its diagonals."""
    across = casadi.cross(points[2, :] - points[0, :], points[3, :] - points[1, :])
    return casadi.norm_2(across) / 2


def areas(design):
    a, b, c, d = design.vertices_coords[np.array(design.pattern.faces_vertices)].transpose(1, 0, 2)
    return np.linalg.norm(np.cross(c - a, d - b), axis=1) / 2


if __name__ == "__main__":
    dome = Path(__file__).with_name("dome.yaml")
    plain = inverse.solve(inverse.load(dome))
    small = inverse.solve(inverse.load(dome, ["constraints.own.facet_area=null"]))  # null: the bounds from above
    smaller = inverse.solve(inverse.load(dome, ["constraints.own.facet_area=[null, 0.13]"]))
    largest = [areas(result.design).max() for result in (plain, small, smaller)]
    print("largest facet {:.4f}, with the constraint {:.4f} and {:.4f}".format(*largest))
    assert small.certified
    assert small.converged
    assert smaller.converged
    assert largest[0] > 0.14
    assert largest[1] <= 0.135 * (1 + 1e-6)
    assert largest[2] <= 0.13 * (1 + 1e-6)
