"""PDF pages: pieces whole where they fit, parts that overlap where not, and what stands below them."""

from __future__ import annotations

import io
import re
from collections import Counter
from collections.abc import Callable

import numpy as np
import pypdf
import pytest
import shapely
from designs import eggbox, hybrid, miura, tube
from hypothesis import given, settings
from hypothesis import strategies as st

from inverse._types import FloatArray
from inverse.errors import InputError
from inverse.fabricate import formats
from inverse.fabricate.cut.crease_plan import crease_plan, layers_plan
from inverse.fabricate.cut.dashes import perforated
from inverse.fabricate.cut.pages import EDGE, FOOT, PAPERS, Page, Placed, laid_out, room_of
from inverse.fabricate.cut.pdf import BAR, _shown, pdf
from inverse.fabricate.cut.plan import Line, Plan
from inverse.fabricate.formats import Settings, pages_note
from inverse.fabricate.units import ratio_below, scale_in_words, scale_of
from inverse.origami.pattern import Design

POINT = 25.4 / 72  # millimetres


def rectangle(width: float, height: float, angle: float = 0.0, piece: int = 0) -> list[Line]:
    c, s = np.cos(angle), np.sin(angle)
    corners = np.array([[0.0, 0], [width, 0], [width, height], [0, height]]) @ np.array([[c, s], [-s, c]])
    return [Line("cut", pair, k, piece) for k, pair in enumerate(np.stack([corners, np.roll(corners, -1, axis=0)], 1))]


def drawing(*lines: list[Line]) -> Plan:
    return Plan("sheet", (1.0, 1.0), tuple(line for own in lines for line in own))


def shown(plan: Plan, page: Page) -> dict[int, FloatArray]:
    """Ends (N, 2, 2) of the lines of every piece where they lie on a page, from the corner of its room."""
    found = {}
    for placed in page.placed:
        ends = np.array([line.ends for line in plan.lines if line.piece == placed.piece])
        found[placed.piece] = ends @ placed.turn.T + placed.shift
    return found


@pytest.mark.parametrize(
    ("size", "angle", "paper", "count"),
    [
        ((150, 200), 0.0, "A4", 1),
        ((200, 150), 0.0, "A4", 1),
        ((260, 190), 0.0, "A4", 1),
        ((262, 100), 0.7, "A4", 1),  # a strip that lies across would be cut in two
        ((380, 150), 0.3, "A3", 1),
        ((350, 240), 0.0, "A4", 2),
        ((880, 100), 1.1, "A4", 4),
    ],
)
def test_pages(size: tuple[float, float], angle: float, paper: str, count: int) -> None:
    plan = drawing(rectangle(*size, angle))
    content = pdf(plan, paper)
    assert pdf(plan, paper) == content
    pages = pypdf.PdfReader(io.BytesIO(content)).pages
    assert len(pages) == count
    for number, page in enumerate(pages, 1):
        sides = [float(page.mediabox.width) * POINT, float(page.mediabox.height) * POINT]
        assert sides == pytest.approx(PAPERS[paper], abs=0.01)
        part = f"part {chr(64 + number)}1, " if count == 2 else f"part A{number}, " if count > 1 else ""
        words = page.extract_text()
        assert f"100 mm, printed true to scale.  sheet, piece 1 of 1, {part}page {number}" in words
        bar = re.search(rb"([\d.]+) ([\d.]+) m ([\d.]+) \2 l S", page.get_contents().get_data().split(b".3 w")[1])
        assert bar is not None
        assert b"2.834646 0 0 2.834646 0 0 cm" in page.get_contents().get_data()
        assert float(bar[1]) == pytest.approx(EDGE)
        assert float(bar[3]) - float(bar[1]) == pytest.approx(BAR)


@settings(deadline=None)
@given(
    sizes=st.lists(st.tuples(st.floats(5, 600), st.floats(5, 600), st.floats(0, 3.2)), min_size=1, max_size=8),
    paper=st.sampled_from(sorted(PAPERS)),
)
def test_pieces_are_moved_stiffly_lie_apart_and_are_cut_only_if_they_must(
    sizes: list[tuple[float, float, float]], paper: str
) -> None:
    plan = drawing(*(rectangle(*size, piece=k) for k, size in enumerate(sizes)))
    room = room_of(paper)
    area = shapely.box(0, 0, *room).buffer(1e-6)
    whole: Counter[int] = Counter()
    covered: dict[int, float] = {}
    for page in laid_out(plan, paper):
        found = shown(plan, page)
        outlines = {piece: shapely.Polygon(ends[:, 0]) for piece, ends in found.items()}
        for piece, outline in outlines.items():
            width, height, _ = sizes[piece]
            assert outline.area == pytest.approx(width * height, rel=1e-9)
            assert outline.exterior.is_ccw  # not turned over
            if page.is_whole:
                whole[piece] += 1
                assert area.contains(outline)
                assert all(outline.distance(other) > 1 for k, other in outlines.items() if k != piece)
            else:
                covered[piece] = covered.get(piece, 0.0) + outline.exterior.intersection(area).length
    for piece, (width, height, _) in enumerate(sizes):
        fits = min(width, height) < room[0] - 1 and max(width, height) < room[1] - 1
        assert whole[piece] <= 1
        if fits:
            assert whole[piece] == 1
        if not whole[piece]:
            assert covered[piece] >= 2 * (width + height) * (1 - 1e-9)  # every line is somewhere


@pytest.mark.parametrize("paper", ["A4", "A2"])
def test_every_page_shows_all_that_is_within_it(paper: str) -> None:
    plan = perforated(crease_plan(tube(6, 10), scale=0.2, flaps=6.0), 4.0, 2.0)
    room = room_of(paper)
    laid, pages = laid_out(plan, paper), pypdf.PdfReader(io.BytesIO(pdf(plan, paper))).pages
    assert len(pages) == len(laid) > 1
    clip = shapely.box(0, 0, *room)
    seen: set[str] = set()
    for page, one in zip(pages, laid, strict=True):
        drawn = page.get_contents().get_data().split(b" W* n")[1:]
        assert len(drawn) == len(one.placed)
        for placed, text in zip(one.placed, drawn, strict=True):
            move = re.search(rb"(-?[\d.]+) (-?[\d.]+) (-?[\d.]+) (-?[\d.]+) (-?[\d.]+) (-?[\d.]+) cm", text)
            assert move is not None
            numbers = np.array([float(number) for number in move.groups()])
            turn, shift = numbers[:4].reshape(2, 2), numbers[4:] - [EDGE, EDGE + FOOT]
            lines = np.array(re.findall(rb"(?<=n )(-?[\d.]+) (-?[\d.]+) m (-?[\d.]+) (-?[\d.]+) l S", text), float)
            found = shapely.linestrings(lines.reshape(-1, 2, 2) @ turn + shift)
            whole = shapely.linestrings(shown(plan, one)[placed.piece])
            within = [shapely.length(shapely.intersection(some, clip)).sum() for some in (found, whole)]
            assert within[0] == pytest.approx(within[1], rel=1e-4)
            own = [word for word in plan.texts if word.piece == placed.piece]
            words = Counter(
                word.words for word in own if clip.contains(shapely.Point(placed.turn @ word.place + placed.shift))
            )
            assert not words - Counter(word.decode() for word in re.findall(rb"\(([\d.]+)\) Tj", text))
            seen |= set(words)
    assert seen == {text.words for text in plan.texts}


@pytest.mark.parametrize(
    ("pieces", "words"),
    [
        ([0], "piece 1 of 20"),
        ([0, 1, 2, 3], "pieces 1 to 4 of 20"),
        ([7, 0, 4, 5], "pieces 1, 5 to 6, 8 of 20"),
        (list(range(0, 20, 2)), "10 pieces of 20"),
    ],
)
def test_a_page_names_its_pieces(pieces: list[int], words: str) -> None:
    assert _shown(Page(tuple(Placed(piece, np.eye(2), np.zeros(2)) for piece in pieces)), 20) == words


def test_parts_without_a_line_are_left_out() -> None:
    names = {page.part_name for page in laid_out(drawing(rectangle(1500, 1500)), "A4")}
    assert "A1" in names
    assert "D3" not in names


@pytest.mark.parametrize("make", [lambda: tube(6, 10), hybrid, eggbox, miura])
@pytest.mark.parametrize("scale", [0.02, 0.11, 0.4])
@pytest.mark.parametrize("keys", [{}, {"flaps": 8.0}, {"layers": "apart"}, {"layers": "stacked"}, {"paper": "A3"}])
def test_the_scale_that_is_named_fits(make: Callable[[], Design], scale: float, keys: dict[str, object]) -> None:
    design, given_keys = make(), Settings(scale=scale, **keys)  # type: ignore[arg-type]
    told = pages_note(design, given_keys)
    pages = laid_out(formats.plan_of(design, given_keys), given_keys.paper or "A4")
    assert (told is None) == all(page.is_whole for page in pages)
    if told is not None:
        named = scale_of(told.split("--scale ")[1].split(" ")[0])
        assert 0.5 * scale * min(room_of("A4")) < named * 2000  # no smaller than it has to be
        assert pages_note(design, Settings(scale=named, **keys)) is None  # type: ignore[arg-type]


@pytest.mark.parametrize(("scale", "model"), [(0.02, "1:50, 1 m = 20 mm"), (1.0, "1:1, 1 m = 1000 mm")])
def test_a_page_tells_the_scale_and_the_kinds_of_lines_that_it_has(scale: float, model: str) -> None:
    for plan in (crease_plan(tube(6, 4), scale=scale, flaps=4.0), layers_plan(tube(6, 4), scale=scale)):
        words = pypdf.PdfReader(io.BytesIO(pdf(plan, "A2"))).pages[0].extract_text()
        assert f"Model {model}." in words
        layers = {line.layer for line in plan.lines}
        for layer in ("cut", "mountain", "valley", "complementary mountain", "complementary valley"):
            assert (re.search(rf"(?<!complementary ){layer}", words) is not None) == (layer in layers), layer
        assert ("cut, fold and glue" in words) == ("flap" in layers)


def test_scales_in_words() -> None:
    for words, scale in (
        ("1:50", 0.02),
        ("1/50", 0.02),
        ("0.02", 0.02),
        ("2:1", 2.0),
        (" 1 : 50", 0.02),
        ("1e-2", 0.01),
    ):
        assert scale_of(words) == pytest.approx(scale)
    for words in ("", "1:", ":5", "1:x", "1:2:3", "1:0", "fifty"):
        with pytest.raises(ValueError, match=r"such as 1:50 or 0\.02"):
            scale_of(words)
    assert scale_in_words(0.02, "m") == "1:50, 1 m = 20 mm"
    assert scale_in_words(2.0, "mm") == "2:1, 1 mm = 2 mm"
    assert scale_in_words(0.5, "unit") == "1:2"


@given(scale=st.floats(1e-4, 1e3))
def test_a_scale_is_rounded_down(scale: float) -> None:
    assert 0.98 * scale < scale_of(ratio_below(scale)) <= scale * (1 + 1e-9)


def test_papers_and_pages_that_cannot_be() -> None:
    with pytest.raises(InputError, match="'A9' is no paper: there are A0, A1") as refusal:
        pdf(drawing(rectangle(100, 100)), "A9")
    assert "Did you mean" in str(refusal.value)
    with pytest.raises(InputError, match=r"needs \d+ pages of A4: at most 500"):
        pdf(drawing(rectangle(9000, 9000)), "A4")
