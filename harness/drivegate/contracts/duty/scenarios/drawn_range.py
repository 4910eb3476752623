"""The range that scenarios of a PM AC drive are drawn from, also that of failures and of position errors."""

from __future__ import annotations

import math
from typing import Final

from drivegate.scenarios.drawn_range import NONE, DrawnRange, Interval
from drivegate.scenarios.drive_scale import rated_torque_at, tidy
from drivegate.scenarios.rotation import sense_of
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import nearest_step
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.drive.pm_ac.limits import FAILURE_SPEED_SHARE, hides_position
from drivegate_cases.scenario.load import DynamometerLoad, HoistLoad, LockedLoad
from drivegate_cases.scenario.piecewise import value_from
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import ShuntSensors, has_encoder
from drivegate_models.units import RADIANS_PER_RPM

FAILURE_TORQUE_SHARE: Final = 0.3
"""Least torque under which something fails, over rated torque: without a current no phase or sensor is missed (1)."""
_SPEED_ROUNDING: Final = 0.01
"""What speeds and torques that people can read are rounded by, over base speed and rated torque (1)."""
SHARE_STEP: Final = 0.05
"""Step of drawn torques and loads over rated torque, and the least of them (1)."""
TURNING_SHARE: Final = 0.1
"""Least speed reference over base speed (1)."""
HEAVIEST_SHARE: Final = 0.85
"""Heaviest load of a speed reference over rated torque (1)."""
HEAVIEST_FAILURE_SHARE: Final = 0.6
"""Greatest torque under which something fails, over rated torque (1)."""
BRAKING_SHARE: Final = 1.0
"""Greatest torque reference against the rotation, over rated torque (1)."""
SLOW_SHARE: Final = 0.01
"""Least speed reference of a run at low speed over base speed (1); it ends at `TURNING_SHARE`."""
SLOW_LOAD_SHARE: Final = 0.2
"""Heaviest load at the end of low speeds over rated torque, and less in proportion to the speed below it (1): more
stops the shaft before a regulator of its speed can act."""
BEYOND_SHARE: Final = 3.0
"""Torque reference that no drive of this kind can follow in weakening, over the one of rated power there (1)."""


def speed_of(drive: PmAcDocument, share: float) -> float:
    """Return a speed between base speed (0) and the highest (1), or below (negative: -1 is standstill) (rpm)."""
    rating = drive.rating
    base, highest = rating.base_speed_rpm, rating.highest_speed_rpm
    speed = base + share * (highest - base if share >= 0.0 else base)
    grain = nearest_step(0.01 * base)
    return min(tidy(round(speed / grain) * grain), highest)


def unnoticed_because(scenario: Scenario) -> str | None:
    """Return why nobody is judged on what a controller does after the failure in a scenario, if there is one."""
    failure, drive = scenario.failure, scenario.drive
    if failure is None or not isinstance(drive, PmAcDocument):
        return None
    base = drive.rating.base_speed_rpm
    # On a change of the reference the shaft is still at the speed before it.
    reference = abs(value_from(scenario.speed_rpm, failure.time_s))
    turning = reference if failure.time_s > 0.0 else abs(scenario.initial_speed_rpm)
    locks = failure.kind == "locked-rotor"
    if locks and isinstance(scenario.load, DynamometerLoad):
        return (
            "its shaft locks under a torque reference, which no answer can keep as the EMF vanishes at once"
        )
    # A shaft that locks shows it by its sudden stop, or by not starting.
    speed = max(turning, reference) if locks else min(turning, reference)
    if speed < (FAILURE_SPEED_SHARE - _SPEED_ROUNDING) * base:
        return f"something fails below {100.0 * FAILURE_SPEED_SHARE:g} % of base speed, where it takes too long to show"
    if max(turning, *(abs(speed) for _, speed in scenario.speed_rpm)) > (1.0 + _SPEED_ROUNDING) * base:
        return (
            "something fails above base speed, where legs that are off rectify and may not be the safe state"
        )
    least = (FAILURE_TORQUE_SHARE - _SPEED_ROUNDING) * rated_torque_at(drive, speed)
    if not locks and abs(_torque(scenario)) < least:
        return (
            f"something fails below {100.0 * FAILURE_TORQUE_SHARE:g} % of rated torque, where it may not show"
        )
    stops = failure.kind == "lost-position" and has_encoder(scenario.sensors, drive)
    if stops and hides_position(drive, speed, abs(_torque(scenario))):
        return "its encoder stops where the EMF is less than what resistance and link leave uncertain"
    return None


def _torque(scenario: Scenario) -> float:
    """Return the torque that is asked for, or that the load demands, as something fails (N·m)."""
    load, failure = scenario.load, scenario.failure
    assert failure is not None, "something fails in such a scenario"
    if isinstance(load, DynamometerLoad):
        return value_from(load.torque_reference_nm, failure.time_s)
    if isinstance(load, LockedLoad):
        return 0.0
    share = value_from(scenario.load_profile, failure.time_s)
    return load.torque_at(value_from(scenario.speed_rpm, failure.time_s), share)


def greatest_angle_error(scenario: Scenario) -> float:
    """Return a bound of the error of the shown angle (electrical rad), 0 for a sensor without such errors."""
    given = scenario.sensors
    if not isinstance(given, ShuntSensors):
        return 0.0
    parts = math.hypot(given.sine_offset, given.cosine_offset) + math.radians(abs(given.track_phase_deg))
    half_gain = 0.5 * abs(given.track_gain)
    # The tracks' vector is off by no more than these parts over its mean length: the sine of the angle error, which is
    # below its tangent.
    sine = min((parts + half_gain) / (1.0 - half_gain), 1.0)
    tracks = min(sine / math.sqrt(1.0 - sine * sine), 0.5 * math.pi) if sine < 1.0 else 0.5 * math.pi
    shaft = math.radians(given.eccentricity_deg) + tracks
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


def drawn_range(scenario: Scenario) -> DrawnRange:
    """Return the range of the family that a scenario belongs to: of a failure, a disturbance, a torque, or a speed."""
    rating, sensors = scenario.drive.rating, scenario.sensors
    base, highest = rating.base_speed_rpm, rating.highest_speed_rpm
    if isinstance(sensors, ShuntSensors) and sensors.shunts == "low-side":
        # At full voltage such shunts see no two phases.
        highest = base
    if scenario.failure is not None:
        speeds = Interval(FAILURE_SPEED_SHARE * base, base)
        return DrawnRange(speeds, speeds, Interval(FAILURE_TORQUE_SHARE, HEAVIEST_FAILURE_SHARE), NONE)
    is_disturbed = scenario.restarts_s or scenario.dropouts or scenario.glitches or scenario.clock_start_s
    if is_disturbed or greatest_angle_error(scenario) > 0.0:
        speeds = Interval(TURNING_SHARE * base, base)
        return DrawnRange(speeds, speeds, Interval(SHARE_STEP, HEAVIEST_SHARE), NONE)
    if _brakes_beyond(scenario):
        speeds = Interval(highest, rating.overspeed_rpm)
        return DrawnRange(speeds, speeds, NONE, Interval(0.0, BRAKING_SHARE))
    if isinstance(scenario.load, DynamometerLoad):
        beyond = _is_beyond(scenario)
        speeds = Interval(base if beyond else 0.0, highest)
        driving = Interval(SHARE_STEP, BEYOND_SHARE if beyond else 1.0)
        return DrawnRange(speeds, speeds, driving, Interval(0.0, BRAKING_SHARE))
    starts = scenario.initial_speed_rpm == 0.0
    if is_slow(scenario):
        speeds = Interval(SLOW_SHARE * base, TURNING_SHARE * base)
        return DrawnRange(speeds, Interval(0.0, highest), Interval(0.0, SLOW_LOAD_SHARE), NONE)
    bounded = starts or isinstance(scenario.load, HoistLoad)
    speeds = Interval(TURNING_SHARE * base, base if bounded else highest)
    return DrawnRange(speeds, speeds, Interval(SHARE_STEP, HEAVIEST_SHARE), NONE)


def slow_load_share(speed_rpm: float, drive: DriveDocument) -> float:
    """Return the heaviest load at a low speed of either sign over rated torque (1)."""
    return SLOW_LOAD_SHARE * abs(speed_rpm) / (TURNING_SHARE * drive.rating.base_speed_rpm)


def is_slow(scenario: Scenario) -> bool:
    """Return True if a run of a speed reference ends below the least speed of the other families."""
    is_held = isinstance(scenario.load, (DynamometerLoad, LockedLoad))
    return (
        not is_held and abs(scenario.speed_rpm[-1][1]) < TURNING_SHARE * scenario.drive.rating.base_speed_rpm
    )


def _is_beyond(scenario: Scenario) -> bool:
    """Return True if a torque reference asks for more than rated power above base speed."""
    reference = scenario.speed_rpm[0][1]
    speed, sense = abs(reference), sense_of(reference)
    most = max(sense * torque for _, torque in scenario.torque_reference_profile)
    above = speed > scenario.drive.rating.base_speed_rpm
    return above and most > (1.0 + SHARE_STEP) * rated_torque_at(scenario.drive, speed)


def _brakes_beyond(scenario: Scenario) -> bool:
    """Return True if a torque reference above the highest speed brakes or is zero throughout."""
    if not isinstance(scenario.load, DynamometerLoad):
        return False
    speeds = [speed for _, speed in scenario.speed_rpm]
    above = min(map(abs, speeds)) > scenario.drive.rating.highest_speed_rpm
    return above and all(
        sense_of(speeds[0]) * torque <= 0.0 for _, torque in scenario.load.torque_reference_nm
    )
