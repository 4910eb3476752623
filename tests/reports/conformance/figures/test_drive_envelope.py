"""The figure of what the drive can do, and its section in the page."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import numpy as np
import pytest

from drivegate.drives.envelope_document import envelope_of
from drivegate.results.result import finite
from drivegate_cases.drive.drive_document import load_drive
from drivegate_reports.conformance.coverage import drive_of
from drivegate_reports.conformance.figures.drive_envelope import alternative, caption, draw
from drivegate_reports.conformance.report import page
from drivegate_reports.page.style import house_style

DRIVE = load_drive("paper-5-phase")


@pytest.fixture(scope="module")
def envelope() -> dict[str, Any]:
    written: dict[str, Any] = finite(envelope_of(DRIVE))
    return written


def test_torque_power_angle_and_ripple_are_drawn_with_their_units(envelope: dict[str, Any]) -> None:
    with house_style():
        figure = draw(envelope, 13.0)
    torque, power, angle, ripple = figure.axes
    labels = [panel.get_ylabel() for panel in figure.axes]
    assert labels == ["torque (N·m)", "power (W)", "angle (el. deg)", "ripple (%)"]
    assert ripple.get_xlabel() == "speed (rpm)"
    written = {text.get_text() for panel in figure.axes for text in panel.texts}
    assert {"most", "rated", "most at 0°", "feasible edge", "least Σ|i|", "line", "limit"} <= written
    rated = torque.lines[1]
    speeds, torques = np.array(rated.get_xdata()), np.array(rated.get_ydata())
    above = speeds >= 500.0
    np.testing.assert_allclose(torques[above] * speeds[above] * np.pi / 30.0, 1500.0, rtol=1e-9)
    assert max(power.lines[0].get_ydata()) == pytest.approx(1846.0, abs=1.0)
    line = np.array(angle.lines[2].get_xydata())
    assert [500.0, 0.0] in line.tolist(), "the line jumps at base speed"


def test_words_have_the_numbers_of_the_drive(envelope: dict[str, Any]) -> None:
    words = alternative(envelope)
    assert "rated are 1500 W from 500 rpm on" in words
    assert "The feasible edge lies between" in words
    assert "At 26 A" in caption(envelope, 13.0)
    assert "its limit of 13 %" in caption(envelope, 13.0)


def test_what_is_out_of_reach_is_left_out() -> None:
    weak = finite(envelope_of(DRIVE.replaced(current_limit_a=2.0)))
    assert "feasible edge lies" not in alternative(weak)
    with house_style():
        written = {text.get_text() for panel in draw(weak, 13.0).axes for text in panel.texts}
    assert "feasible edge" not in written
    assert "most" in written


def test_the_page_says_what_the_drive_can_do_and_what_is_required(recorded_page: str) -> None:
    assert '<h2><span id="drive">What this drive can do</span>' in recorded_page
    assert 'id="drive-envelope"' in recorded_page
    for words in (
        "Line of initial angles: 0° below 500 rpm, then 32.9° + 0.02° per rpm above",
        "Control period: 275 Hz at highest speed, so at most 0.914 ms",
        "Required of a search: from 6 s after a change on the speed stays within 5 rpm (k1)",
        "a ripple below 13 % with the ideal regulator at 1500 rpm and 9.8 N·m",
    ):
        assert words in recorded_page, words


def test_a_result_of_an_earlier_version_has_no_such_section(recorded: dict[str, Any]) -> None:
    earlier = {key: value for key, value in recorded.items() if key != "envelope"}
    assert "What this drive can do" not in page(earlier)


def test_the_drive_is_that_of_the_document(recorded: dict[str, Any]) -> None:
    fan, changed = load_drive("fan-3-phase"), deepcopy(recorded)
    changed["fixed"] = [{"scenario": {"drive": fan.to_mapping()}}]
    assert drive_of(changed) == DRIVE
    changed["drive"] = {key: value for key, value in changed["drive"].items() if key != "document"}
    assert drive_of(changed) == fan, "an earlier version's is that of its first run"
    assert drive_of({}) == DRIVE
