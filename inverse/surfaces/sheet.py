"""What a sheet cannot follow of a mesh: closed surfaces, several parts, holes, facets that branch off."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.surfaces.edges import edges_of
from inverse.surfaces.mesh import MeshTarget

NEAR = 0.5  # facets: parts nearer to each other than this are bridged without a trace
SEAM = 2.0  # facets: two parts belong together if they run beside each other for as long as this
PIECES = 1000  # that an edge of the border is cut into at most
HOLE = 1.0  # facets: holes smaller than this, from corner to corner, are bridged without a trace


@dataclass(frozen=True, eq=False)
class Borders:
    """Parts of a mesh and the lines where they end.

    Attributes:
        part: (T,) int, part that each triangle belongs to: its triangles share edges.
        edges: (B, 2) int, edges of one triangle, in its direction.
        edges_part: (B,) int, their parts.
        loop: (B,) int, the closed line that each of them belongs to.
    """

    part: IntArray
    edges: IntArray
    edges_part: IntArray
    loop: IntArray


def check_sheet(mesh: MeshTarget, facet: float, *, may_have_holes: bool = False) -> None:
    """Refuse what no sheet of facets of about this size can follow.

    Args:
        mesh: the target.
        facet: mean edge length of the seed, in the mesh's unit.
        may_have_holes: whether the sheet is cut out over holes.

    Raises:
        InputError: more than two facets meet at an edge, the mesh is closed, has several parts, or a hole.
    """
    vertices, triangles = mesh.triangles()
    _check_branches(vertices, triangles)
    borders = borders_of(triangles)
    if not len(borders.edges):
        raise InputError(
            "the target mesh is closed: it has no border, as a sheet has one",
            hint="Delete facets of it until it has one border (those that the structure stands on, say), or go around "
            "it with a pattern of kind tube and target: {axis: ..., mesh: ...}.",
        )
    _check_parts(mesh, borders, facet)
    if not may_have_holes:
        _check_holes(vertices, borders, facet)


def borders_of(triangles: IntArray) -> Borders:
    """Parts and borders of triangles (T, 3)."""
    directed = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    owner = np.repeat(np.arange(len(triangles)), 3)
    edge, count = edges_of(triangles)
    number = edge.ravel()
    part = connected(owner, number + len(triangles), len(triangles) + len(count))[: len(triangles)]
    part = np.unique(part, return_inverse=True)[1].ravel()
    rim = count[number] == 1
    border, border_part = directed[rim], part[owner[rim]]
    loop = connected(border[:, 0], border[:, 1], int(triangles.max()) + 1)
    names = np.unique(loop[border[:, 0]], return_inverse=True)[1].ravel()
    return Borders(part, border, border_part, names)


def connected(one: IntArray, other: IntArray, count: int) -> IntArray:
    """Number of the part (count,) that each of some things belongs to, pairs of which are joined."""
    joined = coo_array((np.ones(len(one), bool), (one, other)), shape=(count, count))
    return np.asarray(connected_components(joined, directed=False)[1], np.int64)


def _check_branches(vertices: FloatArray, triangles: IntArray) -> None:
    edge, count = edges_of(triangles)
    many = np.flatnonzero(count > 2)
    if len(many):
        triangle, side = np.argwhere(edge == many[np.argmax(count[many])])[0]
        a, b = (place(vertices[k]) for k in sorted((triangles[triangle, side], triangles[triangle, (side + 1) % 3])))
        raise InputError(
            f"{count[many].max()} facets of the target mesh meet at the edge from {a} to {b}, one of {len(many)} edges "
            "with more than two: a sheet does not branch",
            hint="Delete the facets that stand off the surface, or are there twice.",
        )


def _check_parts(mesh: MeshTarget, borders: Borders, facet: float) -> None:
    """Refuse parts that no seam of some length joins."""
    count = int(borders.part.max()) + 1
    if count == 1:
        return
    vertices, triangles = mesh.triangles()
    group = _joined(vertices, borders, facet, count)[borders.part]
    number = int(group.max()) + 1
    if number == 1:
        return
    _, areas = mesh.samples()
    shares = np.bincount(group, areas) / areas.sum()
    largest = MeshTarget(vertices, triangles[group == np.argmax(shares)])
    others = MeshTarget(vertices, triangles[group != np.argmax(shares)])
    nearest = min(
        float(one.distances(np.concatenate([other.triangles()[0], other.samples()[0]])).min())
        for one, other in ((largest, others), (others, largest))
    )
    told = f"{nearest:.3g} apart" if nearest > 1e-9 * facet else "that only touch"
    raise InputError(
        f"the target mesh has {number} parts {told}, of {_listed(100 * np.sort(shares)[::-1])} % of its area: a sheet "
        "has one",
        hint="Keep one part in the file and design the others by themselves, or join them in the mesh by a surface "
        f"at least {SEAM * facet:.2g} wide.",
    )


def _joined(vertices: FloatArray, borders: Borders, facet: float, count: int) -> IntArray:
    """Number of the group (count,) that parts belong to whose borders run beside each other."""
    a, b = vertices[borders.edges].transpose(1, 0, 2)
    lengths = np.linalg.norm(b - a, axis=1)
    step = NEAR * facet / 2
    pieces = np.minimum(np.ceil(lengths / step).astype(int), PIECES)
    edge = np.repeat(np.arange(len(pieces)), pieces)
    share = (np.arange(len(edge)) - np.repeat(np.cumsum(pieces) - pieces, pieces) + 0.5) / pieces[edge]
    places, part, own = a[edge] + share[:, None] * (b - a)[edge], borders.edges_part[edge], (lengths / pieces)[edge]
    near = cKDTree(places).query_pairs(np.hypot(NEAR * facet, step), output_type="ndarray")
    near = near[part[near[:, 0]] != part[near[:, 1]]]
    # Length of the border of a part that is near to another one, each piece counted once.
    near = np.concatenate([near, near[:, ::-1]])
    pairs = np.unique(np.c_[near[:, 0], part[near[:, 1]]], axis=0)
    beside = np.zeros((0, 2), np.int64)
    if len(pairs):
        names, number = np.unique(np.c_[part[pairs[:, 0]], pairs[:, 1]], axis=0, return_inverse=True)
        beside = names[np.bincount(number.ravel(), own[pairs[:, 0]]) > SEAM * facet]
    return np.unique(connected(beside[:, 0], beside[:, 1], count), return_inverse=True)[1].ravel()


def hole_loops(vertices: FloatArray, borders: Borders) -> list[int]:
    """Closed borders but the longest one of every part: the loops around holes."""
    sizes = _sizes(vertices, borders)
    found: list[int] = []
    for part in range(int(borders.part.max()) + 1):
        own = np.unique(borders.loop[borders.edges_part == part]).tolist()
        found += sorted(own, key=lambda loop: sizes[loop])[:-1]
    return sorted(found)


def _sizes(vertices: FloatArray, borders: Borders) -> FloatArray:
    """Diagonal of the box around every loop."""
    ends = [vertices[borders.edges[borders.loop == loop]].reshape(-1, 3) for loop in range(int(borders.loop.max()) + 1)]
    return np.array([np.linalg.norm(np.ptp(points, axis=0)) for points in ends])


def _check_holes(vertices: FloatArray, borders: Borders, facet: float) -> None:
    """Refuse holes that a sheet without holes would cover."""
    sizes = _sizes(vertices, borders)
    holes = [loop for loop in hole_loops(vertices, borders) if sizes[loop] > HOLE * facet]
    if holes:
        largest = max(holes, key=lambda loop: sizes[loop])
        middle = vertices[borders.edges[borders.loop == largest]].reshape(-1, 3).mean(axis=0)
        many = "a hole" if len(holes) == 1 else f"{len(holes)} holes, the largest"
        raise InputError(
            f"the target mesh has {many} around {place(middle)}, {sizes[largest]:.3g} from corner to corner: this "
            "pattern has none",
            hint="Fill it in the mesh; or take a pattern of kind grid, without trim: none, which is cut out where it "
            "is; or, where the target is a tube, one of kind tube with target: {axis: ..., mesh: ...}.",
        )


def place(point: FloatArray) -> str:
    """A point (3,) as messages name it."""
    return "(" + ", ".join(f"{k:.4g}" for k in point) + ")"


def _listed(numbers: FloatArray) -> str:
    shown = [f"{k:.3g}" for k in numbers[:4]]
    return ", ".join(shown) + (", ..." if len(numbers) > 4 else "")
