"""Seeds that no design can come from: too small, too large or too far away for the target."""

from __future__ import annotations

import numpy as np

from inverse._types import FloatArray
from inverse.origami import geometry
from inverse.origami.pattern import Design
from inverse.spec import FilePattern, GridPattern, Loaded
from inverse.surfaces import Target

ENOUGH = 0.5  # of the target's area: a mesh that cannot have this much is refused, not solved


def check_sizes(loaded: Loaded, seed: Design, target: Target) -> None:
    """Refuse a seed whose edges, within their limits, cannot be grown or shrunk to the target.

    Args:
        loaded: the specification.
        seed: the placed seed.
        target: the target, in the same coordinates.

    Raises:
        InputError: with the place in the specification.
    """
    pattern = loaded.specification.pattern
    low, high = loaded.specification.constraints.edge_length
    vertices, _ = target.triangles()
    area, size = float(target.samples()[1].sum()), geometry.diagonal(vertices)
    key, advice = _cause(loaded)
    largest = high**2 * float(_largest_areas(seed).sum())
    if largest < ENOUGH * area:
        raise loaded.source.error(
            key,
            f"the seed is too small for its target: {geometry.diagonal(seed.vertices_coords):.3g} from corner to "
            f"corner, the target {size:.3g}. Its edges may be {high:g} times as long in the design "
            f"(constraints.edge_length), so that the mesh has at most {largest:.3g} of the target's area of {area:.3g}",
            advice,
        )
    shortest = low * float(geometry.edge_lengths(seed.pattern, seed.vertices_coords).mean())
    if shortest > size:
        raise loaded.source.error(
            key,
            f"the seed is too large for its target: its edges may be {low:g} times as long in the design "
            f"(constraints.edge_length), which is {shortest:.3g} in the mean, and the target is only {size:.3g} from "
            "corner to corner",
            advice,
        )
    if isinstance(pattern, FilePattern) and pattern.keep_position:
        frame = target.frame
        own, asked = ((points - frame.origin) @ frame.axes.T for points in (seed.vertices_coords, vertices))
        beside = np.maximum(own.min(axis=0) - asked.max(axis=0), asked.min(axis=0) - own.max(axis=0))[:2]
        apart = float(np.linalg.norm(np.maximum(beside, 0.0)))
        if apart > 0:
            raise loaded.source.error(
                key, f"the file's pattern lies {apart:.3g} beside the target, whose plan it does not meet", advice
            )


def _cause(loaded: Loaded) -> tuple[tuple[str, ...], str]:
    """The key that makes the seed's size, and what to do about it."""
    pattern = loaded.specification.pattern
    if isinstance(pattern, GridPattern) and pattern.start_size is not None:
        return ("pattern", "start_size"), "Leave start_size out: the seed then covers the target."
    if isinstance(pattern, FilePattern) and pattern.keep_position:
        return ("pattern", "keep_position"), "Leave keep_position out: the pattern is then placed over the target."
    return ("constraints", "edge_length"), "Leave edge_length out: edges may then be 0.3 to 3 times as long."


def _largest_areas(seed: Design) -> FloatArray:
    """Areas (F,) that the facets can have at most with their edges as they are.

    No polygon has more than the one with its corners on a circle; of four sides that is Brahmagupta's formula. For
    others the circle with the same perimeter is more than enough.
    """
    pattern, lengths = seed.pattern, geometry.edge_lengths(seed.pattern, seed.vertices_coords)
    found = np.zeros(len(pattern.faces_vertices))
    for f, edges in enumerate(pattern.faces_edges):
        sides = lengths[list(edges)]
        half = float(sides.sum()) / 2
        quad = len(sides) == 4
        found[f] = np.sqrt(max(float(np.prod(half - sides)), 0.0)) if quad else half**2 / np.pi
    return found
