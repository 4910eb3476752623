"""The drive of the paper, and the conventional 3-phase stars of the same iron and copper next to it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Final

from drivegate.drives.constant_power import constant_power, last_met
from drivegate.drives.rating import rated_drive
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_models.steady.oracle import (
    TorquePoint,
    greatest_torque_at_limit,
    least_current_sum,
    point_at_torque,
)
from drivegate_models.steady.plant import AnyDrive
from drivegate_models.units import RADIANS_PER_RPM

HIGHEST_PUBLISHED_RPM: Final = 1500.0
"""Greatest speed of the published results, three times base speed."""
FASTEST_RPM: Final = 6000.0
"""Speed up to which the range of constant power is looked for, as of the paper's drive."""
WIDE_DEG: Final = 150.0
"""Flat width of the EMF, or window, of the variants (electrical deg)."""
_SLOWEST_RPM: Final = 250.0
_HALVINGS: Final = 16


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


@dataclass(frozen=True)
class ComparedDrive:
    """A drive of the comparison, with ideal current regulators and no core loss."""

    name: str
    """What it is called in figures."""
    document: DriveDocument
    """The drive."""


@dataclass(frozen=True)
class PowerPoint:
    """Rated power at the angle of least Σ|i|."""

    advance_deg: float
    """That angle (electrical deg)."""
    point: TorquePoint
    """The steady state there."""

    @property
    def ripple_percent(self) -> float:
        """Torque ripple, peak to peak over mean (%)."""
        return ripple_percent(self.point)


def ripple_percent(point: TorquePoint) -> float:
    """Return the torque ripple of a steady state, peak to peak over mean (%)."""
    return 100.0 * (point.torque_highest - point.torque_lowest) / point.torque


@cache
def star(**changes: float) -> DriveDocument:
    """Make the star of the same iron and copper, or one that differs in a few keys."""
    return _without_band_and_core_loss(load_drive("star-3-phase").replaced(**changes))


def _without_band_and_core_loss(document: DriveDocument) -> DriveDocument:
    return document.replaced(hysteresis_band_a=0.0, core_loss_conductance_s=0.0)


@cache
def compared_drives() -> tuple[ComparedDrive, ...]:
    """List the 5-phase drive and the stars."""
    five = _without_band_and_core_loss(reference_drive())
    plain = star()
    assert plain.machine.emf_flat_deg is not None, "the packaged star has a trapezoidal EMF"
    window = plain.inverter.window_deg
    return (
        ComparedDrive(f"{five.machine.phases} phases, {five.inverter.window_deg:g}° windows", five),
        ComparedDrive(f"star, EMF flat over {plain.machine.emf_flat_deg:g}°", plain),
        ComparedDrive(f"star, EMF flat over {WIDE_DEG:g}°", star(emf_flat_deg=WIDE_DEG)),
        ComparedDrive(f"star, {WIDE_DEG:g}° for {window:g}° windows", star(window_deg=WIDE_DEG)),
    )


def at_rated_power(drive: AnyDrive, speed_rpm: float) -> PowerPoint:
    """Find the least Σ|i| of rated power at a speed; NaN throughout where that is out of reach."""
    speed = speed_rpm * RADIANS_PER_RPM
    torque = power_torque(speed_rpm, reference_drive().rating.rated_power_w)
    least = least_current_sum(drive, speed, torque)
    advance = least.advance if math.isfinite(least.advance) else 0.0
    point = point_at_torque(drive, speed, advance, torque)
    if not math.isfinite(least.advance):
        point = TorquePoint(False, False, *(math.nan,) * 15, False)
    return PowerPoint(math.degrees(least.advance), point)


@cache
def at_three_times_base_speed() -> tuple[PowerPoint, ...]:
    """Find the least Σ|i| of rated power of every drive of the comparison at the highest published speed."""
    return tuple(at_rated_power(drive.document.plant(), HIGHEST_PUBLISHED_RPM) for drive in compared_drives())


def constant_power_range(document: DriveDocument) -> tuple[float, float]:
    """Find from which speed to which a drive gives rated power, `FASTEST_RPM` at most (rpm)."""
    reached = constant_power(rated_drive(document.replaced(overspeed_rpm=FASTEST_RPM))).reached
    assert reached is not None, f"{document.name} gives its rated power just above base speed"
    plant, power = document.plant(), document.rating.rated_power_w

    def has_power(speed_rpm: float) -> bool:
        speed = speed_rpm * RADIANS_PER_RPM
        return speed * greatest_torque_at_limit(plant, speed).torque >= power

    slowest = last_met(has_power, 1.1 * document.rating.base_speed_rpm, _SLOWEST_RPM, _HALVINGS)
    return slowest, reached / RADIANS_PER_RPM
