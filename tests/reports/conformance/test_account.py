"""The account of a run in words: what it reports is what the signals show."""

from __future__ import annotations

import copy
import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drivegate.contracts.current.words import RunSignals, account, judged_point, run_signals
from drivegate.contracts.recorded_trace import recorded_trace
from drivegate.output.console import console_for
from drivegate.output.continuous_integration import junit_xml, markdown
from drivegate.studies.check.checked import Checked
from drivegate.studies.check.display import show_checked
from drivegate_cases.scenario.load import ConstantPowerLoad
from drivegate_reports.conformance.figures import recorded_run
from drivegate_reports.page.style import house_style


@pytest.fixture(scope="module")
def locked(recorded: dict[str, Any]) -> RunSignals:
    trace = recorded_trace(recorded, recorded["checks"][0])
    assert trace is not None, "the recording is a good one"
    return run_signals(trace)


def test_a_lost_speed_is_reported_as_it_happened(locked: RunSignals) -> None:
    sentences = account(locked)
    assert sentences[0] == "Run: 1500 rpm; constant torque of 9.8 N·m; 20 s."
    order = (
        "the angle passed 51.9°",
        "torque fell below the load",
        "left its band",
        "reached its limit",
        "rested at",
    )
    places = [next(place for place, text in enumerate(sentences) if part in text) for part in order]
    assert places == sorted(places), f"the events are reported out of order: {sentences}"
    assert "236 rpm below the reference" in sentences[-2]
    assert sentences[-1].endswith("at 51.9°, which is the feasible edge.")


@pytest.mark.parametrize(("start", "acquitted"), [(18.0, True), (0.5, False)])
def test_a_dropout_after_the_loss_is_not_blamed(locked: RunSignals, start: float, acquitted: bool) -> None:
    dropout = {"signal": "currents", "start_s": start, "duration_s": 0.1}
    disturbed = replace(locked, scenario=locked.scenario.replaced(dropouts=[dropout]))
    words = f"The speed was lost before the first disturbance of the sensors, at {start:g} s, which is not the cause."
    sentences = account(disturbed)
    assert (words in sentences) is acquitted, sentences
    stated = [sentence for sentence in account(locked) if "left its band" in sentence]
    assert set(stated) <= set(sentences), "the speed left its band when it did, whatever came later"


@pytest.mark.parametrize("output", ["terminal", "Markdown", "JUnit"])
def test_what_happened_is_reported_on_every_output(
    recorded: dict[str, Any], output: str, tmp_path: Path
) -> None:
    if output == "terminal":
        stream = io.StringIO()
        show_checked(console_for(stream), Checked("mine.py:Mine", None, recorded, tmp_path))
        text = stream.getvalue()
    else:
        text = markdown(recorded) if output == "Markdown" else junit_xml(recorded).decode()
    assert "the angle passed 51.9°, the smallest at which" in text, text
    assert text.count("At the end the speed was") == 1, "only a failed check has an account"


def test_times_are_those_of_the_signals(locked: RunSignals) -> None:
    point = judged_point(locked)
    assert point is not None
    loaded = locked.time_s >= point.begins_s
    passed = locked.time_s[loaded & (locked.advance_deg < point.edge_deg)][0]
    sentence = next(text for text in account(locked) if "passed" in text)
    assert float(sentence.split()[1]) == pytest.approx(passed, abs=0.1), (
        "the trace passes the edge at another time"
    )


def test_a_held_speed_is_reported_by_its_judged_stretch(recorded: dict[str, Any]) -> None:
    document = copy.deepcopy(recorded)
    trace = document["traces"][0]
    count = len(trace["time_s"])
    trace["speed_rpm"] = [1500.5] * count
    trace["advance_deg"] = [53.0] * count
    trace["current_sum_a"] = [41.0] * count
    found = recorded_trace(document, document["checks"][0])
    assert found is not None
    sentences = account(run_signals(found))
    assert "the speed was within 0.5 rpm of its reference, the angle rested at 53.0°" in sentences[1]
    assert "Σ|i| lay between 41.00 A and 41.00 A" in sentences[1]


def test_the_figure_shows_the_signals_in_their_units(locked: RunSignals) -> None:
    with house_style():
        figure = recorded_run.draw(locked)
    speed, angle, current, torque = figure.axes
    drawn = {panel.get_ylabel(): [line.get_ydata() for line in panel.lines] for panel in figure.axes}
    assert list(drawn) == ["speed (rpm)", "angle (el. deg)", "current (A)", "torque (N·m)"]
    np.testing.assert_array_equal(speed.lines[1].get_ydata(), locked.speed_rpm)
    np.testing.assert_array_equal(angle.lines[0].get_ydata(), locked.advance_deg)
    np.testing.assert_array_equal(current.lines[0].get_ydata(), locked.current_sum_a)
    np.testing.assert_array_equal(torque.lines[0].get_ydata(), locked.torque_nm)
    assert angle.lines[1].get_ydata()[0] == pytest.approx(51.9, abs=0.1), "the feasible edge"
    assert torque.get_xlabel() == "time (s)"


def test_words_for_the_figure_have_its_numbers(locked: RunSignals) -> None:
    words = recorded_run.alternative(locked)
    assert "ends at -236 rpm" in words.replace("−", "-")
    assert "the current reference at 26.0 A" in words


def test_a_load_at_constant_power_is_left_out_where_it_means_nothing(locked: RunSignals) -> None:
    falling = np.linspace(1500.0, 0.0, locked.time_s.size)
    load = ConstantPowerLoad(kind="constant_power", power_w=1500.0, factor=((0.0, 1.0),))
    scenario = locked.scenario.model_copy(update={"load": load})
    huge = 1500.0 / np.maximum(falling * np.pi / 30.0, 1e-3)
    stalled = replace(locked, scenario=scenario, speed_rpm=falling, load_torque_nm=huge)
    shown = recorded_run.meaningful_load(stalled)
    np.testing.assert_array_equal(np.isnan(shown), falling < 0.5 * locked.speed_reference_rpm)
    with house_style():
        figure = recorded_run.draw(stalled)
    speed, torque = figure.axes[0], figure.axes[3]
    assert torque.get_ylim()[1] < 60.0, "the axis follows a load that means nothing"
    assert "stalled" in [text.get_text() for text in speed.texts]
    assert [text.get_text() for text in torque.texts] == ["motor"], "a load without an end has no label"
    assert recorded_run.meaningful_load(locked) is locked.load_torque_nm, (
        "a constant torque is shown throughout"
    )
