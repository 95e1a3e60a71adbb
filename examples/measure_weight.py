"""A measure: what the folded sheet weighs, told in every report."""

from pathlib import Path

import numpy as np

import inverse

KG_PER_M2 = 2.1  # aluminium, 0.8 mm


@inverse.measure("weight", unit="kg")
def weight(design):
    """Of all facets, cut along a diagonal where they have four sides."""
    area = 0.0
    for face in design.pattern.faces_vertices:
        points = design.vertices_coords[list(face)]
        area += np.linalg.norm(np.cross(points[1:-1] - points[0], points[2:] - points[0]), axis=1).sum() / 2
    return KG_PER_M2 * area


if __name__ == "__main__":
    result = inverse.solve(inverse.load(Path(__file__).with_name("dome.yaml")))
    print(f"{result.report['measures']['weight']:.2f} kg")
    assert result.report["measures"]["weight"] == weight(result.design)
