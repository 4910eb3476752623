"""A drive that states what shows its shaft: fixed, drawn and simpler runs show it, and unfair ones do not count."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegate.contracts.duty.plant_run import duty_sensors
from drivegate.contracts.duty.scenarios.building import (
    load_step_scenario,
    speed_scenario,
    torque_of,
    torque_scenario,
)
from drivegate.contracts.duty.scenarios.drawn.families import drawn_scenarios
from drivegate.contracts.duty.scenarios.feasibility import unfair_because
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios
from drivegate.contracts.duty.scenarios.simplification import DUTY_SIMPLIFICATIONS
from drivegate.scenarios.simplification import simplified
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.failure_kind import FAILURE_KINDS
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.pm_ac import sensing

EXACT = load_drive("pm-ac-interior")
NUMBERS = {"encoder": sensing.ENCODER, "hall": sensing.HALL}


def drive_with(position: str) -> PmAcDocument:
    drive = EXACT.with_overrides([f"sensing.position={position}"])
    assert isinstance(drive, PmAcDocument)
    return drive


BY_HALL = drive_with("hall")


def simpler_runs(scenario: Scenario) -> Iterator[Scenario]:
    """Yield the runs that a scenario can be made simpler to at once."""
    for simplification in DUTY_SIMPLIFICATIONS:
        for fields in simplification(scenario):
            if (found := simplified(scenario, fields)) is not None:
                yield found


@pytest.mark.parametrize("position", NUMBERS)
def test_every_fixed_run_shows_what_the_drive_states(position: str) -> None:
    for run in fixed_scenarios(drive_with(position), detected=FAILURE_KINDS):
        assert duty_sensors(run).position == NUMBERS[position], run.name


@pytest.mark.nightly
@given(st.data())
@settings(max_examples=60)
def test_every_drawn_run_and_what_it_shrinks_to_shows_what_the_drive_states(data: st.DataObject) -> None:
    run = data.draw(drawn_scenarios(BY_HALL, detected=FAILURE_KINDS))
    for shown in (run, *simpler_runs(run)):
        assert duty_sensors(shown).position == sensing.HALL, shown.name


def test_ideal_sensors_show_edges_in_their_places() -> None:
    run = torque_scenario(BY_HALL, 600.0, (0.0,))
    switches = duty_sensors(run).hall
    assert not switches.lags.any()
    assert switches.backlash == 0.0
    assert not duty_sensors(run).ideal
    assert duty_sensors(torque_scenario(EXACT, 600.0, (0.0,))).ideal  # type: ignore[arg-type]


def test_no_torque_is_judged_at_rest_by_hall_switches_alone() -> None:
    for drive, reason in ((BY_HALL, "Hall switches"), (drive_with("encoder"), "None")):
        torque = torque_of(drive, 0.0, 0.3)
        assert reason in str(unfair_because(torque_scenario(drive, 0.0, (0.0, torque))))
        assert unfair_because(torque_scenario(drive, 600.0, (0.0, torque))) is None


@pytest.mark.parametrize(
    ("run", "stops"),
    [
        # 0.99 J at 300 rpm, of which 0.85 of rated torque takes 1.01 J in a sector of 30 degrees of the shaft.
        (load_step_scenario(BY_HALL, 300.0, 2.274, (0.85, 0.55)), True),
        (load_step_scenario(BY_HALL, 300.0, 2.274, (0.2, 0.85)), False),
        (load_step_scenario(BY_HALL, 300.0, 2.274, (0.0, 0.85)), True),
        (load_step_scenario(BY_HALL, 320.0, 2.274, (0.85, 0.55)), False),
        (load_step_scenario(drive_with("encoder"), 300.0, 2.274, (0.85, 0.55)), False),
        (speed_scenario(BY_HALL, (420.0,), torque_nm=1.137, initial_speed_rpm=0.0), False),
    ],
    ids=["begins", "rises by less", "rises", "faster", "encoder", "starts"],
)
def test_a_load_that_stops_the_shaft_within_a_sector_is_set_aside(run: Scenario, stops: bool) -> None:
    assert ("stops the shaft before the next edge" in str(unfair_because(run))) is stops


def test_a_vehicle_has_the_energy_of_its_mass() -> None:
    road = {"wheel_radius_m": 0.1, "gear_ratio": 1.0, "rolling_resistance": 0.2, "drag_area_m2": 0.0}
    vehicle = {"kind": "vehicle", "mass_kg": 10.0, **road}
    # 49 J of the vehicle, and 1 J of the shaft alone, of which a sector takes 1.03 J.
    run = speed_scenario(BY_HALL, (300.0,)).replaced(load=vehicle)
    assert "stops the shaft" not in str(unfair_because(run))


def test_a_scenario_in_a_document_shows_it_when_it_is_read_again() -> None:
    run = torque_scenario(BY_HALL, 600.0, (0.0,))
    again = parse_document(run.to_mapping(), Scenario, "the scenario")
    assert again == run
    assert duty_sensors(again).position == sensing.HALL
