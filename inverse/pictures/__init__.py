"""Pictures of designs: 3D views as PNG, crease patterns as SVG. VTK is loaded in processes of its own."""

from inverse.pictures.crease_pattern import crease_pattern_picture, layers_picture
from inverse.pictures.design_state import design_picture, design_scene
from inverse.pictures.rendering import Renderer, can_render
from inverse.pictures.states import process_picture, states_picture, states_scene

__all__ = [
    "Renderer",
    "can_render",
    "crease_pattern_picture",
    "design_picture",
    "design_scene",
    "layers_picture",
    "process_picture",
    "states_picture",
    "states_scene",
]
