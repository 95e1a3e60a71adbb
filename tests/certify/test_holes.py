"""Every hole is gone around, and what the strips around holes and the vertices leave free is counted."""

from __future__ import annotations

from itertools import combinations

import designs
import numpy as np
import pytest
from certify_cases import (
    FOUR_GON,
    SIX_GON,
    failures,
    frame_of,
    generic,
    hinged,
    motion_of,
    relabelled,
    without_facets,
)

from inverse import certify
from inverse.certify import dual_quaternions as dual
from inverse.certify import loops, mobility
from inverse.certify.mesh import build_mesh
from inverse.files import fold_file
from inverse.origami import seeds


def _sheet(holes, opening, amount=1e-3):
    """A sheet with these holes, (column) facets of its second row; only the strip around ``opening`` opens.

    Conditions of all vertices hold that are interior while the other holes are still filled in: strips around these
    stay closed.
    """
    width = 3 * len(holes) + 1
    facets = {hole: width * 1 + 2 + 3 * hole for hole in holes}
    whole = seeds.grid((3, width), "FL", "FL")
    open_design = generic(designs.without(whole, [facets[opening]]), amount, seed=3)
    faces = [list(face) for face in open_design.pattern.faces_vertices]
    gone = {frozenset(whole.pattern.faces_vertices[facets[hole]]) for hole in holes if hole != opening}
    assert len(open_design.vertices_coords) == len(whole.vertices_coords)
    doc = fold_file.document(
        designs.without(open_design, [f for f, face in enumerate(faces) if frozenset(face) in gone])
    )
    for key in ("file_frames", "bdffpq:holes", "bdffpq:topology", "bdffpq:grid"):
        doc.pop(key, None)
    return doc


@pytest.mark.parametrize(("count", "opening"), [(1, 0), (2, 0), (2, 1), (3, 0), (3, 1), (3, 2)])
def test_the_one_hole_whose_strip_opens_is_found(count, opening):
    doc = _sheet(range(count), opening)
    certificate = certify.check_frame(frame_of(doc))
    assert certificate.n_holes == count
    gaps = np.array([loop.gap for loop in certificate.loops])
    assert len(gaps) == count
    (hole,) = np.flatnonzero(gaps > 1e-7)
    assert np.delete(gaps, hole).max(initial=0.0) < 1e-12
    check = certificate.checks["loop_closure"]
    assert not check.passed
    assert check.value == gaps[hole]
    assert check.worst.startswith(f"hole {hole}, strip of {len(certificate.loops[hole].facets)} facets from facet ")
    # The strip goes around the hole that was meant, which lies in the column of its number.
    points = np.array(doc["vertices_coords"])
    faces = doc["faces_vertices"]
    centre = [np.mean([points[faces[f]].mean(axis=0) for f in loop.facets], axis=0) for loop in certificate.loops]
    along = np.array(centre) @ (points[3 * count + 1] - points[0])
    assert np.argsort(np.argsort(along))[hole] == opening
    assert failures(certificate) >= {"loop_closure", "motion_gap"}


@pytest.mark.parametrize(("section", "rows"), [(FOUR_GON, 1), (FOUR_GON, 3), (SIX_GON, 2)])
def test_a_strip_around_a_tube_opens_as_its_facets_do(section, rows):
    # Against the facets themselves, carried once around the tube: how far this moves the first one's vertices.
    motion = motion_of(fold_file.document(generic(seeds.tube(section, rows), 1e-2)))
    strips = loops.shortest_strips(motion.mesh)
    (value, where), (loop,) = loops.closure(motion, strips)
    (facets, edges) = strips[0]
    worst = 0.0
    for theta in np.linspace(0, np.pi, 361):
        carried = np.eye(8)[0][:, None]
        for facet, edge in zip(facets, edges, strict=True):
            carried = dual.multiply(
                carried, motion.hinges(np.array([theta]), np.array([edge]), np.array([facet]))[:, :, 0]
            )
        moved = dual.move(np.broadcast_to(carried, (8, len(motion.points))), motion.points.T)
        worst = max(worst, float(np.linalg.norm(moved - motion.points.T, axis=0).max()))
    # A bound on the way of any vertex, and not a lavish one.
    assert worst <= value * 1.01
    assert value < 8 * worst
    assert value == max(loop.gap_at_states, loop.gap_between)
    state = float(where.split("t = ")[1].split(" ")[0])
    assert -180 < state <= 180


def test_a_strip_leaves_every_facet_across_the_edge_that_is_told():
    for doc in (_sheet(range(2), 1), fold_file.document(seeds.tube(SIX_GON, 3))):
        mesh, _ = build_mesh(doc["faces_vertices"], len(doc["vertices_coords"]))
        for facets, edges in loops.shortest_strips(mesh):
            assert len(set(facets.tolist())) == len(facets) == len(edges)
            for here, there, edge in zip(facets, np.roll(facets, -1), edges, strict=True):
                assert set(mesh.sides[edge].tolist()) == {here, there}


# Freedom.


@pytest.mark.parametrize("count", [2, 3, 5])
def test_hinges_in_a_row_move_one_by_one(count):
    motion = motion_of(hinged([0.5] * count, [1.0] * (count + 1)))
    assert mobility.freedom(motion, ()) == count
    (fault,) = mobility.faults(motion, ())
    assert fault.startswith(f"there are {count} independent motions: the fold lines fall into {count} groups")
    assert mobility.faults(motion_of(hinged([0.5], [1.0, 1.0])), ()) == []


@pytest.mark.parametrize("seed", range(6))
def test_groups_are_the_fold_lines_that_interior_vertices_join(seed):
    whole = fold_file.document(seeds.grid((4, 5)))
    doc = relabelled(without_facets(whole, {6, 13}, []), np.random.default_rng(seed))
    mesh, _ = build_mesh(doc["faces_vertices"], len(doc["vertices_coords"]))
    ends = [set(mesh.edges[e].tolist()) & set(mesh.interior_vertices.tolist()) for e in mesh.inner]
    group = list(range(len(ends)))
    for _ in ends:
        for a, b in combinations(range(len(ends)), 2):
            if ends[a] & ends[b]:
                group[a] = group[b] = min(group[a], group[b])
    count, found = mobility.groups(mesh)
    assert count == len(set(group)) == found.max() + 1
    assert len(set(zip(group, found.tolist(), strict=True))) == count


@pytest.mark.parametrize("section", [FOUR_GON, SIX_GON])
def test_the_motions_of_a_ring_of_parallel_hinges(section):
    # A planar linkage of k hinges keeps k - 3 motions; tubes of more rows have one.
    motion = motion_of(fold_file.document(seeds.tube(section, 1)))
    assert mobility.freedom(motion, loops.shortest_strips(motion.mesh)) == len(section) - 3
    assert mobility.groups(motion.mesh)[0] == len(section)
    motion = motion_of(fold_file.document(seeds.tube(section, 2)))
    assert mobility.freedom(motion, loops.shortest_strips(motion.mesh)) == 1
