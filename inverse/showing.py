"""What a specification asks for, drawn before it is solved: the placed seed with its sides, numbers and anchors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from inverse._types import FloatArray, IntArray
from inverse.formulation.anchors import sides_of
from inverse.formulation.formulate import Formulation, formulate, keep_out_plane
from inverse.formulation.places import Flat, Path, Place, Ring, Spot, across
from inverse.origami.holes import boundary_loops
from inverse.pictures.colours import INK
from inverse.pictures.plan import Dot, Drawing, Line, Word, scale_bar, wrapped
from inverse.spec import Anchor, Loaded

SIDES = {"u0": "#d1495b", "u1": "#8f2d56", "v0": "#1b7f79", "v1": "#2f5d9b"}
ANCHORS = ("#e08e0b", "#7a5195", "#3c8d2f", "#0b84a5", "#b0413e", "#5c5c8a")
MESH, TARGET, TARGET_FILL, BARRED = "#b9b2a6", "#2f7fb5", "#eaf3f9", "#8a8a86"
WIDTH, DRAWN, MARGIN, HEAD, LINE = 1500, (1260.0, 900.0), 120.0, 150.0, 20.0
DENSE = 26.0  # pixels between vertices below which only those of the rim get numbers
UPRIGHT = 0.2  # upwards part of the normals of planes that are drawn as a line
OUTSIDE = 52  # pixels from a side to its name
LETTERS = 190  # in a line of the legend


@dataclass(frozen=True)
class Shown:
    """A seed with what holds it.

    Attributes:
        drawing: the plan.
        table: sides with the numbers of their vertices, and what every anchor holds, as lines of text.
        notes: sentences about vertices that several anchors name.
    """

    drawing: Drawing
    table: list[str]
    notes: tuple[str, ...]


def shown(loaded: Loaded) -> Shown:
    """Draw the placed seed of a specification, and tell the numbers of its vertices.

    Args:
        loaded: the specification.

    Raises:
        InputError: what solving would refuse.
    """
    formulation = formulate(loaded)
    table = _table(loaded, formulation)
    return Shown(_Plan(loaded, formulation).drawn(table), table, formulation.anchored.notes)


def _table(loaded: Loaded, formulation: Formulation) -> list[str]:
    """Sides and anchors with their vertices."""
    pattern = formulation.goal.model.pattern
    sides = sorted(sides_of(pattern).items())
    lines = [f"side {name}: vertices {_run(line[0])}" for name, line in sides if name != "ends"]
    if not lines:
        rim = [v for loop in boundary_loops(pattern) for v in loop]
        lines.append(f"no sides; {len(rim)} vertices on the rim: {_run(np.array(rim))}")
    anchored = formulation.anchored
    for k, anchor in enumerate(loaded.specification.constraints.anchors):
        names = anchor.side or "vertices"
        lines.append(f"anchor {k}: {names} on a {_kind(anchor)}, holds {_run(anchored.held[k])}")
    if anchored.walls:
        parts = sum(len(wall.vertices) < pattern.n_vertices for wall in anchored.walls)
        rest = f"; for {parts} of them this holds for the vertices beside it only" if parts else ""
        lines.append(f"walls: {len(anchored.walls)}, behind which no vertex may be{rest}")
    return lines


def _kind(anchor: Anchor) -> str:
    return next(name for name in type(anchor.to).one_of if getattr(anchor.to, name) is not None)


def _run(vertices: IntArray) -> str:
    """Numbers in words: first, second to last where they are evenly spaced."""
    numbers = vertices.tolist()
    steps = set(np.diff(vertices).tolist())
    if len(numbers) > 5 and len(steps) == 1:
        return f"{numbers[0]}, {numbers[1]}, ... {numbers[-1]} (step {steps.pop()})"
    if len(numbers) > 12:
        return f"{', '.join(map(str, numbers[:6]))}, ... {', '.join(map(str, numbers[-3:]))} ({len(numbers)})"
    return ", ".join(map(str, numbers)) or "none"


class _Plan:
    """The plan of one task.

    Args:
        loaded: the specification.
        formulation: the same, understood.
    """

    def __init__(self, loaded: Loaded, formulation: Formulation) -> None:
        self.loaded, self.anchored = loaded, formulation.anchored
        goal = formulation.goal
        self.seed, self.target, self.origin = goal.model.seed, goal.target, goal.origin
        axes = self.target.frame.axes
        self.from_above = abs(axes[2, 2]) > 0.7
        self.axes = np.eye(3)[:2] if self.from_above else axes[:2]
        vertices, triangles = self.target.triangles()
        self.triangles = triangles
        self.surface = vertices
        low, high = self._extent()
        self.scale = float(min(DRAWN[0] / (high - low)[0], DRAWN[1] / (high - low)[1]))
        self.low, self.high = low, high
        size = self.scale * (high - low)
        self.left, self.base = (WIDTH - size[0]) / 2 - self.scale * low[0], HEAD + size[1] + self.scale * low[1]
        self.bottom = HEAD + size[1] + 90

    def _extent(self) -> tuple[FloatArray, FloatArray]:
        """The corners of what is shown, (2,) each, in lengths: seed, target, and what anchors are near by."""
        points = np.concatenate([self.seed.vertices_coords, self.surface]) @ self.axes.T
        low, high = points.min(axis=0), points.max(axis=0)
        room = 0.25 * (high - low).max()
        for place in self.anchored.places:
            own = _outline(place) @ self.axes.T
            if len(own) and (own > low - room).all() and (own < high + room).all():
                low, high = np.minimum(low, own.min(axis=0)), np.maximum(high, own.max(axis=0))
        return low, high

    def at(self, points: FloatArray) -> FloatArray:
        """Pixels (n, 2) of points (n, 3)."""
        flat = np.atleast_2d(points) @ self.axes.T
        return np.column_stack([self.left + self.scale * flat[:, 0], self.base - self.scale * flat[:, 1]])

    def drawn(self, table: Sequence[str]) -> Drawing:
        """The page.

        Args:
            table: lines of the legend.
        """
        page = Drawing(f"{self.seed.name}: placed seed", WIDTH, 0)
        self._surface(page)
        self._planes(page)
        points, pattern = self.at(self.seed.vertices_coords), self.seed.pattern
        page.marks += [Line(points[edge], MESH, 1.0) for edge in pattern.edges_vertices]
        for loop in boundary_loops(pattern):
            page.marks.append(Line(points[[*loop, loop[0]]], INK, 1.6))
        self._sides(page, points)
        self._anchors(page, points)
        self._numbers(page, points)
        self._words(page, table)
        return page

    def _surface(self, page: Drawing) -> None:
        """The target: the area within its rim; of tubes and closed surfaces the outline that is seen."""
        rim = _rim(self.triangles) if self.seed.pattern.n_holes == 0 else []
        for loop in rim:
            page.marks.append(Line(self.at(self.surface[loop]), TARGET, 1.4, TARGET_FILL))
        if not rim:
            flat = self.at(self.surface)
            page.marks += [Line(flat[edge], TARGET, 1.4) for edge in _outlines(flat, self.triangles)]

    def _planes(self, page: Drawing) -> None:
        """Keep-outs, walls and planes of anchors as lines, hatched where the design may not be."""
        for keep_out in self.loaded.specification.constraints.keep_out:
            self._trace(page, keep_out_plane(keep_out, self.origin), BARRED, hatched=True)
        for k, place in enumerate(self.anchored.places):
            if isinstance(place, Flat):
                self._trace(page, place, ANCHORS[k % len(ANCHORS)], hatched=False)
        for wall in self.anchored.walls:
            if len(wall.vertices) < self.seed.pattern.n_vertices:
                continue  # it bounds what is beside it, and no line tells how far
            self._trace(page, wall.plane, BARRED, hatched=True)

    def _trace(self, page: Drawing, plane: Flat, colour: str, *, hatched: bool) -> None:
        """A plane that is seen as a line, with hatches on the side that its normal does not point to."""
        normal = self.axes @ plane.normal
        size = float(np.linalg.norm(normal))
        if size < 1 - UPRIGHT:
            return
        normal = normal / size
        along, foot = np.array([-normal[1], normal[0]]), self.axes @ plane.point
        room = 40 / self.scale
        middle = (self.low + self.high) / 2
        foot = foot + ((middle - foot) @ along) * along
        half = float(np.abs(along) @ (self.high - self.low)) / 2 + room
        ends = foot + np.outer([-half, half], along)
        if not ((foot > self.low - 3 * room) & (foot < self.high + 3 * room)).all():
            return
        pixels = np.column_stack([self.left + self.scale * ends[:, 0], self.base - self.scale * ends[:, 1]])
        page.marks.append(Line(pixels, colour, 2.0))
        if hatched:
            step, behind = pixels[1] - pixels[0], np.array([-normal[0], normal[1]])
            length = float(np.linalg.norm(step))
            for t in np.arange(6.0, length, 14.0):
                start = pixels[0] + t / length * step
                page.marks.append(Line(np.stack([start, start + 9 * behind + 6 * step / length]), colour, 1.0))

    def _sides(self, page: Drawing, points: FloatArray) -> None:
        centre = points.mean(axis=0)
        for name, lines in sides_of(self.seed.pattern).items():
            if name == "ends":
                continue
            line = points[lines[0]]
            page.marks.append(Line(line, SIDES[name], 3.0))
            middle = line.mean(axis=0)
            way = _away(middle, centre, line[-1] - line[0])
            reach = float(((line - middle) @ way).max())  # of a zigzag
            page.marks.append(Word(name, middle + (OUTSIDE + reach) * way, 22, SIDES[name], is_bold=True))

    def _anchors(self, page: Drawing, points: FloatArray) -> None:
        for k, place in enumerate(self.anchored.places):
            colour, outline = ANCHORS[k % len(ANCHORS)], _outline(place)
            if isinstance(place, Spot):
                x, y = self.at(outline)[0]
                page.marks += [Line(np.array([[x - 9, y + d], [x + 9, y - d]]), colour, 2.0) for d in (9, -9)]
            elif len(outline):
                page.marks.append(Line(self.at(outline), colour, 3.0, dash=9.0))
        owners: dict[int, list[int]] = {}
        for k, held in enumerate(self.anchored.held):
            for vertex in held.tolist():
                owners.setdefault(vertex, []).append(k)
        for vertex, by in owners.items():
            radius = 5.0
            for k in reversed(by):  # rings for those that several anchors hold
                page.marks.append(Dot(points[vertex], radius + 3.0 * by.index(k), ANCHORS[k % len(ANCHORS)]))

    def _numbers(self, page: Drawing, points: FloatArray) -> None:
        """Numbers of all vertices, of those on the rim if there are too many; those in corners with both indices."""
        pattern, centre = self.seed.pattern, points.mean(axis=0)
        spacing = float(np.median(np.linalg.norm(np.diff(points[pattern.edges_vertices], axis=1), axis=2)))
        loops = boundary_loops(pattern)
        rim = {v for loop in loops for v in loop}
        corners = _corners(pattern.grid, pattern.n_holes)
        size = float(np.clip(0.42 * spacing, 8.0, 13.0))
        words: list[Word] = []
        for vertex, (i, j) in corners.items():
            place = points[vertex] + np.sign(points[vertex] - centre) * [46, 26]
            words.append(Word(f"{vertex} = ({i}, {j})", place, 15, is_bold=True))
        for loop in loops:
            for place, vertex in enumerate(loop):
                chord = points[loop[(place + 1) % len(loop)]] - points[loop[place - 1]]
                way = _away(points[vertex], centre, chord)
                if vertex not in corners:
                    words.append(Word(str(vertex), points[vertex] + (10 + size) * way, size))
        if spacing >= DENSE:
            depth = self.seed.vertices_coords @ np.cross(*self.axes)
            for vertex in np.argsort(-depth, kind="stable").tolist():
                if vertex not in rim:
                    words.append(Word(str(vertex), points[vertex] - [0, 0.6 * size], 0.85 * size, "#77716a"))
        taken = np.empty((0, 2))
        for word in words:  # the first of several that would lie over each other
            apart = np.abs(taken - word.at) / [0.7 * word.size * len(word.text), 1.1 * word.size]
            if (apart.max(axis=1) >= 1).all():
                page.marks.append(word)
                taken = np.vstack([taken, word.at])

    def _words(self, page: Drawing, table: Sequence[str]) -> None:
        view = "from above" if self.from_above else "from the side"
        unit = "" if self.seed.unit == "unit" else f" {self.seed.unit}"
        page.marks.append(Word(self.seed.name, np.array([48.0, 38.0]), 22, is_centred=False, is_bold=True))
        told = f"The placed seed, seen {view}: not yet solved. Blue: the target. Dots: vertices that anchors hold."
        page.marks.append(Word(told, np.array([48.0, 66.0]), 14, is_centred=False))
        length = scale_bar(240 / self.scale)
        right, top = WIDTH - 60.0, 66.0
        ends = np.array([[right - length * self.scale, top], [right, top]])
        page.marks.append(Line(ends, INK, 2.0))
        page.marks.append(Word(f"{length:g}{unit}", ends.mean(axis=0) - [0, 14], 14))
        y = self.bottom
        for line in [*table, *self.anchored.notes]:
            word, _, rest = line.partition(" ")
            if word == "anchor":
                page.marks.append(Dot(np.array([56.0, y]), 6.0, ANCHORS[int(rest.split(":")[0]) % len(ANCHORS)]))
            elif word == "side":
                page.marks.append(Line(np.array([[48.0, y], [64.0, y]]), SIDES[line[5:7]], 3.0))
            for part in wrapped(line.split(", "), LETTERS):
                page.marks.append(Word(part, np.array([76.0, y]), 14, is_centred=False))
                y += LINE
        page.height = int(y + 20)


def _away(place: FloatArray, centre: FloatArray, along: FloatArray) -> FloatArray:
    """The unit vector (2,) across a direction that points away from a centre."""
    length = float(np.linalg.norm(along))
    if length == 0:
        return np.array([0.0, -1.0])
    way = np.array([along[1], -along[0]]) / length
    return np.asarray(way if (place - centre) @ way >= 0 else -way)


def _corners(grid: tuple[int, int] | None, n_holes: int) -> dict[int, tuple[int, int]]:
    """Corner vertices of a grid, or of the seam of a tube, with their indices."""
    if grid is None:
        return {}
    m, n = grid
    rows = (0, m) if n_holes == 0 else (0,)
    return {i * (n + 1) + j: (i, j) for i in rows for j in (0, n)}


def _outline(place: Place) -> FloatArray:
    """Points (n, 3) of what is drawn of a place; none of what has no end."""
    if isinstance(place, Spot):
        return place.at[None]
    if isinstance(place, Path):
        return place.points
    if isinstance(place, Ring):
        angle = np.linspace(0, 2 * np.pi, 65)[:, None]
        first, second = across(place.normal)
        return np.asarray(place.centre + place.radius * (np.cos(angle) * first + np.sin(angle) * second))
    return np.empty((0, 3))


def _outlines(flat: FloatArray, triangles: IntArray) -> IntArray:
    """Edges (n, 2) of a surface between triangles that are seen from the front and from behind, and on its rim.

    Args:
        flat: (V, 2) vertices as they are seen.
        triangles: (T, 3) int.
    """
    a, b, c = flat[triangles].transpose(1, 0, 2)
    front = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0] > 0
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    found, number = np.unique(edges, axis=0, return_inverse=True)
    fronts = np.bincount(number.ravel(), weights=np.tile(front, 3), minlength=len(found))
    count = np.bincount(number.ravel(), minlength=len(found))
    return np.asarray(found[(count == 1) | ((fronts > 0) & (fronts < count))])


def _rim(triangles: IntArray) -> list[IntArray]:
    """Closed loops of vertices along the border of a surface, the first again at the end."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    there = {tuple(edge) for edge in edges.tolist()}
    following = {a: b for a, b in there if (b, a) not in there}
    loops = []
    while following:
        start, here = next(iter(following.items()))
        loop = [start]
        while here in following and here != start:
            loop.append(here)
            here = following[here]
        for vertex in loop:
            following.pop(vertex, None)
        loops.append(np.array([*loop, start]))
    return loops
