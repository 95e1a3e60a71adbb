"""A flat crease pattern folded part of the way, so that it has an intermediate state to be exact in."""

from __future__ import annotations

import numpy as np

from inverse.crossing import crossing_facets
from inverse.errors import InputError
from inverse.origami import folding, geometry
from inverse.origami.pattern import FL, Design, Pattern
from inverse.repair.assignments import Folding
from inverse.repair.measures import laid_upon
from inverse.repair.snap import Snapped, snapped

# Factors of the half-angle tangents whose largest and least are as far above as below 90 degrees. Deep folds make a
# well-shaped solid, but the sheet may run into itself: then less and less.
FOLD_STATES = (1.0, 0.6, 0.35, 0.2, 0.1)
RETURNS = 3  # times at most that a design is led back towards the pattern as drawn
SETTLED_MOVE = 1e-6  # of the diagonal: less need not be led back once more


def folded(flat: Design, motion: Folding, state: float = FOLD_STATES[0]) -> Design:
    """The crease pattern folded to one state, gaps left by its errors shared among the facets."""
    return flat.moved_to(folding.folded_by(flat, 2 * np.arctan(state * motion.tangents)))


def snapped_at_best_state(flat: Design, motion: Folding) -> Snapped:
    """Fold a crease pattern and make it exact, in the deepest state that is sound and has no crossing facets.

    Returns:
        The exact design; the last state tried if none is sound.
    """
    for state in FOLD_STATES:
        result = snapped(folded(flat, motion, state))
        points = result.design.vertices_coords
        if not result.faults and not len(crossing_facets(points, flat.pattern.faces_vertices)):
            break
    for _ in range(0 if result.faults else RETURNS):
        nearer = snapped(led_back(result.design, flat))
        if nearer.faults or len(crossing_facets(nearer.design.vertices_coords, flat.pattern.faces_vertices)):
            break
        step = geometry.diagonal(nearer.design.vertices_coords - result.design.vertices_coords)
        result = nearer
        if step < SETTLED_MOVE * geometry.diagonal(flat.vertices_coords):
            break
    return result


def led_back(design: Design, flat: Design) -> Design:
    """A folded design with every facet in its place, but of the shape that it has in the crease pattern as drawn.

    Facets that were placed one after another drift away from the drawing. Here each takes the drawn facet along by
    the motion that folds its exact one, and the drift is gone to first order.
    """
    developed = laid_out(design, flat)
    pattern = flat.pattern
    facet, _, vertex, _ = pattern.corners.T
    frames = []
    for state in (developed, design):
        a, b = (state.vertices_coords[[face[k] for face in pattern.faces_vertices]] for k in (0, 1))
        along, normal = geometry.unit(b - a), geometry.facet_normals(pattern, state.vertices_coords)
        frames.append((a, np.stack([along, np.cross(normal, along), normal], axis=1)))
    (origin, axes), (place, turned) = ((start[facet], frame[facet]) for start, frame in frames)
    local = np.einsum("cij,cj->ci", axes, flat.vertices_coords[vertex] - origin)
    total = np.zeros_like(flat.vertices_coords)
    np.add.at(total, vertex, place + np.einsum("ci,cij->cj", local, turned))
    return design.moved_to(total / np.bincount(vertex)[:, None])


def check_all_foldlines(pattern: Pattern) -> None:
    """Refuse types that a crease pattern laid out in one layer cannot have.

    Raises:
        InputError: some interior edge is no FL.
    """
    other = pattern.interior_edges[pattern.edges_type[pattern.interior_edges] != FL]
    if len(other):
        a, b = pattern.edges_vertices[other[0]].tolist()
        raise InputError(f"edge {a}-{b} is CFL, but in a flat crease pattern laid out in one layer all lines are FL",
                         hint="Leave the types out, or give a semi-folded state.")  # fmt: skip


def laid_out(design: Design, over: Design) -> Design:
    """The developed state of a design, moved within the plane as near to a crease pattern as can be."""
    flat = folding.flat_state(design, 0.0)
    return design.moved_to(laid_upon(flat, over.vertices_coords))


def angle_range(design: Design) -> tuple[float, float]:
    """Least and largest fold angle in degrees."""
    folds = np.abs(geometry.fold_angles(design.pattern, design.vertices_coords)[design.pattern.interior_edges])
    return float(np.degrees(folds.min())), float(np.degrees(folds.max()))
