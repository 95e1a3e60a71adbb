"""An objective: a dome's crown is pressed down to a level."""

from pathlib import Path

import casadi

import inverse

LEVEL = 0.97  # in the specification's unit


@inverse.objective("level_crown", per="vertex", unit="length")
def level_crown(points, seed):
    """How far a vertex (1, 3) stands above the level."""
    return casadi.fmax(0, points[0, 2] - LEVEL)


if __name__ == "__main__":
    dome = Path(__file__).with_name("dome.yaml")
    plain = inverse.solve(inverse.load(dome))
    level = inverse.solve(inverse.load(dome, ["objectives.level_crown=0.1"]))
    heights = [result.design.vertices_coords[:, 2].max() for result in (plain, level)]
    print(f"highest vertex {heights[0]:.3f}, with the objective {heights[1]:.3f}")
    assert level.certified
    assert level.converged
    assert heights[1] - LEVEL < 0.5 * (heights[0] - LEVEL)
