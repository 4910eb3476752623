"""What the shaft drives: kinds of load, each with its torque against the rotation at a speed.

All oppose the rotation, whichever way the shaft turns, except weights: that of a hoist, and a vehicle's on a slope.
"""

import math
from typing import Annotated, Final, Literal

from pydantic import Field

from drivegate_cases.documents.document import Section
from drivegate_cases.drive.rating import GREATEST_POWER_W, GREATEST_TORQUE_NM, HIGHEST_SPEED_RPM, OVER_RATING
from drivegate_cases.scenario.piecewise import WRITTEN, Profile, ProfilePoint, values_within
from drivegate_models.units import RADIANS_PER_RPM

_MOST_TORQUE_NM: Final = OVER_RATING * GREATEST_TORQUE_NM
_Torque = Annotated[float, Field(ge=0.0, le=_MOST_TORQUE_NM)]
_FactorPoint = Annotated[
    ProfilePoint,
    Field(description="[time in seconds, share of the load, from 0 without it to 1 with all of it]"),
]
GRAVITY = 9.80665
"""Standard gravity (m/s²)."""


class LockedLoad(Section):
    """A dynamometer that keeps the shaft on the speed reference, whatever torque that takes."""

    kind: Literal["locked"] = Field(description="kind of load")


class DynamometerLoad(LockedLoad):
    """A dynamometer that keeps the shaft on the speed reference, while the controller is given a torque reference."""

    # A kind is named by a literal of its own, which no other literal is a subtype of.
    kind: Literal["dynamometer"] = Field(description="kind of load")  # type: ignore[assignment]
    torque_reference_nm: Annotated[
        Profile,
        values_within(
            -_MOST_TORQUE_NM,
            _MOST_TORQUE_NM,
            f"must have torques of at most {_MOST_TORQUE_NM:g} N·m either way",
        ),
    ] = Field(description="torque that the controller is asked for over time, in newton metres")
    released_s: float | None = Field(
        default=None,
        gt=0.0,
        description="time from which the dynamometer no longer holds the shaft, so that the torque turns it freely, in "
        "seconds",
    )


class _SwitchedLoad(Section):
    """A load that a profile of factors switches on and off."""

    factor: Annotated[
        tuple[_FactorPoint, ...], WRITTEN, values_within(0.0, 10.0, "must have shares from 0 to 10")
    ] = Field(
        default=((0.0, 1.0),),
        description="share of the load over time, from 0 without it to 1 with all of it",
    )


class ConstantTorqueLoad(_SwitchedLoad):
    """The same torque at every speed."""

    kind: Literal["constant_torque"] = Field(description="kind of load")
    torque_nm: _Torque = Field(description="torque of the whole load, in newton metres")

    def torque_at(self, speed_rpm: float, share: float = 1.0) -> float:
        del speed_rpm
        return share * self.torque_nm


class HoistLoad(_SwitchedLoad):
    """A weight on a drum, whose torque keeps its sense: it drives a shaft that turns backward."""

    kind: Literal["hoist"] = Field(description="kind of load")
    torque_nm: _Torque = Field(
        description="torque by which the whole weight turns the shaft backward, in newton metres"
    )

    def torque_at(self, speed_rpm: float, share: float = 1.0) -> float:
        return share * (self.torque_nm if speed_rpm >= 0.0 else -self.torque_nm)


class ConstantPowerLoad(_SwitchedLoad):
    """A torque that falls with speed, so that the power stays; it needs a turning shaft."""

    kind: Literal["constant_power"] = Field(description="kind of load")
    power_w: float = Field(
        ge=0.0, le=OVER_RATING * GREATEST_POWER_W, description="power of the whole load, in watts"
    )

    def torque_at(self, speed_rpm: float, share: float = 1.0) -> float:
        return share * self.power_w / (abs(speed_rpm) * 2.0 * math.pi / 60.0)


class FanLoad(_SwitchedLoad):
    """A torque that grows with the square of the speed."""

    kind: Literal["fan"] = Field(description="kind of load")
    torque_nm: _Torque = Field(description="torque of the whole load at speed_rpm, in newton metres")
    speed_rpm: float = Field(
        gt=0.0,
        le=OVER_RATING * HIGHEST_SPEED_RPM,
        description="speed at which the fan demands torque_nm, in rpm",
    )

    def torque_at(self, speed_rpm: float, share: float = 1.0) -> float:
        ratio = speed_rpm / self.speed_rpm
        return share * self.torque_nm * (ratio * ratio)


class VehicleLoad(Section):
    """A vehicle on a road behind a fixed gear; its mass is felt as inertia at the shaft."""

    kind: Literal["vehicle"] = Field(description="kind of load")
    mass_kg: float = Field(gt=0.0, le=1e6, description="mass of the vehicle, in kilograms")
    wheel_radius_m: float = Field(gt=0.0, le=10.0, description="radius of the driven wheels, in metres")
    gear_ratio: float = Field(gt=0.0, le=1e3, description="turns of the shaft for one of the wheels")
    rolling_resistance: float = Field(
        ge=0.0, le=1.0, description="rolling resistance as a share of the vehicle's weight"
    )
    drag_area_m2: float = Field(
        ge=0.0, le=100.0, description="drag coefficient times frontal area, in square metres"
    )
    air_density_kg_m3: float = Field(
        default=1.2, ge=0.0, le=100.0, description="density of the air, in kilograms per cubic metre"
    )
    grade_percent: Annotated[Profile, values_within(-100.0, 100.0, "must have grades from -100 to 100 %")] = (
        Field(
            default=((0.0, 0.0),),
            description="grade of the road over time, in percent, positive where it rises in the forward direction",
        )
    )

    @property
    def lever_m(self) -> float:
        """Way of the vehicle for one radian of the shaft (m)."""
        return self.wheel_radius_m / self.gear_ratio

    @property
    def inertia_kg_m2(self) -> float:
        """The vehicle's mass as an inertia at the shaft (kg·m²)."""
        return self.mass_kg * self.lever_m * self.lever_m

    def torque_at(self, speed_rpm: float, share: float = 0.0) -> float:
        vehicle_speed = speed_rpm * RADIANS_PER_RPM * self.lever_m
        slope = share / 100.0
        weight = self.mass_kg * GRAVITY / math.hypot(1.0, slope)
        drag = 0.5 * self.air_density_kg_m3 * self.drag_area_m2 * vehicle_speed * vehicle_speed
        # Backward, a road that rises forward goes downhill.
        climb = slope if speed_rpm >= 0.0 else -slope
        return self.lever_m * (weight * (self.rolling_resistance + climb) + drag)


SwitchedLoad = ConstantTorqueLoad | HoistLoad | ConstantPowerLoad | FanLoad
Load = Annotated[LockedLoad | DynamometerLoad | SwitchedLoad | VehicleLoad, Field(discriminator="kind")]
