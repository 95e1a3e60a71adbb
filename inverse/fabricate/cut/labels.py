"""Words along the edges of facets, as large as there is room."""

from __future__ import annotations

from typing import Any

import numpy as np

from inverse._types import FloatArray
from inverse.errors import InputError
from inverse.fabricate.cut.plan import Text
from inverse.fabricate.extras import needed

LARGEST = 4.0  # mm, height of capitals
LETTER = 0.85  # width of the widest digit, of the height
_HEIGHT = 0.2  # of capitals at most, of the edge
_OFF = 0.4  # distance of the letters from the edge, of their height
_AROUND = 0.5  # least distance from other edges and words, of their height; more, so that it is clear which is meant
_ALONG = (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8)  # places along the edge
_STEPS = 60
_TURNED = str.maketrans("0689", "0986")  # digits upside down


def words_of(number: int) -> str:
    """The number, with a dot behind it where it would be another one upside down: pieces are turned about."""
    words = str(number)
    turned = words[::-1].translate(_TURNED)
    return f"{words}." if set(words) <= set("0689") and turned != words and turned[0] != "0" else words


def labels_along(outline: FloatArray, edges: list[tuple[FloatArray, str]]) -> list[Text]:
    """Write along edges of a facet, to be read from below or from the right; all words shrink until they have room.

    Args:
        outline: (k, 2) of the facet in mm, counter-clockwise.
        edges: (2, 2) ends of each, the facet on their left, and what is written there.

    Raises:
        InputError: the facet is too narrow for its words.
    """
    facet = needed("shapely").Polygon(outline)
    for step in range(_STEPS):
        texts = _placed(facet, edges, 0.9**step)
        if texts is not None:
            return texts
    words = ", ".join(words for _, words in edges)
    raise InputError(f"a facet has no room for the numbers of its seams, {words}", hint="It is too narrow to be cut.")


def _placed(facet: Any, edges: list[tuple[FloatArray, str]], share: float) -> list[Text] | None:
    """The words at a share of their full height, None where one of them has no room beside those before it."""
    shapely = needed("shapely")
    texts: list[Text] = []
    taken: list[Any] = []
    for ends, words in edges:
        length = float(np.linalg.norm(ends[1] - ends[0]))
        along = (ends[1] - ends[0]) / length
        inwards = np.array([-along[1], along[0]])
        height = share * min(LARGEST, _HEIGHT * length)
        half = (len(words) * LETTER / 2 + _AROUND) * height * along
        top, bottom = ((0.5 + free) * height * inwards for free in (_AROUND, _OFF / 2))
        for share_along in _ALONG:
            place = ends[0] + share_along * (ends[1] - ends[0]) + (_OFF + 0.5) * height * inwards
            room = shapely.Polygon(place + np.array([-half - bottom, half - bottom, half + top, top - half]))
            if facet.contains(room) and not any(room.intersects(other) for other in taken):
                taken.append(room)
                texts.append(Text("label", place, _upright(along), height, words))
                break
        else:
            return None
    return texts


def _upright(along: FloatArray) -> float:
    """Angle in (-pi/2, pi/2] of a direction or its opposite."""
    if along[0] < -1e-9 or (abs(along[0]) <= 1e-9 and along[1] < 0):
        along = -along
    return float(np.arctan2(along[1], along[0]))
