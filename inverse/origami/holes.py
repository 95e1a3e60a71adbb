"""One closed strip of facets around each hole: the generators of the first homology."""

from __future__ import annotations

from collections import deque

from inverse.origami.pattern import B, Pattern


def hole_strips(pattern: Pattern) -> tuple[tuple[int, ...], ...]:
    """The shortest closed facet strip around each hole and around no other one.

    Args:
        pattern: a disk (no strips), a cylinder (one) or a disk with holes.

    Returns:
        For each hole the facets in order; the last shares an edge with the first.
    """
    if pattern.n_holes == 0:
        return ()
    loops = boundary_loops(pattern)
    loops.sort(key=len)
    outer = loops.pop()
    cuts = [_cut(pattern, loop, outer) for loop in loops]
    crossing = {edge: h for h, cut in enumerate(cuts) for edge in cut}
    # A facet pair is crossed positively when it leads to the cut's left side.
    steps: list[list[tuple[int, int, int]]] = [[] for _ in pattern.faces_vertices]
    for edge in pattern.interior_edges.tolist():
        left, right = pattern.edges_faces[edge].tolist()
        pair = tuple(pattern.edges_vertices[edge].tolist())
        sign, hole = 0, -1
        for direction, value in ((pair, 1), (pair[::-1], -1)):
            if direction in crossing:
                sign, hole = value, crossing[direction]
        steps[right].append((left, hole, sign))
        steps[left].append((right, hole, -sign))
    return tuple(_shortest(pattern, steps, cut, h, len(cuts)) for h, cut in enumerate(cuts))


def boundary_loops(pattern: Pattern) -> list[list[int]]:
    """Vertices along every border, with the facets on the left."""
    onward = dict(pattern.edges_vertices[pattern.edges_type == B].tolist())
    loops = []
    while onward:
        start, at = onward.popitem()
        loop = [start]
        while at != start:
            loop.append(at)
            at = onward.pop(at)
        loops.append(loop)
    return loops


def _cut(pattern: Pattern, hole: list[int], outer: list[int]) -> list[tuple[int, int]]:
    """Directed interior edges of a shortest path from a hole's boundary to the outer one."""
    neighbours: dict[int, list[int]] = {}
    for a, b in pattern.edges_vertices[pattern.interior_edges].tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    before = {v: v for v in hole}
    queue, goal = deque(sorted(hole)), set(outer)
    while queue:
        at = queue.popleft()
        if at in goal:
            path = []
            while before[at] != at:
                path.append((before[at], at))
                at = before[at]
            return path[::-1]
        for other in neighbours.get(at, []):
            if other not in before:
                before[other] = at
                queue.append(other)
    return []


def _shortest(
    pattern: Pattern, steps: list[list[tuple[int, int, int]]], cut: list[tuple[int, int]], hole: int, n_holes: int
) -> tuple[int, ...]:
    zero = (0,) * n_holes
    goal = tuple(int(h == hole) for h in range(n_holes))
    best: tuple[int, ...] = ()
    for edge in cut:
        start = int(pattern.edges_faces[pattern.edge_between[frozenset(edge)], 0])
        before: dict[tuple[int, tuple[int, ...]], tuple[int, tuple[int, ...]]] = {}
        queue = deque([(start, zero)])
        while queue and (start, goal) not in before:
            state = queue.popleft()
            for face, crossed, sign in steps[state[0]]:
                winding = tuple(w + sign * (h == crossed) for h, w in enumerate(state[1]))
                if max(map(abs, winding)) <= 1 and (face, winding) not in before:
                    before[face, winding] = state
                    queue.append((face, winding))
        if (start, goal) in before:
            strip, state = [], before[start, goal]
            while state != (start, zero):
                strip.append(state[0])
                state = before[state]
            strip.append(start)
            if not best or len(strip) < len(best):
                best = tuple(strip[::-1])
    return best
