"""What the checks of a drive without a position sensor share."""

from __future__ import annotations

from typing import Final

from drivegate.candidates.declaration import Declaration
from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.record import DutyRecord
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.load import DynamometerLoad, LockedLoad, VehicleLoad
from drivegate_models.units import RADIANS_PER_RPM

SPEED_FACTOR: Final = 2.0
"""Error of the mean speed over k1 (1)."""
TORQUE_SHARE: Final = 0.05
"""Error of the mean torque over the rated one (1)."""


def if_sensorless(_declaration: Declaration, drive: DriveDocument) -> str | None:
    """Return why a check that is judged without a position sensor does not apply."""
    return "the drive has a position sensor" if duty_document(drive).has_sensor else None


def if_speed(declaration: Declaration, drive: DriveDocument) -> str | None:
    """Return why a check of a regulated speed without a position sensor does not apply."""
    if "speed" not in declaration.references:
        return "the candidate follows no speed"
    return if_sensorless(declaration, drive)


def is_sensorless(record: DutyRecord) -> bool:
    """Return True if nothing shows the shaft."""
    return not record.document.has_sensor


def regulates_speed(record: DutyRecord) -> bool:
    """Return True if a run without a sensor has a speed reference."""
    return is_sensorless(record) and not isinstance(
        record.scenario.load, (LockedLoad, DynamometerLoad, VehicleLoad)
    )


def least_speed(record: DutyRecord) -> float:
    """Return the least speed of steady running (rad/s)."""
    return record.document.least_speed_rpm * RADIANS_PER_RPM
