"""The reproduction of the paper: every figure as files and in the page, every number with its verdict."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest

from drivegate_cases.publication import facts
from drivegate_lab.paper.catalogue import FIGURES
from drivegate_lab.paper.figures import cycle_waveforms, initial_angle, ripple_over_speed, speed_limit
from drivegate_lab.paper.report import NUMBERS_FILE, PAGE_FILE, reproduce
from drivegate_lab.paper.verdicts import Verdict
from drivegate_reports.page.style import house_style


@pytest.fixture(scope="module")
def folder(reproduction: tuple[Path, dict[str, Any]]) -> Path:
    return reproduction[0]


@pytest.fixture(scope="module")
def document(reproduction: tuple[Path, dict[str, Any]]) -> dict[str, Any]:
    return reproduction[1]


@pytest.mark.nightly
def test_every_figure_is_a_file_and_in_the_page(folder: Path, document: dict[str, Any]) -> None:
    labels = [figure["label"] for figure in document["figures"]]
    expected = [
        "Fig. 1",
        "Fig. 3",
        "Fig. 5",
        "Fig. 6",
        "Ripple over speed",
        "Fig. 7",
        "Figs. 9 and 10",
        "Speed limit",
    ]
    assert labels == expected
    for figure in document["figures"]:
        vector, pixels = (folder / name for name in figure["files"])
        assert vector.read_text(encoding="utf-8").startswith("<?xml"), vector
        assert pixels.read_bytes().startswith(b"\x89PNG"), pixels
    page = (folder / PAGE_FILE).read_text(encoding="utf-8")
    assert page.count("<figcaption>") == len(FIGURES)
    assert "://" not in page, "the page names an address"
    assert (folder / PAGE_FILE).stat().st_size < 3_000_000


def test_every_number_has_source_tolerance_and_verdict(folder: Path, document: dict[str, Any]) -> None:
    assert json.loads((folder / NUMBERS_FILE).read_text(encoding="utf-8")) == document
    published = {(fact.id, quantity.name) for fact in facts() for quantity in fact.quantities}
    rows = {(row["fact"], row["quantity"]): row for row in document["numbers"]}
    assert published <= set(rows), f"missing: {sorted(published - set(rows))}"
    assert {fact.id for fact in facts()} | {"Fig. 1"} == {fact for fact, _ in rows}
    for row in rows.values():
        assert row["source"], f"{row['quantity']} has no source"
        assert row["verdict"] in get_args(Verdict), row
        if row["verdict"] == "not reproduced":
            assert row["note"], f"nothing explains why {row['quantity']} is not reproduced"
    assert sum(document["verdicts"].values()) == len(rows)
    necessary = rows["P8", "necessary angle at 1500 rpm"]
    assert necessary["numbers"][1]["name"] == "ours"
    assert necessary["numbers"][1]["value"] == pytest.approx(51.9, abs=0.1)
    assert necessary["numbers"][1]["unit"] == "deg"


@pytest.mark.nightly
def test_it_is_the_same_bytes_every_time(folder: Path, document: dict[str, Any], tmp_path: Path) -> None:
    reproduce(tmp_path)
    files = sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    assert len(files) == 2 + 2 * len(FIGURES)
    for file in files:
        assert (tmp_path / file).read_bytes() == (folder / file).read_bytes(), (
            f"{file} differs from run to run"
        )


def test_the_phase_obeys_its_voltage_equation() -> None:
    data = cycle_waveforms.cycle_waveforms()
    assert data.emf_v.max() == pytest.approx(0.339 * 1500.0 * math.pi / 30.0), "k_e times the speed"
    assert np.abs(data.voltage_v).max() <= 48.0 + 1e-9, "half the supply"
    angles = np.arange(data.meeting_deg + 5.0, data.window_deg - 5.0, 0.5)
    current, emf = (
        np.interp(angles, data.angle_deg, values) for values in (data.current_a, data.transformer_emf_v)
    )
    seconds_per_degree = 60.0 / (360.0 * 11.0 * data.speed_rpm)
    derived = 2.88e-3 * np.gradient(current, 0.5 * seconds_per_degree)
    np.testing.assert_allclose(derived, emf, atol=0.05, err_msg="L di/dt (V)")
    assert data.rise_a > 10.0 > 0.0 > data.fall_a


def test_initial_angles_meet_the_published_points() -> None:
    data = initial_angle.initial_angles()
    at = {speed: index for index, speed in enumerate(data.speed_rpm.tolist())}
    assert data.published_deg[at[1500.0]] == pytest.approx(58.0)
    assert data.published_deg[at[1200.0]] == pytest.approx(40.6)
    assert data.edge_deg[at[1500.0]] == pytest.approx(50.8, abs=0.1)
    assert np.all(data.least_power_deg >= data.edge_deg - 0.01), "what costs least is within reach"
    assert np.all(data.initial_deg > data.edge_deg), "the line of `reference` clears the edge"


def test_ripple_below_base_speed_is_small_and_the_greatest_lies_above() -> None:
    data = ripple_over_speed.ripple_over_speed()
    assert data.slow_percent.max() < 13.0
    within = data.speed_rpm <= 1500.0
    assert data.initial_percent.max() < 13.0
    assert data.speed_rpm[within][np.argmax(data.optimal_percent[within])] == 1500.0, (
        "as published, the fastest"
    )
    assert data.published_percent == pytest.approx(12.2, abs=0.1)


def test_power_beyond_three_times_base_speed() -> None:
    data = speed_limit.speed_limit()
    assert data.reached_rpm > 3.0 * data.base_speed_rpm
    assert np.all(data.greatest_power_w >= data.power_at_90_w)
    fast = data.speed_rpm >= data.ninety_from_rpm
    np.testing.assert_allclose(data.greatest_power_w[fast], data.power_at_90_w[fast])
    assert np.all(np.diff(data.edge_deg) > 0.0), "the faster, the more advance"


@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: figure.name)
def test_axes_have_units_and_words_have_numbers(figure: Any) -> None:
    data = figure.compute()
    with house_style():
        drawn = figure.draw(data)
    for panel in drawn.axes:
        for text in (panel.get_xlabel(), panel.get_ylabel()):
            assert "(" in text, f"the axis '{text}' has no unit"
            assert text.endswith(")"), f"the axis '{text}' has no unit"
        assert panel.lines, "a panel shows nothing"
    for words in (figure.alternative(data), figure.caption(data)):
        assert any(character.isdigit() for character in words), words
        assert words.endswith("."), words


def test_what_is_drawn_is_what_was_computed() -> None:
    data = speed_limit.speed_limit()
    with house_style():
        powers, angles = speed_limit.draw(data).axes
    np.testing.assert_array_equal(powers.lines[1].get_ydata(), data.power_at_90_w)
    np.testing.assert_array_equal(powers.lines[2].get_ydata(), data.greatest_power_w)
    np.testing.assert_array_equal(angles.lines[1].get_ydata(), data.edge_deg)
    assert powers.get_ylabel() == "greatest power at 26 A (W)"
