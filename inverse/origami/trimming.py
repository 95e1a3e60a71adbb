"""Meshes without some of their facets: networks over outlines that are no rectangles, or around holes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from inverse._types import IntArray
from inverse.origami.pattern import Design, Pattern

Mask = NDArray[np.bool_]


def in_one_piece(wanted: Mask) -> Mask:
    """The facets of a grid, near to those wanted, that move together.

    Facets that share an edge turn about it freely unless an interior vertex at one of its ends couples their fold to
    others. So only facets around interior vertices stay, and of these vertices the largest number that edges join.
    Where two facets would meet in a corner alone, one of them goes.

    Args:
        wanted: (m, n) of the grid's facets.

    Returns:
        (m, n); none at all where no four facets around a vertex are wanted.
    """
    kept = _coupled(np.array(wanted, bool))
    while len(contacts := _point_contacts(kept)):
        kept[tuple(contacts[0])] = False  # one at a time: others may go with it
        kept = _coupled(kept)
    return kept


def part_of(design: Design, kept: Mask) -> Design:
    """A mesh without some of its facets; vertices keep their order and places.

    Args:
        design: a mesh.
        kept: (F,) of its facets.

    Returns:
        A network of facets, not numbered as a grid.
    """
    pattern, used = without(design.pattern, np.flatnonzero(~kept))
    return Design(pattern, design.vertices_coords[used], design.unit, design.name)


def without(pattern: Pattern, facets: IntArray) -> tuple[Pattern, IntArray]:
    """A pattern without some of its facets.

    Args:
        pattern: the whole pattern.
        facets: (k,) int, those left out.

    Returns:
        The rest, and for each of its vertices (V,) the number it has in the whole.
    """
    left = set(facets.tolist())
    faces = [face for f, face in enumerate(pattern.faces_vertices) if f not in left]
    used = np.unique(np.fromiter((v for face in faces for v in face), np.int64))
    number = np.full(pattern.n_vertices, -1)
    number[used] = np.arange(len(used))

    def types(edges: IntArray) -> NDArray[np.int8]:
        whole = pattern.edge_between
        return pattern.edges_type[[whole[frozenset(pair)] for pair in used[edges].tolist()]]

    return Pattern.from_faces([number[list(face)].tolist() for face in faces], len(used), types), used


def _coupled(mask: Mask) -> Mask:
    """Facets around the largest set of interior vertices that edges join."""
    from scipy.ndimage import label

    inner = mask[:-1, :-1] & mask[1:, :-1] & mask[:-1, 1:] & mask[1:, 1:]
    names, count = label(inner)
    if count == 0:
        return np.zeros_like(mask)
    largest = names == 1 + np.argmax(np.bincount(names.ravel())[1:])
    found = np.zeros_like(mask)
    for i in (0, 1):
        for j in (0, 1):
            found[i : found.shape[0] - 1 + i, j : found.shape[1] - 1 + j] |= largest
    return found


def _point_contacts(mask: Mask) -> IntArray:
    """Facets (k, 2) that meet another one in a corner alone, one of each two."""
    a, b, c, d = mask[:-1, :-1], mask[1:, :-1], mask[:-1, 1:], mask[1:, 1:]
    falling = np.argwhere(b & c & ~a & ~d)
    return np.concatenate([np.argwhere(a & d & ~b & ~c), falling + np.array([1, 0])])
