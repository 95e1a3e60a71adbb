"""How large the numbers of files and specifications may be."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from inverse.errors import InputError

# Coordinates and lengths, in whatever unit: national grids in millimetres need 1e10. Their squares and cubes, and what
# is left of them beside lengths of one unit, stay within double precision.
FARTHEST = 1e12
SMALLEST = 1e-12  # of what must be positive


def check_coordinates(points: NDArray[np.float64], where: str | None) -> None:
    """Refuse points that are not finite or absurdly far away.

    Args:
        points: (N, 3).
        where: the file, for the message.

    Raises:
        InputError: with the number of the worst vertex.
    """
    far = np.abs(points).max(axis=1, initial=0.0)
    wrong = ~(far <= FARTHEST)
    if wrong.any():
        k = int(np.argmax(np.where(wrong, np.nan_to_num(far, nan=np.inf), 0.0)))
        what = f"coordinates up to {FARTHEST:g} are allowed" if np.isfinite(points[k]).all() else "it must be finite"
        raise InputError(f"vertex {k} is at {points[k].tolist()}: {what}", where=where)


def check_extent(points: NDArray[np.float64], what: str, where: str | None) -> None:
    """Refuse what is too small, or too far away for its size.

    Args:
        points: (N, 3), finite.
        what: what they are, for the message.
        where: the file.

    Raises:
        InputError: the points coincide within the digits that numbers have.
    """
    size, away = float(np.ptp(points, axis=0).max(initial=0.0)), float(np.abs(points).max(initial=0.0))
    if size == 0 or size < 1e-12 * away:
        raise InputError(f"all vertices of {what} coincide", where=where)
    if size < SMALLEST:
        raise InputError(f"{what} is {size:g} wide: at least {SMALLEST:g} is needed", where=where,
                         hint="Choose a smaller unit.")  # fmt: skip
    if size < 1e-9 * away:
        raise InputError(f"{what} is {size:g} wide, but {away:g} away from the origin: numbers have too few digits",
                         where=where, hint="Move everything nearer to the origin.")  # fmt: skip
