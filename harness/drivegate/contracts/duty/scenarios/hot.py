"""Runs with windings that are hot at first, of drives whose controllers see their temperature."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.building import (
    PERIODS_AT_A_TIME,
    TORQUE_DIGITS,
    share_scenario,
    start_s,
    torque_scenario,
)
from drivegate.contracts.duty.scenarios.drawn_range import speed_of
from drivegate.scenarios.drive_scale import tidy
from drivegate.scenarios.title import titled
from drivegate_cases.drive.limits import limits_of, rounded
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.thermal import PmAcThermal
from drivegate_cases.scenario.load import DynamometerLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.pm_ac.oracle import CURRENT, Limits, least_at, undistorted_limits
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.units import RADIANS_PER_RPM

COOL_SHARE: Final = 0.9
"""Rise of the temperature over the permitted one up to which the whole torque is required (1)."""
HOT_SHARE: Final = 0.98
"""Rise over the permitted one from which the current has to be that which the windings bear for good (1)."""
WARM_SHARE: Final = 0.75
"""Rise at the start of a run with warm windings, over the permitted one (1)."""
HEATED_SHARE: Final = 0.92
"""Least rise at the start of a run that heats the windings to their limit, over the permitted one (1)."""
HOLDING_SHARE: Final = 0.7
"""Greatest share of the continuous current that weakening alone may need (1)."""
APPROACH: Final = 1.5
"""Length of a run that heats the windings, over the time in which the whole current does (1)."""
SETTLED_S: Final = 2.0
"""Time of a run with heated windings beyond that (s)."""
LONGEST_S: Final = 20.0
"""Longest run that heats the windings (s)."""
_KEPT: Final = 1000


@dataclass(frozen=True)
class HotWindings:
    """What the windings of a drive bear for good."""

    thermal: PmAcThermal
    current: float
    """Continuous current: the peak of a phase that holds the windings at their limit (A)."""
    plant: PmAcDrive
    """The machine with windings at their limit, and the continuous current as its current limit."""
    rate: float
    """Rate at which the current limit heats windings at their limit (K/s)."""

    def temperature_c(self, share: float) -> float:
        """Return the temperature at a share of the permitted rise (degrees Celsius)."""
        return rounded(self.thermal.ambient_c + share * self.thermal.rise_k, 5)

    def holds(self, speed: float, link: float, share: float) -> bool:
        """Return True if a share of the current holds the voltage at a speed (rad/s) and a link voltage (V)."""
        limits = undistorted_limits(self.plant, link)
        held = least_at(self.plant, Limits(share * self.current, limits.voltage), abs(speed), 0.0, CURRENT)
        return not math.isnan(held.torque)


def sensed_windings(drive: PmAcDocument) -> HotWindings | None:
    """Return the windings of a drive whose controllers see their temperature."""
    thermal = drive.thermal
    return None if thermal is None or thermal.sensor_lag_s is None else hot_windings(drive)


@lru_cache(maxsize=_KEPT)
def hot_windings(drive: PmAcDocument) -> HotWindings | None:
    """Return the windings of a drive with thermal data."""
    thermal, resistance, limit = drive.thermal, drive.machine.resistance_ohm, drive.rating.current_limit_a
    if thermal is None:
        return None
    current = thermal.continuous_current(resistance)
    plant = drive.plant()._replace(
        resistance=thermal.resistance_at(thermal.limit_c, resistance), current_limit=min(current, limit)
    )
    return HotWindings(thermal, current, plant, thermal.heating_rate(limit, resistance))


def unfair_heat(scenario: Scenario) -> str | None:
    """State why a run with windings that may reach their limit cannot be judged."""
    drive = duty_document(scenario.drive)
    windings = hot_windings(drive)
    if windings is None:
        return None
    thermal = windings.thermal
    if scenario.winding_temperature_c is None:
        heating = thermal.heating_s(drive.rating.current_limit_a, drive.machine.resistance_ohm)
        if scenario.duration_s > COOL_SHARE * heating:
            return "it lasts so long that its load may heat the windings to their limit"
        return None
    if not isinstance(scenario.load, DynamometerLoad):
        return "a speed regulator may need more torque than hot windings bear"
    links = [2.0 * volts for _, volts in scenario.supply_profile]
    voltage = limits_of(drive).weakening_voltage * min(links)
    speeds = [speed * RADIANS_PER_RPM for _, speed in scenario.speed_rpm]
    if not all(windings.holds(speed, voltage, HOLDING_SHARE) for speed in speeds):
        return "at one of its speeds weakening alone needs most of the current that hot windings bear"
    return None


def hot_speeds(drive: PmAcDocument) -> tuple[float, ...]:
    """Return half of base speed, and the highest of some speeds at which hot windings bear the weakening (rpm)."""
    windings = sensed_windings(drive)
    if windings is None:
        return ()
    voltage = limits_of(drive).weakening_voltage * drive.inverter.link_voltage_v
    places = (1.0, 0.75, 0.5, 0.25) if drive.weakens else ()
    fast = (speed_of(drive, place) for place in places)
    held = (speed for speed in fast if windings.holds(speed * RADIANS_PER_RPM, voltage, HOLDING_SHARE))
    return (speed_of(drive, -0.5), *tuple(held)[:1])


def peak_torque(drive: PmAcDocument) -> float:
    """Return the torque of the current limit (N·m)."""
    return rounded(drive.torque_of_current(drive.rating.current_limit_a), TORQUE_DIGITS)


def hot_run(run: Scenario, share: float) -> Scenario:
    """Begin a run at a share of the permitted rise of the temperature."""
    windings = hot_windings(duty_document(run.drive))
    assert windings is not None, "a drive with thermal data"
    return titled(run.replaced(winding_temperature_c=windings.temperature_c(share)))


def hot_scenarios(drive: PmAcDocument) -> list[Scenario]:
    """Make the fixed runs: warm windings, hot ones at low and high speed, and windings that are heated to the limit."""
    windings = sensed_windings(drive)
    if windings is None or windings.current >= drive.rating.current_limit_a:
        return []
    speeds, peak = hot_speeds(drive), peak_torque(drive)
    return [
        hot_run(share_scenario(drive, speeds[0], 0.0, 0.9), WARM_SHARE),
        *(hot_run(torque_scenario(drive, speed, (peak,)), 1.0) for speed in speeds),
        *_heated(drive, windings, speeds[0], peak),
    ]


def _heated(drive: PmAcDocument, windings: HotWindings, speed_rpm: float, torque_nm: float) -> list[Scenario]:
    """Make the run in which the peak torque heats the windings to their limit, unless that takes too long.

    Windings that get hot slowly begin nearer to it.
    """
    per_second = windings.rate / windings.thermal.rise_k
    begin = max(HEATED_SHARE, 1.0 - (LONGEST_S - SETTLED_S) / APPROACH * per_second)
    lasting = APPROACH * (1.0 - begin) / per_second + SETTLED_S
    if begin + lasting * per_second <= limits_of(drive).temperature_rise:
        # Not even a controller that derates nothing would exceed the limit.
        return []
    periods = PERIODS_AT_A_TIME * math.ceil(round(lasting / (PERIODS_AT_A_TIME * drive.control_period_s), 6))
    run = torque_scenario(drive, speed_rpm, (tidy(torque_nm),))
    return [hot_run(run.replaced(duration_s=start_s(drive, periods)), begin)]
