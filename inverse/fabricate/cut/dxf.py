"""Drawings as DXF: millimetres, one layer per kind of line."""

from __future__ import annotations

from typing import Any

import numpy as np

from inverse.fabricate.cut.plan import LAYERS, Plan
from inverse.fabricate.dxf_file import content_of
from inverse.fabricate.extras import needed
from inverse.pictures.colours import rgb


def crease_dxf(plan: Plan) -> bytes:
    """The content of a DXF file, true to scale.

    Args:
        plan: the drawing.

    Raises:
        InputError: ezdxf is missing.
    """
    ezdxf: Any = needed("ezdxf")
    document = ezdxf.new("R2010", units=ezdxf.units.MM)
    for layer, colour in LAYERS.items():
        document.layers.add(layer).rgb = tuple(rgb(colour).tolist())
    space = document.modelspace()
    for line in plan.lines:
        space.add_line(*line.ends.tolist(), dxfattribs={"layer": line.layer})
    for text in plan.texts:
        entity = space.add_text(text.words, height=text.height, rotation=float(np.degrees(text.angle)))
        entity.dxf.layer = text.layer
        entity.set_placement(text.place.tolist(), align=ezdxf.enums.TextEntityAlignment.MIDDLE_CENTER)
    return content_of(document)
