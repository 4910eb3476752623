"""The house style: readable colours, and text that is the same every time."""

from __future__ import annotations

import re

import pytest

from drivegate_reports.page import style


def _luminance(colour: str) -> float:
    """Return the relative luminance of the Web Content Accessibility Guidelines."""
    parts = [int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]
    linear = [part / 12.92 if part <= 0.03928 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("colour", [style.BLUE, style.VERMILION, style.GREEN, style.SKY, style.GREY])
def test_labels_are_readable_on_white(colour: str) -> None:
    contrast = 1.05 / (_luminance(style.ink(colour)) + 0.05)
    assert contrast >= 4.5, f"the contrast of {style.ink(colour)} is {contrast:.2f}"


@pytest.mark.parametrize(
    ("value", "digits", "text"), [(-2.0, 1, "−2.0"), (3.25, 1, "+3.2"), (-0.001, 1, "0.0"), (0.0, 0, "0")]
)
def test_signed_numbers_have_a_real_minus(value: float, digits: int, text: str) -> None:
    assert style.signed(value, digits) == text


def _line() -> str:
    with style.house_style():
        figure, (panel,) = style.new_figure(2.0, 1)
        panel.plot([0.0, 1.0], [0.0, 1.0])
        style.label(panel, 0.5, 0.5, "a < b", style.BLUE)
        return style.inline_svg(figure, "line")


def test_an_inline_figure_is_one_element_with_identifiers_of_its_own() -> None:
    text = _line()
    assert text.startswith("<svg ")
    assert text.endswith("</svg>")
    assert all(name.startswith("line-") for name in re.findall(r'\bid="([^"]+)"', text))
    assert all(name.startswith("line-") for name in re.findall(r'href="#([^"]+)"', text))
    assert "://" not in text, "the figure names an address"
    assert "a &lt; b" in text, "letters stay text"


def test_a_figure_is_the_same_every_time() -> None:
    assert _line() == _line()


def test_the_house_style_ends_with_its_context() -> None:
    import matplotlib

    before = dict(matplotlib.rcParams)
    with style.house_style():
        assert matplotlib.rcParams["font.size"] == 9.5
    assert dict(matplotlib.rcParams) == before


def test_labels_at_the_ends_are_apart_and_within_the_panel() -> None:
    with style.house_style():
        _, (panel,) = style.new_figure(2.0, 1)
        panel.set_ylim(0.0, 10.0)
        lines = (("motor", 9.9, style.BLUE), ("load", 9.8, style.GREY), ("limit", 9.7, style.GREEN))
        style.label_ends(panel, 1.0, *lines)
    heights = {text.get_text(): text.get_position()[1] for text in panel.texts}
    assert sorted(heights, key=lambda name: heights[name]) == ["limit", "load", "motor"]
    assert max(heights.values()) <= 10.0, "above the panel stands what belongs to the next one"
    assert heights["motor"] - heights["load"] >= 1.5, "one label over the other"
    assert all(text.get_bbox_patch() is not None for text in panel.texts), "the grid strikes the words out"
