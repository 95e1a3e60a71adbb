"""Somebody else's pattern, snapped to the exact set."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from inverse.origami.pattern import Design
    from inverse.repair.repairing import Repair


def repair(
    pattern: Path | str | Design, *, u_lines: str | None = None, v_lines: str | None = None, far: bool = False
) -> Repair:
    """Move a pattern onto the exact set by the least move.

    Args:
        pattern: a FOLD or OBJ file of a semi-folded state or of a flat crease pattern, or a design.
        u_lines: FL or CFL for the interior lines of a grid that are crossed by walking along u, or a word for each,
            separated by commas; FL if only ``v_lines`` is given, deduced if neither is.
        v_lines: the same along v.
        far: also take a pattern that is more than 0.1 rad or mean edges off somewhere.

    Returns:
        The exact design and its certificate; where it could not be made exact, the status says why.

    Raises:
        InputError: a file that cannot be read, or a pattern that is no network of facets with four edges at every
            interior vertex, is off by more than 0.1 rad or mean edges, or cannot fold.
    """
    from inverse.repair.repairing import repaired  # loaded when used: the package itself must import fast

    return repaired(pattern, u_lines, v_lines, far=far)
