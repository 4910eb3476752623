"""Spellings of units and words, and a unit's size, which the units library knows."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivegate_cases.documents.quantity.spelling import spelled
from drivegate_cases.documents.quantity.units import registry, size


def sized(text: str, of: str) -> float | None:
    found = spelled(text)
    assert found is not None
    sizes = [size(unit, of) for unit in found.units]
    return next((found.number.value * known for known in sizes if known is not None), None)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("1 mNm", "newton*meter", 1e-3),
        ("1 Nms2", "kilogram*meter**2", 1.0),
        ("1 oz-in", "newton*meter", 0.0070615518),
        ("1 oz-in²", "kilogram*meter**2", 1.8289979e-5),
        ("1 lb-ft-s²", "kilogram*meter**2", 1.3558179),
        ("1 kg·cm", "newton*meter", 0.0980665),
        ("1 mVs", "volt*second", 1e-3),
        ("1 V/kRPM", "volt*second/shaft_radian", 60.0 / 6283.185307),
        ("1 V per 1000 min-1", "volt*second/shaft_radian", 60.0 / 6283.185307),
        ("1 V/(rad/s)", "volt*second/shaft_radian", 1.0),
        ("1 MHz", "field_hertz", 1e6),
        ("1 milliohm", "ohm", 1e-3),
    ],
)
def test_the_size_of_a_spelling(text: str, unit: str, value: float) -> None:
    assert sized(text, unit) == pytest.approx(value, rel=1e-6)


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        # Newton metres per ampere are volt seconds, and still no flux linkage; neither is an EMF over a speed.
        ("1 Nm/A", "volt*second"),
        ("1 V/krpm", "volt*second"),
        ("1 V/Hz", "volt*second"),
        ("1 Hz", "shaft_rpm"),
        ("1 MH", "henry"),
        ("1 Nm/√W", "newton*meter/ampere"),
        ("1 V//rpm", "volt*second/shaft_radian"),
        ("1 V/(rpm", "volt*second/shaft_radian"),
        ("1 xyz", "ohm"),
    ],
)
def test_what_is_of_another_quantity_or_no_unit(text: str, unit: str) -> None:
    assert sized(text, unit) is None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("5 Arms", {"rms"}),
        ("5 A(rms)", {"rms"}),
        ("5 A eff.", {"rms"}),
        ("7 Apk", {"peak"}),
        ("7 A 0-p", {"peak"}),
        ("7 App", {"peak to peak"}),
        ("3 A DC", {"dc"}),
        ("3~ 400 V", {"ac"}),
        ("1 ohm L-L", {"line"}),
        ("1 ohm line to line @ 25 °C", {"line"}),
        ("1 ohm ±10% (phase-phase)", {"line"}),
        ("1 ohm, per phase", {"phase"}),
        ("1 ohm line-neutral", {"phase"}),
        ("1 Vrms/krpm/phase", {"rms", "phase"}),
        ("phase resistance = 1 ohm", {"phase"}),
        ("1 ohm max.", set()),
    ],
)
def test_words(text: str, words: set[str]) -> None:
    found = spelled(text)
    assert found is not None
    assert found.words == words
    assert found.units


@given(st.text(max_size=250))
def test_any_text_is_read_or_refused(text: str) -> None:
    found = spelled(text)
    for unit in found.units if found else ():
        size(unit, "ohm")


def test_there_is_one_registry() -> None:
    assert registry() is registry()
