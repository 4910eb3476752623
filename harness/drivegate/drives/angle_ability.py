"""What a drive whose controllers answer with an advance angle can do, whoever controls it."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from typing import Any, Final

import numpy as np

from drivegate.drives.ability import Ability, RunTime
from drivegate.drives.constant_power import constant_power
from drivegate.drives.envelope import envelope, recommended_line, speeds_of
from drivegate.drives.envelope_document import envelope_document
from drivegate.drives.envelope_words import facts, required
from drivegate.drives.kinds import FloatArray
from drivegate.drives.power_reach import PowerReach
from drivegate.drives.rating import RatedDrive, rated_drive
from drivegate.drives.required_ripple import unreachable_ripple
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import ideal_time_unit, time_unit
from drivegate_models.units import RADIANS_PER_RPM

SPEEDS: Final = 21
"""Speeds from the lowest loaded to the highest at which rated power is looked for."""
LONGEST_TIME_UNIT_S: Final = 600.0
"""Longest unit of the times in which a drive is run (s): a search then has an hour to converge."""
_LONGEST_STEP_S: Final = 500.0
"""The longest unit up to `LONGEST_TIME_UNIT_S` among the steps of that unit (s)."""


def rating_is_met(drive: RatedDrive) -> bool:
    """Return True if the drive delivers rated power at every speed at which it is required."""
    return all(_greatest(drive, speed) >= drive.demanded_torque(speed) for speed in _speeds(drive).tolist())


def _run_time(document: DriveDocument) -> RunTime:
    share = _LONGEST_STEP_S / ideal_time_unit(document)
    return RunTime(time_unit(document), LONGEST_TIME_UNIT_S, "from change to change", share)


def _speeds(drive: RatedDrive) -> FloatArray:
    return np.linspace(drive.rating.lowest_speed, drive.rating.highest_speed, SPEEDS)


def _greatest(drive: RatedDrive, speed: float) -> float:
    return drive.oracle.greatest_torque_at_limit(drive.constants, speed).torque


def _reach(document: DriveDocument) -> PowerReach:
    drive = rated_drive(document)
    speeds = _speeds(drive)
    return PowerReach(
        speeds=speeds,
        needed=np.array([drive.demanded_torque(speed) for speed in speeds.tolist()]),
        greatest=np.array([_greatest(drive, speed) for speed in speeds.tolist()]),
    )


def _accepts(document: DriveDocument) -> bool:
    """Return True if rated power can be met, and the torque at a required point that follows from it."""
    drive = rated_drive(document)
    if not rating_is_met(drive):
        return False
    # A stated point is refused by itself.
    points = () if document.requirements.point else drive.limits.points
    find = drive.oracle.least_current_sum
    return all(
        isfinite(find(drive.constants, point.speed_rpm * RADIANS_PER_RPM, point.torque_n_m).advance)
        for point in points
    )


def _envelope(document: DriveDocument, report: Callable[[int], None]) -> dict[str, Any]:
    drive = rated_drive(document)
    line = recommended_line(drive)
    points = []
    for point in envelope(drive, line, speeds_of(drive.rating)):
        points.append(point)
        report(len(points))
    return envelope_document(drive, line, points)


ANGLE_ABILITY: Final = Ability(
    run_time=_run_time,
    reach=_reach,
    accepts=_accepts,
    unmet=lambda document: unreachable_ripple(rated_drive(document)),
    constant_power=lambda document: constant_power(rated_drive(document)),
    speeds=lambda document: speeds_of(rated_drive(document).rating),
    envelope=_envelope,
    facts=facts,
    required=required,
)
"""Of half-bridge and star drives."""
