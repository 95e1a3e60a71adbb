"""The animated glTF, read with a reader of its own and played as viewers play it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass

import designs
import numpy as np
import pygltflib
import pytest
from designs import assert_close, best_motion
from scipy.spatial.transform import Rotation, Slerp

import inverse
from inverse.errors import InputError
from inverse.fabricate.film import motion
from inverse.fabricate.film.poses import OPENING
from inverse.fabricate.film.surroundings import Surroundings
from inverse.origami import geometry
from inverse.origami.pattern import Design, Pattern


def roll(count: int = 9) -> Design:
    """A strip of facets, every fold a valley: its ends turn by far more than half a turn, one against the other."""
    angle = np.radians(40) * np.arange(count + 1)
    rim = np.stack([np.cos(angle), np.sin(angle), 0.1 * angle], axis=1)
    points = np.concatenate([rim, rim + np.array([0.0, 0.0, 1.0])])
    k, over = np.arange(count), count + 1
    faces = np.stack([k, k + over, k + over + 1, k + 1], axis=1)
    return Design(Pattern.from_faces(faces.tolist(), len(points), designs.all_fl), points)


MAKERS = {
    "miura": designs.miura,
    "eggbox": designs.eggbox,
    "hybrid": designs.hybrid,
    "polygonal": designs.polygonal,
    "roll": roll,
    "tube": lambda: designs.tube(6, 10),
}
FRAMES = 7
every_design = pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)


@dataclass
class Panel:
    """One animated node as a viewer has it."""

    corners: np.ndarray
    times: np.ndarray
    rotations: np.ndarray
    translations: np.ndarray

    def at(self, time: float) -> np.ndarray:
        """Corners in their parent's frame: spherical interpolation of rotations, linear of translations."""
        turned = Slerp(self.times, Rotation.from_quat(self.rotations))(time).apply(self.corners)
        return turned + [np.interp(time, self.times, axis) for axis in self.translations.T]


class Player:
    """A glTF file."""

    def __init__(self, content: bytes) -> None:
        self.gltf = pygltflib.GLTF2.load_from_bytes(content)
        self.blob = self.gltf.binary_blob()
        (animation,) = self.gltf.animations
        tracks: dict[int, dict[str, tuple[np.ndarray, np.ndarray]]] = {}
        for channel in animation.channels:
            sampler = animation.samplers[channel.sampler]
            assert sampler.interpolation == "LINEAR"
            values = self.array(sampler.input)[:, 0], self.array(sampler.output)
            tracks.setdefault(channel.target.node, {})[channel.target.path] = values
        self.panels = []
        for number, track in sorted(tracks.items()):
            primitive = self.gltf.meshes[self.gltf.nodes[number].mesh].primitives[0]
            (times, rotations), (others, translations) = track["rotation"], track["translation"]
            np.testing.assert_array_equal(times, others)
            self.panels.append(Panel(self.array(primitive.attributes.POSITION), times, rotations, translations))
        (root,) = self.gltf.scenes[self.gltf.scene].nodes
        self.root = self.gltf.nodes[root]
        assert set(tracks) <= set(self.root.children)

    def array(self, number: int) -> np.ndarray:
        accessor = self.gltf.accessors[number]
        view = self.gltf.bufferViews[accessor.bufferView]
        kind = {5126: "<f4", 5125: "<u4"}[accessor.componentType]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor.type]
        start = (view.byteOffset or 0) + (accessor.byteOffset or 0)
        found = np.frombuffer(self.blob, kind, accessor.count * width, start).reshape(-1, width)
        return found.astype(np.float64) if kind == "<f4" else found

    def world(self, time: float) -> list[np.ndarray]:
        """Corners of all panels in the world of the viewer, y upwards."""
        turn, scale = Rotation.from_quat(self.root.rotation), np.array(self.root.scale)
        return [turn.apply(panel.at(time) * scale) + self.root.translation for panel in self.panels]


def glb(design: Design, **options: object) -> bytes:
    return motion.animation(design, ["glb"], frames=FRAMES, **options)["glb"]


def upright(points: np.ndarray) -> np.ndarray:
    """From y upwards to z upwards."""
    return points @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])


@every_design
def test_key_frames_are_states_of_the_motion(make: Callable[[], Design]):
    design = make()
    player = Player(glb(design))
    times = player.panels[0].times
    assert times[0] == 0
    assert times[-1] == pytest.approx((FRAMES - 1) / 25)
    assert (len(times) - 1) % (FRAMES - 1) == 0
    t = np.pi * times / times[-1]
    size = geometry.diagonal(design.vertices_coords)
    vertex = [v for face in design.pattern.faces_vertices for v in face]
    for time, expected in zip(times, inverse.fold(design, np.clip(t, 0, np.pi)).vertices_coords, strict=True):
        shown = np.concatenate(player.world(time))
        assert_close(best_motion(upright(shown), expected[vertex]), expected[vertex], 1e-6 * size)


@every_design
def test_panels_stay_rigid_and_together_between_key_frames(make: Callable[[], Design]):
    design = make()
    player = Player(glb(design))
    size = geometry.diagonal(design.vertices_coords)
    edge = float(np.median(geometry.edge_lengths(design.pattern, design.vertices_coords)))
    times = player.panels[0].times
    some = np.concatenate([(times[1:] + times[:-1]) / 2, np.random.default_rng(1).uniform(0, times[-1], 20)])
    for time in some:
        shown = player.world(time)
        for face, corners in zip(design.pattern.faces_vertices, shown, strict=True):
            own = design.vertices_coords[list(face)]
            distances = np.linalg.norm(corners[:, None] - corners, axis=2)
            assert_close(distances, np.linalg.norm(own[:, None] - own, axis=2), 1e-6 * size)
        by_vertex: dict[int, list[np.ndarray]] = {}
        for face, corners in zip(design.pattern.faces_vertices, shown, strict=True):
            for vertex, corner in zip(face, corners, strict=True):
                by_vertex.setdefault(vertex, []).append(corner)
        apart = max(np.ptp(corners, axis=0).max() for corners in by_vertex.values())
        assert apart <= 1.1 * OPENING * edge + 1e-6 * size


@every_design
def test_quaternions_are_of_unit_length_and_never_jump(make: Callable[[], Design]):
    for panel in Player(glb(make())).panels:
        assert_close(np.linalg.norm(panel.rotations, axis=1), 1.0, 1e-6)
        assert ((panel.rotations[1:] * panel.rotations[:-1]).sum(axis=1) > 0.7).all()


def test_rest_pose_is_the_design_in_metres_with_y_upwards():
    design = designs.hybrid(unit="mm")
    player = Player(glb(design))
    turn = Rotation.from_quat(player.root.rotation)
    for number, face in enumerate(design.pattern.faces_vertices):
        node = player.gltf.nodes[player.root.children[number]]
        corners = Rotation.from_quat(node.rotation).apply(player.panels[number].corners) + node.translation
        shown = turn.apply(corners * player.root.scale) + player.root.translation
        x, y, z = design.vertices_coords[list(face)].T / 1000
        assert_close(shown, np.stack([x, z, -y], axis=1), 1e-8)


def test_both_sides_have_triangles_that_face_them():
    player = Player(glb(designs.miura()))
    for mesh in player.gltf.meshes:
        top, bottom, _ = mesh.primitives
        corners = player.array(top.attributes.POSITION)
        normals = []
        for side in (top, bottom):
            a, b, c = corners[player.array(side.indices).reshape(-1, 3)].transpose(1, 0, 2)
            normals.append(np.cross(b - a, c - a))
        assert (np.einsum("ij,kj->ik", *normals) < 0).all()
        assert top.material != bottom.material
    colours = [m.pbrMetallicRoughness.baseColorFactor for m in player.gltf.materials]
    assert colours[0] != colours[1]


def test_range_begins_and_ends_where_it_says():
    design = designs.tube()
    player = Player(glb(design, degrees=(150.0, 60.0)))
    expected = inverse.fold(design, np.radians([150.0, 60.0])).vertices_coords
    vertex = [v for face in design.pattern.faces_vertices for v in face]
    for time, state in zip(player.panels[0].times[[0, -1]], expected, strict=True):
        shown = upright(np.concatenate(player.world(time)))
        assert_close(best_motion(shown, state[vertex]), state[vertex], 1e-6 * geometry.diagonal(state))


@pytest.mark.node
@every_design
def test_validator_finds_nothing(make: Callable[[], Design], gltf_issues: Callable[[bytes], list[str]]):
    assert gltf_issues(glb(make())) == []


@pytest.mark.node
def test_validator_finds_nothing_with_surroundings(gltf_issues: Callable[[bytes], list[str]]):
    triangle = np.eye(3) * 5, np.array([[0, 1, 2]])
    content = glb(designs.miura(), surroundings=Surroundings(target=triangle, context=triangle, person=True))
    assert gltf_issues(content) == []
    names = [node.name for node in pygltflib.GLTF2.load_from_bytes(content).nodes]
    assert {"target", "roofs", "person"} <= set(names)


@pytest.mark.node
def test_validator_can_say_no(gltf_issues: Callable[[bytes], list[str]]):
    content = glb(designs.miura(1, 1))
    spoilt = content.replace(b'"LINEAR"', b'"LUNEAR"')
    assert spoilt != content
    assert gltf_issues(spoilt)


def test_missing_library_is_named_with_its_extra(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "pygltflib", None)
    with pytest.raises(InputError, match=r"inverse\[fabricate\]"):
        glb(designs.miura(1, 1))
