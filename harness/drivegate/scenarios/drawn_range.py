"""The range that scenarios are drawn from, which no simplification leaves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final, NamedTuple

from drivegate.scenarios.drive_scale import rated_torque_at
from drivegate_cases.drive.plant import NOMINAL
from drivegate_cases.scenario.courses import DISTURBANCES
from drivegate_cases.scenario.load import DynamometerLoad, LockedLoad
from drivegate_cases.scenario.piecewise import breakpoints, value_from, value_until
from drivegate_cases.scenario.scenario import Scenario

LIGHTEST_SHARE: Final = 0.1
"""Lightest load that is drawn, over rated torque at its speed (1)."""
_ROUNDING: Final = 0.005
"""What torques that people can read are rounded by, over themselves (1)."""


class Interval(NamedTuple):
    least: float
    greatest: float

    def extended(self, values: list[float]) -> Interval:
        """Return the interval from here to the farthest of some values."""
        return Interval(min([self.least, *values]), max([self.greatest, *values]))

    def contains(self, values: list[float]) -> bool:
        least, greatest = (1.0 - _ROUNDING) * self.least, (1.0 + _ROUNDING) * self.greatest
        return all(least <= value <= greatest for value in values)


NONE: Final = Interval(0.0, 0.0)
"""No torque at all."""


@dataclass(frozen=True)
class DrawnRange:
    """The speeds and torques that runs of one kind are drawn from."""

    loaded_rpm: Interval
    idle_rpm: Interval
    """Speeds with and without a torque (rpm)."""
    driving_share: Interval
    braking_share: Interval
    """Torques with and against the rotation, over rated torque at their speed (1); 0 counts as neither."""

    def covers(self, simpler: Scenario, start: Scenario) -> bool:
        """Return True if a simpler scenario goes no further than the range, or than simplification started from.

        Disturbances are drawn on either side of nominal, so that each has to stay as near to it as it was.
        """
        old, new = _demands(start), _demands(simpler)
        drawn = (self.loaded_rpm, self.idle_rpm, self.driving_share, self.braking_share)
        in_range = all(
            interval.extended(before).contains(after)
            for interval, before, after in zip(drawn, old, new, strict=True)
        )
        known = _deviations(start)
        return in_range and all(
            size <= (1.0 + _ROUNDING) * known[key] for key, size in _deviations(simpler).items()
        )


def _demands(scenario: Scenario) -> tuple[list[float], list[float], list[float], list[float]]:
    """List loaded and idle speeds (rpm), and driving and braking torques (1), at every corner of the profiles.

    Speeds count without their sign: what may be drawn forward may be drawn backward too.
    """
    drive = scenario.drive
    corners = [(abs(speed), torque / rated_torque_at(drive, speed)) for speed, torque in _corners(scenario)]
    return (
        [speed for speed, share in corners if share != 0.0],
        [speed for speed, share in corners if share == 0.0],
        [share for _, share in corners if share > 0.0],
        [-share for _, share in corners if share < 0.0],
    )


def _corners(scenario: Scenario) -> Iterator[tuple[float, float]]:
    """Find speed (rpm), and torque in its sense (N·m), at every corner of their profiles."""
    load = scenario.load
    profiles = (scenario.speed_rpm, scenario.load_profile, scenario.torque_reference_profile)
    for time in breakpoints(profiles, scenario.duration_s):
        for value_at in (value_until, value_from):
            speed, share, reference = (value_at(profile, time) for profile in profiles)
            if isinstance(load, DynamometerLoad):
                yield speed, reference if speed >= 0.0 else -reference
            elif isinstance(load, LockedLoad) or speed == share == 0.0:
                yield speed, 0.0
            else:
                yield speed, load.torque_at(speed, share)


def _deviations(scenario: Scenario) -> Mapping[str, float]:
    """Measure how far each quantity is from nominal at most, over the nominal value unless that is 0."""
    scales, deviations = scenario.scales, {}
    for quantity in DISTURBANCES:
        nominal = quantity.nominal_in(scenario.drive)
        farthest = max(abs(value - nominal) for _, value in quantity.profile(scenario))
        deviations[quantity.name] = farthest / (nominal or 1.0)
    return {
        **deviations,
        **{f"scales.{key}": abs(getattr(scales, key) - value) for key, value in NOMINAL},
        "gain": max((abs(error.gain - 1.0) for error in scenario.current_errors), default=0.0),
        "offset": max((abs(error.offset_a) for error in scenario.current_errors), default=0.0),
        "dropout": max((dropout.duration_s for dropout in scenario.dropouts), default=0.0),
        "glitch": max((abs(glitch.counts) for glitch in scenario.glitches), default=0),
    }
