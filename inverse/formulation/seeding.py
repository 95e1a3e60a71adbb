"""From the pattern of a specification to the model of its seed, placed over the target."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from inverse._types import FloatArray
from inverse.files import fold_file
from inverse.formulation import placement, sections
from inverse.formulation.calls import called
from inverse.formulation.given import Given
from inverse.formulation.outline import Outline
from inverse.formulation.within import within
from inverse.model import DesignModel
from inverse.origami import seeds
from inverse.origami.families import PATTERN_FAMILIES
from inverse.origami.pattern import Design
from inverse.spec import FamilyPattern, FilePattern, GridPattern, Loaded, MeshKeys, TubePattern
from inverse.surfaces import Target
from inverse.surfaces.holes import HoledTarget
from inverse.surfaces.mesh import MeshTarget
from inverse.surfaces.section import SectionTarget
from inverse.surfaces.sheet import check_sheet


def made(loaded: Loaded, given: Given) -> Design | None:
    """The pattern's seed as a caller, a user's function or a file gives it, if one does."""
    pattern = loaded.specification.pattern
    if given.design is None and isinstance(pattern, FamilyPattern):
        return called(loaded, "pattern", "family", PATTERN_FAMILIES, pattern.parameters, *pattern.size)
    if given.design is None and isinstance(pattern, FilePattern):
        path = loaded.folder / pattern.file
        return within(loaded, ("pattern",), lambda: fold_file.read(path))
    return given.design


def outlined(loaded: Loaded, target: Target, given: Given, made: Design | None) -> tuple[Target, Outline | None]:
    """The target as a seed is placed over it, and what a grid is trimmed to.

    Args:
        loaded: the specification.
        target: the target.
        given: what a caller gave.
        made: the pattern's seed, where it is not built in.

    Returns:
        The target, its holes filled where a grid is cut out over them; the outline, or None.

    Raises:
        InputError: the target is a mesh that no sheet can follow.
    """
    pattern = loaded.specification.pattern
    mesh, is_disk = target, made is None or made.pattern.n_holes == 0
    if not isinstance(mesh, MeshTarget) or not is_disk:
        return target, None
    trims = made is None and isinstance(pattern, GridPattern) and pattern.trim != "none"
    count = len(made.pattern.faces_vertices) if made is not None else np.prod(pattern.size)  # type: ignore[union-attr]
    facet = float(np.sqrt(np.prod(mesh.frame.extent) / count))
    key = ("target", "mesh") if isinstance(loaded.specification.target, MeshKeys) else ("target",)
    place = key if given.target is None else None
    within(loaded, place, lambda: check_sheet(mesh, facet, may_have_holes=trims))
    if not trims:
        return target, None
    assert isinstance(pattern, GridPattern)
    target = HoledTarget.of(mesh) or mesh
    return target, Outline.of(target, always=pattern.trim == "outline")


def build(
    loaded: Loaded, target: Target, outline: Outline | None, origin: FloatArray, made: Design | None
) -> DesignModel:
    """The model of the seed, placed over the target's plan; one that keeps its position is moved to the origin (3,).

    Args:
        loaded: the specification.
        target: the target, relative to the origin.
        outline: what a grid is trimmed to, if it is.
        origin: (3,).
        made: the pattern's seed, where it is not built in.

    Raises:
        InputError: there is no such seed, or facets are too large for the outline.
    """
    specification = loaded.specification
    pattern, unit, name = specification.pattern, specification.units, specification.name
    if made is not None:
        seed = Design(made.pattern, made.vertices_coords, unit, name)
        if isinstance(pattern, FilePattern) and pattern.keep_position:
            return DesignModel(seed.moved_to(seed.vertices_coords - origin))
        turn = pattern.turn if isinstance(pattern, FilePattern | FamilyPattern) else 0
        return DesignModel(placement.place_file(seed, target.frame, turn))

    if isinstance(pattern, TubePattern):
        steps, frame, turned = pattern.steps, target.frame, float(np.radians(pattern.turn))
        if isinstance(target, SectionTarget):
            steps = steps if pattern.section else sections.suited(steps, target)
            ring = seeds.tube(
                steps, 1, sector_angle=np.radians(pattern.sector_angle), fold_state=pattern.fold_state
            ).vertices_coords.reshape(-1, 2, 3)[..., :2]
            width, best = sections.laid(ring.mean(axis=1), target)
            frame, turned = replace(frame, extent=(frame.extent[0], width)), turned + best

        def make_tube(factor: float, rows: FloatArray) -> Design:
            return seeds.tube(
                [(n, a, factor * length) for n, a, length in steps], pattern.size[1],
                sector_angle=np.radians(pattern.sector_angle), fold_state=pattern.fold_state, lengths=rows,
                unit=unit, name=name,
            )  # fmt: skip

        rows = np.ones(pattern.size[1]) if pattern.lengths_v is None else np.array(pattern.lengths_v)
        return DesignModel(placement.place_tube(make_tube, frame, lengths=rows, turn=turned))

    assert isinstance(pattern, GridPattern)  # all others are made by now

    frame = target.frame if outline is None else outline.frame
    lengths: placement.Lengths = pattern.lengths_u, pattern.lengths_v
    if outline is not None and pattern.lengths_u is None and pattern.lengths_v is None:
        lengths = outline.strips(pattern.size, pattern.turn)

    def make(lengths_u: FloatArray, lengths_v: FloatArray) -> Design:
        return seeds.grid(
            pattern.size, pattern.u_lines, pattern.v_lines,
            sector_angle=np.radians(pattern.sector_angle), fold_state=pattern.fold_state,
            lengths_u=lengths_u, lengths_v=lengths_v, unit=unit, name=name,
        )  # fmt: skip

    seed = placement.place_grid(
        make, pattern.size, frame, lengths=lengths, turn=pattern.turn, start_size=pattern.start_size
    )
    return DesignModel(seed) if outline is None else _trimmed(seed, outline)


def _trimmed(seed: Design, outline: Outline) -> DesignModel:
    left, over_holes = outline.trim(seed)
    return DesignModel(left, over_holes, trimmed=left is not seed)
