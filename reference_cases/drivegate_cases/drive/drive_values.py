"""What every kind of drive states, for those whom the kind does not concern."""

from __future__ import annotations

from typing import Any, Protocol, Self

from drivegate_cases.drive.rating import Rating


class DriveValues(Protocol):
    """The values of a drive of any kind, and what follows from them."""

    @property
    def rating(self) -> Rating:
        """What the drive is made for."""

    @property
    def machine(self) -> Any:
        """Windings and shaft."""

    @property
    def inverter(self) -> Any:
        """Supply and bridge."""

    @property
    def provenance(self) -> dict[str, dict[str, str]]:
        """Where its values come from."""

    def value(self, key: str) -> Any:
        """Return the value of a key of any table, by its bare name."""

    def replaced(self, **changes: Any) -> Self:
        """Return a drive that differs in a few keys."""

    def usual_ranges(self) -> tuple[tuple[Any, ...], ...]:
        """Return the ranges that only a wrong unit leaves, those first that others are measured by."""

    def torque_of_current(self, current: float) -> float:
        """Return the most torque of a peak phase current (A) while the voltage is ample (N·m)."""

    def greatest_torque(self, current: float, speed: float) -> float:
        """Return the greatest torque within a current limit (A) and the supply, at a speed (rad/s); in N·m."""
