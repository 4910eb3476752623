"""The drive of the paper, as candidates meet it and as it was calibrated."""

from __future__ import annotations

from functools import cache
from typing import Final

from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_models.steady.plant import AnyDrive
from drivegate_models.units import RADIANS_PER_RPM

HIGHEST_PUBLISHED_RPM: Final = 1500.0
"""Greatest speed of the published results, three times base speed."""


@cache
def reference_drive() -> DriveDocument:
    """Load the calibrated 5-phase drive."""
    return load_drive("paper-5-phase")


@cache
def banded_drive() -> AnyDrive:
    """Make the drive as candidates meet it: with its current band and its core loss."""
    return reference_drive().plant()


@cache
def ideal_drive() -> AnyDrive:
    """Make the drive as it was calibrated: ideal current regulators and no core loss."""
    return banded_drive()._replace(hysteresis_band=0.0, core_loss_conductance=0.0)


def power_torque(speed_rpm: float, power_w: float) -> float:
    """Return the torque of a power."""
    return power_w / (speed_rpm * RADIANS_PER_RPM)
