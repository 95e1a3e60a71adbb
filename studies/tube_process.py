"""How a tube comes from its seed: designs for targets ever nearer to the one asked for, and a picture of them.

python -m studies.tube_process [SPEC.yaml [PICTURE.png]]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import inverse
from inverse.formulation.formulate import build_target
from inverse.origami.pattern import Design
from inverse.pictures import process_picture
from inverse.surfaces.tube import TubeTarget

SHARES = (0.25, 0.5, 0.75, 1.0)  # of the bend and of the change of radius
POINTS = np.linspace(0, 1, 25)


def main() -> None:
    """Solve one target after the other, each from the design before, and print how well each is met."""
    arguments = [Path(argument) for argument in sys.argv[1:]]
    path, picture = [*arguments, *(Path("targets/bend.yaml"), Path("out/process.png"))[len(arguments) :]]
    loaded = inverse.load(path)
    target = build_target(loaded)
    if not isinstance(target, TubeTarget):
        raise SystemExit(f"{path} has no target around an axis")
    designs: list[Design] = []
    titles, result = ["seed"], None
    for share in SHARES:
        on_the_way = target.flattened(share)
        mapping = loaded.specification.model_dump(mode="json", exclude_unset=True)
        profile = np.column_stack([POINTS, on_the_way.radii(POINTS)])
        mapping["target"] = {"axis": {"spline": on_the_way.axis.at(POINTS).tolist()}, "radius": profile.tolist()}
        result = inverse.solve(inverse.load(mapping, folder=path.parent), start=result)
        off = result.report["fit"]["mean_over_radius"]
        print(f"{share:>6.0%} of the target: {result.status}, rings off by {off:.3%} of their radius", flush=True)
        designs = designs or [result.seed]
        designs.append(result.design)
        titles.append(f"{share:.0%}")
    picture.parent.mkdir(parents=True, exist_ok=True)
    process_picture(designs, titles, picture)


if __name__ == "__main__":
    main()
