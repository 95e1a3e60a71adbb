"""The flat pieces of a crease pattern as FOLD."""

from __future__ import annotations

import json

import numpy as np

from inverse.fabricate.cut.crease_plan import seams
from inverse.fabricate.cut.pieces import pieces_of
from inverse.origami import geometry
from inverse.origami.pattern import B, Design


def crease_fold(design: Design, *, scale: float = 1.0) -> bytes:
    """The content of a FOLD file of the flat pieces, side by side, in millimetres.

    Border and seams are boundary edges. ``bdffpq:edges_seam`` has the number that both sides of a seam share, 0
    elsewhere; ``bdffpq:faces_facet`` and ``bdffpq:edges_edge`` the numbers of facets and edges in the design.

    Args:
        design: the design.
        scale: of the model, 1 for full size.

    Raises:
        InputError: the scale is not positive; shapely is missing.
    """
    pattern = design.pattern
    pieces = pieces_of(design, scale)
    numbers = seams(design, pieces)
    valley = geometry.fold_angles(pattern, design.vertices_coords) > 0
    coords: list[list[float]] = []
    edges: list[list[int]] = []
    faces: list[list[int]] = []
    facets: list[int] = []
    own: list[int] = []
    right = 0.0
    for piece in pieces:
        first = {v: len(coords) + k for k, v in enumerate(piece.places)}
        places = np.array(list(piece.places.values()))
        low = places.min(axis=0)
        coords += (places - low + [right, 0.0]).tolist()
        right += float(np.ptp(places[:, 0])) * 1.05
        used: dict[int, None] = {}
        for f in piece.faces:
            face = pattern.faces_vertices[f]
            faces.append([first[v] for v in face])
            facets.append(f)
            used |= dict.fromkeys(pattern.faces_edges[f])
        own += used
        edges += [[first[v] for v in pattern.edges_vertices[edge].tolist()] for edge in used]
    border = [pattern.edges_type[edge] == B or edge in numbers for edge in own]
    assignment = ["B" if rim else "V" if valley[edge] else "M" for edge, rim in zip(own, border, strict=True)]
    document = {
        "file_spec": 1.2,
        "file_creator": "inverse",
        "file_title": design.name,
        "file_classes": ["singleModel"],
        "frame_title": "crease pattern",
        "frame_classes": ["creasePattern"],
        "frame_attributes": ["2D"],
        "frame_unit": "mm",
        "vertices_coords": coords,
        "edges_vertices": edges,
        "edges_assignment": assignment,
        "faces_vertices": faces,
        "bdffpq:edges_edge": own,
        "bdffpq:edges_seam": [numbers.get(edge, 0) for edge in own],
        "bdffpq:faces_facet": facets,
    }
    return (json.dumps(document, allow_nan=False) + "\n").encode()
