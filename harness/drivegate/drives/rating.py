"""A drive with its rating, as studies of what it can do take both: the one place that reads them from a document."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from typing import Final

from drivegate.drives.kinds import require_angles
from drivegate.scenarios.drive_scale import scale_of
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import Limits, limits_of
from drivegate_models.steady.oracle import demanded_torque
from drivegate_models.steady.plant import AnyDrive
from drivegate_models.units import RADIANS_PER_RPM

MOST_CHOPS: Final = 500.0
"""Chops in half an electrical cycle at base speed from which a band is taken as none, since each costs time."""


@dataclass(frozen=True)
class Rating:
    base_speed: float
    """Speed up to which torque is constant, and above which power is (rad/s)."""
    lowest_speed: float
    """Lowest speed at which rated power is required; right at base speed there is no advance yet (rad/s)."""
    highest_speed: float
    """Highest speed at which rated power is required (rad/s)."""
    overspeed: float
    """Greatest speed (rad/s)."""
    power: float
    """Rated power at the shaft (W)."""


@dataclass(frozen=True)
class RatedDrive:
    document: DriveDocument
    constants: AnyDrive
    """The plant's constants, its band none where it is so narrow that it chops more than `MOST_CHOPS` times.
    """
    ideal: AnyDrive
    """The same with the ideal current regulator."""
    rating: Rating
    limits: Limits
    has_band: bool = True
    """Whether the document's band is in the constants, or none was given."""

    def demanded_torque(self, speed: float) -> float:
        """Return the torque of rated power at a speed (rad/s), constant below base speed (N·m)."""
        return demanded_torque(self.constants, speed, self.rating.base_speed, self.rating.power)


def rated_drive(document: DriveDocument) -> RatedDrive:
    """Take drive and rating from a document; one whose controllers answer with no angle is refused."""
    given = require_angles(document).rating
    base_speed = given.base_speed_rpm * RADIANS_PER_RPM
    rating = Rating(
        base_speed=base_speed,
        lowest_speed=scale_of(document).lowest_loaded_rpm * RADIANS_PER_RPM,
        highest_speed=given.highest_speed_rpm * RADIANS_PER_RPM,
        overspeed=given.overspeed_rpm * RADIANS_PER_RPM,
        power=given.rated_power_w,
    )
    ideal = document.replaced(hysteresis_band_a=0.0).plant()
    own = document.plant()
    has_band = _chops(own, base_speed) <= MOST_CHOPS
    return RatedDrive(
        document=document,
        constants=own if has_band else ideal,
        ideal=ideal,
        rating=rating,
        limits=limits_of(document),
        has_band=has_band,
    )


def machine_constants(document: DriveDocument) -> dict[str, float]:
    """Take from a document the constants that a fit may change, by their keys."""
    keys = ["emf_constant_v_s_per_rad", "inductance_h", "resistance_ohm"]
    if document.machine.emf_shape == "trapezoid":
        keys.append("emf_flat_deg")
    return {key: float(document.value(key)) for key in keys}


def drive_with(document: DriveDocument, constants: Mapping[str, float]) -> AnyDrive:
    """Make the plant of other constants, without the band, across which torque jumps, and without core loss."""
    changes: dict[str, float] = {**constants, "hysteresis_band_a": 0.0, "core_loss_conductance_s": 0.0}
    return document.replaced(**changes).plant()


def _chops(constants: AnyDrive, speed: float) -> float:
    """Count how often the current crosses its band, up and down, in half an electrical cycle without EMF."""
    if constants.hysteresis_band == 0.0:
        return 0.0
    frequency = constants.half_supply_voltage / (2.0 * constants.inductance * constants.hysteresis_band)
    return float(frequency * pi / (constants.pole_pairs * speed))
