"""Existing buildings around a design: read, measured and drawn; nothing of the core depends on them."""

from inverse.context.building import Building, Context, Surface, triangulated
from inverse.context.city_json import read_city_json
from inverse.context.eaves import eaves, facing_eaves

__all__ = ["Building", "Context", "Surface", "eaves", "facing_eaves", "read_city_json", "triangulated"]
