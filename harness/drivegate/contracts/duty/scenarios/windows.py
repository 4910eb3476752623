"""The stretches of a run in which a steady state of a controller of duty ratios is judged."""

from __future__ import annotations

from typing import Final

from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.overload import overloaded_s
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.plant import Scales
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.control_periods import first_period_from
from drivegate_cases.scenario.load import DynamometerLoad, VehicleLoad
from drivegate_cases.scenario.profile import Dwell, dwells, released_s
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.units import RADIANS_PER_RPM

WINDOW_SHARE: Final = 0.25
"""Length of the judged stretch at the end of a dwell, over the settling time (1)."""
RUN_UP_SHARE: Final = 2.0
"""Time for a change of the speed over that which rated torque takes, load and weakening included (1)."""


def duty_dwells(scenario: Scenario) -> tuple[Dwell, ...]:
    """Find the stretches of a scenario in which references, load, supply and plant are all constant.

    Single samples are lost in them, behind which a controller has to settle again.
    """
    return dwells(scenario, seen_throughout=True)


def settling_s(drive: PmAcDocument, *, held: bool) -> float:
    """Return the time in which a speed settles, or on a held shaft a torque (s)."""
    limits = limits_of(drive)
    return float(limits.held_settling_s if held else limits.settling_s)


def is_held(scenario: Scenario) -> bool:
    """Return True if a dynamometer holds the shaft while the controller follows a torque."""
    return isinstance(scenario.load, DynamometerLoad)


def shaft_inertia(scenario: Scenario, scales: Scales) -> float:
    """Return the inertia that the machine turns, with that of a vehicle, at some deviations of the plant (kg·m²)."""
    vehicle = scenario.load.inertia_kg_m2 if isinstance(scenario.load, VehicleLoad) else 0.0
    return duty_document(scenario.drive).machine.inertia_kg_m2 * scales.inertia + vehicle


def run_up_s(drive: PmAcDocument, speed_change_rpm: float, inertia_factor: float = 1.0) -> float:
    """Return the time in which a free shaft is to have changed its speed (s)."""
    torque = drive.rating.rated_power_w / (drive.rating.highest_speed_rpm * RADIANS_PER_RPM)
    return (
        RUN_UP_SHARE
        * drive.machine.inertia_kg_m2
        * inertia_factor
        * abs(speed_change_rpm)
        * RADIANS_PER_RPM
        / torque
    )


def duty_windows(scenario: Scenario) -> list[tuple[Dwell, float, float]]:
    """Find the end of every dwell that is long enough to settle in, with its start and end (s).

    Where a dwell is too short for the shaft to reach its reference, the next one has to make the rest of the way.
    """
    drive, held = duty_document(scenario.drive), is_held(scenario)
    settling, period = settling_s(drive, held=held), drive.control_period_s
    length = WINDOW_SHARE * settling
    windows = []
    speed = scenario.initial_speed_rpm
    released, (_, overloaded) = released_s(scenario), overloaded_s(scenario)
    for dwell in duty_dwells(scenario):
        if (released is not None and dwell.start >= released) or dwell.start >= overloaded:
            break
        change = 0.0 if held else dwell.speed_rpm - speed
        run_up = run_up_s(drive, change, shaft_inertia(scenario, dwell.scales) / drive.machine.inertia_kg_m2)
        needed = first_period_from(settling + length + run_up, period)
        speed += change if run_up <= dwell.duration else change * dwell.duration / run_up
        if round(dwell.end / period) - round(dwell.start / period) >= needed:
            windows.append((dwell, dwell.end - length, dwell.end))
    return windows


def released_windows(scenario: Scenario) -> list[tuple[Dwell, float, float]]:
    """Find the second half of every stretch in which a shaft turns freely under one torque reference."""
    released = released_s(scenario)
    later = [dwell for dwell in duty_dwells(scenario) if released is not None and dwell.start >= released]
    return [(dwell, 0.5 * (dwell.start + dwell.end), dwell.end) for dwell in later]
