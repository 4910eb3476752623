"""How far a position sensor with errors is off, and what torque that costs at the least."""

from __future__ import annotations

import math
from typing import Final

from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import ShuntSensors
from drivegate_models.units import RADIANS_PER_RPM

GREATEST_ANGLE_DEG: Final = 12.0
"""Error of the angle up to which anybody is judged (electrical degrees)."""


def greatest_angle_error(scenario: Scenario) -> float:
    """Return a bound of the error of the shown angle (electrical rad), 0 for a sensor without such errors."""
    given = scenario.sensors
    if not isinstance(given, ShuntSensors):
        return 0.0
    shaft = (
        math.radians(given.eccentricity_deg)
        + math.hypot(given.sine_offset, given.cosine_offset)
        + 0.5 * abs(given.track_gain)
        + math.radians(abs(given.track_phase_deg))
    )
    fastest = max(abs(speed) for _, speed in scenario.speed_rpm) * RADIANS_PER_RPM
    return scenario.drive.machine.pole_pairs * (shaft + fastest * given.latency_s)


def lost_torque_share(scenario: Scenario) -> float:
    """Return the share of a torque that an angle's error costs on a machine of any saliency (1).

    The mean of a torque of least current falls by 1 - J0(A) for its part by the magnet, and by 1 - J0(2 A) for that by
    the saliency, with the Bessel function J0 and the amplitude A of the angle's error. Its series is cut where it
    alternates, so that the share is not too small.
    """
    angle = greatest_angle_error(scenario)
    return angle * angle
