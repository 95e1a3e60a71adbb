"""Light, shade and edges of what the 3D pictures show."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from inverse._types import FloatArray, IntArray
from inverse.origami import geometry
from inverse.origami.pattern import Pattern
from inverse.pictures import colours
from inverse.pictures.scene import Facets, Lines, cells_of


def light_of(view: FloatArray) -> FloatArray:
    """Unit vector (3,) to the light: high, on the left of the viewer, who looks along ``-view[2]``."""
    towards = np.array([view[2, 0], view[2, 1], 0.0])
    light = -0.75 * view[0] + 0.2 * towards / np.linalg.norm(towards) + np.array([0.0, 0.0, 0.9])
    return np.asarray(light / np.linalg.norm(light))


def sun_of(view: FloatArray) -> FloatArray:
    """Direction (3,) to the light that throws the shadows: higher, so that they are as short as about noon."""
    return np.asarray(light_of(view) + np.array([0.0, 0.0, 1.2]))


def structure(
    pattern: Pattern,
    points: FloatArray,
    view: FloatArray,
    eye: FloatArray | None,
    pixel: float,
    sides: tuple[colours.Shades, colours.Shades],
    *,
    faint: float = 0.0,
) -> tuple[Facets, Lines]:
    """Facets and edges of a mesh.

    Args:
        pattern: the mesh.
        points: (V, 3) vertices.
        view: right, up and towards the viewer.
        eye: (3,) position of the viewer, None if far away.
        pixel: length of a pixel.
        sides: colours of the top side and of the other one.
        faint: from 0 to 1, how faintly edges are drawn: for stacks of layers that they would blacken.
    """
    normals = geometry.facet_normals(pattern, points)
    gaze = view[2] if eye is None else eye - geometry.facet_centroids(pattern, points)
    front = ((normals * gaze).sum(axis=-1) >= 0)[:, None]
    share = brightness(np.where(front, normals, -normals), light_of(view))
    shown = np.where(front, colours.blend(sides[0], share), colours.blend(sides[1], share))
    length = float(np.median(geometry.edge_lengths(pattern, points)))
    width = float(np.clip(0.035 * length / pixel, 0.5, 2.0)) * (1 - 0.5 * faint)
    ink = colours.blend((colours.FACET_EDGE, colours.LAYER_EDGE), np.full(len(pattern.edges_vertices), faint))
    edges = Lines(points, pattern.edges_vertices, ink, width)
    return Facets(points, cells_of(pattern.faces_vertices), shown), edges


def sides_of(pattern: Pattern, points: FloatArray, view: FloatArray) -> tuple[colours.Shades, colours.Shades]:
    """Colours of the top side and of the other one; the warmer ones go to the side that the viewer sees more of."""
    face, _, vertex, following = pattern.corners.T
    middles = geometry.facet_centroids(pattern, points)
    area = np.cross(points[vertex] - middles[face], points[following] - middles[face]) @ view[2]
    depth = middles @ view[2]  # of a tube, the near half is seen
    top_is_seen = float((area * (depth - depth.min())[face]).sum()) >= 0
    return (colours.WARM, colours.COOL) if top_is_seen else (colours.COOL, colours.WARM)


def target(vertices: FloatArray, triangles: IntArray, view: FloatArray) -> tuple[Facets, Lines]:
    """A translucent surface and its rim."""
    # Blended in their order, far ones first: depth peeling shows nothing with some software renderers.
    triangles = triangles[np.argsort((vertices[triangles] @ view[2]).mean(axis=1), kind="stable")]
    share = brightness(_normals(vertices, triangles, view), light_of(view))
    facets = Facets(vertices, cells_of(triangles), colours.blend(colours.TARGET, share), colours.TARGET_OPACITY)
    rim = _sharp_edges(vertices, triangles, None)
    return facets, Lines(vertices, rim, np.tile(colours.rgb(colours.TARGET[0]), (len(rim), 1)), 1.2)


def buildings(vertices: FloatArray, triangles: IntArray, view: FloatArray) -> tuple[Facets, Lines]:
    """Walls in light grey, roofs warmer, and the edges where they meet."""
    share = brightness(_normals(vertices, triangles, view), light_of(view))
    roof = are_roofs(vertices, triangles)
    shown = np.where(roof[:, None], colours.blend(colours.ROOF, share), colours.blend(colours.WALL, share))
    sharp = _sharp_edges(vertices, triangles, 20.0)
    ink = np.tile(colours.rgb(colours.CONTEXT_EDGE), (len(sharp), 1))
    return Facets(vertices, cells_of(triangles), shown), Lines(vertices, sharp, ink, 0.7)


def are_roofs(vertices: FloatArray, triangles: IntArray) -> NDArray[np.bool_]:
    """Which triangles (T,) of buildings are level enough to be roofs (or grounds)."""
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    return np.asarray(np.abs(geometry.unit(np.cross(b - a, c - a))[:, 2]) > 0.35)


def solid(vertices: FloatArray, triangles: IntArray, view: FloatArray, shades: colours.Shades) -> Facets:
    """A surface of one colour."""
    share = brightness(_normals(vertices, triangles, view), light_of(view))
    return Facets(vertices, cells_of(triangles), colours.blend(shades, share))


def ground(centre: FloatArray, radius: float, height: float) -> Facets:
    """A disc that fades into the white of the page."""
    rings, spokes = 48, 96
    angle = 2 * np.pi * np.arange(spokes) / spokes
    r = radius * np.arange(rings + 1) / rings
    x, y = centre[0] + np.outer(r, np.cos(angle)), centre[1] + np.outer(r, np.sin(angle))
    points = np.stack([x, y, np.full_like(x, height)], axis=2).reshape(-1, 3)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(rings), np.arange(spokes), indexing="ij"))
    a, b = i * spokes + j, i * spokes + (j + 1) % spokes
    share = 1 - (i + 0.5) / rings
    fade = share * share * (3 - 2 * share)
    return Facets(
        points,
        cells_of(np.stack([a, a + spokes, b + spokes, b], axis=1)),
        colours.blend(colours.GROUND, fade),
    )


def shadow(points: FloatArray, cells: IntArray, count: int, view: FloatArray, height: float) -> Facets:
    """Where ``count`` polygons throw their shadow on the plane z = ``height``."""
    light = sun_of(view)
    fallen = points - np.outer((points[:, 2] - height) / light[2], light)
    fallen[:, 2] = height
    return Facets(fallen, cells, np.tile(colours.rgb(colours.SHADOW), (count, 1)))


def brightness(normals: FloatArray, light: FloatArray) -> FloatArray:
    """From 0 (turned away from the light) to 1."""
    share = np.clip((normals @ light + 0.35) / 1.35, 0, 1)
    return np.asarray(share)


def _normals(vertices: FloatArray, triangles: IntArray, view: FloatArray) -> FloatArray:
    """Unit normals (T, 3) on the side of the viewer."""
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return np.asarray(np.where((normals @ view[2] < 0)[:, None], -normals, normals))


def _sharp_edges(vertices: FloatArray, triangles: IntArray, degrees: float | None) -> IntArray:
    """Edges (S, 2) of triangles that have one neighbour only, or whose neighbours bend by more than ``degrees``.

    Vertices at one place count as one.
    """
    tolerance = 1e-6 * geometry.diagonal(vertices)
    _, first, place = np.unique(np.rint(vertices / tolerance), axis=0, return_index=True, return_inverse=True)
    welded = first[place.ravel()][triangles]
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    ends = np.sort(np.concatenate([welded[:, [0, 1]], welded[:, [1, 2]], welded[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(len(triangles)), 3)
    edges, which, count = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(which.ravel(), kind="stable")
    begin = np.cumsum(count) - count
    sharp: NDArray[np.bool_] = count == 1
    if degrees is not None:
        pair = count >= 2
        one, two = owner[order[begin[pair]]], owner[order[begin[pair] + 1]]
        sharp[pair] = np.abs((normals[one] * normals[two]).sum(axis=1)) < np.cos(np.radians(degrees))
    return np.asarray(edges[sharp & (edges[:, 0] != edges[:, 1])], np.int64)
