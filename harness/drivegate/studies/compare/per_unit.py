"""Per-unit bases of a drive, by which drives of any size are compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Final

from drivegate.scenarios.drive_scale import scale_of
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.errors import InputError

BASES_IN_WORDS: Final = (
    "Per unit (pu): speed over base speed, torque over that of rated power at base speed, Σ|i| over phases times "
    "the current limit, powers and losses over rated power."
)
"""The bases in words."""
_SHOWN_OF_HASH: Final = 8


@dataclass(frozen=True)
class Bases:
    """What one per unit is on a drive."""

    speed_rpm: float
    """Base speed (rpm)."""
    torque_nm: float
    """Torque of rated power at base speed (N·m)."""
    current_sum_a: float
    """Current limit of all phases (A)."""
    power_w: float
    """Rated power (W)."""

    def document(self) -> dict[str, float]:
        """Return the bases as plain data."""
        return asdict(self)


def bases_of(drive: DriveDocument) -> Bases:
    """Return the per-unit bases of a drive."""
    rating = drive.rating
    return Bases(
        speed_rpm=rating.base_speed_rpm,
        torque_nm=scale_of(drive).rated_torque_nm,
        current_sum_a=drive.machine.phases * rating.current_limit_a,
        power_w=rating.rated_power_w,
    )


def drive_labels(drives: Sequence[DriveDocument]) -> tuple[str, ...]:
    """Label every drive by its name, and by its hash where another has the same name."""
    names = [drive.name for drive in drives]
    for place, drive in enumerate(drives):
        same = next((other for other in drives[:place] if other.values_hash == drive.values_hash), None)
        if same is not None:
            raise InputError(
                f"the drives '{same.name}' and '{drive.name}' have the same values, so there is nothing to compare "
                "between them; name each drive once"
            )
    return tuple(
        drive.name if names.count(drive.name) == 1 else f"{drive.name} ({drive.values_hash[:_SHOWN_OF_HASH]})"
        for drive in drives
    )
