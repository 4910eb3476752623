"""Speeds that no drive reaches in the time that is judged."""

from __future__ import annotations

import pytest

from drivegate.contracts.duty.scenarios.building import (
    hoist_scenario,
    load_step_scenario,
    speed_scenario,
    torque_of,
)
from drivegate.contracts.duty.scenarios.feasibility import unfair_because
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios
from drivegate.contracts.duty.scenarios.reaching import is_too_late, runs_away
from drivegate.contracts.duty.scenarios.windows import duty_windows
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.failure_kind import FAILURE_KINDS
from drivegate_models.units import RADIANS_PER_RPM


def _drive(name: str) -> PmAcDocument:
    drive = load_drive(name)
    assert isinstance(drive, PmAcDocument)
    return drive


SURFACE = _drive("pm-ac-surface")


@pytest.mark.parametrize("name", ["pm-ac-interior", "pm-ac-surface", "pm-ac-msl", "pm-ac-2kw"])
def test_no_fixed_scenario_is_set_aside(name: str) -> None:
    fixed = fixed_scenarios(_drive(name), detected=FAILURE_KINDS)
    assert [run.name for run in fixed if unfair_because(run) is not None] == []


def test_a_run_that_begins_above_overspeed_is_set_aside() -> None:
    run = load_step_scenario(SURFACE, 1650.0, torque_of(SURFACE, 1650.0, 1.0), (0.2, 0.45))
    assert unfair_because(run) is None
    for far in (2000.0, -2000.0):
        reason = unfair_because(run.replaced(initial_speed_rpm=far))
        assert reason is not None
        assert "overspeed" in reason


def test_what_a_stretch_is_too_short_for_is_left_to_the_next() -> None:
    run = speed_scenario(SURFACE, (1600.0, 1500.0), initial_speed_rpm=100.0)
    assert len(duty_windows(run)) == 2
    short = run.replaced(speed_rpm=((0.0, 1600.0), (0.01, 1600.0), (0.01, 1500.0)))
    assert len(duty_windows(short)) == 1
    far = short.replaced(duration_s=run.duration_s - run.speed_rpm[1][0])
    assert duty_windows(far) == [], "in the first one the shaft has hardly begun to move"


def test_a_run_whose_limits_leave_little_torque_to_accelerate_needs_more_time() -> None:
    torque = torque_of(SURFACE, 1650.0, 0.85)
    run = speed_scenario(SURFACE, (1650.0,), torque_nm=torque, initial_speed_rpm=200.0)
    assert unfair_because(run) is None
    weak = run.replaced(supply_v=((0.0, 38.0),))
    reason = unfair_because(weak)
    assert reason is not None
    assert "too late to settle" in reason
    assert unfair_because(weak.replaced(duration_s=10.0 * run.duration_s)) is None


def test_a_run_whose_limits_leave_no_torque_is_late_however_long_it_is() -> None:
    run = speed_scenario(SURFACE, (600.0,), torque_nm=torque_of(SURFACE, 600.0, 0.9), initial_speed_rpm=300.0)
    assert not is_too_late(run)
    assert is_too_late(run.replaced(supply_v=((0.0, 36.0),), duration_s=10.0 * run.duration_s))


def test_a_load_moves_the_shaft_before_a_regulator_bears_it() -> None:
    """A load that leaves little torque lets the shaft come back late, but not where it begins borne."""
    torque = torque_of(SURFACE, 1650.0, 0.85)
    run = load_step_scenario(SURFACE, 1650.0, torque, (0.0, 1.0))
    weak = run.replaced(supply_v=((0.0, 36.2),))
    assert not is_too_late(run)
    assert is_too_late(weak)
    assert not is_too_late(weak.replaced(duration_s=4.0 * run.duration_s))


def test_a_weight_on_a_rotor_too_light_for_any_regulator_is_set_aside() -> None:
    """Until the torque has risen, the weight has brought the shaft beyond overspeed."""
    torque = torque_of(SURFACE, 600.0, 0.9)
    rise = SURFACE.requirements.rise_periods * SURFACE.control_period_s
    room = (SURFACE.rating.overspeed_rpm - 600.0) * RADIANS_PER_RPM
    for share, away in ((0.9, True), (1.1, False)):
        inertia = share * torque * rise / room
        machine = SURFACE.machine.model_copy(update={"inertia_kg_m2": inertia})
        run = hoist_scenario(SURFACE.model_copy(update={"machine": machine}), (-600.0,), torque)
        assert runs_away(run) == away
        reason = unfair_because(run)
        assert (reason is not None and "above overspeed before" in reason) == away
