"""Pages and boards: true to scale, within their frames, the same bytes each time."""

from __future__ import annotations

import io
from dataclasses import replace
from itertools import pairwise
from xml.etree import ElementTree

import designs
import numpy as np
import pypdf
import pytest
from PIL import Image
from pypdf.generic import ContentStream

from inverse.boards import fonts
from inverse.boards.board import board
from inverse.boards.drawings import drawings
from inverse.boards.page import Layout, page
from inverse.boards.pdf import POINT, pdf
from inverse.boards.picture import OUTLINE
from inverse.boards.png import png
from inverse.boards.scales import ANY, largest_scale, read_scale, round_length
from inverse.boards.sheet import Area, Pen, Sheet, Stroke, Text, line
from inverse.boards.svg import svg
from inverse.boards.views import VIEWS, Subject
from inverse.errors import InputError
from inverse.origami.pattern import Design
from inverse.pictures.camera import basis


def metres(design: Design, size: float) -> Design:
    """A design so many metres long, moved away from the origin."""
    points = design.vertices_coords * size / np.ptp(design.vertices_coords, axis=0).max()
    return replace(design.moved_to(points + np.array([500.0, -300.0, 20.0])), unit="m", name="Wien Süd")


SHEET = metres(designs.miura(6, 8), 12.0)
CASES = {
    "sheet": Subject(SHEET, supports=(0, 1, 2), free=(0.0, 150.0)),
    "tube": Subject(metres(designs.tube(6, 6), 5.0)),
    "hybrid": Subject(replace(designs.hybrid(6), unit="unit")),
}


def paths(content: bytes) -> tuple[tuple[float, float], list[tuple[float, np.ndarray]]]:
    """Page size in mm, and width of the pen and points in mm of every path that a PDF strokes."""
    leaf = pypdf.PdfReader(io.BytesIO(content)).pages[0]
    found: list[tuple[float, np.ndarray]] = []
    points: list[list[float]] = []
    width = 0.0
    for operands, operator in ContentStream(leaf.get_contents(), None).operations:
        if operator == b"w":
            width = float(operands[0])
        elif operator in (b"m", b"l"):
            points.append([float(x) for x in operands])
        elif operator in (b"S", b"f*", b"B*", b"n"):
            found += [(width, np.array(points))] if operator == b"S" and points else []
            points = []
    return tuple(float(side) / POINT for side in leaf.mediabox[2:]), found


@pytest.mark.parametrize(("name", "rows"), [("plan", (0, 1)), ("front", (0, 2)), ("right", (1, 2))])
def test_pdf_is_true_to_scale(name: str, rows: tuple[int, int]):
    """The widest and highest extent of the heavy outline are those of the design at 1:100."""
    subject = replace(CASES["sheet"], style="line", supports=())
    sheet = page(subject, name, Layout("A3", "1:100"))
    size, found = paths(pdf(sheet))
    assert sorted(size) == pytest.approx([297, 420], abs=0.01)
    heavy = OUTLINE.width * np.clip(VIEWS[name].draw(subject).apart * 10 / 9, 0.25, 1.0)
    drawn = np.concatenate([points for width, points in found if width == pytest.approx(heavy, abs=1e-5)])
    c, s = np.cos(subject.turn), np.sin(subject.turn)
    own = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    extents = np.ptp(SHEET.vertices_coords @ own.T, axis=0)[list(rows)]
    np.testing.assert_allclose(np.ptp(drawn, axis=0), 10 * extents, atol=0.02)


def test_words_of_a_page_are_in_the_pdf():
    sheet = page(CASES["sheet"], "front", Layout("A3", "1:100", "May 2026"))
    text = pypdf.PdfReader(io.BytesIO(pdf(sheet))).pages[0].extract_text()
    for words in ("Front elevation", "1:100", "A3", "Wien Süd", "May 2026", "12.00 m"):
        assert words in text, words


@pytest.mark.parametrize("subject", CASES.values(), ids=CASES)
@pytest.mark.parametrize("name", [*VIEWS, "board"])
def test_all_is_within_the_frame_and_no_words_overlap(subject: Subject, name: str):
    sheet = board(subject, Layout()) if name == "board" else page(subject, name, Layout("A4"))
    single = [item.lines[0] for item in sheet.items if isinstance(item, Stroke) and len(item.lines) == 1]
    frame = max(single, key=lambda points: np.ptp(points, axis=0).prod())
    assert np.ptp(frame, axis=0).min() > 0.85 * min(sheet.width, sheet.height)
    low, high = frame.min(axis=0) - 1e-6, frame.max(axis=0) + 1e-6
    boxes = []
    for item in sheet.items:
        if isinstance(item, Text):
            wide = fonts.width(item.words, item.size, bold=item.bold)
            start = {"start": 0.0, "middle": -wide / 2, "end": -wide}[item.align]
            x, y = item.place
            part = [(start, 0.0), (start + wide, 0.72 * item.size)]
            if item.turned:
                part = [(-0.72 * item.size, start), (0.0, start + wide)]
            boxes.append((item.words, *(np.array([x, y]) + corner for corner in np.array(part))))
            corners = [*boxes[-1][1:]]
        else:
            corners = item.rings if isinstance(item, Area) else item.lines
        for points in corners:
            assert (points >= low).all(), item
            assert (points <= high).all(), item
    for k, (words, low, high) in enumerate(boxes):
        for other, below, above in boxes[:k]:
            assert (low > above).any() or (high < below).any(), (words, other)


def test_many_states_have_words_that_do_not_overlap():
    sheet = page(replace(CASES["tube"], states=12), "motion", Layout("A4"))
    texts = [item for item in sheet.items if isinstance(item, Text) and item.align == "middle"]
    ends = []
    for text in texts:
        if text.words[-1] in "°)" or "developed" in text.words:
            half = fonts.width(text.words, text.size) / 2
            ends.append((text.place[0] - half, text.place[0] + half))
    assert len(ends) == 12
    assert all(a[1] < b[0] for a, b in pairwise(sorted(ends)))


def test_same_drawing_same_bytes():
    subject = CASES["hybrid"]
    once, twice = (drawings(subject, ["plan", "motion"], ["pdf", "svg", "png"], Layout(), size=400) for _ in range(2))
    assert once == twice
    assert list(once) == ["plan.pdf", "plan.svg", "plan.png", "motion.pdf", "motion.svg", "motion.png"]


def test_svg_is_in_millimetres():
    root = ElementTree.fromstring(svg(page(CASES["tube"], "axonometric", Layout("A2"))))
    assert (root.get("width"), root.get("height"), root.get("viewBox")) == ("594mm", "420mm", "0 0 594 420")
    words = [element.text for element in root.iter("{http://www.w3.org/2000/svg}text")]
    assert "Axonometric" in words


def test_png_has_the_size_that_is_asked_for():
    picture = Image.open(io.BytesIO(png(page(CASES["tube"], "front", Layout("A3")), 900)))
    assert max(picture.size) == 900
    assert min(picture.size) == 636
    ink = np.asarray(picture.convert("L"))
    assert (ink < 60).mean() > 1e-3
    # The bands that it is drawn in leave no seams: half the size looks the same.
    half = np.asarray(
        picture.convert("L").resize((picture.width // 2, picture.height // 2), Image.Resampling.BOX), float
    )
    small = Image.open(io.BytesIO(png(page(CASES["tube"], "front", Layout("A3")), 450)))
    assert np.abs(np.asarray(small.convert("L"), float) - half).mean() < 4


def test_png_draws_holes_dashes_and_turned_words():
    square = np.array([[10.0, 10.0], [90.0, 10.0], [90.0, 90.0], [10.0, 90.0]])
    hole = 50 + (square - 50) / 2
    sheet = Sheet(100.0, 100.0, "test", [Area((square, hole), "#808080")])
    sheet.items.append(line((0, 5), (100, 5), pen=Pen(2.0, "#000000", (10.0, 10.0))))
    sheet.items.append(Text("HHHH", (8.0, 30.0), 8.0, turned=True))
    shown = np.asarray(Image.open(io.BytesIO(png(sheet, 200))).convert("L"))
    assert shown[100, 30] == 128
    assert shown[100, 100] == 255
    assert shown[190, 10] == 0
    assert shown[190, 30] == 255
    letters = np.argwhere(shown[:, :18] < 100)
    letters = letters[letters[:, 0] < 180]
    assert 120 < letters[:, 0].max() <= 141  # upwards from where it begins
    assert np.ptp(letters[:, 0]) > np.ptp(letters[:, 1])


def test_letters_that_no_font_has_do_no_harm():
    odd = Subject(replace(SHEET, name="Łódka 東京"))
    sheet = page(odd, "plan", Layout())
    text = pypdf.PdfReader(io.BytesIO(pdf(sheet))).pages[0].extract_text()
    assert "Łódka ??" in text
    assert "Łódka 東京" in svg(sheet).decode()
    png(sheet, 300)


@pytest.mark.parametrize(
    ("word", "unit", "factor"),
    [("1:50", "m", 20.0), (" 1 : 50 ", "mm", 0.02), ("2:1", "cm", 20.0), ("1:12.5", "m", 80.0)],
)
def test_scales_are_read(word: str, unit: str, factor: float):
    assert read_scale(word, unit).factor == pytest.approx(factor)


@pytest.mark.parametrize("word", ["50", "1:0", "0:1", "1/50", "one", "1:-5", "1:1e9", "1:9999999"])
def test_what_is_no_scale_is_refused(word: str):
    with pytest.raises(InputError, match="scale"):
        read_scale(word, "m")


def test_a_unit_without_length_has_no_scale():
    with pytest.raises(InputError, match="'unit', which has no length"):
        read_scale("1:50", "unit")
    assert largest_scale(23.0, "unit").words == "1 unit = 20 mm"


@pytest.mark.parametrize("steps", [None, ANY])
def test_largest_scale_fits_and_is_not_small(steps: tuple[float, ...] | None):
    for most in np.geomspace(1e-3, 1e3, 200):
        scale = largest_scale(most, "m") if steps is None else largest_scale(most, "m", steps)
        assert most / 2.01 < scale.factor <= most * (1 + 1e-6)
        assert read_scale(scale.words, "m").factor == pytest.approx(scale.factor)


def test_round_lengths():
    assert [round_length(x) for x in (0.3, 1.0, 4.99, 5.0, 37.0)] == [0.2, 1.0, 2.0, 5.0, 20.0]


def test_a_scale_that_is_too_large_says_what_fits_and_that_does():
    with pytest.raises(InputError, match=r"at 1:25 the drawing is .* mm, which has no room on A4") as refused:
        page(CASES["sheet"], "plan", Layout("A4", "1:25"))
    hint = refused.value.hint or ""
    words = hint.split()
    page(CASES["sheet"], "plan", Layout("A4", words[words.index("--scale") + 1]))
    page(CASES["sheet"], "plan", Layout(words[words.index("--paper") + 1], "1:25"))
    with pytest.raises(InputError, match="the board has no room on A1") as refused:
        board(CASES["sheet"], Layout(None, "1:5"))
    words = (refused.value.hint or "").split()
    board(CASES["sheet"], Layout(None, words[words.index("--scale") + 1]))


def test_a_person_is_drawn_to_scale_and_only_where_lengths_are_known():
    tall = CASES["sheet"].person(basis(-np.pi / 2, 0.0))
    assert tall is not None
    assert np.ptp(tall[..., 2]) == pytest.approx(1.75)
    assert CASES["hybrid"].height == 0
    assert Subject(metres(designs.miura(4, 4), 1.0)).height == 0  # larger than the design
