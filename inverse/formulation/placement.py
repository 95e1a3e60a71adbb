"""The seed over its target: scaled, turned and placed so that its design state covers the target's plan."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from inverse._types import FloatArray
from inverse.origami import geometry
from inverse.origami.pattern import Design, Pattern
from inverse.surfaces import Frame

Lengths = tuple[Sequence[float] | FloatArray | None, Sequence[float] | FloatArray | None]


def drifts(pattern: Pattern, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean vectors from side u0 to u1 and from v0 to v1 of a grid's vertices ``points`` (V, 3)."""
    if pattern.grid is None:
        raise ValueError("only a grid has drifts")
    m, n = pattern.grid
    table = points.reshape(m + 1, n + 1, 3)
    return (table[-1] - table[0]).mean(axis=0), (table[:, -1] - table[:, 0]).mean(axis=0)


def place_grid(
    make: Callable[[FloatArray, FloatArray], Design],
    size: tuple[int, int],
    frame: Frame,
    *,
    lengths: Lengths = (None, None),
    turn: int = 0,
    start_size: tuple[float, float] | None = None,
) -> Design:
    """A grid seed whose two drifts are the sides of the target's plan.

    Args:
        make: builds the seed from strip lengths along u and v.
        size: facets along u and v.
        frame: plan of the target.
        lengths: strip lengths along u and v up to a factor, equal if None.
        turn: 0: u along the plan's x; 90: u along its y.
        start_size: drifts along u and v instead of the plan's sides.

    Returns:
        The placed seed.
    """
    extent = start_size or (frame.extent if turn == 0 else frame.extent[::-1])
    along_u, along_v = (
        np.ones(k) if one is None else np.asarray(one, np.float64) for one, k in zip(lengths, size, strict=True)
    )
    seed = make(along_u, along_v)
    reached = [np.linalg.norm(d) for d in drifts(seed.pattern, seed.vertices_coords)]
    factors = [wanted / have for wanted, have in zip(extent, reached, strict=True)]
    seed = make(along_u * factors[0], along_v * factors[1])
    return seed.moved_to(placed(seed, frame, turn))


def place_tube(
    make: Callable[[float, FloatArray], Design],
    frame: Frame,
    *,
    lengths: FloatArray,
    turn: float = 0.0,
) -> Design:
    """A tube seed along the chord of a target's axis, as long as the axis and as wide as the tube in the mean.

    Args:
        make: builds the seed, which runs along z, from a factor of its section and the lengths of its rows.
        frame: plan of the target: x along the chord, its extent the length of the axis and the mean width.
        lengths: (n,) of the rows up to a factor.
        turn: of the seed about its axis, radians.

    Returns:
        The placed seed.
    """
    length, width = frame.extent
    seed = make(1.0, lengths)
    middle, radius = _tube_axis(seed)
    factors = width / 2 / radius, length / float(np.ptp(seed.vertices_coords[:, 2]))
    seed = make(factors[0], lengths * factors[1])
    middle, _ = _tube_axis(seed)
    # The rows zigzag along the seed's y, which is easiest to bend: in the plane of the axis.
    c, s = np.cos(turn), np.sin(turn)
    points = (seed.vertices_coords - middle) @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    along, bulge, side = frame.axes
    return seed.moved_to(points @ np.stack([-side, bulge, along]) + frame.origin)


def _tube_axis(seed: Design) -> tuple[FloatArray, float]:
    """The middle (3,) of a tube seed that runs along z, and the rms distance of its facets' centroids from its axis."""
    m, n = seed.pattern.grid or (0, 0)
    rings = geometry.facet_centroids(seed.pattern, seed.vertices_coords).reshape(m, n, 3)[..., :2]
    centres = rings.mean(axis=0)
    radius = float(np.sqrt(np.mean(np.sum((rings - centres) ** 2, axis=2))))
    height = seed.vertices_coords[:, 2]
    return np.r_[centres.mean(axis=0), (height.min() + height.max()) / 2], radius


def place_file(seed: Design, frame: Frame, turn: int = 0) -> Design:
    """A pattern of its own, scaled as a whole so that it covers the target's plan as well as it can."""
    own = _own_axes(seed)
    size = np.ptp(seed.vertices_coords @ own.T, axis=0)[:2]
    wanted = np.array(frame.extent if turn == 0 else frame.extent[::-1])
    scaled = seed.moved_to(seed.vertices_coords * float(np.sqrt(np.prod(wanted / size))))
    return scaled.moved_to(placed(scaled, frame, turn))


def placed(seed: Design, frame: Frame, turn: int = 0) -> FloatArray:
    """Vertices (V, 3) of a seed turned into the plan of a target, centre on centre."""
    axes = frame.axes if turn == 0 else np.stack([frame.axes[1], -frame.axes[0], frame.axes[2]])
    points = seed.vertices_coords
    return np.asarray((points - points.mean(axis=0)) @ _own_axes(seed).T @ axes + frame.origin)


def _own_axes(seed: Design) -> FloatArray:
    """Rows x, y (in the sheet) and z: along the drifts of a grid or a tube, else the principal axes of the vertices."""
    points = seed.vertices_coords
    if seed.pattern.grid is not None and seed.pattern.n_holes == 0:
        u, v = drifts(seed.pattern, points)
        z = np.cross(u, v)
    else:
        spread = np.linalg.eigh(np.cov(points.T))[1]
        u, z = spread[:, 2], spread[:, 0]
        # The side from which the facets turn counter-clockwise is the top.
        a, b, c = points[list(seed.pattern.faces_vertices[0][:3])]
        z = z if np.cross(b - a, c - a) @ z > 0 else -z
        if seed.pattern.grid is not None:
            table = points.reshape(seed.pattern.grid[0], -1, 3)
            u = (table[:, -1] - table[:, 0]).mean(axis=0)  # from one open end to the other
            z = z - (z @ u) / (u @ u) * u
    x, z = u / np.linalg.norm(u), z / np.linalg.norm(z)
    return np.stack([x, np.cross(z, x), z])
