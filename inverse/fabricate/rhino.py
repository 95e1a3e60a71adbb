"""3DM files for Rhino: solids of panels, or the ideal surface with its foldlines, on layers by name."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np

from inverse._types import FloatArray
from inverse.errors import InputError
from inverse.fabricate.extras import needed
from inverse.fabricate.meshes import COLOURS, DESIGN_STATE, parts_of
from inverse.fabricate.panels.thickness import Thickness
from inverse.fabricate.parts import Part
from inverse.origami import geometry
from inverse.origami.pattern import Design
from inverse.pictures import colours

_UNITS = {
    "m": "Meters",
    "cm": "Centimeters",
    "mm": "Millimeters",
    "um": "Microns",
    "nm": "Nanometers",
    "in": "Inches",
    "pt": "PrinterPoints",
}


def threedm(design: Design, *, t: float = DESIGN_STATE, thickness: Thickness | None = None) -> dict[str, bytes]:
    """3DM in the design's unit.

    Panels are solids on the layers ``upper``, ``lower`` and ``hinge``; the ideal surface is a mesh of its facets on the
    layer ``facets``, with a line for every edge on a layer for its kind. Objects bear names.

    Args:
        design: the mesh.
        t: folding amount in radians.
        thickness: of the panels; None for the ideal surface.

    Returns:
        The content of one file by its name.

    Raises:
        InputError: rhino3dm is missing, or the design cannot be made that thick, or does not fold to ``t`` then.
    """
    rhino: Any = needed("rhino3dm")
    parts = parts_of(design, t, thickness)
    file = _File(rhino, design.unit)
    if thickness is None:
        (surface,) = parts
        file.mesh(surface)
        # Which side is a valley does not change in the motion.
        kinds = colours.edge_kinds(design.pattern, geometry.fold_angles(design.pattern, design.vertices_coords))
        names = list(colours.EDGE_COLOURS)
        for (a, b), kind in zip(design.pattern.edges_vertices.tolist(), kinds.tolist(), strict=True):
            file.line(surface.points[[a, b]], f"{a}-{b}", names[kind], colours.EDGE_COLOURS[names[kind]])
    else:
        for part in parts:
            file.solid(part)
    return {f"{'surface' if thickness is None else 'panels'}.3dm": file.content()}


class _File:
    """A 3DM file in the making."""

    def __init__(self, rhino: Any, unit: str) -> None:
        self._rhino = rhino
        self._model = rhino.File3dm()
        self._model.ApplicationName = "inverse"
        self._model.Settings.ModelUnitSystem = getattr(rhino.UnitSystem, _UNITS.get(unit, "None"))
        self._layers: dict[str, int] = {}

    def mesh(self, part: Part) -> None:
        """Triangles and quads stay what they are; Rhino knows no larger facets, which become fans."""
        mesh = self._rhino.Mesh()
        for point in part.points.tolist():
            mesh.Vertices.Add(*point)
        for polygon in part.polygons:
            if len(polygon) <= 4:
                mesh.Faces.AddFace(*polygon)
            else:
                for k in range(1, len(polygon) - 1):
                    mesh.Faces.AddFace(polygon[0], polygon[k], polygon[k + 1])
        mesh.Normals.ComputeNormals()
        self._model.Objects.AddMesh(mesh, self._attributes(part.name, part.layer, COLOURS[part.layer]))

    def solid(self, part: Part) -> None:
        """A prism as a closed polysurface."""
        rhino = self._rhino
        below, above = np.split(part.points, 2)
        up = above[0] - below[0]
        along = geometry.unit(below[1] - below[0])
        origin, x, y = below[0], along, np.cross(geometry.unit(up), along)
        plane = rhino.Plane(rhino.Point3d(*origin), rhino.Vector3d(*x), rhino.Vector3d(*y))
        rim = rhino.PolylineCurve(rhino.Polyline([rhino.Point3d(*point) for point in (*below, below[0])]))
        extrusion = rhino.Extrusion.CreateWithPlane(rim, plane, float(np.linalg.norm(up)), True)
        solid = None if extrusion is None else extrusion.ToBrep(False)
        if solid is None or not (solid.IsValid and solid.IsSolid):
            raise InputError(
                f"layer {part.name} does not become a solid in Rhino: it is nearly nothing",
                hint="Take a smaller thickness.",
            )
        self._model.Objects.AddBrep(solid, self._attributes(part.name, part.layer, COLOURS[part.layer]))

    def line(self, ends: FloatArray, name: str, layer: str, colour: str) -> None:
        """A straight line."""
        curve = self._rhino.LineCurve(*(self._rhino.Point3d(*point) for point in ends.tolist()))
        self._model.Objects.AddCurve(curve, self._attributes(name, layer, colour))

    def content(self) -> bytes:
        """The file."""
        return base64.b64decode(self._model.Encode())

    def _attributes(self, name: str, layer: str, colour: str) -> Any:
        if layer not in self._layers:
            made = self._rhino.Layer()
            made.Name = layer
            made.Color = (*colours.rgb(colour).tolist(), 255)
            self._layers[layer] = self._model.Layers.Add(made)
        attributes = self._rhino.ObjectAttributes()
        attributes.Name = name
        attributes.LayerIndex = self._layers[layer]
        return attributes
