"""Speeds at which candidates are checked under load, as far as they are made for them."""

from __future__ import annotations

from typing import TypeAlias

from drivegate.scenarios.drive_scale import scale_of
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.errors import InputError

SpeedRange: TypeAlias = tuple[float, float]
"""Lowest and highest speed (rpm)."""


def loaded_range(drive: DriveDocument, declared_rpm: SpeedRange | None) -> SpeedRange:
    """Return the speeds of loaded runs."""
    scale = scale_of(drive)
    lowest, highest = scale.lowest_loaded_rpm, scale.highest_loaded_rpm
    if declared_rpm is None:
        return lowest, highest
    if declared_rpm[1] < lowest or declared_rpm[0] > highest:
        raise InputError(
            f"the candidate declares a speed_range_rpm of {declared_rpm[0]:g} to {declared_rpm[1]:g} rpm, but is "
            f"checked under load from {lowest:g} to {highest:g} rpm; declare a range that has some of these speeds"
        )
    return max(lowest, declared_rpm[0]), min(highest, declared_rpm[1])
