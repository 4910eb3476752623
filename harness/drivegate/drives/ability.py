"""What is asked of any kind of drive: what it can do, whoever controls it, and what no controller can do on it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from drivegate.drives.constant_power import ConstantPower
from drivegate.drives.power_reach import PowerReach
from drivegate.drives.required_ripple import UnreachableRipple
from drivegate_cases.drive.drive_document import DriveDocument


@dataclass(frozen=True)
class RunTime:
    """How long a drive takes for what its runs are measured by."""

    time: float
    """That time (s)."""
    longest: float
    """Longest time that is accepted (s)."""
    until: str
    """What happens in that time, in words."""
    share: float
    """Share of the inertia with which the time would be short enough (1)."""


class Ability(ABC):
    """What drives of a kind can do; each method takes the drive's document."""

    @abstractmethod
    def run_time(self, drive: DriveDocument) -> RunTime:
        """Return how long a drive takes for what its runs are measured by."""

    @abstractmethod
    def reach(self, drive: DriveDocument) -> PowerReach:
        """Return what a drive can deliver of its rated power."""

    def accepts(self, drive: DriveDocument) -> bool:
        """Return True if rated power, and whatever follows from it, can be met."""
        return self.reach(drive).is_met

    def unmet(self, _drive: DriveDocument) -> tuple[UnreachableRipple, ...]:
        """Return the requirements besides rated power that no controller can meet."""
        return ()

    @abstractmethod
    def constant_power(self, drive: DriveDocument) -> ConstantPower:
        """Return how far a drive keeps its rated power."""

    @abstractmethod
    def speeds(self, drive: DriveDocument) -> Sequence[float]:
        """Return the speeds at which a drive is looked at."""

    @abstractmethod
    def envelope(self, drive: DriveDocument, report: Callable[[int], None]) -> dict[str, Any]:
        """Return what a drive can do as plain data, after reporting the number of each speed that is finished."""

    @abstractmethod
    def facts(self, envelope: dict[str, Any], /) -> Sequence[str]:
        """Describe such an envelope in sentences."""

    @abstractmethod
    def required(self, drive: DriveDocument) -> Sequence[str]:
        """Return what is required of the controllers of a drive, in its own numbers."""


def rating_document(drive: DriveDocument) -> dict[str, float]:
    """Return the part of an envelope that states the rating."""
    keys = ("base_speed_rpm", "highest_speed_rpm", "overspeed_rpm", "rated_power_w", "current_limit_a")
    return {key: getattr(drive.rating, key) for key in keys}
