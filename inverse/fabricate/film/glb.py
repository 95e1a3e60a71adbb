"""The motion as animated glTF: one node per panel, turned and moved as a rigid body from key frame to key frame."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from inverse._types import FloatArray, IntArray
from inverse.errors import InputError
from inverse.fabricate.film.poses import Poses
from inverse.fabricate.film.stage import Solid, Stage
from inverse.fabricate.units import metres
from inverse.origami import geometry
from inverse.pictures import colours, drawing

# Numbers of the glTF 2.0 specification.
_FLOAT, _UNSIGNED = 5126, 5125
_VERTICES, _INDICES = 34962, 34963
_LINE_LOOP, _TRIANGLES = 2, 4
_Z_UP = [-(0.5**0.5), 0.0, 0.0, 0.5**0.5]  # glTF has y upwards


def motion_glb(stage: Stage, keys: Poses, rate: float) -> bytes:
    """A binary glTF file of a motion.

    Every panel is a node with a track of rotations and one of translations, so that players, which turn and move
    evenly between key frames, keep panels rigid. The two sides have materials of their own. Lengths are metres
    (a design without a unit is taken for metres).

    Args:
        stage: the design and what stands around it.
        keys: the key frames.
        rate: frames of the stage in a second; key frames between them are as much closer in time.

    Returns:
        The content of a .glb file.

    Raises:
        InputError: pygltflib is missing.
    """
    file = _File(f"{stage.design.name}: motion")
    design = stage.design
    home = design.vertices_coords.mean(axis=0)  # near it, single precision is fine
    children = _panels(file, stage, keys, home, rate)
    children += [_solid(file, solid, home) for solid in stage.solids]
    scale = metres(design.unit)
    x, y, z = (scale * home).tolist()
    root = file.node(name=design.name, children=children, rotation=_Z_UP, scale=[scale] * 3, translation=[x, z, -y])
    return file.content(root)


def _panels(file: _File, stage: Stage, keys: Poses, home: FloatArray, rate: float) -> list[int]:
    """Nodes of all panels, animated."""
    design = stage.design
    top, bottom = drawing.sides_of(design.pattern, design.vertices_coords, stage.view)
    materials = file.material("top", top[1]), file.material("bottom", bottom[1]), file.material("edges", colours.INK)
    seconds = np.linspace(0.0, (len(stage.t) - 1) / rate, len(keys.t))
    times = file.accessor(seconds, "SCALAR", bounds=True)
    centroids = geometry.facet_centroids(design.pattern, design.vertices_coords)
    fans: dict[int, tuple[int, int]] = {}
    nodes = []
    for f, face in enumerate(design.pattern.faces_vertices):
        n = len(face)
        if n not in fans:
            fan = np.array([(0, k, k + 1) for k in range(1, n - 1)])
            fans[n] = file.indices(fan), file.indices(fan[:, ::-1])
        corners = file.accessor(design.vertices_coords[list(face)] - centroids[f], "VEC3", _VERTICES, bounds=True)
        parts = [(fans[n][0], _TRIANGLES), (fans[n][1], _TRIANGLES), (None, _LINE_LOOP)]
        mesh = file.mesh(
            [(corners, faces, mode, material) for (faces, mode), material in zip(parts, materials, strict=True)]
        )
        # Where nothing plays, panels are in the design state.
        place = (centroids[f] - home).tolist()
        nodes.append(file.node(name=f"panel {f}", mesh=mesh, rotation=[0.0, 0.0, 0.0, 1.0], translation=place))
        file.track(nodes[-1], "rotation", times, file.accessor(keys.quaternions[:, f], "VEC4"))
        file.track(nodes[-1], "translation", times, file.accessor(keys.centroids[:, f] - home, "VEC3"))
    return nodes


def _solid(file: _File, solid: Solid, home: FloatArray) -> int:
    """A node that stands still, seen from both sides."""
    material = file.material(solid.name, solid.shades[1], solid.opacity)
    used, triangles = np.unique(solid.triangles, return_inverse=True)
    corners = file.accessor(solid.vertices[used] - home, "VEC3", _VERTICES, bounds=True)
    faces = file.indices(triangles.reshape(-1, 3))
    return file.node(name=solid.name, mesh=file.mesh([(corners, faces, _TRIANGLES, material)]))


class _File:
    """A glTF file in the making: its parts get numbers as they are added."""

    def __init__(self, name: str) -> None:
        try:
            import pygltflib
        except ImportError:
            raise InputError(
                "glTF needs the Python package pygltflib", hint='pip install "inverse[fabricate]"'
            ) from None
        self._types: Any = pygltflib
        self._gltf = pygltflib.GLTF2(asset=pygltflib.Asset(version="2.0", generator="inverse"))
        self._animation = pygltflib.Animation(name="motion")
        self._gltf.animations.append(self._animation)
        self._gltf.scene = 0
        self._name = name
        self._blob = bytearray()

    def material(self, name: str, colour: str, opacity: float = 1.0) -> int:
        """A dull colour given as #rrggbb; glTF has linear colours."""
        shade = colours.rgb(colour) / 255
        linear = np.where(shade <= 0.04045, shade / 12.92, ((shade + 0.055) / 1.055) ** 2.4)
        dull = self._types.PbrMetallicRoughness(
            baseColorFactor=[*linear.tolist(), opacity], metallicFactor=0.0, roughnessFactor=0.9
        )
        material = self._types.Material(
            name=name,
            pbrMetallicRoughness=dull,
            doubleSided=name not in ("top", "bottom"),
            alphaMode="OPAQUE" if opacity == 1 else "BLEND",
            alphaCutoff=None,
        )
        return self._add(self._gltf.materials, material)

    def accessor(self, values: FloatArray, kind: str, target: int | None = None, *, bounds: bool = False) -> int:
        """Numbers in single precision, with their bounds where glTF asks for them."""
        return self._accessor(np.ascontiguousarray(values, np.float32), _FLOAT, kind, target, bounds)

    def indices(self, triangles: IntArray) -> int:
        """Vertices of triangles."""
        return self._accessor(np.ascontiguousarray(triangles.ravel(), np.uint32), _UNSIGNED, "SCALAR", _INDICES, False)

    def mesh(self, parts: list[tuple[int, int | None, int, int]]) -> int:
        """A mesh of primitives, each with its corners, its indices if it has any, its mode and its material."""
        primitives = [
            self._types.Primitive(
                attributes=self._types.Attributes(POSITION=corners), indices=indices, mode=mode, material=material
            )
            for corners, indices, mode, material in parts
        ]
        return self._add(self._gltf.meshes, self._types.Mesh(primitives=primitives))

    def node(self, **keys: Any) -> int:
        """A node with the given keys."""
        return self._add(self._gltf.nodes, self._types.Node(**keys))

    def track(self, node: int, path: str, times: int, values: int) -> None:
        """How a node's rotation or translation runs, turning evenly and moving evenly between the times."""
        sampler = self._types.AnimationSampler(input=times, output=values, interpolation="LINEAR")
        target = self._types.AnimationChannelTarget(node=node, path=path)
        number = self._add(self._animation.samplers, sampler)
        self._animation.channels.append(self._types.AnimationChannel(sampler=number, target=target))

    def content(self, root: int) -> bytes:
        """The file, with this node as all that its scene shows."""
        self._gltf.scenes.append(self._types.Scene(name=self._name, nodes=[root]))
        self._gltf.buffers.append(self._types.Buffer(byteLength=len(self._blob)))
        self._gltf.set_binary_blob(bytes(self._blob))
        return b"".join(self._gltf.save_to_bytes())

    def _accessor(self, values: NDArray[Any], component: int, kind: str, target: int | None, bounds: bool) -> int:
        view = self._types.BufferView(buffer=0, byteOffset=len(self._blob), byteLength=values.nbytes, target=target)
        self._blob += values.tobytes()
        accessor = self._types.Accessor(
            bufferView=self._add(self._gltf.bufferViews, view), componentType=component, type=kind,
            count=values.shape[0],
            min=np.atleast_1d(values.min(axis=0)).tolist() if bounds else None,
            max=np.atleast_1d(values.max(axis=0)).tolist() if bounds else None,
        )  # fmt: skip
        return self._add(self._gltf.accessors, accessor)

    @staticmethod
    def _add(items: list[Any], item: Any) -> int:
        items.append(item)
        return len(items) - 1
