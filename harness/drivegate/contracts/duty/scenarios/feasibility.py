"""What no controller of duty ratios could do: the rules for scenarios that a candidate may fairly be judged on."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Final

import numpy as np

from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.drawn_range import (
    TURNING_SHARE,
    greatest_angle_error,
    is_slow,
    slow_load_share,
    unnoticed_because,
)
from drivegate.contracts.duty.scenarios.hot import unfair_heat
from drivegate.contracts.duty.scenarios.linked import unfair_supply
from drivegate.contracts.duty.scenarios.overload import overloaded_s
from drivegate.contracts.duty.scenarios.reaching import (
    BRAKING_SHARE,
    greatest_braking,
    greatest_torque,
    is_too_late,
    load_on_shaft,
    runs_away,
)
from drivegate.contracts.duty.scenarios.released import is_stalled, unfair_release
from drivegate.contracts.duty.scenarios.unsensed import unfair_without_sensor
from drivegate.contracts.duty.scenarios.windows import duty_dwells, shaft_inertia
from drivegate.scenarios.drive_scale import rated_torque_at
from drivegate.scenarios.rotation import needs_reverse
from drivegate_cases.drive.data_sheet import USABLE_SHARE
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.plant import NOMINAL
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.limits import GREATEST_ANGLE_DEG
from drivegate_cases.scenario.courses import friction_since, profiles_of
from drivegate_cases.scenario.load import DynamometerLoad, LockedLoad, VehicleLoad
from drivegate_cases.scenario.piecewise import value_from
from drivegate_cases.scenario.profile import Dwell, dwell_of
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import EDGES_A_LINE, SHUNTS, ShuntSensors
from drivegate_models.contract.duty.signals import LEG_OFF
from drivegate_models.loop.sensing.hall import SECTOR
from drivegate_models.machine import ledger
from drivegate_models.machine.friction import friction_torque
from drivegate_models.pm_ac.plant.advance import make_phases
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.rectifying import settle_rectifying
from drivegate_models.units import RADIANS_PER_RPM

FALSE_SHARE: Final = 0.25
"""Greatest share of false edges in a speed window of an encoder (1)."""
IN_HAND: Final = USABLE_SHARE
"""Share of the greatest torque that a speed's load may take; the rest is for regulation (1)."""
_KEPT: Final = 20_000
_ROUNDING: Final = 0.01
"""What torques that people can read are rounded by, over themselves (1)."""


def unfair_because(scenario: Scenario) -> str | None:
    """State why a candidate may not be judged on a scenario; a torque reference out of reach is judged as such."""
    reasons = (
        _unfair_begin,
        unnoticed_because,
        _unfair_position,
        unfair_without_sensor,
        unfair_release,
        unfair_heat,
        unfair_supply,
        _unfair_load,
    )
    return next((because for reason in reasons if (because := reason(scenario)) is not None), None)


def _unfair_begin(scenario: Scenario) -> str | None:
    """State why a scenario begins as no drive does, or goes where none may."""
    differs = scenario.scales != NOMINAL
    if differs and abs(scenario.initial_speed_rpm) > scenario.drive.rating.base_speed_rpm:
        return "it begins above base speed, on a plant that the controller does not know"
    if _is_beyond_overspeed(scenario):
        return "it begins or has a reference above overspeed, where a drive turns itself off"
    if (because := scenario.drive.one_way_because) is not None and needs_reverse(scenario):
        return f"it needs a shaft that turns both ways, but {because}"
    current = _rectified_current(scenario)
    if current > limits_of(duty_document(scenario.drive)).peak_a:
        return "it begins so fast that the current through the diodes alone exceeds the limit of OVC-1"
    if current > 0.0 and scenario.turns_before:
        return "in the turns before it the controller holds off a current of the diodes, which flows when it begins"
    return None


def _unfair_position(scenario: Scenario) -> str | None:
    """State why the sensor of the shaft shows too little of it, or what is too wrong."""
    if _shows_a_failure(scenario):
        return "its false edges are so many of an encoder's speed window that they look like a failure of the encoder"
    greatest_deg = GREATEST_ANGLE_DEG["exact"]
    if greatest_angle_error(scenario) > math.radians(greatest_deg):
        return (
            f"its position is more than {greatest_deg:g} electrical degrees off, which costs too much torque"
        )
    by_hall = scenario.drive.position == "hall"
    is_torque = isinstance(scenario.load, DynamometerLoad)
    if by_hall and is_torque and any(speed == 0.0 for _, speed in scenario.speed_rpm):
        return "Hall switches show the angle of a shaft at rest no closer than 30 electrical degrees"
    if by_hall and is_slow(scenario):
        return "below 10 % of base speed the edges of Hall switches come too rarely to regulate the speed by them"
    return None


def _unfair_load(scenario: Scenario) -> str | None:
    """State why no torque within the limits bears the load of a scenario."""
    weakens = duty_document(scenario.drive).weakens
    if isinstance(scenario.load, LockedLoad) and weakens:
        return None
    if _stops_at_low_speed(scenario):
        return "at so low a speed its load stops the shaft before a regulator of the speed can act"
    if _stops_within_a_sector(scenario):
        return "a load stops the shaft before the next edge of its Hall switches can show it"
    # No controller turns a shaft that is stalled at first, or overloaded at last.
    turning = duty_dwells(scenario)[1 if is_stalled(scenario) else 0 :]
    _, overloaded = overloaded_s(scenario)
    if not all(_is_driven(scenario, dwell) for dwell in turning if dwell.start < overloaded):
        unweakened = "" if weakens else " without field weakening"
        return f"at one of its operating points no currents within the limits give the torque{unweakened}"
    if runs_away(scenario):
        return "its load drives the shaft above overspeed before a torque can rise against it"
    if is_too_late(scenario):
        return "the torque that the limits leave brings its shaft to a reference too late to settle there"
    return None


def _is_beyond_overspeed(scenario: Scenario) -> bool:
    speeds = (scenario.initial_speed_rpm, *(speed for _, speed in scenario.speed_rpm))
    return max(map(abs, speeds)) > scenario.drive.rating.overspeed_rpm


def _shows_a_failure(scenario: Scenario) -> bool:
    """Return True if false edges are a great part of those that show the speed."""
    sensors = scenario.sensors if isinstance(scenario.sensors, ShuntSensors) else SHUNTS
    slowest = min(abs(speed) for _, speed in scenario.speed_rpm)
    edges = EDGES_A_LINE * sensors.encoder_lines * slowest / 60.0 * sensors.speed_window_s
    return any(abs(glitch.counts) > FALSE_SHARE * edges for glitch in scenario.glitches)


def _stops_at_low_speed(scenario: Scenario) -> bool:
    """Return True if a load at low speed is more than its share of what may be drawn at the end of that range."""
    load, drive = scenario.load, scenario.drive
    # Without a sensor, loads at low speed have a rule of their own.
    if isinstance(load, (LockedLoad, DynamometerLoad, VehicleLoad)) or drive.position == "none":
        return False
    end = TURNING_SHARE * drive.rating.base_speed_rpm
    return any(
        0.0 < abs(dwell.speed_rpm) < end
        and abs(load.torque_at(dwell.speed_rpm, dwell.load_factor))
        + friction_since(scenario.scales, dwell.scales)
        > slow_load_share(dwell.speed_rpm, drive) * rated_torque_at(drive, end) * (1.0 + _ROUNDING)
        for dwell in duty_dwells(scenario)
    )


def _stops_within_a_sector(scenario: Scenario) -> bool:
    """Return True if a load that begins or rises takes all energy of a shaft in one sector of its Hall switches."""
    load = scenario.load
    if isinstance(load, (LockedLoad, DynamometerLoad)) or scenario.drive.position != "hall":
        return False
    machine, inertia = duty_document(scenario.drive).machine, shaft_inertia(scenario, scenario.scales)
    before, time, speed_rpm = 0.0, 0.0, scenario.initial_speed_rpm
    for dwell in duty_dwells(scenario):
        torque = load.torque_at(speed_rpm, dwell.load_factor) + friction_since(scenario.scales, dwell.scales)
        speed = speed_rpm * RADIANS_PER_RPM
        energy = 0.5 * inertia * speed * speed
        if dwell.start == time and 0.0 < energy < (torque - before) * SECTOR / machine.pole_pairs:
            return True
        before, time, speed_rpm = torque, dwell.end, dwell.speed_rpm
    return False


def _is_driven(scenario: Scenario, dwell: Dwell) -> bool:
    """Return True if the torque of a load, or of a torque reference, has to be reached."""
    load = scenario.load
    speed = abs(dwell.speed_rpm) * RADIANS_PER_RPM
    document = duty_document(scenario.drive)
    plant = document.plant(dwell.scales)
    if isinstance(load, LockedLoad):
        demanded = abs(dwell.torque_reference_nm or 0.0)
    else:
        idle = dwell.load_factor == 0.0 == dwell.speed_rpm
        demanded = 0.0 if idle else load.torque_at(dwell.speed_rpm, dwell.load_factor)
        demanded += friction_torque(plant, speed)
    if plant.dc_link.capacitance > 0.0 and _brakes(scenario, dwell):
        # The source may take nothing back.
        most = greatest_braking(plant, speed, 2.0 * dwell.supply_v, document.weakens)
        return abs(demanded) <= BRAKING_SHARE * most
    # A weight that drives the shaft has to be braked: within the same currents, and with less voltage.
    return abs(demanded) <= required_torque(document, plant, speed, 2.0 * dwell.supply_v)


def _brakes(scenario: Scenario, dwell: Dwell) -> bool:
    """Return True if the torque that a dwell demands is against the rotation."""
    if isinstance(scenario.load, LockedLoad):
        return (dwell.torque_reference_nm or 0.0) * dwell.speed_rpm < 0.0
    return load_on_shaft(scenario, dwell, 0.0) * dwell.speed_rpm > 0.0


def required_torque(document: PmAcDocument, plant: PmAcDrive, speed: float, link: float) -> float:
    """Return the greatest torque that any controller has to reach at a speed (rad/s) and a link voltage (V), in N·m.

    It is below every load where the limits leave none.
    """
    limits, weakens = limits_of(document), document.weakens
    return min(
        IN_HAND * greatest_torque(plant, speed, link, weakens),
        limits.weakening * greatest_torque(plant, speed, limits.weakening_voltage * link, weakens),
    )


def _rectified_current(scenario: Scenario) -> float:
    """Return the greatest phase current with which a scenario begins, while all legs are off (A)."""
    is_held = isinstance(scenario.load, LockedLoad)
    speed_rpm = value_from(scenario.speed_rpm, 0.0) if is_held else scenario.initial_speed_rpm
    begin = dwell_of(
        scenario, {name: value_from(points, 0.0) for name, points in profiles_of(scenario).items()}
    )
    plant, speed = duty_document(scenario.drive).plant(begin.scales), speed_rpm * RADIANS_PER_RPM
    return _settled_peak(plant, speed, 2.0 * begin.supply_v, scenario.control_period_s)


@lru_cache(maxsize=_KEPT)
def _settled_peak(plant: PmAcDrive, speed: float, link: float, period: float) -> float:
    totals = np.zeros(ledger.ENTRIES)
    legs_off = np.zeros(3), np.full(3, LEG_OFF, np.int64)
    settle_rectifying(plant, make_phases(), 0.0, speed, link, (1.0, 1.0), period, *legs_off, totals)
    return float(totals[ledger.PEAK])
