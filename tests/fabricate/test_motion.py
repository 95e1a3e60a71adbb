"""States of a motion as files, the frames of animations and what stands around them."""

from __future__ import annotations

import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import designs
import numpy as np
import pytest
from designs import assert_close, best_motion

import inverse
from inverse.errors import InputError
from inverse.fabricate.film import motion
from inverse.fabricate.film.poses import poses
from inverse.fabricate.film.stage import set_stage
from inverse.fabricate.film.surroundings import Surroundings, person, read_buildings, read_target
from inverse.origami import geometry
from inverse.origami.pattern import Design

TARGETS = Path(__file__).parents[2] / "targets"
every_design = pytest.mark.parametrize("make", designs.ALL.values(), ids=designs.ALL)


@every_design
def test_states_between_the_flat_ones_are_designs_themselves(make: Callable[[], Design], tmp_path: Path):
    for degrees, content in zip((37.0, 139.5), motion.states(make(), [37.0, 139.5]), strict=True):
        path = tmp_path / "state.fold"
        path.write_text(content)
        certificate = inverse.check(path)
        # Crossings are another question: the seeds' motion may have some.
        wrong = [name for name, one in certificate.checks.items() if not one.passed and name != "crossing_design"]
        assert not wrong, certificate.checks
        state, document = inverse.read(path), json.loads(content)
        angles = np.degrees(geometry.fold_angles(state.pattern, state.vertices_coords))
        assert_close(angles, document["edges_foldAngle"], 1e-9)
        assert document["frame_title"] == f"t = {degrees:g} degrees"


@every_design
def test_flat_states_are_exact_and_in_the_plane(make: Callable[[], Design]):
    design = make()
    lengths = geometry.edge_lengths(design.pattern, design.vertices_coords)
    for kind, content in zip(("FL", "CFL"), motion.states(design, [180.0, 0.0]), strict=True):
        document = json.loads(content)
        points = np.array(document["vertices_coords"])
        assert points.shape == (design.pattern.n_vertices, 2)
        a, b = points[design.pattern.edges_vertices].transpose(1, 0, 2)
        assert_close(np.linalg.norm(b - a, axis=1), lengths, 1e-12 * lengths.max() * len(lengths))
        folded = np.array([word == kind for word in document["bdffpq:edges_type"]])
        angles = np.array(document["edges_foldAngle"])
        assert (np.abs(angles[folded]) == 180).all()
        assert (angles[~folded] == 0).all()


def test_state_at_90_degrees_is_the_design():
    design = designs.hybrid()
    document = json.loads(motion.states(design, [90.0])[0])
    assert_close(document["vertices_coords"], design.vertices_coords, 1e-12)


@every_design
def test_body_neither_drifts_nor_tumbles_and_stands_on_its_ground(make: Callable[[], Design]):
    design = make()
    t = np.linspace(0, np.pi, 41)
    held = poses(design, t).vertices_coords
    free = inverse.fold(design, t).vertices_coords
    size = geometry.diagonal(design.vertices_coords)
    for mine, theirs in zip(held, free, strict=True):
        assert_close(best_motion(mine, theirs), theirs, 1e-10 * size)
    assert_close(held[20], design.vertices_coords, 1e-12 * size)
    assert_close(held[..., :2].mean(axis=1), np.tile(design.vertices_coords[:, :2].mean(axis=0), (41, 1)), 1e-10 * size)
    assert_close(held[..., 2].min(axis=1), design.vertices_coords[:, 2].min(), 1e-10 * size)
    # From frame to frame there is no turn left to take back.
    for before, after in pairwise(held):
        turned = best_motion(after, before)
        assert np.linalg.norm(turned - (after - after.mean(axis=0) + before.mean(axis=0)), axis=1).max() < 0.05 * size


def test_a_frame_does_not_depend_on_the_others():
    design = designs.tube()
    some, all_of_them = np.array([2.9, 0.3]), np.linspace(0, np.pi, 50)
    together = poses(design, np.concatenate([all_of_them, some])).vertices_coords[-2:]
    assert_close(poses(design, some).vertices_coords, together, 1e-12)


def test_design_that_does_not_fold_is_refused():
    with pytest.raises(InputError, match=r"come apart by .* of its diagonal"):
        motion.states(designs.perturbed(designs.miura(), 1e-3), [45.0])


def test_person_is_as_tall_as_it_should_be_and_closed():
    vertices, triangles = person("cm", np.array([1.0, 2.0, 3.0]), np.array([0.0, 1.0, 0.0]))
    assert_close(np.ptp(vertices[:, 2]), 175.0, 1e-9)
    assert vertices[:, 2].min() == pytest.approx(3.0)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert set(map(tuple, edges.tolist())) == {(b, a) for a, b in edges.tolist()}
    a, b, c = vertices[triangles].transpose(1, 0, 2)
    assert np.einsum("ij,ij->", a - vertices.mean(axis=0), np.cross(b - a, c - a)) > 0


def test_person_stands_beside_the_motion_on_the_viewers_side_and_looks_at_the_viewer():
    stage = set_stage(designs.tube(6, 10), np.linspace(0, np.pi, 9), Surroundings(person=True))
    body = stage.figure[0]
    assert (body @ stage.view[0]).min() > (stage.points @ stage.view[0]).max()
    assert body[:, 2].min() == pytest.approx(stage.points[:, 2].min())
    towards = stage.view[2] * [1.0, 1.0, 0.0]
    # Beside the nearer half of what moves; feet point forward.
    assert (body @ towards).mean() > (stage.points @ towards).mean()
    feet = body[body[:, 2] < body[:, 2].min() + 0.05]
    assert (feet @ towards).mean() > (body @ towards).mean()


def test_person_among_buildings_is_in_sight():
    design, t = designs.miura(8, 8), np.linspace(0, np.pi, 5)
    free = set_stage(design, t, Surroundings(person=True))
    # A building between the viewer and the place where the person would stand.
    corner = free.figure[0].mean(axis=0) + 3 * free.view[2] * [1.0, 1.0, 0.0] - [2.0, 2.0, 0.0]
    corner[2] = free.ground
    box = corner + np.array([[x, y, z] for x in (0, 4.0) for y in (0, 4.0) for z in (0, 4.0)])
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([corner for a, b, c, d in sides for corner in ((a, b, c), (a, c, d))])
    stage = set_stage(design, t, Surroundings(context=(box, triangles), person=True))
    body = stage.figure[0]
    assert body[:, 2].min() == pytest.approx(free.ground)
    position = np.array(stage.camera((1280, 720)).position)
    for point in body[::9]:
        a, b, c = box[triangles].transpose(1, 0, 2)
        # The ray from the eye to the body, against all triangles (Moeller and Trumbore).
        solved = np.linalg.solve(np.stack([b - a, c - a, np.broadcast_to(position - point, a.shape)], axis=2),
                                 (position - a)[..., None])[..., 0]  # fmt: skip
        u, v, s = solved.T
        assert not ((u >= 0) & (v >= 0) & (u + v <= 1) & (s > 1e-9) & (s < 1)).any()


def test_person_needs_a_unit():
    with pytest.raises(InputError, match="frame_unit"):
        set_stage(designs.miura(unit="unit"), np.array([1.0, 2.0]), Surroundings(person=True))


def test_surroundings_come_from_a_specification_or_from_files():
    vertices, triangles = read_target(TARGETS / "vault.yaml")
    assert len(triangles)
    assert np.isfinite(vertices).all()
    assert len(read_target(TARGETS / "hypar.obj")[1])
    ours, theirs = (
        read_buildings(TARGETS / "vault.yaml", "m"),
        read_buildings(TARGETS / "vienna_excerpt.city.jsonl", "mm"),
    )
    assert len(ours[1]) == len(theirs[1])
    assert_close(np.ptp(theirs[0], axis=0) / 1000, np.ptp(ours[0], axis=0), 1e-9)
    with pytest.raises(InputError, match="names no buildings"):
        read_buildings(TARGETS / "dome.yaml", "m")
