"""Every field of both nameplates is what a drive's file states, in SI units."""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import Any, Final

import pytest

from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.sensors import ShuntSensors
from drivegate_models.contract.current.records import NAMEPLATE, nameplate_record
from drivegate_models.contract.current.signals import HALF_BRIDGE, PM_AC, STAR
from drivegate_models.contract.duty.records import DUTY_NAMEPLATE, duty_nameplate_record
from drivegate_models.contract.duty.signals import (
    ENCODER_POSITION,
    EXACT_POSITION,
    HALL_POSITION,
    NO_POSITION,
    SPEED_REFERENCE,
    TORQUE_REFERENCE,
)

RPM: Final = pi / 30.0
DEGREE: Final = pi / 180.0
PERIOD: Final = 4e-4


def stated(name: str) -> PmAcDocument:
    drive = load_drive(name)
    assert isinstance(drive, PmAcDocument)
    return drive


LINKED = ["pm-ac-hub", "pm-ac-servo-48v", "pm-ac-chopper"]
"""Drives whose link is not ideal; each states all that the nameplate has of it."""


def _of_windings(drive: PmAcDocument, key: str) -> float:
    """Return a thermal value of the windings, 0 where there is none."""
    return float(getattr(drive.thermal, key, None) or 0.0)


def _of_link(drive: PmAcDocument, key: str) -> float:
    """Return a stated value of the link, 0 where there is none."""
    return float(getattr(drive.link, key, None) or 0.0)


OF_DUTY_RATIOS: Final[dict[str, Callable[[PmAcDocument], float]]] = {
    "struct_size": lambda _drive: DUTY_NAMEPLATE.itemsize,
    "kind": lambda _drive: PM_AC,
    "reference_kind": lambda _drive: SPEED_REFERENCE,
    "pole_pairs": lambda drive: drive.machine.pole_pairs,
    "updates": lambda drive: {"single": 1, "double": 2, "sawtooth": 0}[drive.inverter.carrier],
    "update_delay": lambda drive: drive.inverter.update_delay,
    "supply_voltage": lambda drive: drive.inverter.link_voltage_v,
    "base_speed": lambda drive: drive.rating.base_speed_rpm * RPM,
    "highest_speed": lambda drive: drive.rating.highest_speed_rpm * RPM,
    "rated_power": lambda drive: drive.rating.rated_power_w,
    "current_limit": lambda drive: drive.rating.current_limit_a,
    "control_period": lambda drive: (
        1.0 / drive.inverter.carrier_frequency_hz / {"double": 2.0}.get(drive.inverter.carrier, 1.0)
    ),
    "dead_time": lambda drive: drive.inverter.dead_time_s,
    "resistance": lambda drive: drive.machine.resistance_ohm,
    "direct_inductance": lambda drive: drive.machine.direct_inductance_h,
    "quadrature_inductance": lambda drive: drive.machine.quadrature_inductance_h,
    "magnet_flux": lambda drive: drive.machine.magnet_flux_v_s,
    "inertia": lambda drive: drive.machine.inertia_kg_m2,
    "core_loss_conductance": lambda drive: drive.machine.core_loss_conductance_s,
    "control_every": lambda drive: drive.inverter.control_every or 1,
    "switch_drop": lambda drive: drive.inverter.switch_drop_v,
    "diode_drop": lambda drive: drive.inverter.diode_drop_v,
    "position_error": lambda drive: {"exact": 12.0, "encoder": 0.0, "hall": 2.5}[drive.position] * DEGREE,
    "link_capacitance": lambda drive: _of_link(drive, "capacitance_f"),
    "source_resistance": lambda drive: _of_link(drive, "source_resistance_ohm"),
    "link_limit": lambda drive: _of_link(drive, "link_limit_v"),
    "charge_limit": lambda drive: _of_link(drive, "charge_limit_a"),
    "discharge_limit": lambda drive: _of_link(drive, "discharge_limit_a"),
    "chopper_voltage": lambda drive: _of_link(drive, "chopper_on_v"),
    "chopper_resistance": lambda drive: _of_link(drive, "chopper_resistance_ohm"),
    "position": lambda _drive: EXACT_POSITION,
    "least_speed": lambda _drive: 0.0,
    "start_time": lambda _drive: 0.0,
    "is_reversing": lambda _drive: 1,
    "heat_capacity": lambda drive: _of_windings(drive, "heat_capacity_j_per_k"),
    "thermal_resistance": lambda drive: _of_windings(drive, "thermal_resistance_k_per_w"),
    "ambient_temperature": lambda drive: _of_windings(drive, "ambient_c"),
    "temperature_limit": lambda drive: _of_windings(drive, "limit_c"),
    "temperature_coefficient": lambda drive: _of_windings(drive, "temperature_coefficient_per_k"),
    "temperature_lag": lambda drive: _of_windings(drive, "sensor_lag_s"),
    "voltage_filter": lambda _drive: 0.0,
}
"""What each field of a nameplate of duty ratios is of a drive's file."""


@pytest.mark.parametrize(
    "name", ["pm-ac-surface", "pm-ac-interior", "pm-ac-2kw", "pm-ac-msl", "pm-ac-servo", *LINKED]
)
@pytest.mark.parametrize("field", DUTY_NAMEPLATE.names)
def test_a_field_of_the_nameplate_of_duty_ratios_is_what_the_drive_states(field: str, name: str) -> None:
    assert field in OF_DUTY_RATIOS, f"nothing is asserted of the field '{field}'"
    drive = stated(name)
    record = duty_nameplate_record(drive.duty_nameplate(drive.control_period_s, torque_reference=False))[0]
    assert record[field] == pytest.approx(OF_DUTY_RATIOS[field](drive), rel=1e-12)
    by_torque = drive.duty_nameplate(drive.control_period_s, torque_reference=True)
    assert by_torque.reference_kind == TORQUE_REFERENCE


def test_drops_and_the_error_of_the_position_are_on_the_nameplate() -> None:
    hall = stated("pm-ac-interior").replaced(sensing={"position": "hall"})
    drive = hall.with_overrides(["switch_drop_v=1.6", "diode_drop_v=1.1"])
    assert isinstance(drive, PmAcDocument)
    plate = drive.duty_nameplate(drive.control_period_s, torque_reference=False)
    assert (plate.switch_drop, plate.diode_drop) == (1.6, 1.1)
    usual = ShuntSensors(kind="shunts")
    switches = usual.placement_error_deg + usual.hysteresis_deg
    assert plate.position_error == pytest.approx(switches * DEGREE, rel=1e-12)
    encoder = drive.replaced(sensing={"position": "encoder"})
    assert isinstance(encoder, PmAcDocument)
    assert encoder.duty_nameplate(1e-4, torque_reference=False).position_error == 0.0


@pytest.mark.parametrize(
    ("position", "number"), [("encoder", ENCODER_POSITION), ("hall", HALL_POSITION), ("none", NO_POSITION)]
)
def test_what_shows_the_shaft_is_on_the_nameplate(position: str, number: int) -> None:
    drive = stated("pm-ac-interior").replaced(sensing={"position": position})
    assert isinstance(drive, PmAcDocument)
    assert drive.duty_nameplate(1e-4, torque_reference=False).position == number


def test_a_drive_that_turns_one_way_says_so_on_the_nameplate() -> None:
    drive = stated("pm-ac-interior").with_overrides(["rating.reverses=false"])
    assert isinstance(drive, PmAcDocument)
    assert drive.duty_nameplate(1e-4, torque_reference=False).is_reversing == 0


OF_CURRENTS: Final[dict[str, Callable[[Any], float]]] = {
    "struct_size": lambda _drive: NAMEPLATE.itemsize,
    "phases": lambda drive: drive.machine.phases,
    "pole_pairs": lambda drive: drive.machine.pole_pairs,
    "half_supply_voltage": lambda drive: drive.inverter.supply_voltage_v,
    "base_speed": lambda drive: drive.rating.base_speed_rpm * RPM,
    "rated_power": lambda drive: drive.rating.rated_power_w,
    "current_limit": lambda drive: drive.rating.current_limit_a,
    "control_period": lambda _drive: PERIOD,
    "hysteresis_band": lambda drive: drive.inverter.hysteresis_band_a,
    "resistance": lambda drive: drive.machine.resistance_ohm,
    "inductance": lambda drive: drive.machine.inductance_h,
    "emf_constant": lambda drive: drive.machine.emf_constant_v_s_per_rad,
    "inertia": lambda drive: drive.machine.inertia_kg_m2,
    "kind": lambda drive: {"half-bridge": HALF_BRIDGE, "star": STAR}[drive.kind],
    "window": lambda drive: drive.inverter.window_deg * DEGREE,
    "conducting_phases": lambda drive: drive.machine.phases * drive.inverter.window_deg / 180.0,
    "advance_start": lambda drive: drive.advance.start_deg * DEGREE,
    "advance_slope": lambda drive: drive.advance.slope_deg_per_rpm * DEGREE / RPM,
    "highest_speed": lambda drive: drive.rating.highest_speed_rpm * RPM,
}
"""The same of a nameplate of current references."""


def with_a_line(name: str) -> DriveDocument:
    """Return a drive that states its line of advance angles."""
    drive = load_drive(name)
    return drive.replaced(advance={"start_deg": 33.0, "slope_deg_per_rpm": 0.025})


@pytest.mark.parametrize("name", ["paper-5-phase", "fan-3-phase", "star-3-phase", "traction-7-phase"])
@pytest.mark.parametrize("field", NAMEPLATE.names)
def test_a_field_of_the_nameplate_of_current_references_is_what_the_drive_states(
    field: str, name: str
) -> None:
    assert field in OF_CURRENTS, f"nothing is asserted of the field '{field}'"
    drive = with_a_line(name)
    record = nameplate_record(drive.nameplate(PERIOD))[0]
    assert record[field] == pytest.approx(OF_CURRENTS[field](drive), rel=1e-12)
