"""Whether a design lies so far from the origin that its file's coordinates are too coarse for the limits.

A coordinate of 1e6 m has 1e-10 m as its last digit. Nothing can be read from a file that was lost in writing it, so
such a design does not pass; but then its rounding is at fault, not its geometry, and the messages say so.
"""

from __future__ import annotations

import numpy as np

from inverse.certify.certificate import LIMITS, Measured
from inverse.certify.claims import ANGLE_TOLERANCE
from inverse.certify.measures import edge_lengths
from inverse.certify.structure import Structure

FAR = 10.0  # diagonals from the origin: from nearer, a place at the origin gains less than two digits
# Values that rounding alone gives, as multiples of a coordinate's last digit over the shortest edge: up to 17 were
# seen, in sheets of 32 x 32 facets.
GROWTH = 30.0
ROUNDED = ("planarity", "developability", "flat_foldability", "motion_gap", "loop_closure")


def explained(found: dict[str, Measured], structure: Structure) -> dict[str, Measured]:
    """The failing measures, with a sentence where rounding of the file's coordinates is enough to explain them."""
    mesh = structure.mesh
    if mesh is None:
        return found
    reach = float(np.abs(structure.given).max())
    size = float(np.linalg.norm(np.ptp(structure.given[mesh.tail], axis=0)))
    if reach <= FAR * size:
        return found
    shortest = float(edge_lengths(mesh, structure.given).min())
    digit = float(np.spacing(reach))
    share = digit / max(shortest, digit)
    # Angles and flat states that a file claims differ from the vertices', or facets are spoilt altogether.
    spoilt = GROWTH * share > np.radians(ANGLE_TOLERANCE) and (not structure.faults or structure.halves is None)
    told = dict(found)
    for name, (value, worst) in found.items():
        if value is None or value <= LIMITS[name][0]:
            continue
        if (name in ROUNDED and value <= GROWTH * share) or (name == "structure" and spoilt):
            told[name] = (
                value,
                f"{worst}; so far from the origin the last digit of a coordinate is {share:.1g} of the shortest edge,"
                " which is too coarse: place the design near the origin",
            )
    return told
