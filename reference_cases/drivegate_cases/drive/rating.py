"""The table `[rating]` of a drive: what it is made for."""

from typing import Any, ClassVar, Final, Self

from pydantic import ConfigDict, Field, model_validator

from drivegate_cases.documents.document import Section
from drivegate_models.units import RADIANS_PER_RPM

GREATEST_TORQUE_NM: Final = 1e9
"""Greatest torque of rated power at base speed that is taken for one (N·m): ten times that of 10 MW at 1 rpm."""
GREATEST_POWER_W: Final = 1e9
HIGHEST_SPEED_RPM: Final = 1e6
OVER_RATING: Final = 10.0
"""Greatest speed, torque or power of a scenario over the overspeed, rated torque or rated power of its drive (1)."""

FOLLOWING: Final = ("rated_power_w", "current_limit_a")
"""Keys that follow from the currents of a data sheet where they are left out."""


def _without_following(schema: dict[str, Any]) -> None:
    """Let editors accept a table that leaves out what follows from other keys."""
    schema["required"] = [key for key in schema["required"] if key not in FOLLOWING]


class Rating(Section):
    """Power, current and the speeds between which the power is constant."""

    model_config = ConfigDict(json_schema_extra=_without_following)

    needs_weakening: ClassVar[bool] = True
    """Whether the highest speed must be above base speed, so that controllers weaken the field."""

    base_speed_rpm: float = Field(
        gt=0.0, le=HIGHEST_SPEED_RPM, description="speed at which constant power begins, in turns a minute"
    )
    highest_speed_rpm: float = Field(
        gt=0.0,
        le=HIGHEST_SPEED_RPM,
        description="speed up to which constant power is required, in turns a minute; base_speed_rpm for a PM AC drive "
        "without field weakening",
    )
    overspeed_rpm: float = Field(
        gt=0.0,
        le=HIGHEST_SPEED_RPM,
        description="highest speed of all, beyond that of constant power, in turns a minute",
    )
    rated_power_w: float = Field(
        gt=0.0,
        le=GREATEST_POWER_W,
        description="rated power at the shaft, in watts; by default 92 % of what continuous_current_a produces from "
        "base speed to the highest",
    )
    current_limit_a: float = Field(
        gt=0.0,
        le=1e5,
        description="greatest current reference, in ampere, peak value of a phase; by default peak_current_a, or else "
        "continuous_current_a",
    )
    continuous_current_a: float | None = Field(
        default=None,
        gt=0.0,
        le=1e5,
        description="continuous (rated) current of a data sheet, in ampere, peak value of a phase: 1.414 times the "
        "rms value",
    )
    peak_current_a: float | None = Field(
        default=None,
        gt=0.0,
        le=1e5,
        description="greatest current of a data sheet, in ampere, peak value of a phase: 1.414 times the rms value",
    )

    @property
    def rated_torque_nm(self) -> float:
        """Torque of rated power at base speed (N·m)."""
        return self.rated_power_w / (self.base_speed_rpm * RADIANS_PER_RPM)

    @model_validator(mode="after")
    def _values_fit_together(self) -> Self:
        base, highest = self.base_speed_rpm, self.highest_speed_rpm
        if highest < base or (highest == base and self.needs_weakening):
            unweakened = (
                "" if self.needs_weakening else ", or equal to it for a drive without field weakening"
            )
            raise ValueError(
                f"the key 'highest_speed_rpm' is {highest:g}, but must be above the base speed of {base:g} rpm"
                f"{unweakened}"
            )
        if self.overspeed_rpm < self.highest_speed_rpm:
            raise ValueError(
                f"the key 'overspeed_rpm' is {self.overspeed_rpm:g}, but must be at least the "
                f"highest speed of {self.highest_speed_rpm:g} rpm"
            )
        self._check_currents()
        torque = self.rated_torque_nm
        if torque > GREATEST_TORQUE_NM:
            raise ValueError(
                f"the key 'rated_power_w' is {self.rated_power_w:g}, which takes {torque:.3g} N·m at "
                f"{self.base_speed_rpm:g} rpm, but must take at most {GREATEST_TORQUE_NM:g} N·m"
            )
        return self

    def _check_currents(self) -> None:
        """Refuse a current above the peak current, which bounds all others."""
        if self.peak_current_a is None:
            return
        for key in ("continuous_current_a", "current_limit_a"):
            current = getattr(self, key)
            if current is not None and current > self.peak_current_a:
                raise ValueError(
                    f"the key '{key}' is {current:g}, but must be at most the peak current, and peak_current_a is "
                    f"{self.peak_current_a:g}"
                )
