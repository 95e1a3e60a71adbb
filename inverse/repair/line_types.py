"""Which lines of opposite edges are foldlines and which complementary ones, read off a semi-folded state."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.origami import geometry
from inverse.origami.pattern import CFL, EDGE_TYPE_NAMES, FL, Design, Pattern
from inverse.repair.foreign import Pair, pair_of

# Radians: where the sector angles prefer one reading by less than this, mountain and valley decide.
UNDECIDED = 0.02


def lines_of_edges(pattern: Pattern) -> IntArray:
    """(E,) int: number of the line in ``pattern.lines`` that each edge belongs to, -1 on the boundary."""
    found = np.full(len(pattern.edges_vertices), -1, np.int64)
    for number, edges in enumerate(pattern.lines_edges):
        found[list(edges)] = number
    return found


def ring_angles(pattern: Pattern, points: FloatArray) -> FloatArray:
    """Sector angles (I, 4) in radians around the interior vertices; the k-th lies after ring edge k."""
    spokes = points[pattern.ring_vertices] - points[pattern.interior_vertices][:, None]
    after = np.roll(spokes, -1, axis=1)
    sine = np.linalg.norm(np.cross(spokes, after), axis=2)
    return np.asarray(np.arctan2(sine, np.einsum("ikx,ikx->ik", spokes, after)))


def deduced(design: Design) -> IntArray:
    """Types (E,) of a semi-folded design's edges that its geometry calls for.

    Opposite sector angles are supplementary at a vertex of one type (Miura) and equal at one of two (Voss). Where
    both are nearly so, signs decide: at a Miura vertex three folds of four are mountains or three valleys; at a
    Voss vertex opposite folds are alike, so that the number of mountains is even. Every vertex votes whether its
    two lines are of the same type; the lines take the types that contradict the fewest votes by weight. Exchanging
    all FL and CFL of connected lines names the flat states the other way round and is as good: the reading with
    more foldlines is taken, the first line an FL where that is a tie.

    Args:
        design: in a semi-folded state; its types are not looked at.

    Raises:
        InputError: a line crosses itself at a vertex that calls for two types.
    """
    pattern = design.pattern
    line_of = lines_of_edges(pattern)
    votes = _votes(design)
    first, second = line_of[pattern.ring_edges[:, :2]].T
    alone = np.flatnonzero((first == second) & (votes < 0))
    if len(alone):
        vertex = pattern.interior_vertices[alone[0]]
        raise InputError(f"the line that crosses itself at vertex {vertex} would need two types there",
                         hint="Give the types in the file (bdffpq:edges_type).")  # fmt: skip
    n_lines = len(pattern.lines)
    weights = np.zeros((n_lines, n_lines))
    np.add.at(weights, (first, second), votes)
    weights = weights + weights.T
    np.fill_diagonal(weights, 0.0)
    sign = _two_colouring(weights)

    lengths = np.bincount(line_of[line_of >= 0], minlength=n_lines)
    for members in _components(weights != 0):
        balance = int(np.sum(sign[members] * lengths[members]))
        if balance < 0 or (balance == 0 and sign[members[0]] < 0):
            sign[members] *= -1
    types = np.zeros(len(line_of), np.int64)
    inner = line_of >= 0
    types[inner] = np.where(sign[line_of[inner]] > 0, FL, CFL)
    return types


def from_file(pattern: Pattern, words: dict[Pair, str]) -> IntArray | None:
    """Types (E,) that a file gives; None if it gives none.

    Raises:
        InputError: it types some interior edges only.
    """
    if not words:
        return None
    types = np.zeros(len(pattern.edges_vertices), np.int64)
    for e in pattern.interior_edges.tolist():
        a, b = pattern.edges_vertices[e].tolist()
        if pair_of(a, b) not in words:
            raise InputError(f"bdffpq:edges_type gives interior edge {a}-{b} no type: FL or CFL is needed",
                             hint="Leave the key out, and the types are deduced.")  # fmt: skip
        types[e] = EDGE_TYPE_NAMES.index(words[pair_of(a, b)])
    return types


def typed(pattern: Pattern, types: IntArray) -> Pattern:
    """The same network with these types (E,).

    Raises:
        InputError: a line changes its type, or a flat state does not exist.
    """
    known = {pair_of(a, b): t for (a, b), t in zip(pattern.edges_vertices.tolist(), types.tolist(), strict=True)}
    return Pattern.from_faces(
        pattern.faces_vertices,
        pattern.n_vertices,
        lambda edges: np.array([known[pair_of(a, b)] for a, b in edges.tolist()], np.int8),
        pattern.grid,
    )


def _votes(design: Design) -> FloatArray:
    """(I,) in radians: by how much each vertex prefers lines of the same type; negative for different types."""
    pattern, points = design.pattern, design.vertices_coords
    theta = ring_angles(pattern, points)
    sums, differences = theta[:, :2] + theta[:, 2:] - np.pi, theta[:, :2] - theta[:, 2:]
    votes = np.abs(differences).max(axis=1) - np.abs(sums).max(axis=1)
    folds = geometry.fold_angles(pattern, points)[pattern.ring_edges]
    # The product of all four signs: negative where the numbers of mountains and of valleys are odd.
    parity = -np.sign(folds).prod(axis=1)
    return np.asarray(np.where(np.abs(votes) < UNDECIDED, UNDECIDED * parity, votes))


def _two_colouring(weights: FloatArray) -> IntArray:
    """Signs (n,) for which the sum of weights[i, j] s_i s_j is large: strongest links first, then single changes."""
    n = len(weights)
    sign, group = np.ones(n, np.int64), np.arange(n)
    i, j = np.triu(weights).nonzero()
    for k in np.argsort(-np.abs(weights[i, j]), kind="stable").tolist():
        a, b = i[k], j[k]
        if group[a] != group[b]:
            members = group == group[b]
            if weights[a, b] * sign[a] * sign[b] < 0:
                sign[members] *= -1
            group[members] = group[a]
    # Each change makes the sum larger, so this ends.
    while (gain := -sign * (weights @ sign)).max(initial=0.0) > 1e-12:
        sign[np.argmax(gain)] *= -1
    return sign


def _components(linked: np.ndarray) -> list[list[int]]:
    """Connected sets of a graph given by its (n, n) bool matrix, members in rising order."""
    left = set(range(len(linked)))
    found = []
    while left:
        start = min(left)
        reached, queue = {start}, deque([start])
        while queue:
            for other in np.flatnonzero(linked[queue.popleft()]).tolist():
                if other not in reached:
                    reached.add(other)
                    queue.append(other)
        left -= reached
        found.append(sorted(reached))
    return found


def words_of(given: Sequence[str], count: int, name: str) -> list[int]:
    """Types of ``count`` lines from one word for all, or one for each."""
    words = [word.strip().upper() for word in given]
    for word in words:
        if word not in ("FL", "CFL"):
            raise InputError(f"{name} has {word!r}: allowed are FL and CFL",
                             hint=f"Write {name} FL, or one word for each line: {name} FL,CFL,...")  # fmt: skip
    if len(words) == 1:
        words *= count
    if len(words) != count:
        raise InputError(f"{name} has {len(words)} words, but the grid has {count} interior lines there",
                         hint="Give one word for all lines, or one for each.")  # fmt: skip
    return [EDGE_TYPE_NAMES.index(word) for word in words]
