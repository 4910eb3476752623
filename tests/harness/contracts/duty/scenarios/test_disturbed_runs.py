"""Restarts, clocks, lost samples and false edges of PM AC drives: what their controllers see, and what is fair."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from tests.harness.contracts.key_effects import seen

from drivegate.contracts.duty.scenarios.building import (
    failing,
    most_false_edges,
    restarted,
    torque_scenario,
    with_false_edges,
    with_lost_samples,
    with_position_errors,
)
from drivegate.contracts.duty.scenarios.drawn.circumstances import joint_change_scenarios
from drivegate.contracts.duty.scenarios.feasibility import unfair_because
from drivegate.contracts.duty.scenarios.windows import duty_windows
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.piecewise import Profile
from drivegate_cases.scenario.scenario import Scenario
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


def test_what_is_judged_after_a_restart_begins_again() -> None:
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


def stepping_s(profile: Profile) -> set[float]:
    """Give the times at which a profile steps."""
    return {after[0] for before, after in pairwise(profile) if before[1] != after[1]}


@given(run=joint_change_scenarios(DRIVE))
@settings(max_examples=25, derandomize=True, database=None)
def test_two_things_happen_at_once_in_a_joint_change(run: Scenario) -> None:
    profiles = (run.torque_reference_profile, run.speed_rpm, run.load_profile, run.supply_profile)
    steps = [stepping_s(profile) for profile in profiles]
    disturbed = {*run.restarts_s, *(lost.start_s for lost in run.dropouts)}
    # A level may be drawn twice, which is no step.
    times = set().union(*steps, disturbed)
    assert not times or max(times) - min(times) < 21 * PERIOD, "one comes later"
    assert len(duty_windows(run)) == 1 + bool(times), "what has no time to settle is not judged"


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


ERRORS = {
    "eccentricity_deg": 4.0,
    "eccentric_from_deg": 30.0,
    "sine_offset": 0.15,
    "cosine_offset": -0.1,
    "track_gain": -0.2,
    "track_phase_deg": 9.0,
}


def tracked(angle: float) -> float:
    """Return the angle of two tracks with `ERRORS`, less its mean over a turn."""
    phase = math.radians(ERRORS["track_phase_deg"])
    gain = 1.0 + ERRORS["track_gain"]
    sine = gain * math.sin(angle + phase) + ERRORS["sine_offset"]
    alignment = math.atan2(gain * math.sin(phase), 1.0 + gain * math.cos(phase))
    error = math.remainder(math.atan2(sine, math.cos(angle) + ERRORS["cosine_offset"]) - angle, 2.0 * math.pi)
    return error - alignment


def test_the_angle_of_a_sensor_with_tracks_is_exactly_that_of_its_sine_and_cosine() -> None:
    assert sum(map(tracked, np.linspace(0.0, 2.0 * math.pi, 400, endpoint=False))) == pytest.approx(
        0.0, abs=1e-9
    )
    held = torque_scenario(DRIVE, 1500.0, (0.5,))
    plain = seen(with_position_errors(held, 1))
    shown = seen(with_position_errors(held, 1, **ERRORS))
    for sense, true in list(zip(shown.senses, plain.senses, strict=True))[::50]:
        angle = true.angle
        expected = angle + tracked(angle) + math.radians(4.0) * math.sin(angle - math.radians(30.0))
        off = math.remainder(sense.angle - expected, 2.0 * math.pi)
        assert abs(off) < 1e-13, f"the angle is off by {off:g} rad at {angle:g} rad"


def test_the_speed_of_a_sensor_with_errors_is_the_slope_of_its_angle() -> None:
    held = torque_scenario(DRIVE, 1500.0, (0.5,))
    senses = seen(with_position_errors(held, 1, latency_s=2e-5, **ERRORS)).senses
    for before, now, after in zip(senses[10:-2:50], senses[11:-1:50], senses[12::50], strict=True):
        slope = math.remainder(after.angle - before.angle, 2.0 * math.pi) / (2.0 * PERIOD)
        assert now.speed == pytest.approx(slope, rel=3e-4)


@pytest.mark.parametrize("periods", [1, 3])
def test_what_is_late_shows_angle_and_speed_of_some_time_ago(periods: int) -> None:
    held = torque_scenario(DRIVE, 1000.0, (0.5,))
    held = held.replaced(speed_rpm=((0.0, 1000.0), (held.duration_s, 1500.0)))
    # Half a period more, in which the speed is between those of two samples.
    late, plain = (
        seen(with_position_errors(held, 1, **own)).senses
        for own in ({"latency_s": (periods + 0.5) * PERIOD}, {})
    )
    assert plain[-1].speed > 1.4 * plain[0].speed, "the speed changes"
    for number in range(periods + 1, len(late), 37):
        older, newer = plain[number - periods - 1], plain[number - periods]
        assert late[number].speed == pytest.approx(0.5 * (older.speed + newer.speed), rel=1e-12)
        middle = older.angle + 0.5 * math.remainder(newer.angle - older.angle, 2.0 * math.pi)
        assert math.remainder(late[number].angle - middle, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_a_position_that_is_too_far_off_is_set_aside() -> None:
    pairs = DRIVE.machine.pole_pairs
    for electrical_deg, is_fair in ((11.0, True), (13.0, False)):
        phase_deg = electrical_deg / pairs - 4.0
        run = with_position_errors(HELD, 1, eccentricity_deg=4.0, track_phase_deg=phase_deg)
        assert (unfair_because(run) is None) is is_fair


def test_a_magnet_that_slips_turns_the_angle_for_good() -> None:
    run = failing(HELD, "slip", 0.5 * HELD.duration_s, slip_deg=60.0)
    slipped, plain = seen(run), seen(HELD)
    turned = [
        math.degrees(math.remainder(one.angle - other.angle, 2.0 * math.pi)) * DRIVE.machine.pole_pairs
        for one, other in zip(slipped.senses, plain.senses, strict=True)
    ]
    half = math.ceil(0.5 * HELD.control_periods)
    assert turned == pytest.approx([0.0] * half + [60.0] * (len(turned) - half), abs=1e-6)
    with pytest.raises(InputError, match="needs the position 'exact'"):
        run.replaced(sensors="shunts")


def test_no_false_edges_without_an_encoder() -> None:
    with pytest.raises(InputError, match="or an encoder on a PM AC drive"):
        HELD.replaced(glitches=({"time_s": 0.01, "counts": 3},))
