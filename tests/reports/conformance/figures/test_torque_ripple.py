"""The torque over one electrical period, beside a check of the ripple that fails."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

import numpy as np
import pytest

from drivegate.contracts.current.words import RunSignals, run_signals
from drivegate.contracts.recorded_trace import recorded_trace
from drivegate_cases.drive.drive_document import load_drive
from drivegate_reports.conformance.figures.torque_ripple import (
    alternative,
    caption,
    cycle_at,
    draw,
    ripple_of,
)
from drivegate_reports.conformance.report import page
from drivegate_reports.page.style import house_style


@pytest.fixture
def signals(recorded: dict[str, Any]) -> RunSignals:
    """Return the signals of a search that has locked up at 1500 rpm and 9.8 N·m."""
    found = recorded_trace(recorded, recorded["checks"][0])
    assert found is not None
    return run_signals(found)


def at_angle(signals: RunSignals, degrees: float) -> RunSignals:
    """Replace the advance angle, and the torque by what the load demands."""
    from dataclasses import replace

    angles, torques = np.full_like(signals.advance_deg, degrees), np.full_like(signals.torque_nm, 9.8)
    return replace(signals, advance_deg=angles, torque_nm=torques)


def test_it_is_the_torque_of_the_published_figure_at_the_same_point(signals: RunSignals) -> None:
    ripple = ripple_of("RIP-1", at_angle(signals, 52.5))
    assert ripple is not None
    # The published figure leaves the core loss out, which drags on the shaft only where a phase floats.
    ideal = load_drive("paper-5-phase").plant()._replace(hysteresis_band=0.0, core_loss_conductance=0.0)
    published = cycle_at(ideal, 1500.0, 52.5, 9.8)
    assert ripple.cycle.ripple_percent == pytest.approx(published.ripple_percent, abs=0.3)
    assert not ripple.is_short
    low, high = ripple.cycle.torque_nm.min(), ripple.cycle.torque_nm.max()
    assert f"from {low:.2f} to {high:.2f} N·m around its mean of 9.80 N·m" in alternative(ripple)


def test_a_torque_out_of_reach_is_reported_and_drawn_at_the_current_limit(signals: RunSignals) -> None:
    ripple = ripple_of("RIP-1", at_angle(signals, 40.0))
    assert ripple is not None
    assert ripple.is_short
    assert ripple.cycle.current_reference_a == signals.scenario.drive.rating.current_limit_a
    assert "9.80 N·m of the run are out of reach" in caption(ripple)


def test_mean_and_band_are_drawn_and_the_labels_stand_beside_the_traces(signals: RunSignals) -> None:
    ripple = ripple_of("RIP-2", at_angle(signals, 52.5))
    assert ripple is not None
    with house_style():
        (panel,) = draw(ripple).axes
    shaded = panel.collections[0].get_paths()[0].get_extents()
    mean = ripple.cycle.mean_nm
    assert (shaded.y0, shaded.y1) == pytest.approx((mean * (1.0 - 0.065), mean * (1.0 + 0.065)))
    mean_line, trace = panel.get_lines()
    assert mean_line.get_ydata()[0] == mean
    assert max(trace.get_xdata()) <= 360.0 + 1e-9
    assert all(text.get_position()[0] > 360.0 for text in panel.texts), "labels off the traces"
    assert "(el. deg)" in panel.get_xlabel()


@pytest.mark.parametrize("check", ["RIP-3", "CNV-1"])
def test_other_checks_have_none(signals: RunSignals, check: str) -> None:
    assert ripple_of(check, signals) is None


def test_it_stands_with_the_counterexample_of_its_check_alone(recorded: dict[str, Any]) -> None:
    document = deepcopy(recorded)
    document["checks"][0] |= {"id": "RIP-1"}
    document["checks"][1] |= {"id": "RIP-2"}
    text = page(document)
    assert text.count('<figure class="card" id="torque-RIP-1"') == 1
    assert 'id="torque-RIP-2"' not in text, "a check that is met shows its run alone"
