"""The table `[thermal]` of a PM AC drive: the temperature of its windings, and what senses it."""

from __future__ import annotations

from collections.abc import Mapping
from math import sqrt
from typing import TYPE_CHECKING, Any, Final, Self

from pydantic import Field, field_validator, model_validator

from drivegate_cases.documents.document import Section

if TYPE_CHECKING:
    from drivegate_models.pm_ac.winding import Winding

LEAST_HEATING_S: Final = 3.0
"""Least time in which the current limit heats the windings from the surroundings to their limit (s)."""
MOST_HEATING_S: Final = 2400.0
"""Greatest time of that (s)."""
LEAST_CONTINUOUS: Final = 0.1
"""Least continuous current over the current limit (1)."""
MOST_CONTINUOUS: Final = 2.0
"""Greatest continuous current over the current limit (1)."""
_MOST_PER_K: Final = 0.01
_TIME_CONSTANT: Final = "time_constant"
_HOTTEST_C: Final = 260.0
_ZERO_C: Final = 273.15
COPPER: Final = 0.00393
"""Temperature coefficient of copper (1/K)."""


class PmAcThermal(Section):
    """A thermal node: the copper loss heats the windings, which pass the heat on to the surroundings."""

    heat_capacity_j_per_k: float = Field(
        gt=0.0, le=1e9, description="heat capacity of all windings together, in joules per kelvin"
    )
    thermal_resistance_k_per_w: float = Field(
        gt=0.0,
        le=1e6,
        description="rise of the windings' temperature above the surroundings for each watt of copper loss, in kelvins "
        "per watt",
    )
    limit_c: float = Field(
        ge=-50.0,
        le=_HOTTEST_C,
        description="greatest permitted temperature of the windings, in degrees Celsius",
    )
    ambient_c: float = Field(
        default=25.0,
        ge=-60.0,
        le=_HOTTEST_C,
        description="temperature of the surroundings, at which resistance_ohm is stated, in degrees Celsius",
    )
    temperature_coefficient_per_k: float = Field(
        default=COPPER,
        ge=0.0,
        le=_MOST_PER_K,
        description="change of the resistance for each kelvin, over that at ambient_c",
    )
    sensor_lag_s: float | None = Field(
        default=None,
        ge=0.0,
        le=600.0,
        description="time constant of the sensor in the windings, in seconds; without a sensor where it is left out",
    )

    @model_validator(mode="before")
    @classmethod
    def _has_no_time_constant(cls, values: Any) -> Any:
        known = (
            next((key for key in values if _TIME_CONSTANT in str(key)), None)
            if isinstance(values, Mapping)
            else None
        )
        if known is not None:
            raise ValueError(
                f"the key '{known}' is unknown: divide the windings' time constant in seconds by "
                "thermal_resistance_k_per_w, and state that as heat_capacity_j_per_k"
            )
        return values

    @field_validator("limit_c", "ambient_c", mode="before")
    @classmethod
    def _is_in_degrees_celsius(cls, temperature: Any) -> Any:
        if isinstance(temperature, int | float) and temperature > _HOTTEST_C:
            raise ValueError(
                f"must be at most {_HOTTEST_C:g}: in degrees Celsius, {temperature:g} K are {temperature - _ZERO_C:g}"
            )
        return temperature

    @field_validator("temperature_coefficient_per_k", mode="before")
    @classmethod
    def _is_no_percentage(cls, coefficient: Any) -> Any:
        if isinstance(coefficient, int | float) and coefficient > _MOST_PER_K:
            raise ValueError(
                f"must be at most {_MOST_PER_K:g}: of copper it is {COPPER:g}, which is {100.0 * COPPER:g} % for each "
                "kelvin"
            )
        return coefficient

    @model_validator(mode="after")
    def _limit_is_above_ambient(self) -> Self:
        if self.limit_c <= self.ambient_c:
            raise ValueError(
                f"the key 'limit_c' is {self.limit_c:g}, but must be above ambient_c, {self.ambient_c:g} degrees "
                "Celsius"
            )
        return self

    @property
    def rise_k(self) -> float:
        """Permitted rise of the temperature above the surroundings (K)."""
        return self.limit_c - self.ambient_c

    def resistance_at(self, temperature_c: float, resistance: float) -> float:
        """Return a winding resistance (ohm) at a temperature, by that at `ambient_c`."""
        return resistance * (1.0 + self.temperature_coefficient_per_k * (temperature_c - self.ambient_c))

    def continuous_current(self, resistance: float) -> float:
        """Return the peak current of a phase (A) that holds the windings at their limit, by the resistance (ohm)."""
        hot = self.resistance_at(self.limit_c, resistance)
        return sqrt(self.rise_k / (self.thermal_resistance_k_per_w * 1.5 * hot))

    def heating_rate(self, current: float, resistance: float) -> float:
        """Return the rate at which a peak current of a phase (A) heats windings at their limit (K/s)."""
        loss = 1.5 * self.resistance_at(self.limit_c, resistance) * current * current
        return (loss - self.rise_k / self.thermal_resistance_k_per_w) / self.heat_capacity_j_per_k

    def heating_s(self, current: float, resistance: float) -> float:
        """Return the time in which a peak current (A) heats the windings from `ambient_c` to the limit at least (s)."""
        loss = 1.5 * self.resistance_at(self.limit_c, resistance) * current * current
        return self.heat_capacity_j_per_k * self.rise_k / loss

    def check_fit(self, machine: Any, inverter: Any, rating: Any) -> None:
        """Refuse values that only a wrong unit has on a machine with a current limit."""
        limit, resistance = rating.current_limit_a, machine.resistance_ohm
        if resistance == 0.0:
            raise ValueError(
                "the table [thermal] is for windings that their loss heats, but the key 'resistance_ohm' is 0; state "
                "the resistance, or leave [thermal] out"
            )
        continuous = self.continuous_current(resistance)
        if not LEAST_CONTINUOUS * limit <= continuous <= MOST_CONTINUOUS * limit:
            shares = (continuous / (share * limit) for share in (MOST_CONTINUOUS, LEAST_CONTINUOUS))
            least, most = (self.thermal_resistance_k_per_w * share * share for share in shares)
            raise ValueError(
                f"the key 'thermal_resistance_k_per_w' in [thermal] is {self.thermal_resistance_k_per_w:g}, with which "
                f"the windings bear {continuous:.3g} A for good, but a current limit of {limit:g} A requires "
                f"{least:.2g} to {most:.2g}; is it in kelvins per watt, and are the temperatures in degrees Celsius?"
            )
        heating = self.heating_s(limit, resistance)
        if not LEAST_HEATING_S <= heating <= MOST_HEATING_S:
            least, most = (
                bound * self.heat_capacity_j_per_k / heating for bound in (LEAST_HEATING_S, MOST_HEATING_S)
            )
            raise ValueError(
                f"the key 'heat_capacity_j_per_k' in [thermal] is {self.heat_capacity_j_per_k:g}, with which the "
                f"current limit heats the windings to their limit in {heating:.2g} s, but it must be {least:.2g} to "
                f"{most:.2g}; is it in joules per kelvin?"
            )
        lag, period = self.sensor_lag_s, inverter.control_period_s
        if lag is not None and (0.0 < lag < period or lag > heating):
            raise ValueError(
                f"the key 'sensor_lag_s' in [thermal] is {lag:g}, but must be 0, or from a control period of "
                f"{period:g} s to {heating:.2g} s, in which the current limit heats the windings to their limit; is it "
                "in seconds?"
            )

    def plant(self, control_period: float, initial_c: float | None) -> Winding:
        """Return the node of the plant at an initial temperature (degrees Celsius), by default that of `ambient_c`."""
        from drivegate_models.pm_ac.winding import make_winding

        return make_winding(
            heat_capacity=self.heat_capacity_j_per_k,
            thermal_resistance=self.thermal_resistance_k_per_w,
            ambient=self.ambient_c,
            coefficient=self.temperature_coefficient_per_k,
            control_period=control_period,
            initial=self.ambient_c if initial_c is None else initial_c,
            lag=self.sensor_lag_s,
        )
