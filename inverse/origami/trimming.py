"""Grids without some of their facets: networks over outlines that are no rectangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from inverse._types import IntArray
from inverse.origami.pattern import Design, Pattern

Mask = NDArray[np.bool_]


def in_one_piece(wanted: Mask) -> Mask:
    """The facets of a grid, near to those wanted, that move together.

    Facets that share an edge turn about it freely unless an interior vertex at one of its ends couples their fold to
    others. So only facets around interior vertices stay, and of these vertices the largest number that edges join.
    Where two facets would meet in a corner alone, their neighbours stay as well.

    Args:
        wanted: (m, n) of the grid's facets.

    Returns:
        (m, n); none at all where no four facets around a vertex are wanted.
    """
    kept = np.array(wanted, bool)
    while True:
        kept = _coupled(kept)
        filled = _without_point_contacts(kept)
        if (filled == kept).all():
            return kept
        kept = filled


def trimmed(design: Design, kept: Mask) -> Design:
    """A grid without some of its facets; vertices keep their order and places.

    Args:
        design: a grid.
        kept: (m, n) of its facets.

    Returns:
        A network of facets, no longer numbered as a grid.
    """
    pattern = design.pattern
    faces = [face for face, stays in zip(pattern.faces_vertices, kept.ravel(), strict=True) if stays]
    used = np.unique(np.array(faces))
    number = np.full(pattern.n_vertices, -1)
    number[used] = np.arange(len(used))

    def types(edges: IntArray) -> NDArray[np.int8]:
        whole = pattern.edge_between
        return pattern.edges_type[[whole[frozenset(pair)] for pair in used[edges].tolist()]]

    own = Pattern.from_faces([number[list(face)].tolist() for face in faces], len(used), types)
    return Design(own, design.vertices_coords[used], design.unit, design.name)


def _coupled(mask: Mask) -> Mask:
    """Facets around the largest set of interior vertices that edges join."""
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


def _without_point_contacts(mask: Mask) -> Mask:
    """With the neighbours of facets that meet in a corner alone."""
    a, b, c, d = mask[:-1, :-1], mask[1:, :-1], mask[:-1, 1:], mask[1:, 1:]
    corner = (a & d & ~b & ~c) | (b & c & ~a & ~d)
    found = mask.copy()
    for i in (0, 1):
        for j in (0, 1):
            found[i : found.shape[0] - 1 + i, j : found.shape[1] - 1 + j] |= corner
    return found
