"""The limits of a drive with what follows from its rating, and the times that it needs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from drivegate_cases.documents.wording import decimal_exponent, significant
from drivegate_cases.drive.document import DriveDocument
from drivegate_cases.drive.requirements import RequiredPoint
from drivegate_models.units import RADIANS_PER_RPM

POINT_POWER_SHARE: Final = 1.02625
"""Power at the required point over rated power, where none is stated: 9.8 N·m at 1500 rpm over 1.5 kW (1)."""
SPEED_TOLERANCE_SHARE: Final = 0.01
"""Speed tolerance k1 over base speed, where none is stated (1)."""
MECHANICAL_TIMES: Final = 11.0
"""Mechanical time constants in a unit of time (1)."""
ELECTRICAL_PERIODS: Final = 91.0
"""Electrical periods at base speed in a unit of time (1)."""
SHORTEST_TIME_UNIT_S: Final = 1.0
"""Whatever the drive, ten of the means over `MEAN_UNITS` by which convergence is judged, of 0.1 s and more (s)."""
MEAN_UNITS: Final = 0.1
"""Units of time over which the means of the current sum are taken: nine electrical periods, and a tenth more (1)."""
RIPPLE: Final = 0.13
"""Limit of the torque ripple of decoupled phases with the ideal regulator, where none is stated: the paper's (1)."""
CLOSED_LOOP_RIPPLE: Final = 0.20
"""The same with band and speed regulator, which add to it (1)."""
SETTLING_UNITS: Final = 6.0
"""Units of time in which a search has to converge, where no time is stated (1)."""
_KEPT: Final = 100
_STEPS: Final = ("1", "2", "5")
# Closer to each other: a search that has a third less time than it needs fails.
_STEPS_OF_TIME: Final = ("1", "1.5", "2", "3", "5", "7")


@dataclass(frozen=True)
class Limits:
    """What the controllers of a drive are judged by."""

    speed_tolerance_rpm: float
    """Greatest speed error k1 of a search that has converged (rpm)."""
    power_tolerance: float
    """Greatest variation k2 of the current sum, as a share of it (1)."""
    angle_tolerance_deg: float
    """Greatest movement of the advance angle (electrical degrees)."""
    settling_s: float
    """Time in which a search has to converge (s)."""
    optimum_tolerance: float
    """Greatest excess of the current sum over the least one, as a share of it (1)."""
    ripple: float
    """Limit of the torque ripple with the ideal regulator, peak to peak over mean (1); inf for none."""
    closed_loop_ripple: float
    """The same with hysteresis band and speed regulator (1)."""
    points: tuple[RequiredPoint, ...]
    """Operating points at which the ripple is required."""


@lru_cache(maxsize=_KEPT)
def limits_of(drive: DriveDocument) -> Limits:
    """Return all limits of a drive; what its file leaves out follows from its rating."""
    stated, rating = drive.requirements, drive.rating
    torque = POINT_POWER_SHARE * rating.rated_power_w / (rating.highest_speed_rpm * RADIANS_PER_RPM)
    at_highest = RequiredPoint(speed_rpm=rating.highest_speed_rpm, torque_n_m=rounded(torque, 3))
    return Limits(
        speed_tolerance_rpm=speed_tolerance_of(drive),
        power_tolerance=stated.power_tolerance_percent / 100.0,
        angle_tolerance_deg=stated.angle_tolerance_deg,
        settling_s=settling_of(drive),
        optimum_tolerance=stated.optimum_tolerance_percent / 100.0,
        ripple=_ripple(drive, stated.ripple_percent, RIPPLE),
        closed_loop_ripple=_ripple(drive, stated.closed_loop_ripple_percent, CLOSED_LOOP_RIPPLE),
        points=stated.point or (at_highest,),
    )


def speed_tolerance_of(drive: DriveDocument) -> float:
    """Return the greatest speed error k1 of a drive of any kind (rpm)."""
    stated = drive.requirements.speed_tolerance_rpm
    return SPEED_TOLERANCE_SHARE * drive.rating.base_speed_rpm if stated is None else stated


def settling_of(drive: DriveDocument) -> float:
    """Return the time in which the controller of a drive of any kind has to settle (s)."""
    stated = drive.requirements.settling_s
    return SETTLING_UNITS * time_unit(drive) if stated is None else stated


def _ripple(drive: DriveDocument, stated_percent: float | None, of_decoupled: float) -> float:
    if stated_percent is not None:
        return stated_percent / 100.0
    return of_decoupled if drive.has_split_supply else math.inf


def time_unit(drive: DriveDocument) -> float:
    """Return the unit of the times in which a drive is run: 1 s, or 1.5, 2, 3, 5, 7, 10 s … for one that is slower.

    The speed moves in mechanical time constants, J·ω/T at base speed and rated torque, and currents and torque repeat
    in electrical periods; the slower one rules. A drive that is faster gets no shorter times, since convergence is
    judged by means over 0.1 s, and searches decide no more often.
    """
    return max(nearest_step(ideal_time_unit(drive), _STEPS_OF_TIME), SHORTEST_TIME_UNIT_S)


def ideal_time_unit(drive: DriveDocument) -> float:
    """Return the time that `time_unit` rounds to a step (s)."""
    speed = drive.rating.base_speed_rpm * RADIANS_PER_RPM
    electrical = 2.0 * math.pi / (drive.machine.pole_pairs * speed)
    return max(MECHANICAL_TIMES * mechanical_time(drive), ELECTRICAL_PERIODS * electrical)


def mean_time(drive: DriveDocument) -> float:
    """Return the time of the means of the current sum by which convergence is judged (s).

    Over fewer electrical periods, the part of one that is left over moves the mean of a current sum that stands still.
    """
    return MEAN_UNITS * time_unit(drive)


def mechanical_time(drive: DriveDocument) -> float:
    """Return the time in which rated torque accelerates the shaft to base speed, J·ω/T (s)."""
    speed = drive.rating.base_speed_rpm * RADIANS_PER_RPM
    return drive.machine.inertia_kg_m2 * speed * speed / drive.rating.rated_power_w


def nearest_step(value: float, steps: tuple[str, ...] = _STEPS) -> float:
    """Return the nearest of 1, 2, 5 times a power of ten, or of other steps that people read easily; 0 of 0."""
    if value <= 0.0:
        return 0.0
    exponent = decimal_exponent(value)
    nearby = [float(f"{step}e{exponent}") for step in steps] + [float(f"1e{exponent + 1}")]
    return min(nearby, key=lambda step: max(step / value, value / step))


def rounded(value: float, digits: int) -> float:
    """Round to decimals, or to as many significant digits where that would lose what there is."""
    few = round(value, digits)
    return few if abs(few) >= float(f"1e{2 - digits}") else significant(value, digits)
