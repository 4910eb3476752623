"""Faulty controllers without a position sensor: each is caught by its check in one run that is made for it."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from tests.harness.contracts.reading import is_read, read_off

from drivegate.candidates.builtin.duty_loading import SENSORLESS, DutyController
from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.checks.margin import Margin
from drivegate.contracts.catalogue import check_of
from drivegate.contracts.duty.contract import DUTY
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.building import share_scenario
from drivegate.contracts.duty.scenarios.sensorless import (
    flying_start,
    least_rpm,
    lost_rotor,
    overloaded,
    sensorless_load_step,
    sensorless_reversal,
    sensorless_start,
    slowly_loaded,
)
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_lab.candidates.families import DESIGN, SENSORLESS_DESIGN_NAMES
from drivegate_lab.candidates.sensorless_controller import SensorlessController
from drivegate_lab.candidates.sensorless_designs import SENSORLESS_DESIGNS
from drivegate_lab.candidates.sensorless_faults import SENSORLESS_FAULTS
from drivegate_models.pm_ac.closed_loop import prepared_duty_loop

SENSED, DRIVE = load_drive("pm-ac-2kw"), duty_document(load_drive("pm-ac-2kw-sensorless"))
FAST = duty_document(load_drive("pm-ac-servo-sensorless"))
LEAST, BASE, TOP = least_rpm(DRIVE), DRIVE.rating.base_speed_rpm, DRIVE.rating.highest_speed_rpm
TWICE = least_rpm(DRIVE, 2.0)
SHOWN_BY: dict[str, Callable[[], Scenario]] = {
    "observer-without-resistance": lambda: slowly_loaded(DRIVE, LEAST, 0.8),
    "long-dead-time-assumed": lambda: slowly_loaded(DRIVE, LEAST, 0.8),
    "observer-voltage-too-new": lambda: share_scenario(FAST, FAST.rating.highest_speed_rpm, 0.0, 0.5),
    "angle-negated": lambda: slowly_loaded(DRIVE, TWICE, 0.0),
    "observer-gain-signed": lambda: slowly_loaded(DRIVE, -BASE, 0.8),
    "standstill-presumed": lambda: flying_start(DRIVE, BASE),
    "start-for-ever": lambda: lost_rotor(DRIVE, BASE, 0.0, from_standstill=True),
    "angle-reported-late": lambda: flying_start(DRIVE, TOP),
    "loss-untold": lambda: lost_rotor(DRIVE, BASE, 0.5),
    "electrical-angle-reported": lambda: slowly_loaded(DRIVE, TWICE, 0.0),
    "starts-forward-only": lambda: sensorless_start(DRIVE, TWICE, 0.0, 0.0).replaced(
        speed_rpm=((0.0, -TWICE),)
    ),
    "forward-presumed": lambda: flying_start(DRIVE, -BASE),
    "weak-start": lambda: sensorless_start(DRIVE, TWICE, 0.5, 90.0),
    "dead-time-left-out": lambda: slowly_loaded(DRIVE, LEAST, 0.8),
    "handover-half-a-turn-off": lambda: sensorless_start(DRIVE, TWICE, 0.0, 0.0),
    "handover-without-torque": lambda: sensorless_start(DRIVE, TWICE, 0.5, 0.0),
    "stall-believed": lambda: overloaded(DRIVE, TWICE),
    "coasts-to-reverse": lambda: sensorless_reversal(DRIVE, 4.0 * LEAST, 0.0),
    "slow-observer": lambda: sensorless_load_step(DRIVE, BASE, 0.8),
}


STEADY_MEANS = ("SLS-2", "SLS-8")


def _record(scenario: Scenario, controller: DutyController | SensorlessController) -> DutyRecord:
    return DUTY.record(prepared_duty_loop, NOTHING_DECLARED, scenario, controller)


def _margin(check: str, record: DutyRecord) -> Margin | None:
    return check_of("duty", check, NOTHING_DECLARED).evaluate(record)


def test_every_fault_has_a_run() -> None:
    assert set(SHOWN_BY) == set(SENSORLESS_FAULTS)


@pytest.mark.one_in(5)
@pytest.mark.parametrize("name", SHOWN_BY)
def test_a_fault_is_caught_where_the_controller_without_it_passes(name: str) -> None:
    fault, scenario = SENSORLESS_FAULTS[name], SHOWN_BY[name]()
    assert DUTY.unfair_because(scenario) is None
    right = _margin(fault.check, _record(scenario, DutyController(SENSORLESS)))
    record = _record(scenario, SensorlessController(fault))
    wrong = _margin(fault.check, record)
    assert right is not None
    assert right.met, right
    assert wrong is not None
    assert not wrong.met, wrong
    if fault.check not in STEADY_MEANS:
        measured, numbers = read_off(check_of("duty", fault.check, NOTHING_DECLARED), record)
        assert is_read(measured, numbers), f"{measured!r} is not among {numbers}"


def test_a_fault_idles_on_a_drive_with_a_sensor() -> None:
    assert {fault.on(SENSED).idle_because for fault in SENSORLESS_FAULTS.values()} == {
        "this drive has a position sensor"
    }
    idle = [name for name, fault in SENSORLESS_FAULTS.items() if fault.on(DRIVE).idle_because is not None]
    assert idle == ["observer-voltage-too-new"], "3.4 degrees at its highest speed"
    idle = [name for name, fault in SENSORLESS_FAULTS.items() if fault.on(FAST).idle_because is not None]
    assert idle == ["handover-half-a-turn-off", "stall-believed"], "its observer finds a lost rotor again"


@pytest.mark.one_in(2)
@pytest.mark.parametrize(("drive", "check"), [(DRIVE, "SLS-2"), (FAST, "SLS-3")])
def test_a_resistance_left_out_loses_the_rotor_or_turns_its_angle(drive: PmAcDocument, check: str) -> None:
    fault = SENSORLESS_FAULTS["observer-without-resistance"]
    assert fault.on(drive).check == fault.check_on(drive) == check
    record = _record(slowly_loaded(drive, -least_rpm(drive), -0.8), SensorlessController(fault))
    margin = _margin(check, record)
    assert margin is not None
    assert not margin.met, margin


def test_designs_are_candidates_by_name() -> None:
    assert set(SENSORLESS_DESIGN_NAMES) == set(SENSORLESS_DESIGNS)
    for name in SENSORLESS_DESIGN_NAMES:
        assert DESIGN.contract(name) == "duty"
        assert isinstance(DESIGN.load_controller(name), SensorlessController)


@pytest.mark.one_in(3)
@pytest.mark.parametrize("name", SENSORLESS_DESIGN_NAMES)
def test_a_design_starts_and_bears_a_load_as_the_controller_does_but_otherwise(name: str) -> None:
    scenario = slowly_loaded(DRIVE, -TWICE, 0.8)
    record = _record(scenario, SensorlessController(SENSORLESS_DESIGNS[name]))
    for check in ("SLS-1", "SLS-2", "SLS-3"):
        margin = _margin(check, record)
        assert margin is not None
        assert margin.met, margin
    plain = _record(scenario, DutyController(SENSORLESS))
    assert record.run.column("speed").tolist() != plain.run.column("speed").tolist(), "it is another design"
