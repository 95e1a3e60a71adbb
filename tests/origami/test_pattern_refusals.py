"""What is no pattern is refused, by the vertex, edge or facet where it is none."""

from __future__ import annotations

import numpy as np
import pytest
from designs import all_fl

from inverse.errors import InputError
from inverse.origami.pattern import CFL, FL, Pattern

QUADS = [[3 * i + j, 3 * i + j + 3, 3 * i + j + 4, 3 * i + j + 1] for i in range(2) for j in range(2)]


def quads(m: int, n: int, columns: int, *, around: bool = False) -> list[list[int]]:
    """Facets of a grid whose vertex (i, j) is i columns + j; both directions wrap around if asked to."""
    rows = m if around else m + 1

    def number(i: int, j: int) -> int:
        return (i % rows) * columns + j % columns

    corners = ((0, 0), (1, 0), (1, 1), (0, 1))
    return [[number(i + a, j + b) for a, b in corners] for i in range(m) for j in range(n)]


def refuse(faces: list[list[int]], n_vertices: int, match: str, types=all_fl) -> None:
    with pytest.raises(InputError, match=match):
        Pattern.from_faces(faces, n_vertices, types)


def test_no_facets() -> None:
    refuse([], 0, "no facets")


@pytest.mark.parametrize("face", [[0, 1], [0, 1, 0, 2], [0, 0, 1]])
def test_a_facet_without_three_vertices_is_named(face: list[int]) -> None:
    refuse([QUADS[0], face], 9, r"facet 1 has vertices \[0")


def test_a_vertex_that_is_not_there_is_named() -> None:
    refuse([*QUADS[:3], [4, 7, 9, 5]], 9, "vertex 9, but there are 9 vertices")


def test_a_negative_vertex_is_named() -> None:
    refuse([*QUADS[:3], [4, 7, -1, 5]], 9, "vertex -1")


def test_a_vertex_without_facets_is_named() -> None:
    refuse(QUADS, 10, "vertex 9 belongs to no facet")


def test_an_edge_of_three_facets_is_named() -> None:
    refuse([[0, 1, 2], [1, 0, 3], [0, 1, 4]], 5, "edge 0-1 belongs to more than two facets")


@pytest.mark.parametrize("flipped", range(4))
def test_a_flipped_facet_is_named_by_an_edge_of_it(flipped: int) -> None:
    faces = [face[::-1] if f == flipped else face for f, face in enumerate(QUADS)]
    with pytest.raises(InputError, match=r"edge (\d)-(\d) run along it in the same direction") as caught:
        Pattern.from_faces(faces, 9, all_fl)
    edge = {int(word) for word in caught.value.message.split("edge ")[1].split(" ")[0].split("-")}
    assert len(edge) == 2
    assert edge <= set(QUADS[flipped])


def test_a_moebius_strip() -> None:
    strip = quads(5, 1, 2)[:-1]
    refuse([*strip, [8, 1, 0, 9]], 10, "same direction")


@pytest.mark.parametrize("degree", [3, 5, 6])
def test_an_interior_vertex_of_another_degree_is_named(degree: int) -> None:
    fan = [[7, k, (k + 1) % degree] for k in range(degree)]
    number = {v: k for k, v in enumerate(sorted({v for face in fan for v in face}))}
    centre = number[7]
    faces = [[number[v] for v in face] for face in fan]
    refuse(faces, degree + 1, f"interior vertex {centre} has {degree} edges")


@pytest.mark.parametrize("line", [(3, 4), (4, 5), (1, 4), (4, 7)])
def test_a_line_that_changes_its_type_is_named_by_its_vertex(line: tuple[int, int]) -> None:
    def types(edges: np.ndarray) -> np.ndarray:
        return np.where((np.sort(edges, axis=1) == line).all(axis=1), CFL, FL).astype(np.int8)

    refuse(QUADS, 9, r"vertex 4 has edges .*CFL.*: opposite edges", types)


def test_a_surface_that_touches_itself_in_a_vertex() -> None:
    refuse([[0, 1, 2], [0, 3, 4]], 5, "around vertex 0 do not form one fan")
    two_facets_that_touch = [face for f, face in enumerate(quads(4, 4, 5)) if f not in (5, 10)]
    refuse(two_facets_that_touch, 25, "around vertex 12 do not form one fan")


def test_a_vertex_with_two_closed_fans() -> None:
    upper = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]]
    lower = [[v + 4 * (v > 0) for v in face] for face in upper]
    refuse(upper + lower, 9, "vertex 0 ")


def test_a_vertex_with_two_closed_fans_of_four_edges_together() -> None:
    refuse([[0, 1, 5, 2], [0, 2, 6, 1], [0, 3, 7, 4], [0, 4, 8, 3]], 9, "vertex 0 ")


def test_two_pieces() -> None:
    refuse([[0, 1, 2], [3, 4, 5]], 6, "in one piece|not connected")


def test_a_disk_beside_a_torus() -> None:
    """Boundary loops and Euler characteristic are those of a disk."""
    torus = quads(3, 4, 4, around=True)
    refuse([*torus, [12, 13, 14]], 15, "facet 12 is not connected to facet 0")


def test_closed_surfaces_and_handles() -> None:
    torus = quads(3, 4, 4, around=True)
    refuse(torus, 12, "0 boundary loops and Euler characteristic 0")
    octahedron = [[4, k, (k + 1) % 4] for k in range(4)] + [[5, (k + 1) % 4, k] for k in range(4)]
    refuse(octahedron, 6, "0 boundary loops and Euler characteristic 2")
    refuse(torus[1:], 12, "1 boundary loops and Euler characteristic -1")


@pytest.mark.parametrize(("kind", "word"), [(FL, "FL"), (CFL, "CFL")])
def test_an_odd_number_of_lines_round_a_hole(kind: int, word: str) -> None:
    """Five facets around, of whose axial lines one is of this kind: a flat state does not exist."""
    faces = [
        [3 * i + j, 3 * ((i + 1) % 5) + j, 3 * ((i + 1) % 5) + j + 1, 3 * i + j + 1] for i in range(5) for j in range(2)
    ]

    def types(edges: np.ndarray) -> np.ndarray:
        other = FL + CFL - kind
        axial = edges[:, 0] // 3 == edges[:, 1] // 3
        return np.where(axial & (edges[:, 0] // 3 == 2), kind, other).astype(np.int8)

    refuse(faces, 15, rf"the number of {word} lines around a hole is odd.* seen at edge \d+-\d+", types)
