"""What is told about a thick structure: its range, and its contacts."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from inverse.certify import check_frame
from inverse.fabricate.panels.contacts import Contact, first_contacts, penetrations
from inverse.fabricate.panels.panels import Panels
from inverse.files import fold_file


def report_lines(
    panels: Panels, states: int = 24, progress: Callable[[str, int, int], None] | None = None
) -> list[str]:
    """Sentences about the range of a thick structure and who meets whom in it and beyond.

    Args:
        panels: the structure.
        states: sampled over the range.
        progress: told what is done, and how much of how much; of 0 where that is not known.

    Raises:
        InputError: manifold3d is missing.
    """
    low, high = np.degrees([panels.range.low, panels.range.high])
    lines = [f"panels fold from t = {low:.5g} to {high:.5g} degrees"]
    tell = progress or (lambda words, done, of: None)
    found: list[Contact] = []
    for done, t in enumerate(panels.range.states(states)):
        tell("looking for panels that meet, states", done, states)
        found += penetrations(panels, np.array([t]))[0]
    if found:
        worst = max(found, key=lambda contact: contact.volume)
        lines.append(
            f"panels penetrate each other in that range, the most {_who(panels, worst)}, "
            f"by {worst.volume:.3g} cubic units"
        )
    else:
        lines.append(f"no panels penetrate each other at {states} states of that range")

    def look(t: float) -> None:
        tell(f"looking for the first contact, at t = {np.degrees(t):.5g} degrees", 0, 0)

    for contact, way in zip(first_contacts(panels, states, look), ("developed", "flat-folded"), strict=True):
        told = "none" if contact is None else f"panels {_who(panels, contact)}"
        lines.append(f"first contact towards the {way} state: {told}")
    words = "looking for facets that cross, states"
    certificate = check_frame(fold_file.frame(panels.design), lambda done, of: tell(words, done, of))
    lines += [f"without thickness, {crossing.sentence}" for crossing in certificate.crossings]
    return lines


def _who(panels: Panels, contact: Contact) -> str:
    one, other = (panels.names[facet] for facet in contact.facets)
    return f"{one} and {other} at t = {np.degrees(contact.t):.5g} degrees"
