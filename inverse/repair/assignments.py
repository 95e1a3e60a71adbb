"""Mountains and valleys of a flat crease pattern: what the file says is checked, what it leaves open is searched.

Around a flat-foldable vertex of degree 4 with sector angles a, b, pi - a, pi - b (the k-th after crease k) and
half-angle tangents t_k there are two ways to fold, each up to the exchange of mountain and valley:

    t2 = t0, t3 = -t1, t1 / t0 = -cos((a + b) / 2) / cos((a - b) / 2)
    t3 = t1, t2 = -t0, t1 / t0 =  sin((a + b) / 2) / sin((a - b) / 2)

so that |t| is one number along a whole line of creases, and the ratio of two lines is known where they cross.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.origami.pattern import Design, Pattern
from inverse.repair.foreign import Pair, pair_of
from inverse.repair.line_types import lines_of_edges, ring_angles

SMALLEST_RATIO = 0.01  # |t1 / t0| and its inverse: beyond it two of the four creases hardly fold
# Of the logarithms of ratios, while the search compares ways to reach the same line: what fits a pattern exactly is
# preferred to what fits it nearly.
AGREEMENTS = (1e-6, 1e-3, 0.1)
MOST_TRIALS = 200_000


@dataclass(frozen=True)
class Way:
    """One way to fold a vertex.

    Attributes:
        signs: of its four creases in ring order, +1 valley, -1 mountain.
        log_ratio: logarithm of |t1 / t0|.
    """

    signs: tuple[int, int, int, int]
    log_ratio: float


@dataclass(frozen=True, eq=False)
class Folding:
    """Signs of all creases, and the half-angle tangents up to a common factor.

    Attributes:
        tangents: (E,) signed tan(rho / 2) of every edge, geometric mean of the largest and least 1; 0 on the border.
        searched: the file left mountains and valleys open, and they were chosen.
        disagreement: (I,) by how much the logarithm of the ratio of two lines is off where they cross.
    """

    tangents: FloatArray
    searched: bool
    disagreement: FloatArray


def foldings(design: Design, assignments: dict[Pair, str], file_vertices: IntArray) -> Folding:
    """The one-parameter motion of a flat crease pattern.

    Args:
        design: laid out in the plane z = 0, counter-clockwise.
        assignments: M or V of edges, as far as they are given.
        file_vertices: (V,) numbers of the vertices in messages.

    Raises:
        InputError: mountains and valleys that cannot be folded at a vertex, or that no choice makes consistent.
    """
    pattern = design.pattern
    given = np.zeros(len(pattern.edges_vertices), np.int64)
    for e in pattern.interior_edges.tolist():
        a, b = pattern.edges_vertices[e].tolist()
        given[e] = {"M": -1, "V": 1}.get(assignments.get(pair_of(a, b), ""), 0)
    ways = _ways(design, given, file_vertices)
    line_of = lines_of_edges(pattern)
    order = _order(pattern, line_of)
    found = None
    for agreement in AGREEMENTS:
        found = found or _searched(pattern, ways, given, line_of, order, agreement)
    if found is None:
        raise InputError(
            "no mountains and valleys were found with which this pattern folds as one rigid mechanism",
            hint="A line of creases opens and closes with one ratio to every line it crosses. If the pattern does, "
            "give edges_assignment (M and V) in the file.",
        )
    signs, chosen = found
    # A line without interior vertices on it, or what no vertex settles, folds as a valley.
    signs = np.where((signs == 0) & (line_of >= 0), 1, signs)
    log_size, disagreement = _sizes(pattern, line_of, chosen)
    tangents = np.zeros(len(given))
    inner = line_of >= 0
    tangents[inner] = signs[inner] * np.exp(log_size[line_of[inner]])
    return Folding(tangents, bool((given[inner] == 0).any()), disagreement)


def _ways(design: Design, given: IntArray, file_vertices: IntArray) -> list[list[Way]]:
    """The ways to fold every interior vertex that the given mountains and valleys allow."""
    pattern = design.pattern
    theta = ring_angles(pattern, design.vertices_coords)
    # Half of the error of opposite angles each, so that small ones cancel to first order.
    a, b = ((theta[:, k] + np.pi - theta[:, k + 2]) / 2 for k in (0, 1))
    ways = []
    for k, ring in enumerate(pattern.ring_edges):
        vertex = file_vertices[pattern.interior_vertices[k]]
        half_sum, half_difference = (a[k] + b[k]) / 2, (a[k] - b[k]) / 2
        sides = (-np.cos(half_sum), np.cos(half_difference)), (np.sin(half_sum), np.sin(half_difference))
        possible = []
        for alike, (over, under) in zip((0, 1), sides, strict=True):
            if min(abs(over), abs(under)) < SMALLEST_RATIO * max(abs(over), abs(under)):
                continue
            s = 1 if over * under > 0 else -1
            one = (1, s, 1, -s) if alike == 0 else (1, s, -1, s)
            size = float(np.log(abs(over)) - np.log(abs(under)))
            possible += [Way(one, size), Way((-one[0], -one[1], -one[2], -one[3]), size)]
        words = given[ring]
        if (words != 0).all() and abs(words.sum()) != 2:
            mountains = int((words < 0).sum())
            raise InputError(
                f"vertex {vertex} has {mountains} mountains and {4 - mountains} valleys: they must differ by 2 "
                "(Maekawa)"
            )
        ways.append([way for way in possible if all(w in (0, s) for w, s in zip(words, way.signs, strict=True))])
        if not possible:
            raise InputError(f"vertex {vertex} cannot fold: its creases cross at right angles")
        if not ways[-1]:
            raise InputError(
                f"the mountains and valleys at vertex {vertex} cannot fold: the two creases of its smallest sector "
                "angle must differ, or two of its creases would stay flat"
            )
    return ways


def _order(pattern: Pattern, line_of: IntArray) -> list[int]:
    """Interior vertices so that each comes as soon as its lines are known: choices are tested at once."""
    crossing = line_of[pattern.ring_edges[:, :2]]
    left = list(range(len(crossing)))
    neighbours: dict[int, list[int]] = {k: [] for k in left}
    number = {v: k for k, v in enumerate(pattern.interior_vertices.tolist())}
    for k, ring in enumerate(pattern.ring_vertices.tolist()):
        neighbours[k] = [number[v] for v in ring if v in number]
    order: list[int] = []
    known: set[int] = set()
    placed: set[int] = set()
    rim: set[int] = set()
    while len(order) < len(left):
        rim -= placed
        if not rim:
            rim = {next(k for k in left if k not in placed)}
        at = max(sorted(rim), key=lambda k: sum(line in known for line in crossing[k].tolist()))
        order.append(at)
        placed.add(at)
        known |= set(crossing[at].tolist())
        rim |= set(neighbours[at])
    return order


def _searched(
    pattern: Pattern, ways: list[list[Way]], given: IntArray, line_of: IntArray, order: list[int], agreement: float
) -> tuple[IntArray, list[Way]] | None:
    """Depth-first: a way for every vertex that agrees in signs and in sizes with those before it, or None.

    Where the file leaves no choice anywhere, sizes are not compared: a pattern drawn inexactly has them nearly right,
    and its errors are reported afterwards.
    """
    compare = any(len(options) > 1 for options in ways)
    lines = line_of[pattern.ring_edges[:, :2]].tolist()
    taken = _Taken(pattern.ring_edges.tolist(), lines, given.copy(), agreement if compare else np.inf)
    untried: list[list[Way]] = []
    trials = 0
    while len(taken.steps) < len(order):
        depth = len(taken.steps)
        k = order[depth]
        if len(untried) == depth:
            untried.append([way for way in reversed(ways[k]) if taken.admits(k, way)])
        if untried[-1] and trials < MOST_TRIALS:
            trials += 1
            taken.take(k, untried[-1].pop())
            continue
        if depth == 0 or trials >= MOST_TRIALS:
            return None
        untried.pop()
        taken.undo()
    chosen = {step.vertex: step.way for step in taken.steps}
    return taken.sign, [chosen[k] for k in range(len(ways))]


@dataclass(frozen=True)
class _Step:
    """A way taken at a vertex, and what it decided: edges and lines that were open before."""

    vertex: int
    way: Way
    edges: list[int]
    lines: list[int]


@dataclass
class _Taken:
    """Ways taken so far, with the signs of edges and the sizes of lines that follow from them."""

    rings: list[list[int]]
    lines: list[list[int]]
    sign: IntArray
    agreement: float
    size: dict[int, float] = field(default_factory=dict)
    steps: list[_Step] = field(default_factory=list)

    def admits(self, k: int, way: Way) -> bool:
        """Whether a way at vertex k agrees with those taken."""
        if any(self.sign[e] not in (0, s) for e, s in zip(self.rings[k], way.signs, strict=True)):
            return False
        a, b = self.lines[k]
        if a == b:
            return abs(way.log_ratio) <= self.agreement
        if a not in self.size or b not in self.size:
            return True
        return abs(self.size[b] - self.size[a] - way.log_ratio) <= self.agreement

    def take(self, k: int, way: Way) -> None:
        """Take a way at vertex k."""
        edges = [e for e in self.rings[k] if self.sign[e] == 0]
        for e, s in zip(self.rings[k], way.signs, strict=True):
            self.sign[e] = s
        a, b = self.lines[k]
        lines = []
        if a not in self.size and b not in self.size:
            self.size[a] = 0.0
            lines.append(a)
        if a not in self.size:
            self.size[a] = self.size[b] - way.log_ratio
            lines.append(a)
        if b not in self.size:
            self.size[b] = self.size[a] + way.log_ratio
            lines.append(b)
        self.steps.append(_Step(k, way, edges, lines))

    def undo(self) -> None:
        """Take the last way back."""
        step = self.steps.pop()
        self.sign[step.edges] = 0
        for line in step.lines:
            del self.size[line]


def _sizes(pattern: Pattern, line_of: IntArray, chosen: list[Way]) -> tuple[FloatArray, FloatArray]:
    """Least-squares logarithms of |t| of every line, centred, and what each vertex disagrees by."""
    n_lines, n = len(pattern.lines), len(chosen)
    table = np.zeros((n, n_lines))
    first, second = line_of[pattern.ring_edges[:, :2]].T
    np.add.at(table, (np.arange(n), second), 1.0)
    np.add.at(table, (np.arange(n), first), -1.0)
    ratios = np.array([way.log_ratio for way in chosen])
    sizes = np.linalg.lstsq(table, ratios, rcond=None)[0] if n else np.zeros(n_lines)
    sizes = sizes - (sizes.max() + sizes.min()) / 2
    return np.asarray(sizes), np.abs(table @ sizes - ratios)
