"""Crease patterns to cut: read back by other libraries, put together by their labels, and measured."""

from __future__ import annotations

import io
import json
from collections import Counter
from collections.abc import Callable
from typing import Any

import ezdxf
import numpy as np
import pytest
import shapely
import svgelements
from designs import assert_close, eggbox, holed, hybrid, miura, tube
from hypothesis import given
from hypothesis import strategies as st

import inverse
from inverse.errors import InputError
from inverse.fabricate.cut.crease_plan import crease_plan, layers_plan
from inverse.fabricate.cut.dashes import perforated
from inverse.fabricate.cut.dxf import crease_dxf
from inverse.fabricate.cut.fold import crease_fold
from inverse.fabricate.cut.pieces import pieces_of
from inverse.fabricate.cut.plan import FOLDS, LAYERS, Line, Plan
from inverse.fabricate.cut.svg import svg
from inverse.files import fold_file
from inverse.origami import geometry, seeds
from inverse.origami.pattern import FL, Design, FloatArray, Pattern
from inverse.spec import load

SCALE = 0.037
POINT = 25.4 / 72


def solved_tube() -> Design:
    """A tube without symmetry."""
    target = {"axis": {"arc": [[0, 0, 0], [0.4, 0, 1.5], [1.5, 0, 2.6]]}, "radius": [[0, 1.0], [1, 0.7]]}
    task = {"name": "bent", "pattern": {"kind": "tube", "size": [6, 6]}, "target": target}
    result = inverse.solve(load(task))
    assert result.certified
    return result.design


def rolled_strip() -> Design:
    """Twelve sectors of 40 degrees of a pleated cone: laid flat they go round by more than a turn."""
    rise, sector = np.radians(15.0), np.radians(40.0)
    step = np.arccos((np.cos(sector) + np.sin(rise) ** 2) / np.cos(rise) ** 2)
    i = np.arange(13)
    flat = np.cos(rise) * np.stack([np.cos(i * step), np.sin(i * step)], axis=1)
    ways = np.column_stack([flat, np.sin(rise) * (-1.0) ** i])
    points = np.concatenate([ways, 1.6 * ways])
    faces = [[k, k + 13, k + 14, k + 1] for k in range(12)]
    pattern = Pattern.from_faces(faces, 26, lambda edges: np.full(len(edges), FL, np.int8))
    return Design(pattern, points, "m", "rolled")


DESIGNS: dict[str, Callable[[], Design]] = {
    "tube of 4": lambda: tube(4, 4),
    "tube of 6": lambda: tube(6, 10),
    "tube of 8": lambda: tube(8, 5),
    "plus": lambda: seeds.tube(seeds.NAMED_SECTIONS["plus"], 4),
    "L": lambda: seeds.tube(seeds.NAMED_SECTIONS["L"], 5),
    "tube without symmetry": solved_tube,
    "hybrid": hybrid,
    "eggbox": eggbox,
    "Miura": miura,
    "hole": holed,
    "rolled strip": rolled_strip,
}


@pytest.fixture(scope="module", params=DESIGNS)
def design(request: pytest.FixtureRequest) -> Design:
    return DESIGNS[request.param]()


# ---- reading back

Drawn = tuple[list[tuple[str, FloatArray]], list[tuple[str, FloatArray]]]  # layer and ends; words and place


def from_svg(content: bytes) -> Drawn:
    # Its millimetre is 0.0393701 inches, not 1 / 25.4: so that a pixel is a millimetre.
    document = svgelements.SVG.parse(io.BytesIO(content), ppi=1 / 0.0393701)
    lines, texts = [], []
    for element in document.elements():
        layer = element.values.get("{http://www.inkscape.org/namespaces/inkscape}label") or element.values.get("id", "")
        if isinstance(element, svgelements.SimpleLine):
            ends = np.array([[element.x1, element.y1], [element.x2, element.y2]])
            lines.append((layer, ends * [1, -1]))
        elif isinstance(element, svgelements.Text):
            place = element.transform.point_in_matrix_space((0, 0))
            texts.append((element.text, np.array([place.x, -place.y])))
    return lines, texts


def from_dxf(content: bytes) -> Drawn:
    document = ezdxf.read(io.StringIO(content.decode()))
    auditor = document.audit()
    assert not auditor.errors
    assert not auditor.fixes
    assert document.units == ezdxf.units.MM
    space = document.modelspace()
    lines = [(one.dxf.layer, np.array([one.dxf.start.vec2, one.dxf.end.vec2])) for one in space.query("LINE")]
    texts = [(one.dxf.text, np.array(one.get_placement()[1].vec2)) for one in space.query("TEXT")]
    return lines, texts


READERS: dict[str, Callable[[Plan], Drawn]] = {
    "svg": lambda plan: from_svg(svg(plan)),
    "dxf": lambda plan: from_dxf(crease_dxf(plan)),
}


def sides(polygon: FloatArray) -> FloatArray:
    """Length of the edge from every corner on, and angle there, (k, 2), of a polygon that turns counter-clockwise."""
    ahead, back = np.roll(polygon, -1, axis=0) - polygon, np.roll(polygon, 1, axis=0) - polygon
    cross = ahead[:, 0] * back[:, 1] - ahead[:, 1] * back[:, 0]
    return np.column_stack([np.linalg.norm(ahead, axis=1), np.arctan2(cross, (ahead * back).sum(axis=1))])


def signature(polygon: FloatArray) -> FloatArray:
    """Edge lengths and angles of a polygon (k, 2) that turns counter-clockwise, from its least one on."""
    rows = [np.roll(sides(polygon), -k, axis=0).ravel() for k in range(len(polygon))]
    return min(rows, key=lambda row: tuple(np.round(row, 6)))


def flat_facets(design: Design) -> list[FloatArray]:
    """Every facet of a design in its own plane, millimetres of the model."""
    found = []
    for face, normal in zip(
        design.pattern.faces_vertices, geometry.facet_normals(design.pattern, design.vertices_coords), strict=True
    ):
        points = 1000 * SCALE * design.vertices_coords[list(face)]
        x = geometry.unit(points[1] - points[0])
        found.append((points - points[0]) @ np.stack([x, np.cross(normal, x)], axis=1))
    return found


def assert_same_facets(polygons: list[FloatArray], design: Design) -> None:
    """All edge lengths and sector angles are those of the design, facet by facet, to 1e-9 relative."""
    ours, theirs = ([signature(one) for one in some] for some in (flat_facets(design), polygons))
    assert len(ours) == len(theirs)
    for rows in (ours, theirs):
        rows.sort(key=lambda row: tuple(np.round(row, 6)))
    left = list(theirs)
    for row in ours:
        near = min(range(len(left)), key=lambda k: np.abs(left[k] - row).max() if len(left[k]) == len(row) else np.inf)
        assert np.abs(left[near] / row - 1).max() < 1e-9
        left.pop(near)


Place = tuple[float, float]


def put_together(drawn: Drawn) -> tuple[list[FloatArray], Callable[[list[float]], Place]]:
    """Facets of a drawing, (k, 2) each, and where the vertex at a place is first drawn when equal labels are joined."""
    lines, texts = drawn
    ends = [pair for layer, pair in lines if layer != "flap"]
    places = {tuple(point) for pair in ends for point in pair.tolist()}
    polygons = shapely.get_parts(shapely.polygonize([shapely.LineString(pair) for pair in ends]))
    cut = shapely.union_all([shapely.LineString(pair) for layer, pair in lines if layer == "cut"]).buffer(1e-6)
    # A hole is cut all around, and bears no label.
    marks = shapely.MultiPoint([place for _, place in texts])
    polygons = [one for one in polygons if not (cut.contains(one.exterior) and one.disjoint(marks))]
    facets = [np.array(shapely.geometry.polygon.orient(one).exterior.coords)[:-1] for one in polygons]
    joined = {place: place for place in places}

    def root(point: list[float]) -> Place:
        place = (point[0], point[1])
        while joined[place] != place:
            place = joined[place]
        return place

    sides: dict[str, list[FloatArray]] = {}
    for words, place in texts:
        (within,) = [facet for facet, one in zip(facets, polygons, strict=True) if one.contains(shapely.Point(place))]
        edges = np.stack([within, np.roll(within, -1, axis=0)], axis=1)
        nearest = min(edges, key=lambda edge: shapely.LineString(edge).distance(shapely.Point(place)))
        sides.setdefault(words, []).append(nearest)
    for pair in sides.values():
        one, other = pair
        lengths = [np.linalg.norm(edge[1] - edge[0]) for edge in pair]
        assert abs(lengths[0] / lengths[1] - 1) < 1e-9
        for here, there in zip(one.tolist(), other[::-1].tolist(), strict=True):  # each goes round its own facet
            joined[root(here)] = root(there)
    return facets, root


Edge = tuple[Any, Any]  # from a vertex to the next one around a facet


def around(facets: list[list[Any]], polygons: list[FloatArray]) -> dict[Edge, tuple[Edge, FloatArray]]:
    """For every edge of every facet the next one around it, and its own length and angle."""
    found = {}
    for facet, polygon in zip(facets, polygons, strict=True):
        edges = list(zip(facet, [*facet[1:], facet[0]], strict=True))
        found |= dict(zip(edges, zip([*edges[1:], edges[0]], sides(polygon), strict=True), strict=True))
    return found


def walked(ours: dict[Edge, tuple[Edge, FloatArray]], theirs: dict[Edge, tuple[Edge, FloatArray]], first: Edge) -> Any:
    """Edges of a drawing by those of a design, from a first one on over all facets; None if they differ anywhere."""
    begin = next(iter(ours))
    found, left = {begin: first}, [begin]
    while left:
        edge = left.pop()
        own, other = ours[edge], theirs[found[edge]]
        if np.abs(other[1] / own[1] - 1).max() > 1e-9:
            return None
        back, other_back = edge[::-1], found[edge][::-1]
        if (back in ours) != (other_back in theirs):
            return None
        for here, there in ((own[0], other[0]), (back, other_back)):
            if here in ours and here not in found:
                left.append(here)
            if here in ours and found.setdefault(here, there) != there:
                return None
    return found if len(found) == len(ours) == len(theirs) else None


def vertices_of(drawn: Drawn, design: Design) -> dict[int, Place]:
    """Where each vertex of a design is drawn: a drawing put together has the same facets, and the same beside each."""
    facets, root = put_together(drawn)
    ours = around([list(face) for face in design.pattern.faces_vertices], flat_facets(design))
    theirs = around([[root(point) for point in facet.tolist()] for facet in facets], facets)
    found = next(filter(None, (walked(ours, theirs, first) for first in theirs)), None)
    assert found is not None, "the drawing put together is not the design"
    pairs = {(edge[0], other[0]) for edge, other in found.items()}
    assert len(pairs) == len(dict(pairs)) == len({place for _, place in pairs})
    return dict(pairs)


@pytest.mark.parametrize("flaps", [0.0, 3.0])
@pytest.mark.parametrize("reader", READERS)
def test_pieces_put_together_by_their_labels_are_the_design(reader: str, flaps: float, design: Design) -> None:
    drawn = READERS[reader](crease_plan(design, scale=SCALE, flaps=flaps))
    place_of = vertices_of(drawn, design)
    assert sorted(place_of) == list(range(design.pattern.n_vertices))
    root = put_together(drawn)[1]
    layers: dict[frozenset[Place], set[str]] = {}
    for layer, ends in drawn[0]:
        if layer != "flap":
            layers.setdefault(frozenset(map(root, ends.tolist())), set()).add(layer)
    document = fold_file.document(design)
    words = {"M": "mountain", "V": "valley"}
    for pair, kind, word in zip(
        document["edges_vertices"], document["bdffpq:edges_type"], document["edges_assignment"], strict=True
    ):
        found = layers.pop(frozenset(place_of[v] for v in pair))
        folded = words.get(word, "") if kind == "FL" else f"complementary {words.get(word)}"
        if kind == "B":
            assert found == {"cut"}
        elif kind == "FL" and design.name != "rolled":  # which is cut at a foldline
            assert found == {folded}
        else:
            assert "cut" in found or kind == "FL"
            assert found <= ({"cut", folded} if flaps or kind == "FL" else {"cut"})
    assert not layers


def test_putting_together_notices_labels_that_are_exchanged() -> None:
    design = tube(6, 10)
    lines, texts = from_svg(svg(crease_plan(design, scale=SCALE)))
    first, second = [next(k for k, (words, _) in enumerate(texts) if words == number) for number in ("3", "5")]
    assert vertices_of((lines, texts), design)
    texts[first], texts[second] = ("5", texts[first][1]), ("3", texts[second][1])
    with pytest.raises(AssertionError):
        vertices_of((lines, texts), design)


@pytest.mark.node
def test_fold_file_is_valid_and_the_same_facets(design: Design, rabbit_ear: Callable[[dict], dict]) -> None:
    document = json.loads(crease_fold(design, scale=SCALE))
    flat = document | {"vertices_coords": [[x, y, 0.0] for x, y in document["vertices_coords"]]}
    found = rabbit_ear(flat)
    assert found["validate"]["summary"] == "valid"
    assert not found["kawasaki"]
    points = np.array(document["vertices_coords"])
    assert_same_facets([points[face] for face in document["faces_vertices"]], design)
    assert document["frame_classes"] == ["creasePattern"]
    assert sorted(document["bdffpq:faces_facet"]) == list(range(len(design.pattern.faces_vertices)))
    counts = Counter(number for number in document["bdffpq:edges_seam"] if number)
    assert set(counts.values()) <= {2}


def test_reading_back_notices_a_wrong_length() -> None:
    plan = crease_plan(hybrid(), scale=SCALE)
    wrong = Plan(
        plan.title, plan.size, tuple(Line(one.layer, one.ends * [1 + 1e-7, 1]) for one in plan.lines), plan.texts
    )
    facets, _ = put_together(from_svg(svg(wrong)))
    with pytest.raises(AssertionError):
        assert_same_facets(facets, hybrid())


# ---- pieces, labels and flaps


def test_nothing_lies_over_anything(design: Design) -> None:
    plan = crease_plan(design, scale=SCALE, flaps=3.0)
    facets, _ = put_together(from_svg(svg(plan)))
    outline = [line.ends for line in plan.lines if line.layer == "flap"]
    flaps = [
        np.array([a[0], b[0], b[1], c[1]]) for a, b, c in zip(outline[::3], outline[1::3], outline[2::3], strict=True)
    ]
    low = [0.0, plan.size[1]]  # what is read back hangs down from the top
    polygons = [shapely.Polygon(corners - low) for corners in flaps] + [shapely.Polygon(one) for one in facets]
    area = sum(polygon.area for polygon in polygons)
    assert shapely.union_all(polygons).area == pytest.approx(area, rel=1e-9)
    points = np.array([line.ends for line in plan.lines]).reshape(-1, 2)
    assert points.min() >= 9.999
    assert (points.max(axis=0) <= np.array(plan.size) - 9.999).all()
    seams = {text.words for text in plan.texts}
    assert len(flaps) <= len(seams)
    assert len(flaps) >= 0.9 * len(seams) or design.name == "rolled"  # whose seam meets the strip's other end


def test_a_piece_that_would_lie_over_itself_is_cut() -> None:
    design = rolled_strip()
    pieces = pieces_of(design, SCALE)
    assert len(pieces) == 2
    assert sorted(f for piece in pieces for f in piece.faces) == list(range(12))
    assert {text.words for text in crease_plan(design, scale=SCALE).texts} == {"1"}


def test_layers_lie_where_they_lie() -> None:
    design = tube(6, 4)
    plan = layers_plan(design, scale=SCALE)
    names = [text.words for text in plan.texts]
    assert names == [f"layer {k} of {len(names)}" for k in range(1, len(names) + 1)]
    step = (plan.size[0] - 10.0) / len(names)
    flat = [line.ends - [step * np.floor((line.ends[:, 0].mean() - 10.0) / step), 0.0] for line in plan.lines]
    by_edge: dict[int, list[FloatArray]] = {}
    for line, ends in zip(plan.lines, flat, strict=True):
        by_edge.setdefault(line.edge, []).append(ends)
    assert set(by_edge) == set(range(len(design.pattern.edges_vertices)))
    doubled = [ends for ends in by_edge.values() if len(ends) == 2]
    assert doubled
    assert_close([a - b for a, b in doubled], 0.0, 1e-9)  # a seam is drawn in both layers, at one place


@pytest.mark.parametrize(
    ("options", "words"),
    [({"scale": 0.0}, "scale is 0"), ({"scale": np.nan}, "scale is nan"), ({"flaps": -1.0}, "flaps are -1 mm")],
)
def test_settings_that_cannot_be_are_refused(options: dict[str, float], words: str) -> None:
    with pytest.raises(InputError, match=words):
        crease_plan(miura(), **options)


# ---- dashes

LENGTHS = st.floats(0.1, 300.0)


@given(length=LENGTHS, dash=st.floats(0.2, 20.0), gap=st.floats(0.2, 20.0), angle=st.floats(0, 6.3))
def test_dashes_have_their_length_and_keep_from_the_ends(length: float, dash: float, gap: float, angle: float) -> None:
    start, way = np.array([3.0, -2.0]), np.array([np.cos(angle), np.sin(angle)])
    plan = Plan("line", (1.0, 1.0), (Line(FOLDS[1], np.array([start, start + length * way]), 7),))
    cuts = [(line.ends - start) @ way for line in perforated(plan, dash, gap).lines]
    ends = np.array(cuts)
    across = np.array([(line.ends - start) @ [-way[1], way[0]] for line in perforated(plan, dash, gap).lines])
    assert_close(across, 0.0, 1e-9)
    if length < dash + gap:
        assert_close(ends, [[length / 4, 3 * length / 4]], 1e-9)
        return
    assert len(ends) == int(length / (dash + gap))
    assert_close(ends[:, 1] - ends[:, 0], dash, 1e-9)
    between = np.r_[2 * ends[0, 0], ends[1:, 0] - ends[:-1, 1], 2 * (length - ends[-1, 1])]
    assert_close(between, between[0], 1e-8)
    assert between[0] >= gap - 1e-9
    assert {line.edge for line in perforated(plan, dash, gap).lines} == {7}


def test_what_is_cut_is_not_perforated() -> None:
    plan = crease_plan(hybrid(), scale=SCALE)
    dashed = perforated(plan, 3.0, 2.0)
    for layer in LAYERS:
        counts = [sum(line.layer == layer for line in one.lines) for one in (plan, dashed)]
        assert counts[0] == counts[1] if layer not in FOLDS else counts[0] <= counts[1]
    with pytest.raises(InputError, match=r"make 9.44e\+09 cuts: at most 500000 are drawn"):
        perforated(plan, 1e-7, 1e-7)
    for wrong in ((0.0, 1.0), (1.0, -1.0), (np.inf, 1.0)):
        with pytest.raises(InputError, match="more than 0 is needed"):
            perforated(plan, *wrong)
