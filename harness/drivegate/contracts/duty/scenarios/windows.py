"""The stretches of a run in which a steady state of a controller of duty ratios is judged."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

from drivegate.contracts.duty.document import duty_document
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.control_periods import first_period_from
from drivegate_cases.scenario.load import DynamometerLoad
from drivegate_cases.scenario.piecewise import breakpoints, value_from, value_until
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.units import RADIANS_PER_RPM

WINDOW_SHARE: Final = 0.25
"""Length of the judged stretch at the end of a dwell, over the settling time (1)."""
RUN_UP_SHARE: Final = 2.0
"""Time for a change of the speed over that which rated torque takes, load and weakening included (1)."""


@dataclass(frozen=True)
class DutyDwell:
    """A stretch in which nothing outside of the controller changes."""

    start: float
    end: float
    """Time at which it begins and ends (s)."""
    speed_rpm: float
    """Speed reference, or the speed that the shaft is held at (rpm)."""
    torque_reference_nm: float | None
    """Torque reference (N·m); None where the reference is the speed."""
    load_factor: float
    """Share of the load."""
    supply_v: float
    """Half of the link's voltage (V)."""
    resistance_factor: float
    emf_factor: float
    inertia_factor: float
    """Drift of the plant's parameters (1)."""


def duty_dwells(scenario: Scenario) -> tuple[DutyDwell, ...]:
    """Find the stretches of a scenario in which references, load, supply and plant are all constant."""
    profiles = (
        scenario.speed_rpm,
        scenario.torque_reference_profile,
        scenario.load_profile,
        scenario.supply_profile,
        scenario.resistance_profile,
        scenario.emf_profile,
        scenario.inertia_profile,
    )
    torque_is_reference = isinstance(scenario.load, DynamometerLoad)
    events_s = _events_s(scenario)
    found: list[tuple[float, float, list[float]]] = []
    for start, end in pairwise(
        breakpoints((*profiles, tuple((time, 0.0) for time in events_s)), scenario.duration_s)
    ):
        constant = [value_from(points, start) for points in profiles]
        if constant != [value_until(points, end) for points in profiles]:
            continue
        if found and found[-1][1:] == (start, constant) and start not in events_s:
            found[-1] = (found[-1][0], end, constant)
        else:
            found.append((start, end, constant))
    return tuple(
        DutyDwell(start, end, speed, torque if torque_is_reference else None, *others)
        for start, end, (speed, torque, *others) in found
    )


def _events_s(scenario: Scenario) -> frozenset[float]:
    """List the times from which on a controller has to settle again: restarts, and the end of what is lost (s)."""
    ends = [lost.end_s for lost in scenario.dropouts] + [glitch.time_s for glitch in scenario.glitches]
    return frozenset((*scenario.restarts_s, *ends))


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


def duty_windows(scenario: Scenario) -> list[tuple[DutyDwell, float, float]]:
    """Find the end of every dwell that is long enough to settle in, with its start and end (s)."""
    drive = duty_document(scenario.drive)
    settling, period = limits_of(drive).settling_s, drive.control_period_s
    length = WINDOW_SHARE * settling
    windows = []
    before = scenario.initial_speed_rpm
    for dwell in duty_dwells(scenario):
        change = 0.0 if dwell.torque_reference_nm is not None else dwell.speed_rpm - before
        needed = first_period_from(
            settling + length + run_up_s(drive, change, scenario.scales.inertia * dwell.inertia_factor),
            period,
        )
        before = dwell.speed_rpm
        if round(dwell.end / period) - round(dwell.start / period) >= needed:
            windows.append((dwell, dwell.end - length, dwell.end))
    return windows
