"""Facets that pass through each other: decided exactly, in one state or in many of a motion at once."""

from inverse.crossing.exact import crossing_facets as crossing_facets
from inverse.crossing.exact import triangles_of as triangles_of
from inverse.crossing.states import first_crossing as first_crossing
