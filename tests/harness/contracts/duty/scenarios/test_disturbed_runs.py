"""Restarts, clocks, lost samples and false edges of PM AC drives: what their controllers see, and what is fair."""

from __future__ import annotations

import math

import pytest
from tests.harness.contracts.key_effects import seen

from drivegate.contracts.duty.scenarios.building import (
    most_false_edges,
    restarted,
    torque_scenario,
    with_false_edges,
    with_lost_samples,
)
from drivegate.contracts.duty.scenarios.feasibility import unfair_because
from drivegate.contracts.duty.scenarios.windows import duty_windows
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.sensors import SHUNTS
from drivegate_models.errors import InputError

DRIVE = load_drive("pm-ac-interior").replaced(settling_s=0.02)
assert isinstance(DRIVE, PmAcDocument)
HELD = torque_scenario(DRIVE, 1000.0, (0.5,))
PERIOD = HELD.control_period_s


def test_a_controller_is_reset_in_the_midst_of_a_run_that_goes_on() -> None:
    run = restarted(HELD, (0.25, 0.5), clock_start_s=60.0)
    shown = seen(run)
    periods = HELD.control_periods
    assert shown.resets == [0, math.ceil(0.25 * periods), math.ceil(0.5 * periods)]
    times = [sense.time for sense in shown.senses]
    assert times == pytest.approx([60.0 + number * PERIOD for number in range(run.control_periods)])
    assert shown.plant == seen(run.replaced(restarts_s=())).plant, "the drive is another one"


def test_what_is_judged_after_a_restart_begins_anew() -> None:
    run = restarted(HELD, (0.5,))
    (_, start, end), *_ = reversed(duty_windows(run))
    assert start - run.restarts_s[0] >= 0.02
    assert end == run.duration_s


@pytest.mark.parametrize("signal", ["currents", "speed", "supply"])
def test_a_lost_sample_reads_zero_once(signal: str) -> None:
    run = with_lost_samples(HELD, (signal,), (0.5,))
    lost, whole = seen(run), seen(run.replaced(dropouts=()))
    column = {"currents": "phase_currents", "speed": "speed", "supply": "supply_voltage"}[signal]
    number = math.ceil(0.5 * HELD.control_periods)
    differing = [
        place
        for place, (one, other) in enumerate(zip(lost.senses, whole.senses, strict=True))
        if one != other
    ]
    assert differing == [number]
    value = getattr(lost.senses[number], column)
    assert value == ((0.0, 0.0, 0.0) if signal == "currents" else 0.0)
    assert lost.plant == whole.plant


def test_false_edges_turn_the_angle_and_too_many_of_them_are_set_aside() -> None:
    most = most_false_edges(DRIVE)
    run = with_false_edges(HELD, most, 0.5, 1)
    shown, plain = seen(run), seen(run.replaced(glitches=()))
    turned = shown.senses[-1].angle - plain.senses[-1].angle
    assert math.remainder(turned, 2.0 * math.pi) == pytest.approx(most * math.pi / 2 / SHUNTS.encoder_lines)
    assert math.degrees(turned) * DRIVE.machine.pole_pairs == pytest.approx(3.0, abs=0.4)
    assert unfair_because(run) is None
    slow = with_false_edges(torque_scenario(DRIVE, 100.0, (0.5,)), most, 0.5, 1)
    assert "false edges" in (unfair_because(slow) or "")


def test_no_false_edges_without_an_encoder() -> None:
    with pytest.raises(InputError, match="or an encoder on a PM AC drive"):
        HELD.replaced(glitches=({"time_s": 0.01, "counts": 3},))
