"""Files of buildings that are no CityJSON, known by how they begin, so that a message can name them."""

from __future__ import annotations

import re

_BEGINNINGS: tuple[tuple[str, bytes], ...] = (
    ("an IFC file", rb"\s*ISO-10303-21;.{0,4000}?FILE_SCHEMA\s*\(\s*\(\s*'IFC"),
    ("a STEP file", rb"\s*ISO-10303-21;"),
    ("a DXF file", rb"(\s*999\s*\n[^\n]*\n)*\s*0\s*\r?\n\s*SECTION|AutoCAD Binary DXF"),
    ("a DWG file", rb"AC10\d\d"),
    ("a CityGML file", rb"\s*(<\?xml.{0,500}?)?<(\w+:)?CityModel\b"),
    ("an XML file", rb"\s*<\?xml"),
    ("a PLY file", rb"ply\r?\n"),
    ("an OFF file", rb"[CN]{0,2}OFF\s"),
    ("an STL file", rb"solid\s.{0,500}?facet\s"),
    ("a GLB file", rb"glTF"),
    ("a 3DM file", rb"3D Geometry File Format"),
    ("a SketchUp file", rb"\xff\xfe\xff\x0eS\x00k\x00e\x00t\x00c\x00h\x00U\x00p\x00"),
    ("a PDF file", rb"%PDF"),
    ("a ZIP archive", rb"PK\x03\x04"),
    ("a gzip archive", rb"\x1f\x8b"),
    ("an OBJ file", rb"(\s*#[^\n]*\n|\s*(mtllib|o|g|s|usemtl|vn|vt)\s[^\n]*\n)*\s*v\s+[-+.\d]"),
    ("a GeoJSON file", rb"\s*\{.{0,500}?\"type\"\s*:\s*\"(FeatureCollection|Feature)\""),
    ("a glTF file", rb"\s*\{.{0,2000}?\"asset\"\s*:\s*\{"),
)
BEGINNING = 8192  # bytes that are looked at


def other_format(beginning: bytes) -> str | None:
    """What a file is, such as "an IFC file", where it is one of the formats that buildings often come in.

    Args:
        beginning: its first :data:`BEGINNING` bytes.
    """
    text = beginning.removeprefix(b"\xef\xbb\xbf")
    return next((name for name, form in _BEGINNINGS if re.match(form, text, re.DOTALL | re.IGNORECASE)), None)
