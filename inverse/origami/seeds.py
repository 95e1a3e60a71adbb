"""Seeds in closed form: translation surfaces that satisfy every constraint exactly.

P(i, j) = A(i) + B(j) with steps u_i = l_i (n_i s, a_i c, 0) and v_j = k_j (0, b_j d, m_j w), where n, a, b, m
are +-1, s^2 + c^2 = d^2 + w^2 = 1 and c d = cos(sector angle). At each line exactly one sign flips, so every
vertex is a Miura or a Voss vertex as the types of its two lines say.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from inverse._types import BoolArray, FloatArray, IntArray
from inverse.crossing import crossing_facets
from inverse.errors import InputError
from inverse.extending.registry import Registry
from inverse.origami.geometry import diagonal
from inverse.origami.hybrids import crosses, lengths_without_crossing
from inverse.origami.pattern import CFL, FL, Design, Pattern

Word = str | Sequence[str]
Section = Sequence[tuple[int, int, float]]
_TYPES = {"FL": FL, "CFL": CFL}

#: Closed sections of tubes by their number of sides, steps (n, a, length): squares with 0 to 3 notched corners.
SECTIONS: dict[int, Section] = {
    4: ((1, 1, 1), (1, -1, 1), (-1, -1, 1), (-1, 1, 1)),
    6: ((1, 1, 2), (1, -1, 1), (-1, -1, 1), (1, -1, 1), (-1, -1, 1), (-1, 1, 2)),
    8: ((1, 1, 2), (1, -1, 2), (1, 1, 2), (1, -1, 2), (-1, -1, 3), (-1, 1, 1), (-1, -1, 1), (-1, 1, 3)),
    10: (
        *((1, 1, 2), (1, -1, 1), (1, 1, 1), (1, -1, 1), (-1, -1, 1)),
        *((1, -1, 1), (-1, -1, 1), (-1, 1, 1), (-1, -1, 1), (-1, 1, 2)),
    ),
}
#: Closed sections by the word that specifications use.
NAMED_SECTIONS: Registry[Section] = Registry(
    "a section",
    {
        **{f"{k}-gon": section for k, section in SECTIONS.items()},
        "plus": (
            *((1, 1, 1), (1, -1, 1), (1, 1, 1), (1, -1, 1), (-1, -1, 1), (1, -1, 1)),
            *((-1, -1, 1), (-1, 1, 1), (-1, -1, 1), (-1, 1, 1), (1, 1, 1), (-1, 1, 1)),
        ),
        "L": ((1, 1, 3), (1, -1, 1), (-1, -1, 2), (1, -1, 2), (-1, -1, 1), (-1, 1, 3)),
    },
)


def section(name: str, steps: Section) -> None:
    """Register a closed section of tubes, for ``pattern: {kind: tube, section: name, ...}``.

    Args:
        name: of the section.
        steps: (n, a, length) around, see :func:`tube`.

    Raises:
        InputError: the name is taken or no word, or no tube has this section.
    """
    try:
        rows = tuple((int(n), int(a), float(length)) for n, a, length in steps)
    except (TypeError, ValueError):
        raise InputError(f"section {name} is {steps!r}: a list of steps (n, a, length) is wanted") from None
    try:
        tube(rows, 1)
    except InputError as error:
        raise InputError(f"section {name}: {error.message}", hint=error.hint) from None
    NAMED_SECTIONS.add(name, rows)


def grid_pattern(size: tuple[int, int], u_lines: Word = "FL", v_lines: Word = "FL") -> Pattern:
    """The pattern of an m x n grid of quads, vertex (i, j) numbered i (n + 1) + j.

    Args:
        size: facets along u and v, (m, n).
        u_lines: type of the m - 1 interior lines crossed by walking along u, one word for all or a list.
        v_lines: type of the n - 1 interior lines crossed by walking along v.

    Returns:
        The pattern, without coordinates.

    Raises:
        InputError: a size below 1, a word other than FL and CFL, or a wrong number of words.
    """
    m, n = _size(size)
    u_types, v_types = _word(u_lines, m - 1, "u_lines"), _word(v_lines, n - 1, "v_lines")
    return _grid_pattern(m, n, tuple(u_types), tuple(v_types))


@lru_cache(maxsize=4)
def _grid_pattern(m: int, n: int, u_types: tuple[int, ...], v_types: tuple[int, ...]) -> Pattern:
    """The same, one object for all grids of these sizes and types: what is derived from it is derived once."""
    i, j = (k.ravel() for k in np.meshgrid(np.arange(m), np.arange(n), indexing="ij"))
    first = i * (n + 1) + j
    faces = np.stack([first, first + n + 1, first + n + 2, first + 1], axis=1)

    def types(edges: IntArray) -> np.ndarray:
        (i0, j0), (i1, _) = (np.divmod(edges[:, k], n + 1) for k in (0, 1))
        u_type = np.r_[0, u_types, 0][i0]
        v_type = np.r_[0, v_types, 0][j0]
        return np.asarray(np.where(i0 == i1, u_type, v_type), np.int8)

    return Pattern.from_faces(faces.tolist(), (m + 1) * (n + 1), types, grid=(m, n))


def grid(
    size: tuple[int, int],
    u_lines: Word = "FL",
    v_lines: Word = "FL",
    *,
    sector_angle: float = np.pi / 3,
    fold_state: float = 0.5,
    lengths_u: Sequence[float] | FloatArray | None = None,
    lengths_v: Sequence[float] | FloatArray | None = None,
    unit: str = "m",
    name: str = "seed",
) -> Design:
    """A semi-folded grid seed: Miura (FL/FL), eggbox (CFL/FL, FL/CFL) or a hybrid.

    Args:
        size: facets along u and v, (m, n).
        u_lines: one word or m - 1 words, see :func:`grid_pattern`.
        v_lines: one word or n - 1 words.
        sector_angle: of every facet, radians in (0, pi/2).
        fold_state: in (0, 1); c = cos(sector_angle) + fold_state (1 - cos(sector_angle)).
        lengths_u: m strip lengths, 1 if not given.
        lengths_v: n strip lengths, 1 if not given.
        unit: length unit.
        name: title.

    Returns:
        The seed; its residuals are zero to rounding.

    Raises:
        InputError: a value out of its range, or words whose translation surface doubles back: vertices
            coincide or facets cross; the message names the line at which it does.
    """
    m, n = _size(size)
    pattern = grid_pattern((m, n), u_lines, v_lines)
    s, c, d, w = _directions(sector_angle, fold_state)
    along_u = _lengths(lengths_u, m, "lengths_u")
    along_v = _lengths(lengths_v, n, "lengths_v")
    u_is_fl = np.array(_word(u_lines, m - 1, "u_lines")) == FL
    v_is_fl = np.array(_word(v_lines, n - 1, "v_lines")) == FL

    # Two readings of the words give a mesh: FL flips (a, m) or FL flips (n, b). The first is kept unless its two
    # drifts are nearly parallel, in which case the sheet has no extent in one direction, or it doubles back.
    # They are compared in a reference state, so that the choice does not depend on the fold state.
    reference = _directions(np.pi / 3, 0.5)
    readings = []
    for fl_flips_a in (True, False):
        n_sign, a_sign = _signs(u_is_fl != fl_flips_a), _signs(u_is_fl == fl_flips_a)
        b_sign, m_sign = _signs(v_is_fl != fl_flips_a), _signs(v_is_fl == fl_flips_a)
        steps = []
        for x, y, p, q in (reference, (s, c, d, w)):
            u = along_u[:, None] * np.stack([n_sign * x, a_sign * y, 0 * n_sign], axis=1)
            v = along_v[:, None] * np.stack([0 * b_sign, b_sign * p, m_sign * q], axis=1)
            steps.append((u, v))
        area = float(np.linalg.norm(np.cross(steps[0][0].sum(axis=0), steps[0][1].sum(axis=0))))
        readings.append((area, *steps[1]))
    if readings[0][0] < 0.25 * readings[1][0]:
        readings.reverse()
    refusals = []
    for _, u, v in readings:
        points = _walk(u)[:, None, :] + _walk(v)[None, :, :]
        refusal = _doubling_back(points, pattern)
        if refusal is None:
            return Design(pattern, points.reshape(-1, 3), unit, name)
        refusals.append(refusal)
    raise _doubled(refusals[0], (u_is_fl, along_u), (v_is_fl, along_v))


def _doubled(where: str, u: tuple[BoolArray, FloatArray], v: tuple[BoolArray, FloatArray]) -> InputError:
    """What is said of a seed that doubles back, with strip lengths for which it does not, if there are any.

    Args:
        where: it does.
        u: which lines along u are foldlines, and the lengths of the strips.
        v: the same along v.
    """
    mixed = [(name, *one) for name, one in (("u", u), ("v", v)) if len(set(one[0].tolist())) > 1]
    message = f"the line types make the seed double back: {where}"
    if len(mixed) == 2:
        return InputError(
            f"{message}. Types that are mixed along u and along v do so for all strip lengths and angles",
            hint="Give all u_lines or all v_lines one type; or bring a hybrid of both from a FOLD file, as kind: file.",
        )
    for name, is_fl, lengths in mixed:
        types = np.where(is_fl, FL, CFL).tolist()
        if crosses(types, lengths.tolist()):
            return InputError(message, hint=f"It does not with lengths_{name}: {lengths_without_crossing(types)}")
    return InputError(
        f"the seed is too narrow or too flat for numbers in a file: {where}",
        hint="Take a sector_angle and a fold_state that are farther from their limits.",
    )


def section_types(section: Section) -> list[int]:
    """Types of the axial lines of a tube with this section, where each step begins: a fold (FL) or an elbow (CFL).

    Args:
        section: steps (n, a, length) around, see :func:`tube`.

    Returns:
        FL or CFL for each step.

    Raises:
        InputError: the section does not close at every fold state (the message gives the missing lengths),
            or two steps differ in both signs or in none.
    """
    if len(section) < 3:
        raise InputError(f"the section has {len(section)} steps: at least 3 are needed to close")
    for n, a, length in section:
        if abs(n) != 1 or abs(a) != 1 or not (np.isfinite(length) and length > 0):
            raise InputError(f"section step ({n}, {a}, {length:g}): the signs must be 1 or -1, the length positive")
    lengths = sum(length for _, _, length in section)
    missing = sum(n * length for n, _, length in section), sum(a * length for _, a, length in section)
    if max(map(abs, missing)) > 1e-12 * lengths:
        raise InputError(
            f"the section does not close: its n-signed lengths sum to {missing[0]:g} and its a-signed ones to "
            f"{missing[1]:g}",
            hint="Both sums must be zero, so that the tube stays closed at every fold state.",
        )
    types = []
    for (n, a, _), (next_n, next_a, _) in zip([section[-1], *section[:-1]], section, strict=True):
        if (n == next_n) == (a == next_a):
            raise InputError(
                f"section steps ({n}, {a}) and ({next_n}, {next_a}) follow each other: exactly one sign must flip",
            )
        types.append(FL if n != next_n else CFL)
    return types


def tube(
    section: Section,
    n_rows: int,
    *,
    sector_angle: float = np.pi / 3,
    fold_state: float = 0.5,
    lengths: Sequence[float] | FloatArray | None = None,
    unit: str = "m",
    name: str = "tube",
) -> Design:
    """Tachi's isotropic cylinder: a closed section of signed steps swept along rows that alternate.

    Args:
        section: steps (n, a, length) around; n and a are +-1. Where n flips lies a fold (FL), where a flips
            an elbow (CFL).
        n_rows: rows along.
        sector_angle: radians in (0, pi/2).
        fold_state: in (0, 1).
        lengths: n_rows row lengths, 1 if not given.
        unit: length unit.
        name: title.

    Returns:
        The tube in its design state, its axis along z.

    Raises:
        InputError: the section does not close at every fold state (the message gives the missing lengths),
            two steps differ in both signs or in none, or the section crosses itself.
    """
    if n_rows < 1:
        raise InputError(f"the tube has {n_rows} rows: at least 1 is needed")
    types, k = section_types(section), len(section)
    s, c, d, w = _directions(sector_angle, fold_state)
    u = np.array([[length * n * s, length * a * c, 0.0] for n, a, length in section])
    rows = _lengths(lengths, n_rows, "lengths")
    v = rows[:, None] * np.stack([_signs(np.ones(n_rows - 1, bool)) * d, np.full(n_rows, w)], axis=1)
    ring, axis = _walk(u)[:-1], np.c_[np.zeros(n_rows + 1), _walk(v)]
    points = (ring[:, None, :] + axis[None, :, :]).reshape(-1, 3)

    i, j = (x.ravel() for x in np.meshgrid(np.arange(k), np.arange(n_rows), indexing="ij"))
    here, there = i * (n_rows + 1) + j, (i + 1) % k * (n_rows + 1) + j
    faces = np.stack([here, there, there + 1, here + 1], axis=1)

    def edge_types(edges: IntArray) -> np.ndarray:
        column = edges // (n_rows + 1)
        return np.asarray(np.where(column[:, 0] == column[:, 1], np.array(types)[column[:, 0]], FL), np.int8)

    meeting = _meeting(ring[:, :2], points, faces[j == 0].tolist())  # all rows have the same section
    if meeting is not None:
        raise InputError(f"the section crosses itself: steps {meeting[0]} and {meeting[1]} meet (counted from 0)")
    pattern = Pattern.from_faces(faces.tolist(), k * (n_rows + 1), edge_types, grid=(k, n_rows))
    return Design(pattern, points, unit, name)


def _meeting(corners: FloatArray, points: FloatArray, row: list[list[int]]) -> tuple[int, int] | None:
    """Two steps of a closed section, corners (k, 2), that cross or touch; its first row of facets shows crossings."""
    pairs = crossing_facets(points, row)
    if len(pairs):
        return int(pairs[0, 0]), int(pairs[0, 1])
    # What only touches, up to rounding, is no crossing yet: corners on steps that they do not belong to.
    k, steps = len(corners), np.roll(corners, -1, axis=0) - corners
    along = np.einsum("csx,sx->cs", corners[:, None] - corners, steps) / np.einsum("sx,sx->s", steps, steps)
    beside = corners[:, None] - corners - np.clip(along, 0, 1)[..., None] * steps
    distances = np.linalg.norm(beside, axis=2)
    c = np.arange(k)
    distances[c, c] = distances[c, c - 1] = np.inf
    corner, step = divmod(int(np.argmin(distances)), k)
    touches = distances[corner, step] < 1e-9 * np.abs(corners - corners[0]).max()
    return (min(corner, step), max(corner, step)) if touches else None


def _size(size: tuple[int, int]) -> tuple[int, int]:
    m, n = (int(x) for x in size)
    if m < 1 or n < 1:
        raise InputError(f"size is {m} x {n}: a grid needs at least 1 facet in both directions")
    return m, n


def _word(word: Word, count: int, name: str) -> list[int]:
    words = [word] * count if isinstance(word, str) else list(word)
    known = [word] if isinstance(word, str) else words
    for given in known:
        if given not in _TYPES:
            raise InputError(
                f"{name} has the word {given!r}: a line is 'FL' (foldline) or 'CFL' (complementary foldline)"
            )
    if len(words) != count:
        raise InputError(
            f"{name} has {len(words)} words, but there are {count} interior lines",
            hint=f"Give one word for all lines, or {count} words.",
        )
    return [_TYPES[w] for w in words]


def _lengths(lengths: Sequence[float] | FloatArray | None, count: int, name: str) -> FloatArray:
    if lengths is None:
        return np.ones(count)
    values = np.asarray(lengths, np.float64)
    if values.shape != (count,):
        raise InputError(f"{name} has {values.size} lengths, but there are {count} strips")
    if not (np.isfinite(values) & (values > 0)).all():
        raise InputError(f"{name} must be positive lengths, given {values.tolist()}")
    return values


def _directions(sector_angle: float, fold_state: float) -> tuple[float, float, float, float]:
    if not 0 < sector_angle < np.pi / 2:
        raise InputError(
            f"the sector angle is {np.degrees(sector_angle):g} degrees: it must lie between 0 and 90, both excluded",
        )
    if not 0 < fold_state < 1:
        raise InputError(f"the fold state is {fold_state:g}: it must lie between 0 and 1, both excluded")
    cosine = np.cos(sector_angle)
    c = cosine + fold_state * (1 - cosine)
    d = cosine / c
    return float(np.sqrt(1 - c * c)), float(c), float(d), float(np.sqrt(1 - d * d))


def _signs(flips: np.ndarray) -> FloatArray:
    """+1, then the sign after each line, flipped where ``flips`` says so."""
    return np.asarray(np.cumprod(np.r_[1.0, np.where(flips, -1.0, 1.0)]))


def _walk(steps: FloatArray) -> FloatArray:
    return np.vstack([np.zeros(steps.shape[1]), np.cumsum(steps, axis=0)])


def _doubling_back(points: FloatArray, pattern: Pattern) -> str | None:
    """Where a grid, points (m + 1, n + 1, 3), has coincident vertices or crossing facets; None if nowhere."""
    from scipy.spatial import cKDTree

    flat = points.reshape(-1, 3)
    columns, what = points.shape[1], "vertices coincide"
    pairs = cKDTree(flat).query_pairs(1e-9 * diagonal(flat), output_type="ndarray")
    if not len(pairs):
        columns, what = points.shape[1] - 1, "facets cross"
        pairs = crossing_facets(flat, pattern.faces_vertices)
    if not len(pairs):
        return None
    i, j = np.divmod(pairs, columns)
    worst = int(np.argmin(np.maximum(i.max(axis=1), j.max(axis=1))))
    # The last row of vertices is the border: what comes to lie on it turned back at the line before.
    m, n = points.shape[0] - 1, points.shape[1] - 1
    line = f"u line {min(i[worst].max(), m - 1)}" if np.ptp(i[worst]) else f"v line {min(j[worst].max(), n - 1)}"
    return f"{what}, first at {line} (counted from 1)"
