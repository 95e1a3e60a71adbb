"""A pattern family: Miura sheets whose strips grow by a ratio from one to the next."""

from pathlib import Path

import numpy as np

import inverse


@inverse.pattern_family("tapered")
def tapered(m, n, *, ratio=1.1):
    """A grid of m x n facets, semi-folded, of any size: it is placed over the target."""
    return inverse.seeds.grid((m, n), lengths_u=ratio ** np.arange(m))


if __name__ == "__main__":
    pattern = "pattern={kind: family, family: tapered, size: [6, 8], ratio: 1.2}"
    result = inverse.solve(inverse.load(Path(__file__).with_name("dome.yaml"), [pattern]))
    points = result.seed.vertices_coords.reshape(7, 9, 3)
    strips = np.linalg.norm(points[1:, 0] - points[:-1, 0], axis=1)
    print(f"{result.status}: strips of the seed from {strips.min():.3f} to {strips.max():.3f}")
    assert result.certified
    assert result.converged
    assert np.allclose(strips[1:] / strips[:-1], 1.2)
