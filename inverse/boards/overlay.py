"""Areas cut and put together by shapely, on a grid where rounding has made their outlines cross."""

from __future__ import annotations

from typing import Any

from inverse.fabricate.extras import needed


def less(area: Any, other: Any, near: float) -> Any:
    """An area without another one.

    Args:
        area: what is cut.
        other: what is taken away.
        near: length that is too small to be seen.
    """
    shapely = needed("shapely")
    try:
        return shapely.difference(area, other)
    except shapely.GEOSException:
        return shapely.difference(shapely.buffer(area, 0.0), shapely.buffer(other, 0.0), grid_size=0.1 * near)


def union(areas: Any, near: float) -> Any:
    """All areas in one.

    Args:
        areas: polygons.
        near: length that is too small to be seen.
    """
    shapely = needed("shapely")
    try:
        return shapely.union_all(areas)
    except shapely.GEOSException:
        return shapely.union_all(shapely.buffer(areas, 0.0), grid_size=0.1 * near)
