"""MP4 and GIF, read back; and the pictures they are made of."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable
from itertools import pairwise
from typing import NoReturn

import designs
import numpy as np
import pytest
from PIL import Image

from inverse import pictures
from inverse.errors import InputError
from inverse.fabricate.film import film, motion
from inverse.fabricate.film.stage import NEARLY, set_stage
from inverse.fabricate.film.surroundings import Surroundings
from inverse.pictures import rendering
from inverse.pictures.camera import VIEW_ANGLE

SIZE = (320, 180)
# imageio's reader leaves the pipes of a film that it has read to its end open.
pytestmark = pytest.mark.filterwarnings("ignore:unclosed file:ResourceWarning")


@pytest.fixture(scope="module")
def drawn(lacking: Callable[[str], NoReturn]) -> tuple[dict[str, bytes], list[tuple[int, int]]]:
    if (sentence := pictures.can_render()) is not None:
        lacking(sentence)
    told: list[tuple[int, int]] = []
    design = designs.tube(6, 4)
    content = motion.animation(
        design, ["mp4", "gif"], frames=9, size=SIZE, progress=lambda done, count: told.append((done, count))
    )
    return content, told


def frames_of(content: bytes, tmp_path) -> tuple[dict, list[np.ndarray]]:
    import imageio_ffmpeg

    path = tmp_path / "film.mp4"
    path.write_bytes(content)
    reader = imageio_ffmpeg.read_frames(str(path))
    about = next(reader)
    width, height = about["size"]
    return about, [np.frombuffer(frame, np.uint8).reshape(height, width, 3) for frame in reader]


def test_mp4_has_as_many_frames_of_the_size_as_asked_for(drawn, tmp_path):
    about, frames = frames_of(drawn[0]["mp4"], tmp_path)
    assert len(frames) == 9
    assert about["size"] == SIZE
    assert about["fps"] == 25
    assert about["codec"] == "h264"


def test_gif_has_the_same_frames_and_repeats(drawn, tmp_path):
    _, expected = frames_of(drawn[0]["mp4"], tmp_path)
    with Image.open(io.BytesIO(drawn[0]["gif"])) as gif:
        assert gif.n_frames == 9
        assert gif.size == SIZE
        assert gif.info["loop"] == 0
        for number, picture in enumerate(expected):
            gif.seek(number)
            assert gif.info["duration"] == 40
            difference = np.abs(np.asarray(gif.convert("RGB")).astype(int) - picture)
            assert difference.mean() < 4
            assert np.asarray(gif.convert("RGB"))[0, 0].tolist() == [255, 255, 255]


def test_structure_moves_and_the_page_around_it_is_still(drawn, tmp_path):
    _, frames = frames_of(drawn[0]["mp4"], tmp_path)
    for before, after in pairwise(frames):
        assert np.abs(before.astype(int) - after).max() > 60
    for frame in frames:
        rim = np.concatenate([frame[:4].ravel(), frame[-3:].ravel(), frame[:, :4].ravel(), frame[:, -4:].ravel()])
        assert rim.min() > 245


def test_progress_counts_up_to_all_frames(drawn):
    done = [count for count, of in drawn[1] if of == 9]
    assert done == sorted(done)
    assert done[-1] == 9
    assert len(done) == len(drawn[1])


@pytest.mark.parametrize("make", [designs.miura, designs.hybrid, lambda: designs.tube(6, 10)])
@pytest.mark.parametrize("with_person", [False, True])
def test_one_camera_sees_all_of_every_frame(make, with_person: bool):
    t = np.linspace(0, np.pi, 7)
    stage = set_stage(make(), t, Surroundings(person=with_person))
    scenes = list(film._scenes(stage, SIZE, None))
    assert {scene.camera for scene in scenes} == {scenes[0].camera}
    camera = scenes[0].camera
    half = np.tan(np.radians(VIEW_ANGLE / 2)) * np.array([SIZE[0] / SIZE[1], 1.0])
    points = stage.points if stage.figure is None else np.concatenate([stage.points, stage.figure[0]])
    seen = (points - camera.position) @ stage.view.T
    share = np.abs(seen[:, :2]) / -seen[:, 2:] / half
    assert (seen[:, 2] < 0).all()
    assert 0.5 < share.max() < 0.95
    words = [scene.captions[0].text for scene in scenes]
    assert words == ["t = 0°", "t = 30°", "t = 60°", "t = 90°", "t = 120°", "t = 150°", "t = 180°"]


def test_flat_states_are_drawn_shortly_before():
    stage = set_stage(designs.miura(), np.array([0.0, np.pi / 2, np.pi]), Surroundings())
    np.testing.assert_allclose(stage.frames.t, [NEARLY, np.pi / 2, np.pi - NEARLY])


def test_edges_grow_faint_towards_stacks_of_layers():
    t = np.linspace(0, np.pi, 19)
    for make, developed, flat in ((designs.miura, 0, 1), (designs.eggbox, 1, 1), (lambda: designs.miura(1, 1), 0, 0)):
        faint = set_stage(make(), t, Surroundings()).faint
        np.testing.assert_allclose(faint[[0, -1]], [developed, flat], atol=1e-12)
        assert (faint[3:-3] == 0).all()


@pytest.mark.parametrize("size", [(641, 480), (640, 481), (32, 480), (640, 5000)])
def test_sizes_that_cannot_be_are_refused(size: tuple[int, int]):
    with pytest.raises(InputError, match="must be even and from 64 to 4096"):
        motion.animation(designs.miura(), ["mp4"], size=size)


def test_without_means_to_draw_it_is_said_what_can_be_had(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(rendering, "lacking", lambda: "No 3D pictures here.")
    with pytest.raises(InputError, match=r"No 3D pictures here.\n.*glb and html"):
        motion.animation(designs.miura(), ["gif"])


def test_missing_library_is_named_with_its_extra(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(InputError, match=r"inverse\[fabricate\]"):
        motion.animation(designs.miura(), ["mp4"])
