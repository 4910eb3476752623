"""What no controller without a position sensor could do."""

from __future__ import annotations

from itertools import pairwise
from math import pi, sqrt
from typing import Final

from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.reaching import load_on_shaft
from drivegate.contracts.duty.scenarios.windows import duty_dwells
from drivegate.scenarios.drive_scale import rated_torque_at
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.sensorless import START_TORQUE
from drivegate_cases.scenario.courses import profiles_of
from drivegate_cases.scenario.load import HoistLoad, LockedLoad, VehicleLoad
from drivegate_cases.scenario.piecewise import value_from
from drivegate_cases.scenario.profile import Dwell, dwell_of
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.pm_ac.rectifying import rectifies
from drivegate_models.units import RADIANS_PER_RPM

TAKE_OVER_S: Final = 0.1
"""Time in which a controller takes over a turning shaft (s)."""
REACTION_S: Final = 0.05
"""Time in which a load that comes on may move the shaft freely (s)."""
_ROUNDING: Final = 0.01


def unfair_without_sensor(scenario: Scenario) -> str | None:
    """State why nobody controls a drive without a position sensor in a scenario; None with a sensor."""
    document = duty_document(scenario.drive)
    if document.has_sensor:
        return None
    least = document.least_speed_rpm * (1.0 - _ROUNDING)
    dwells = duty_dwells(scenario)
    if any(abs(dwell.speed_rpm) < least for dwell in dwells):
        speed = f"{document.least_speed_rpm:.4g} rpm"
        return f"without a position sensor, nothing is required below the least speed of {speed}"
    if conducts_off(scenario, document):
        return "without a position sensor, a shaft so fast that the diodes conduct cannot be taken over"
    if isinstance(scenario.load, (LockedLoad, VehicleLoad)):
        return None
    if scenario.restarts_s:
        return "a controller without a position sensor cannot take over a shaft under a load after a restart"
    return _unfair_start(scenario, document, _begin(scenario)) or _unfair_step(scenario, document, dwells)


def _begin(scenario: Scenario) -> Dwell:
    """Return the conditions with which a scenario begins."""
    return dwell_of(
        scenario, {name: value_from(points, 0.0) for name, points in profiles_of(scenario).items()}
    )


def most_induced(document: PmAcDocument) -> float:
    """Return the EMF between lines over the link up to which a controller takes over a shaft (1).

    Diodes that conduct all the time put a fundamental of ``(2 / pi) V`` on a phase, against its current. Without
    resistance, ``(2 / pi) V (cos(a)**2 + (L_d / L_q) sin(a)**2) / cos(a)`` is the EMF of a phase whose terminals lag
    behind it by an angle ``a``. A sample differs from their fundamental by up to 30 degrees, and must not differ from
    the EMF by more than 90: ``a`` is at most 60 degrees. A controller that models the diodes could follow a shaft
    further, which none has to.
    """
    machine = document.machine
    share = machine.direct_inductance_h / machine.quadrature_inductance_h
    return float(sqrt(3.0) / pi * (1.0 + 3.0 * share))


def conducts_off(scenario: Scenario, document: PmAcDocument) -> bool:
    """Return True if a run begins so fast that the terminals show the link in place of the EMF."""
    first = _begin(scenario)
    is_held = isinstance(scenario.load, LockedLoad)
    speed = abs(first.speed_rpm if is_held else scenario.initial_speed_rpm) * RADIANS_PER_RPM
    return bool(rectifies(document.plant(first.scales), speed / most_induced(document), 2.0 * first.supply_v))


def fastest_taken_over_rpm(document: PmAcDocument) -> float:
    """Return the greatest speed of a shaft that a run may begin at (rpm): the highest one with a sensor."""
    highest, machine = document.rating.highest_speed_rpm, document.machine
    if document.has_sensor:
        return highest
    inverter = document.inverter
    emf = (inverter.link_voltage_v + 2.0 * inverter.diode_drop_v) * most_induced(document) / sqrt(3.0)
    speed = emf / (machine.pole_pairs * machine.magnet_flux_v_s * RADIANS_PER_RPM)
    return float(min(highest, (1.0 - _ROUNDING) * speed))


def _unfair_start(scenario: Scenario, document: PmAcDocument, first: Dwell) -> str | None:
    initial = scenario.initial_speed_rpm
    torque = load_on_shaft(scenario, first, initial * RADIANS_PER_RPM)
    if 0.0 < abs(initial) < document.least_speed_rpm * (1.0 - _ROUNDING):
        return "without a position sensor, a shaft that turns below the least speed cannot be taken over"
    if initial == 0.0:
        if isinstance(scenario.load, HoistLoad) and torque != 0.0:
            return "without a position sensor, a weight drives the shaft before a start has found the rotor"
        if abs(torque) > START_TORQUE * rated_torque_at(document, 0.0) * (1.0 + _ROUNDING):
            return "without a position sensor, no start is required above half of rated torque"
        return None
    moved = abs(torque) * TAKE_OVER_S / document.machine.inertia_kg_m2 / RADIANS_PER_RPM
    if abs(initial) - moved < document.least_speed_rpm * (1.0 - _ROUNDING):
        return "its load stops the shaft before a controller without a position sensor can take it over"
    return None


def _unfair_step(scenario: Scenario, document: PmAcDocument, dwells: tuple[Dwell, ...]) -> str | None:
    """State why a load that comes on at once is too much at its speed."""
    moved = REACTION_S / document.machine.inertia_kg_m2 / RADIANS_PER_RPM
    for before, dwell in pairwise(dwells):
        if before.end != dwell.start:
            continue
        speed = abs(dwell.speed_rpm)
        loads = [load_on_shaft(scenario, each, dwell.speed_rpm * RADIANS_PER_RPM) for each in (before, dwell)]
        if speed - abs(loads[1] - loads[0]) * moved < document.least_speed_rpm * (1.0 - _ROUNDING):
            return "its load stops the shaft before a controller without a position sensor can act"
    return None
