"""The table `[rating]` of a drive: what it is made for."""

from typing import Final, Self

from pydantic import Field, model_validator

from drivegate_cases.documents.document import Section
from drivegate_models.units import RADIANS_PER_RPM

GREATEST_TORQUE_NM: Final = 1e6
"""Greatest torque of rated power at base speed that is taken for one (N·m)."""


class Rating(Section):
    """Power, current and the speeds between which the power is constant."""

    base_speed_rpm: float = Field(
        gt=0.0, le=1e6, description="speed at which constant power begins, in turns a minute"
    )
    highest_speed_rpm: float = Field(
        gt=0.0, le=1e6, description="speed up to which constant power is required, in turns a minute"
    )
    overspeed_rpm: float = Field(
        gt=0.0, le=1e6, description="highest speed of all, beyond that of constant power, in turns a minute"
    )
    rated_power_w: float = Field(gt=0.0, le=1e9, description="rated power at the shaft, in watts")
    current_limit_a: float = Field(gt=0.0, le=1e5, description="greatest current reference, in ampere")

    @model_validator(mode="after")
    def _speeds_rise(self) -> Self:
        if self.highest_speed_rpm <= self.base_speed_rpm:
            raise ValueError(
                f"the key 'highest_speed_rpm' is {self.highest_speed_rpm:g}, but must be above the "
                f"base speed of {self.base_speed_rpm:g} rpm"
            )
        if self.overspeed_rpm < self.highest_speed_rpm:
            raise ValueError(
                f"the key 'overspeed_rpm' is {self.overspeed_rpm:g}, but must be at least the "
                f"highest speed of {self.highest_speed_rpm:g} rpm"
            )
        return self._with_a_torque_in_range()

    def _with_a_torque_in_range(self) -> Self:
        torque = self.rated_power_w / (self.base_speed_rpm * RADIANS_PER_RPM)
        if torque > GREATEST_TORQUE_NM:
            raise ValueError(
                f"the key 'rated_power_w' is {self.rated_power_w:g}, which takes {torque:.3g} N·m at "
                f"{self.base_speed_rpm:g} rpm, but must take at most {GREATEST_TORQUE_NM:g} N·m"
            )
        return self
