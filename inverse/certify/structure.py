"""Whether a file holds a bidirectionally flat-foldable network at all: topology, types, facets, signs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from inverse._types import BoolArray, FloatArray, IntArray
from inverse.certify.measures import BOUNDARY, CFL, FL, UNKNOWN, fold_halves
from inverse.certify.mesh import Mesh, build_mesh
from inverse.files.fold_format import FoldFrame

COINCIDENT = 1e-9  # of the diagonal
SMALLEST_TURN = 1e-9  # radians, of a facet's boundary at each of its vertices
CODES = {"B": BOUNDARY, "FL": FL, "CFL": CFL}
WORDS = {BOUNDARY: "B", FL: "FL", CFL: "CFL", UNKNOWN: "no type"}


@dataclass(frozen=True, eq=False)
class Structure:
    """What was derived from a file, as far as its faults allow.

    Attributes:
        faults: sentences, empty for a sound file.
        points: (V, 3) vertices, centred and scaled to a bounding-box diagonal of 1.
        unit: the length in the file that became 1.
        given: (V, 3) the file's vertices over a power of two, which loses no digit: what is measured on single
            facets is measured on these.
        mesh: None if the facets form no surface in one piece.
        types: (E,) edge types, from the file, ``UNKNOWN`` where it gives none that can be.
        file_edge: (E,) the file's number of each edge, -1 if it is missing there.
        halves: sin and cos of half the fold angles, (E,) each; None if some facet is not simple and convex,
            so that angles mean nothing.
        typed: every interior edge is FL or CFL.
        signs: sides of the facets, (F,) of +-1, in the developed and in the flat-folded state; None if these
            contradict each other.
    """

    faults: list[str]
    points: FloatArray
    unit: float
    given: FloatArray
    mesh: Mesh | None
    types: IntArray
    file_edge: IntArray
    halves: tuple[FloatArray, FloatArray] | None
    typed: bool
    signs: tuple[IntArray | None, IntArray | None]


def examine(frame: FoldFrame) -> Structure:
    """Derive a design's structure from its vertices, facets and edge types, and collect the faults."""
    nothing = np.empty(0, np.int64)
    mesh, faults = build_mesh(frame.faces_vertices, len(frame.vertices_coords))
    used = np.unique([v for facet in frame.faces_vertices for v in facet]).astype(np.int64)
    given, exponent = powers_of_two_off(frame.vertices_coords)
    points, size = normalized(given, used)
    with np.errstate(over="ignore"):
        unit = float(np.ldexp(size, exponent))
    if unit == 0:
        faults.append("all vertices coincide")
    if mesh is None:
        return Structure(faults, points, unit, given, None, nothing, nothing, None, False, (None, None))

    if mesh.n_holes is None:
        faults.append("the surface is no disk, with or without holes")
    file_edge, found = _match_edges(mesh, frame)
    faults += found
    types, found = _types(mesh, frame, file_edge)
    faults += found
    typed = bool((types[mesh.inner] > BOUNDARY).all())
    ring_faults = _ring_faults(mesh, types)
    faults += ring_faults
    if not len(mesh.inner):
        faults.append("there is no interior edge, so that nothing folds")
    signs: tuple[IntArray | None, IntArray | None] = (None, None)
    if typed and not ring_faults:
        (developed, found), (folded, more) = colouring(mesh, types, CFL), colouring(mesh, types, FL)
        signs = developed, folded
        faults += found + more
    halves = None
    if unit > 0:
        faults += _coincidences(points, used)
        found = _shape_faults(mesh, points)
        faults += found
        halves = None if found else fold_halves(mesh, given)
    return Structure(faults, points, unit, given, mesh, types, file_edge, halves, typed, signs)


def normalized(points: FloatArray, used: IntArray) -> tuple[FloatArray, float]:
    """Points (V, 3) with the bounding box of the used ones centred at 0 and its diagonal scaled to 1.

    Returns:
        The points, and the diagonal before; 0, and nothing scaled, if all coincide.
    """
    box = points[used]
    low, high = box.min(axis=0, initial=np.inf), box.max(axis=0, initial=-np.inf)
    diagonal = float(np.linalg.norm(high - low)) if len(box) else 0.0
    if diagonal == 0:
        return points, 0.0
    return (points - (low + high) / 2) / diagonal, diagonal


def powers_of_two_off(vertices: FloatArray) -> tuple[FloatArray, int]:
    """Vertices (V, 3) over the power of two that brings the largest coordinate below 1, and its exponent.

    Numbers near the ends of the floating-point range are allowed so.
    """
    _, exponent = np.frexp(np.abs(vertices).max(initial=0.0))
    return np.asarray(np.ldexp(vertices, -exponent)), int(exponent)


def colouring(mesh: Mesh, types: IntArray, flips_across: int) -> tuple[IntArray | None, list[str]]:
    """Sides of the facets in a flat state: the sign changes across the edges that are folded there.

    Returns:
        (F,) of +-1, None if the signs contradict each other around a hole, and that fault.
    """
    flips = np.where(types == flips_across, -1, 1)
    signs = np.ones(len(mesh.facets), np.int64)
    for facets, parents, edges in mesh.tree:
        signs[facets] = signs[parents] * flips[edges]
    left, right = signs[mesh.sides[mesh.off_tree]].T
    wrong = mesh.off_tree[left * flips[mesh.off_tree] != right]
    if not len(wrong):
        return signs, []
    state = "developed" if flips_across == CFL else "flat-folded"
    return None, [
        f"the number of {WORDS[flips_across]} lines around a hole is odd, so that there is no {state} state"
        f" (seen at {mesh.name(wrong[0])})"
    ]


def _match_edges(mesh: Mesh, frame: FoldFrame) -> tuple[IntArray, list[str]]:
    """The file's number of every edge of the mesh, and what its list has too many or too few."""
    n_vertices = len(frame.vertices_coords)
    ours = np.sort(mesh.edges, axis=1)
    listed = np.sort(frame.edges_vertices, axis=1)
    number: dict[int, int] = {}
    faults = []
    keys = (ours[:, 0] * n_vertices + ours[:, 1]).tolist()
    wanted = set(keys)
    for k, (key, (a, b)) in enumerate(
        zip((listed[:, 0] * n_vertices + listed[:, 1]).tolist(), listed.tolist(), strict=True)
    ):
        if key in number:
            faults.append(f"edge {a}-{b} is listed twice, as edges {number[key]} and {k}")
        elif key not in wanted:
            faults.append(f"edge {k} joins vertices {a} and {b}, which no facet joins")
        else:
            number[key] = k
    found = np.array([number.get(key, -1) for key in keys], np.int64)
    faults += [f"{mesh.name(e)} of the facets is not listed" for e in np.flatnonzero(found < 0).tolist()]
    return found, faults


def _types(mesh: Mesh, frame: FoldFrame, file_edge: IntArray) -> tuple[IntArray, list[str]]:
    types = np.array([CODES[frame.edges_type[k]] if k >= 0 else UNKNOWN for k in file_edge], np.int64)
    faults = []
    is_inner = mesh.sides[:, 1] >= 0
    for e in np.flatnonzero((types != UNKNOWN) & (is_inner == (types == BOUNDARY))).tolist():
        place, needed = ("inside", "FL or CFL is") if is_inner[e] else ("on the boundary", "B is")
        faults.append(f"{mesh.name(e)} lies {place} and is typed {WORDS[types[e]]}: {needed} needed")
        types[e] = UNKNOWN if is_inner[e] else BOUNDARY
    assigned = np.array([frame.edges_assignment[k] == "B" if k >= 0 else False for k in file_edge], bool)
    for e in np.flatnonzero((file_edge >= 0) & (assigned == is_inner)).tolist():
        place, needed = ("inside", "M or V is") if is_inner[e] else ("on the boundary", "B is")
        word = frame.edges_assignment[file_edge[e]]
        faults.append(f"{mesh.name(e)} lies {place} and is assigned {word}: {needed} needed")
    return types, faults


def _ring_faults(mesh: Mesh, types: IntArray) -> list[str]:
    wrong = np.flatnonzero(mesh.degrees != 4)
    if len(wrong):
        return [f"interior vertex {mesh.interior_vertices[k]} has {mesh.degrees[k]} edges: 4 are needed" for k in wrong]
    around = types[mesh.edge_of[mesh.rings]]
    unequal = np.flatnonzero((around[:, :2] != around[:, 2:]).any(axis=1))
    return [
        f"vertex {mesh.interior_vertices[k]} has edges {', '.join(WORDS[t] for t in around[k])}:"
        " opposite ones must be of one type"
        for k in unequal
    ]


def _coincidences(points: FloatArray, used: IntArray) -> list[str]:
    distance, neighbour = cKDTree(points[used]).query(points[used], k=2)
    close = np.flatnonzero(distance[:, 1] <= COINCIDENT)
    # A vertex is listed first or second among its own neighbours if they coincide exactly.
    other = np.where(neighbour[close, 0] == close, neighbour[close, 1], neighbour[close, 0])
    pairs = np.unique(np.sort(used[np.stack([close, other], axis=1)], axis=1), axis=0)
    return [f"vertices {a} and {b} coincide" for a, b in pairs.tolist()]


def _shape_faults(mesh: Mesh, points: FloatArray) -> list[str]:
    """Edges and facets without size, facets that are not simple and convex."""
    length = np.linalg.norm(points[mesh.head] - points[mesh.tail], axis=1)
    no_length = np.flatnonzero(length[mesh.half_edges] <= COINCIDENT)
    faults = [f"{mesh.name(e)} has no length" for e in no_length.tolist()]
    # Twice the area of the facets as vectors, by Newell's sum around their first vertices.
    origin = points[mesh.tail[mesh.starts]][mesh.facet]
    swept = np.cross(points[mesh.tail] - origin, points[mesh.head] - origin)
    normal = np.add.reduceat(swept, mesh.starts, axis=0)
    size = np.linalg.norm(normal, axis=1)
    longest = np.maximum.reduceat(length, mesh.starts)
    no_area: BoolArray = size <= 1e-12 * np.maximum(longest, COINCIDENT) ** 2
    faults += [f"facet {f} has no area" for f in np.flatnonzero(no_area)]
    unit = normal / np.where(no_area, 1.0, size)[:, None]
    out = points[mesh.head] - points[mesh.tail]
    into = out[mesh.previous]
    sine = np.einsum("ij,ij->i", unit[mesh.facet], np.cross(into, out))
    turn = np.arctan2(sine, np.einsum("ij,ij->i", into, out))
    reflex = np.maximum.reduceat((turn < SMALLEST_TURN) | (turn > np.pi - SMALLEST_TURN), mesh.starts)
    # A convex polygon turns once around; one that turns more often crosses itself.
    wound = np.add.reduceat(turn, mesh.starts) > 3 * np.pi
    for f in np.flatnonzero((reflex | wound) & ~no_area):
        corners = slice(mesh.starts[f], mesh.starts[f] + len(mesh.facets[f]))
        vertex = mesh.tail[corners][turn[corners].argmin()]
        faults.append(f"facet {f} is not simple and convex, see its corner at vertex {vertex}")
    return faults
