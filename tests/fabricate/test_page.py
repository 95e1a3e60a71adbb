"""The page with a slider, in a browser without a network."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import designs
import numpy as np
import pytest

import inverse
from inverse.fabricate.film import motion
from inverse.fabricate.film.surroundings import Surroundings
from inverse.origami.footprint import box_axes, extents

NAME = 'tube </script><b>"bold"</b>'


@dataclass
class Opened:
    """The page and what it said and asked for."""

    page: Any
    said: list[str]
    requests: list[str]

    def picture(self) -> str:
        """What the canvas shows, after what was asked to be drawn is drawn."""
        return self.page.evaluate(
            "new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(view_of()))))"
        )


@pytest.fixture
def opened(browser: Any, tmp_path: Path) -> Iterator[Opened]:
    design = replace(designs.tube(6, 4), name=NAME)
    triangle = np.array([[0.0, 0, 0], [9, 0, 0], [0, 9, 0]]), np.array([[0, 1, 2]])
    path = tmp_path / "motion.html"
    around = Surroundings(target=triangle, context=triangle, person=True)
    path.write_bytes(motion.animation(design, ["html"], frames=19, surroundings=around)["html"])
    context = browser.new_context(viewport={"width": 900, "height": 600}, offline=True)
    page = context.new_page()
    found = Opened(page, [], [])
    page.on("console", lambda message: found.said.append(message.text))
    page.on("pageerror", lambda error: found.said.append(str(error)))
    page.on("request", lambda request: found.requests.append(request.url))
    page.goto(path.as_uri())
    page.evaluate("window.view_of = () => document.querySelector('canvas').toDataURL()")
    yield found
    assert found.said == []
    assert [url for url in found.requests if not url.startswith(("file:", "data:"))] == []
    context.close()


def until(page: Any, condition: str) -> None:
    """Wait for a condition; playwright's own waiting needs eval, which the page forbids."""
    end = time.monotonic() + 20
    while not page.evaluate(condition):
        assert time.monotonic() < end, f"not {condition} in time"
        page.wait_for_timeout(20)


pytestmark = pytest.mark.browser


def test_slider_moves_the_structure_and_the_figures(opened: Opened):
    page = opened.page
    slider = page.locator("#slider")
    assert slider.input_value() == "9"  # the design state
    assert page.locator("#state").text_content() == "t = 90.0°"
    seen = [opened.picture()]
    slider.focus()
    states = inverse.fold(designs.tube(6, 4), np.radians([100.0, 110.0])).vertices_coords
    for degrees, points in zip(("100.0", "110.0"), states, strict=True):
        page.keyboard.press("ArrowRight")
        assert page.locator("#state").text_content() == f"t = {degrees}°"
        words = page.locator("#figures").text_content()
        box = [float(number) for number in re.findall(r"[\d.]+", words)]
        assert words.endswith(" m")
        np.testing.assert_allclose(box, extents(points, box_axes(points)), atol=0.0051)
        seen.append(opened.picture())
    assert len(set(seen)) == 3


@pytest.mark.parametrize(
    "act",
    [
        lambda page: (page.mouse.move(400, 300), page.mouse.down(), page.mouse.move(480, 330), page.mouse.up()),
        lambda page: (page.mouse.move(400, 300), page.mouse.wheel(0, -300), until(page, "view.zoom > 1")),
        lambda page: (page.locator("#view").focus(), page.keyboard.press("ArrowUp")),
        lambda page: (page.locator("#view").focus(), page.keyboard.press("+")),
    ],
    ids=["drag", "wheel", "arrow", "plus"],
)
def test_view_turns_and_zooms_and_comes_back(opened: Opened, act: Callable[[Any], Any]):
    first = opened.picture()
    act(opened.page)
    assert opened.picture() != first
    opened.page.locator("#view").focus()
    opened.page.keyboard.press("Home")
    assert opened.picture() == first


def test_plays_and_pauses(opened: Opened):
    page = opened.page
    page.keyboard.press(" ")
    assert page.locator("#play").text_content() == "Pause"
    until(page, "Number(slider.value) > 11")
    # To the end and back again.
    until(page, "way === -1")
    page.locator("#play").click()
    assert page.locator("#play").text_content() == "Play"


def test_name_is_text_whatever_it_holds(opened: Opened):
    assert opened.page.locator("h1").text_content() == NAME
    assert opened.page.title() == f"{NAME}: motion"
    assert opened.page.locator("b").count() == 0


def test_everything_is_drawn(opened: Opened):
    """Colours of the sheet's two sides and of the page: not one flat colour, no fault of WebGL."""
    opened.picture()
    count = opened.page.evaluate("""() => {
        const canvas = document.createElement("canvas"), shown = document.querySelector("#view");
        Object.assign(canvas, { width: shown.width, height: shown.height });
        const context = canvas.getContext("2d");
        context.drawImage(shown, 0, 0);
        return new Set(new Uint32Array(context.getImageData(0, 0, canvas.width, canvas.height).data.buffer)).size;
    }""")
    assert count > 20
    assert opened.page.evaluate("gl.getError()") == 0
