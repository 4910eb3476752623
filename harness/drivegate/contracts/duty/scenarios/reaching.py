"""Whether the torque of a drive brings its shaft to the reference of the speed in time, and bears its load."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from math import copysign, isfinite
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.windows import (
    WINDOW_SHARE,
    duty_dwells,
    duty_windows,
    settling_s,
    shaft_inertia,
)
from drivegate.scenarios.rotation import sense_of
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.greatest_torque import braking_within, greatest_within
from drivegate_cases.scenario.load import HoistLoad, LockedLoad, SwitchedLoad, VehicleLoad
from drivegate_cases.scenario.profile import Dwell
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.machine.friction import friction_torque
from drivegate_models.pm_ac.oracle import undistorted_limits
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.units import RADIANS_PER_RPM

REACTION_SHARE: Final = 0.05
"""Time of reaction (the inverse of its bandwidth) of the slowest regulator that settles, over the settling time: its
integral is slower than its gain, and both have to be over (1)."""
REMAINING_SHARE: Final = 0.5
"""Part of the settling time that has to be left when the shaft reaches its reference (1)."""
BRAKING_SHARE: Final = 0.8
"""Share of the greatest braking torque that a controller has to reach on a link that is not ideal (1)."""
_CELLS: Final = 24
_SPEEDS: Final = 33
_KEPT: Final = 20_000


def is_too_late(scenario: Scenario) -> bool:
    """Return True if the torque that a controller has to reach brings the shaft too late to a reference that is judged.

    The shaft begins where the run begins it, and at each change where the one before has brought it. A load that comes
    on or goes moves it until a regulator bears it.
    """
    if isinstance(scenario.load, LockedLoad):
        return False
    drive = duty_document(scenario.drive)
    settling = settling_s(drive, held=False)
    judged = {dwell.start for dwell, _, _ in duty_windows(scenario)}
    for dwell, _, pushed in _changes(scenario, reaction_s(drive) / drive.machine.inertia_kg_m2):
        if dwell.start not in judged:
            continue
        left = dwell.duration - (WINDOW_SHARE + REMAINING_SHARE) * settling
        if _speed_after(scenario, dwell, pushed, left) != dwell.speed_rpm * RADIANS_PER_RPM:
            return True
    return False


def runs_away(scenario: Scenario) -> bool:
    """Return True if a change of the load drives the shaft above overspeed while the torque of a good drive rises."""
    if isinstance(scenario.load, LockedLoad):
        return False
    drive = duty_document(scenario.drive)
    rise = drive.requirements.rise_periods * drive.control_period_s
    overspeed = drive.rating.overspeed_rpm * RADIANS_PER_RPM
    changes = _changes(scenario, rise / drive.machine.inertia_kg_m2)
    return any(abs(pushed) > max(overspeed, abs(speed)) for _, speed, pushed in changes)


def _changes(scenario: Scenario, moved: float) -> Iterator[tuple[Dwell, float, float]]:
    """Follow the shaft from change to change: the stretch, and the speeds before and after its load moves it (rad/s).

    `moved` is the change of speed for each torque (rad/s/(N·m)) until a regulator bears what the load has changed by.
    """
    speed, borne = scenario.initial_speed_rpm * RADIANS_PER_RPM, 0.0
    for dwell in duty_dwells(scenario):
        acting = load_on_shaft(scenario, dwell, speed)
        pushed = _moved(scenario, speed, (acting - borne) * moved)
        yield dwell, speed, pushed
        speed = _speed_after(scenario, dwell, pushed, dwell.duration)
        borne = load_on_shaft(scenario, dwell, speed)


def reaction_s(drive: PmAcDocument) -> float:
    """Return the time in which the slowest regulator that settles bears a load that comes on (s)."""
    return REACTION_SHARE * settling_s(drive, held=False)


def load_on_shaft(scenario: Scenario, dwell: Dwell, speed: float) -> float:
    """Return the torque of load and friction on the shaft at a speed (rad/s), positive forward (N·m).

    All but a hoist oppose the rotation. Of a shaft at rest they oppose the one that it is about to begin.
    """
    load = scenario.load
    assert not isinstance(load, LockedLoad), "a shaft that is held has no load"
    turning = speed or dwell.speed_rpm * RADIANS_PER_RPM
    if turning == 0.0 and not isinstance(load, HoistLoad):
        return 0.0
    return _torque_against(load, dwell, duty_document(scenario.drive).plant(dwell.scales), turning)


def _torque_against(
    load: SwitchedLoad | VehicleLoad, dwell: Dwell, plant: PmAcDrive, turning: float
) -> float:
    """Return the torque of load and friction on a shaft that turns at a speed (rad/s), positive forward (N·m)."""
    against = load.torque_at(turning / RADIANS_PER_RPM, dwell.load_factor)
    return -sense_of(turning) * (against + float(friction_torque(plant, abs(turning))))


@lru_cache(maxsize=_KEPT)
def greatest_torque(plant: PmAcDrive, speed: float, link: float, weakens: bool) -> float:
    """Find the greatest torque at a speed (rad/s) and a link (V), in N·m; below every load where there is none."""
    torque = greatest_within(plant, undistorted_limits(plant, link), speed, weakens=weakens).torque
    return torque if isfinite(torque) else -1.0


@lru_cache(maxsize=_KEPT)
def greatest_braking(plant: PmAcDrive, speed: float, link: float, weakens: bool) -> float:
    """Find the greatest torque against the rotation at a speed (rad/s) and a source (V), in N·m, as above."""
    torque = braking_within(plant, undistorted_limits(plant, link), speed, weakens=weakens).torque
    return -torque if isfinite(torque) else -1.0


def _moved(scenario: Scenario, speed: float, change: float) -> float:
    """Return a speed after a change (rad/s); only a hoist turns the shaft the other way."""
    moved = speed + change
    return 0.0 if moved * speed <= 0.0 and not isinstance(scenario.load, HoistLoad) else moved


def _speed_after(scenario: Scenario, dwell: Dwell, speed: float, time: float) -> float:
    """Return the speed (rad/s) that the shaft has after a time (s): the reference, if it gets there."""
    reference = dwell.speed_rpm * RADIANS_PER_RPM
    step = (reference - speed) / _CELLS
    if step == 0.0:
        return reference
    load, document = scenario.load, duty_document(scenario.drive)
    assert not isinstance(load, LockedLoad), "a shaft that is held has no load"
    inertia, plant = shaft_inertia(scenario, dwell.scales), document.plant(dwell.scales)
    speeds, driving, braking = _required_torques(document, plant, 2.0 * dwell.supply_v)
    for cell in range(_CELLS):
        middle = speed + (cell + 0.5) * step
        torque = float(np.interp(abs(middle), speeds, braking if middle * step < 0.0 else driving))
        # A cell whose middle is at rest lies on the way to the reference.
        loaded = _torque_against(load, dwell, plant, middle or reference)
        accelerating = torque + copysign(1.0, step) * loaded
        if accelerating <= 0.0:
            return speed + cell * step
        time -= inertia * abs(step) / accelerating
        if time < 0.0:
            return middle
    return reference


@lru_cache(maxsize=_KEPT)
def _required_torques(
    document: PmAcDocument, plant: PmAcDrive, link: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return speeds (rad/s) up to overspeed, and the torques that any controller has to reach at each (N·m).

    They are the torques with the rotation and against it.
    """
    limits, weakens = limits_of(document), document.weakens
    speeds = np.linspace(0.0, document.rating.overspeed_rpm * RADIANS_PER_RPM, _SPEEDS)
    voltage = limits.weakening_voltage * link
    driving = [greatest_torque(plant, float(speed), voltage, weakens) for speed in speeds]
    driven = limits.weakening * np.maximum(np.array(driving), 0.0)
    if plant.dc_link.capacitance == 0.0:
        return speeds, driven, driven
    braking = [greatest_braking(plant, float(speed), voltage, weakens) for speed in speeds]
    return speeds, driven, BRAKING_SHARE * np.maximum(np.array(braking), 0.0)
