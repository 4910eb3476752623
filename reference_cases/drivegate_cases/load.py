"""What the shaft drives: kinds of load, each with the torque that it asks for at a speed."""

import math
from typing import Annotated, Literal

from pydantic import Field, field_validator

from drivegate_cases.document import Section
from drivegate_cases.piecewise import Profile, ProfilePoint, check_times

_Torque = Annotated[float, Field(ge=0.0, le=1e6)]
_FactorPoint = Annotated[
    ProfilePoint,
    Field(description="[time in seconds, share of the load, from 0 without it to 1 with all of it]"),
]
_GREATEST_FACTOR = 10.0


class LockedLoad(Section):
    """A dynamometer that keeps the shaft on the speed reference, whatever torque that takes."""

    kind: Literal["locked"] = Field(description="kind of load")


class _DrawnLoad(Section):
    """A load that a profile of factors switches on and off."""

    factor: tuple[_FactorPoint, ...] = Field(
        description="list of [time in seconds, share of the load], best from share 0 at first"
    )

    @field_validator("factor")
    @classmethod
    def _factors_in_range(cls, factor: Profile) -> Profile:
        if any(not 0.0 <= share <= _GREATEST_FACTOR for _, share in factor):
            raise ValueError(f"must have shares from 0 to {_GREATEST_FACTOR:g}")
        return check_times(factor)


class ConstantTorqueLoad(_DrawnLoad):
    """The same torque at every speed."""

    kind: Literal["constant_torque"] = Field(description="kind of load")
    torque_nm: _Torque = Field(description="torque of the whole load, in newton metres")

    def torque_at(self, speed_rpm: float) -> float:
        """Torque of the whole load.

        Parameters
        ----------
        speed_rpm : float
            Speed of the shaft (rpm); without influence here.

        Returns
        -------
        float
            Torque (N·m).
        """
        del speed_rpm
        return self.torque_nm


class ConstantPowerLoad(_DrawnLoad):
    """A torque that falls with speed, so that the power stays; it needs a turning shaft."""

    kind: Literal["constant_power"] = Field(description="kind of load")
    power_w: float = Field(ge=0.0, le=1e9, description="power of the whole load, in watts")

    def torque_at(self, speed_rpm: float) -> float:
        """Torque of the whole load.

        Parameters
        ----------
        speed_rpm : float
            Speed of the shaft (rpm), above 0.

        Returns
        -------
        float
            Torque (N·m), power over angular speed.
        """
        return self.power_w / (speed_rpm * 2.0 * math.pi / 60.0)


class FanLoad(_DrawnLoad):
    """A torque that grows with the square of the speed."""

    kind: Literal["fan"] = Field(description="kind of load")
    torque_nm: _Torque = Field(description="torque of the whole load at speed_rpm, in newton metres")
    speed_rpm: float = Field(gt=0.0, le=1e6, description="speed at which the fan asks for torque_nm, in rpm")

    def torque_at(self, speed_rpm: float) -> float:
        """Torque of the whole load.

        Parameters
        ----------
        speed_rpm : float
            Speed of the shaft (rpm).

        Returns
        -------
        float
            Torque (N·m), by the fan law proportional to the square of the speed.
        """
        return self.torque_nm * (speed_rpm / self.speed_rpm) ** 2


DrawnLoad = ConstantTorqueLoad | ConstantPowerLoad | FanLoad
Load = Annotated[LockedLoad | DrawnLoad, Field(discriminator="kind")]
