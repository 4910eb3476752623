"""The mirror image of a run, and what of it only drives and candidates that reverse are run in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, seed, settings

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.duty.checks.symmetry import same_both_ways
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.building import hoist_scenario, speed_scenario, torque_scenario
from drivegate.contracts.duty.scenarios.drawn.families import FAMILY_GROUPS, drawn_scenarios
from drivegate.contracts.duty.scenarios.feasibility import unfair_because
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios
from drivegate.drives.running import recorded
from drivegate.gate.shard import FixedRuns, run_fixed
from drivegate.scenarios.rotation import goes_backward, mirrored, needs_reverse
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.failure_kind import FAILURE_KINDS, FailureKind
from drivegate_cases.scenario.load import DynamometerLoad, HoistLoad, VehicleLoad
from drivegate_cases.scenario.piecewise import value_from
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

DRIVE = load_drive("pm-ac-interior").replaced(settling_s=0.1)
SETTLED = load_drive("pm-ac-interior").replaced(settling_s=0.8)
assert isinstance(DRIVE, PmAcDocument)
assert isinstance(SETTLED, PmAcDocument)


def record_of(scenario: Scenario, name: str = "foc") -> DutyRecord:
    loaded = own_candidate(resolve_candidate(name))
    record = recorded(loaded, scenario, loaded.controller())
    assert isinstance(record, DutyRecord)
    return record


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "name", ["foc", "predictive-flux", "direct-torque", "load-observer", "foc-loss-model"]
)
def test_drive_and_controllers_turn_backward_as_they_turn_forward(name: str) -> None:
    run = mirrored(torque_scenario(DRIVE, 3000.0, (1.0, -1.0)).replaced(initial_angle_deg=20.0))
    record = record_of(run, name)
    assert record.mirror is not None
    for column, sign in (("torque", -1.0), ("direct", 1.0), ("quadrature", -1.0), ("speed", -1.0)):
        own, other = record.run.column(column), record.mirror.run.column(column)
        assert np.max(np.abs(own - sign * other)) < 1e-6, f"{column} is not mirrored"
    margin = same_both_ways(record)
    assert margin is not None
    assert margin.value > 0.999


def vehicle_on(grade: float, speed: float = 600.0) -> Scenario:
    """Make a run of a light vehicle on a grade (%) at a speed (rpm)."""
    vehicle = VehicleLoad(
        kind="vehicle",
        mass_kg=10.0,
        wheel_radius_m=0.1,
        gear_ratio=2.0,
        rolling_resistance=0.01,
        drag_area_m2=0.1,
        grade_percent=((0.0, grade),),
    )
    run = speed_scenario(DRIVE, (speed,))
    return run.replaced(load=vehicle, initial_speed_rpm=speed)


def test_a_vehicle_is_mirrored_with_its_road() -> None:
    run = vehicle_on(5.0)
    record, mirror = record_of(run), record_of(mirrored(run))
    for column, sign in (("torque", -1.0), ("load", -1.0), ("speed", -1.0), ("input_power", 1.0)):
        own, other = record.run.column(column), mirror.run.column(column)
        assert np.max(np.abs(own - sign * other)) < 1e-6, f"{column} is not mirrored"
    assert vehicle_on(5.0).replaced(load=mirrored(vehicle_on(-5.0)).load) == vehicle_on(5.0)


@pytest.mark.parametrize(("grade", "is_fair"), [(5.0, True), (-5.0, True), (100.0, False), (-100.0, False)])
def test_a_slope_must_be_climbed_and_braked_within_the_limits(grade: float, is_fair: bool) -> None:
    assert (unfair_because(vehicle_on(grade)) is None) is is_fair
    assert (unfair_because(mirrored(vehicle_on(grade))) is None) is is_fair


def test_a_difference_of_the_limit_is_no_margin() -> None:
    record = record_of(mirrored(torque_scenario(DRIVE, 1000.0, (1.0,))))
    assert record.mirror is not None
    rated = record.document.rating.rated_torque_nm
    windows = tuple(replace(window, torque=window.torque + 0.02 * rated) for window in record.steady)
    record.__dict__["steady"] = windows
    margin = same_both_ways(record)
    assert margin is not None
    assert margin.value == pytest.approx(0.0, abs=1e-3)


def test_a_run_forward_or_of_a_speed_is_compared_with_none() -> None:
    for run in (
        torque_scenario(DRIVE, 1000.0, (1.0,)),
        speed_scenario(DRIVE, (500.0, -500.0)),
        mirrored(speed_scenario(DRIVE, (500.0,))),
    ):
        assert contract_of(DRIVE).unseen(NOTHING_DECLARED, run).mirror is None


def test_a_hoist_brakes_a_shaft_forward_and_drives_it_backward() -> None:
    run = hoist_scenario(SETTLED, (500.0, -500.0), 1.0)
    record = record_of(run)
    lifting, lowering = record.steady
    assert lifting.torque == pytest.approx(1.0, rel=0.05)
    assert lowering.torque == pytest.approx(1.0, rel=0.05)
    assert lowering.speed == pytest.approx(-lifting.speed, rel=1e-3)


def test_nobody_is_run_backward_who_states_to_turn_one_way() -> None:
    one_way = DRIVE.with_overrides(["rating.reverses=false"])
    contract = contract_of(DRIVE)
    backward = [run for run in contract.fixed_scenarios(DRIVE, NOTHING_DECLARED) if goes_backward(run)]
    assert backward
    declared = replace(NOTHING_DECLARED, reverses=False)
    for drive, declaration in ((one_way, NOTHING_DECLARED), (DRIVE, declared)):
        assert not any(map(goes_backward, contract.fixed_scenarios(drive, declaration)))
    with pytest.raises(
        InputError, match=r"speeds from 0, since the key 'reverses' in the drive's \[rating\]"
    ):
        backward[0].replaced(drive=one_way)
    both_ways = [run for run in fixed_scenarios(DRIVE) if needs_reverse(run)]
    assert len(fixed_scenarios(DRIVE)) == len(fixed_scenarios(DRIVE, reverses=False)) + len(both_ways)


def pulls_backward(run: Scenario) -> bool:
    """Return True if a run asks for what a shaft that turns one way cannot do, looked at every millisecond."""
    if isinstance(run.load, HoistLoad):
        return True
    torques = run.load.torque_reference_nm if isinstance(run.load, DynamometerLoad) else ((0.0, 0.0),)
    times = [0.001 * number for number in range(int(1000.0 * run.duration_s))]
    return any(
        value_from(run.speed_rpm, time) < 0.0
        or (value_from(torques, time) < 0.0 and value_from(run.speed_rpm, time) == 0.0)
        for time in times
    )


@pytest.mark.parametrize("detected", [(), FAILURE_KINDS])
def test_no_fixed_run_pulls_a_shaft_backward_that_turns_one_way(detected: tuple[FailureKind, ...]) -> None:
    runs = fixed_scenarios(DRIVE, detected=detected, reverses=False)
    assert not [run.name for run in runs if pulls_backward(run)]
    assert any(pulls_backward(run) for run in fixed_scenarios(DRIVE, detected=detected))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("group", range(len(FAMILY_GROUPS)))
def test_no_drawn_run_pulls_a_shaft_backward_that_turns_one_way(group: int) -> None:
    drawn = drawn_scenarios(DRIVE, group, detected=FAILURE_KINDS, reverses=False)

    @settings(max_examples=40, database=None, deadline=None, suppress_health_check=list(HealthCheck))
    @seed(group)
    @given(drawn)
    def drawn_forward(run: Scenario) -> None:
        assert not pulls_backward(run)

    drawn_forward()


def test_a_torque_backward_at_standstill_needs_a_drive_that_reverses() -> None:
    one_way = DRIVE.with_overrides(["rating.reverses=false"])
    assert isinstance(one_way, PmAcDocument)
    for torques, at_rest, braking in (((1.0, -1.0), True, False), ((1.0, 0.5), False, False)):
        assert needs_reverse(torque_scenario(DRIVE, 0.0, torques)) is at_rest
        assert needs_reverse(torque_scenario(DRIVE, 1000.0, torques)) is braking
        assert (unfair_because(torque_scenario(one_way, 0.0, torques)) is not None) is at_rest
        assert unfair_because(torque_scenario(DRIVE, 0.0, torques)) is None


def test_a_stored_run_backward_is_set_aside_for_a_candidate_that_turns_one_way() -> None:
    loaded = own_candidate(
        replace(resolve_candidate("foc"), declaration=replace(NOTHING_DECLARED, reverses=False))
    )
    outcome = run_fixed(loaded, FixedRuns((torque_scenario(DRIVE, 0.0, (-1.0,)),)))
    assert not outcome.runs
    assert "states 'reverses = false'" in outcome.infeasible[0].reason
