"""Checks that apply only to candidates which are made for some of the speeds they are judged at."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import ReasonNotApplicable
from drivegate.scenarios.drive_scale import SpeedRange, scale_of
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.requirements import points_of

JudgedSpeeds: TypeAlias = Callable[[DriveDocument], SpeedRange]
"""From a drive to the lowest and highest speed that a check judges (rpm)."""


def below_base(drive: DriveDocument) -> SpeedRange:
    return 0.0, math.nextafter(drive.rating.base_speed_rpm, 0.0)


def above_base(drive: DriveDocument) -> SpeedRange:
    return drive.rating.base_speed_rpm, math.inf


def constant_power(drive: DriveDocument) -> SpeedRange:
    return scale_of(drive).lowest_loaded_rpm, drive.rating.highest_speed_rpm


def beyond_constant_power(drive: DriveDocument) -> SpeedRange:
    return math.nextafter(drive.rating.highest_speed_rpm, math.inf), drive.rating.overspeed_rpm


def required_points(drive: DriveDocument) -> SpeedRange:
    speeds = [point.speed_rpm for point in points_of(drive)]
    return min(speeds), max(speeds)


def unless_speeds(judged: JudgedSpeeds) -> ReasonNotApplicable:
    """Let a check apply unless the candidate declares a range without any of the speeds it is judged at."""

    def reason(declaration: Declaration, drive: DriveDocument) -> str | None:
        lowest, highest = judged(drive)
        declared = declaration.speed_range_rpm
        endless = highest == math.inf
        reaches = declared is not None and (declared[1] > lowest if endless else declared[1] >= lowest)
        if declared is None or (declared[0] <= highest and reaches):
            return None
        return (
            f"the candidate declares a speed range of {declared[0]:g} to {declared[1]:g} rpm, "
            f"which contains none of {_in_words(lowest, highest)}"
        )

    return reason


def _in_words(lowest: float, highest: float) -> str:
    if highest == math.inf:
        return f"the speeds above {lowest:g} rpm"
    if lowest == highest:
        return f"{lowest:g} rpm"
    return f"the speeds from {lowest:g} to {highest:g} rpm"
