"""Thick panels over their motion: range, penetration, first contacts and time.

    python -m benchmarks.panels                     prints the table
    python -m benchmarks.panels --sizes 8 16        grids of these sizes only
    python -m benchmarks.panels --pictures docs/images

delta is 10 degrees, the thickness 0.9 of the largest that works. What a figure means stands in docs/panels.md.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

import inverse
from inverse.fabricate.panels.contacts import Contact, first_contacts, penetrations
from inverse.fabricate.panels.panels import Panels, panels
from inverse.fabricate.panels.thickness import Thickness
from inverse.fabricate.picture import panels_picture
from inverse.origami import seeds
from inverse.origami.pattern import Design

VAULT = Path(__file__).parents[1] / "targets" / "vault.yaml"
SECTION = [(1, 1, 2), (1, -1, 1), (-1, -1, 1), (1, -1, 1), (-1, -1, 1), (-1, 1, 2)]
STATES = 24
HEADER = (
    f"{'design':14}{'facets':>7}{'thick':>9}{'range':>16}{'overlap':>9}{'contact':>9}{'contact':>9}"
    f"{'panels s':>10}{'10 states s':>13}{'contacts s':>12}"
)


def thickened(design: Design) -> Panels:
    """Panels of 0.9 of the largest thickness that works."""
    largest = panels(design, Thickness(1e-9)).largest.min()
    return panels(design, Thickness(0.9 * float(largest)))


def row(name: str, design: Design) -> str:
    """What is measured of one design."""
    thickness = thickened(design).thickness
    began = time.perf_counter()
    thick = panels(design, thickness)
    built = time.perf_counter()
    found = penetrations(thick, thick.range.states(STATES))
    checked = time.perf_counter()
    below, above = first_contacts(thick, STATES)
    done = time.perf_counter()
    smallest = thick.volumes.sum(axis=1).min()
    overlap = max((contact.volume for state in found for contact in state), default=0.0) / smallest
    low, high = np.degrees([thick.range.low, thick.range.high])
    seconds = (checked - built) * 10 / STATES
    return (
        f"{name:14}{len(thick.names):7}{thickness.thickness:9.4g}{f'{low:.3f}-{high:.3f}':>16}{overlap:9.1g}"
        f"{told(below):>9}{told(above):>9}{built - began:10.2f}{seconds:13.2f}{done - checked:12.2f}"
    )


def told(contact: Contact | None) -> str:
    return "-" if contact is None else f"{np.degrees(contact.t):.3f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", type=int, nargs="+")
    parser.add_argument("--pictures", type=Path)
    arguments = parser.parse_args()
    shown = {}
    if arguments.sizes is None or arguments.pictures:
        vault = inverse.solve(inverse.load(VAULT, ["pattern.size=[16,16]"])).design
        shown = {"vault": vault, "tube": seeds.tube(SECTION, 10)}
    print(HEADER)
    for name, design in shown.items():
        print(row(name, design), flush=True)
        if arguments.pictures:
            columns, rows = (6, 1) if name == "tube" else (3, 2)
            panels_picture(thickened(design), arguments.pictures / f"thick_{name}.png", columns=columns, rows=rows)
    for n in arguments.sizes or (16, 32, 64):
        for name, u_lines in (("Miura", "FL"), ("eggbox", "CFL")):
            print(row(f"{name} {n}", seeds.grid((n, n), u_lines, "FL")), flush=True)


if __name__ == "__main__":
    main()
