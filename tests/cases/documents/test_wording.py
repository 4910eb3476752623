import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivegate_cases.documents.wording import counted, nearest, one_line, shortened, shown

ANY_TEXT = st.text(st.characters(codec=None), max_size=100)


@given(ANY_TEXT)
def test_any_text_becomes_one_printable_line(text: str) -> None:
    line = one_line(text)
    assert line.isprintable(), f"{line!r} is not printable"
    line.encode("utf-8")


@pytest.mark.parametrize(("count", "text"), [(0, "0 runs"), (1, "1 run"), (2, "2 runs")])
def test_a_number_agrees_with_its_noun(count, text):
    assert counted(count, "run") == text


def test_printable_text_stays_as_it_is() -> None:
    assert one_line("9.8 N·m at 1500 rpm") == "9.8 N·m at 1500 rpm"


@given(
    st.recursive(st.none() | st.booleans() | st.integers() | st.floats() | ANY_TEXT, st.lists, max_leaves=30)
)
def test_any_value_is_shown_in_a_short_line(value: object) -> None:
    line = shown(value)
    assert line.isprintable(), f"{line!r} is not printable"
    assert len(line) <= 60, f"{len(line)} characters are too many for a message"


def test_a_long_value_is_cut_in_its_middle() -> None:
    assert re.fullmatch(r'"x+…x+"', shown("x" * 1000))


@given(ANY_TEXT, st.integers(1, 50))
def test_a_shortened_text_has_both_ends(text: str, longest: int) -> None:
    short = shortened(text, longest)
    assert len(short) == min(len(text), longest)
    if short != text:
        place = longest // 2
        assert short == f"{text[:place]}…{text[len(text) - (longest - 1 - place) :]}"


def test_a_huge_integer_is_shown_by_its_size() -> None:
    assert shown(10**5000) == "an integer of 16610 bits"


def test_the_nearest_name_is_found_whatever_its_case() -> None:
    assert nearest("Inductence_H", ["resistance_ohm", "inductance_h"]) == "inductance_h"


def test_there_is_a_nearest_name_even_for_something_unlike_all() -> None:
    assert nearest("zzz", ["phases", "name"]) in ("phases", "name")


def test_nothing_is_near_when_nothing_is_known() -> None:
    assert nearest("phases", []) is None
