"""The two fonts of drawings: Helvetica, which every PDF reader has, and Vera, which reportlab brings with it.

Vera is a little wider, so it is drawn a little smaller and takes the room that Helvetica is measured by.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from inverse.fabricate.extras import needed

SMALLER = {False: 0.85, True: 0.78}  # size of Vera, of Helvetica's, by whether they are bold


def width(words: str, size: float, *, bold: bool = False) -> float:
    """Width of words in Helvetica, in the unit of the size."""
    metrics = needed("reportlab.pdfbase.pdfmetrics")
    return float(metrics.stringWidth(words, "Helvetica-Bold" if bold else "Helvetica", size))


def in_helvetica(words: str) -> bool:
    """Whether Helvetica has all letters of some words."""
    try:
        words.encode("cp1252")
    except UnicodeEncodeError:
        return False
    return True


def in_vera(words: str) -> str:
    """The same words, with a question mark for every letter that Vera lacks."""
    known = _letters()
    return "".join(letter if ord(letter) in known else "?" for letter in words)


def vera(*, bold: bool) -> Path:
    """The file of Vera."""
    return Path(needed("reportlab").__file__).parent / "fonts" / ("VeraBd.ttf" if bold else "Vera.ttf")


@cache
def _letters() -> frozenset[int]:
    fonts = needed("reportlab.pdfbase.ttfonts")
    return frozenset(fonts.TTFont("Vera", str(vera(bold=False))).face.charToGlyph)
