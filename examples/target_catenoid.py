"""A target surface: part of a catenoid, which is no height over a plane."""

from pathlib import Path

import numpy as np

import inverse
from inverse.surfaces.mesh import MeshTarget


@inverse.target("catenoid")
def catenoid(*, waist, height, angle=120.0, finely=60):
    """The soap film between two rings, of which an angle in degrees is taken."""
    z, phi = np.meshgrid(np.linspace(-height / 2, height / 2, finely), np.radians(np.linspace(0, angle, finely)))
    radius = waist * np.cosh(z / waist)
    vertices = np.stack([radius * np.cos(phi), radius * np.sin(phi), z], axis=-1).reshape(-1, 3)
    first = (np.arange(finely - 1)[:, None] * finely + np.arange(finely - 1)).ravel()
    quads = np.stack([first, first + finely, first + finely + 1, first + 1], axis=1)
    return MeshTarget(vertices, np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


if __name__ == "__main__":
    target = "target={surface: catenoid, waist: 1, height: 1, angle: 90}"
    result = inverse.solve(inverse.load(Path(__file__).with_name("dome.yaml"), [target]))
    print(f"{result.status}: rms {result.report['fit']['rms_relative']:.4%} of the diagonal")
    assert result.certified
    assert result.converged
    assert result.report["fit"]["rms"] < 0.1 * result.report["fit"]["start_rms"]
