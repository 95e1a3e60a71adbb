"""Words that double back, and strip lengths with which they do not."""

from __future__ import annotations

import ast
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import inverse
from inverse.errors import InputError
from inverse.origami.hybrids import crosses, lengths_without_crossing
from inverse.origami.pattern import CFL, FL

WORDS = st.lists(st.sampled_from(["FL", "CFL"]), min_size=1, max_size=24)


def advised(error: InputError) -> dict[str, Any]:
    """What a hint says to write."""
    assert error.hint is not None
    found = re.fullmatch(r"It does not with (lengths_[uv]): (\[[\d, ]+\])", error.hint)
    assert found is not None, error.hint
    return {found[1]: ast.literal_eval(found[2])}


@settings(max_examples=60, deadline=None)
@given(
    word=WORDS, other=st.sampled_from(["FL", "CFL"]), along_u=st.booleans(), strips=st.integers(1, 6), data=st.data()
)
def test_the_advice_for_a_word_mixed_in_one_direction_works(
    word: list[str], other: str, along_u: bool, strips: int, data: st.DataObject
) -> None:
    """At any angle, and for any lengths of the other strips: the seed itself is asked."""
    keys: dict[str, Any] = {
        "sector_angle": np.radians(data.draw(st.floats(10, 80))),
        "fold_state": data.draw(st.floats(0.1, 0.9)),
        "lengths_v" if along_u else "lengths_u": data.draw(
            st.lists(st.floats(0.2, 5), min_size=strips, max_size=strips)
        ),
    }
    size = (len(word) + 1, strips) if along_u else (strips, len(word) + 1)
    words = (word, other) if along_u else (other, word)
    try:
        inverse.seeds.grid(size, *words, **keys)
    except InputError as error:
        lengths = advised(error)
        assert set(lengths) == {"lengths_u" if along_u else "lengths_v"}
        inverse.seeds.grid(size, *words, **keys | lengths)


@given(word=st.lists(st.sampled_from([FL, CFL]), max_size=60))
def test_lengths_are_whole_and_no_longer_than_there_are_strips(word: list[int]) -> None:
    lengths = lengths_without_crossing(word)
    assert len(lengths) == len(word) + 1
    assert 1 <= min(lengths) <= max(lengths) <= len(word) + 1
    assert not crosses(word, lengths)


def test_a_spiral_is_wound_evenly() -> None:
    assert max(lengths_without_crossing([FL, CFL] * 3)) == 3
    assert max(lengths_without_crossing([FL, CFL] * 30)) == 30


def test_equal_strips_stay_equal_where_they_do() -> None:
    assert lengths_without_crossing([FL, FL, FL, CFL, CFL, FL, FL, FL]) == [1] * 9


def test_words_mixed_both_ways_are_said_to_be_beyond_help() -> None:
    """And the way out that is named is one."""
    word = ["FL", "CFL", "FL"]
    with pytest.raises(InputError, match="mixed along u and along v do so for all strip lengths and angles") as caught:
        inverse.seeds.grid((4, 4), word, word)
    assert caught.value.hint is not None
    assert "Give all u_lines or all v_lines one type" in caught.value.hint
    with pytest.raises(InputError) as caught:
        inverse.seeds.grid((4, 4), "FL", word)
    inverse.seeds.grid((4, 4), "FL", word, **advised(caught.value))


def test_angles_at_their_limits_are_blamed_where_they_are_the_reason() -> None:
    with pytest.raises(InputError, match="too narrow or too flat") as caught:
        inverse.seeds.grid((6, 6), "CFL", "FL", sector_angle=1e-8)
    assert caught.value.hint is not None
    assert "sector_angle" in caught.value.hint
