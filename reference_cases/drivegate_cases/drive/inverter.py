"""The table `[inverter]` of a drive: its supply, current regulators and devices."""

from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from drivegate_cases.documents.document import Section

_Energy = Annotated[float, Field(ge=0.0, le=1e3)]


class Inverter(Section):
    """Half-bridge legs, each with a hysteresis current regulator, at a split supply or a link of twice its voltage."""

    supply_voltage_v: float = Field(
        gt=0.0,
        le=1e5,
        description="voltage of one half of the supply, in volts; of a star, half of its link's",
    )
    hysteresis_band_a: float = Field(
        ge=0.0, le=1e4, description="half-width of the current band, in ampere, or 0 for the ideal regulator"
    )
    window_deg: float = Field(
        gt=0.0, le=180.0, description="conduction in each half cycle, in electrical degrees"
    )
    regulation: Literal["every-half", "upper-only", "pwm-on", "on-pwm"] | None = Field(
        default=None,
        description="parts of a star's windows that chop: every half, those of the upper switches only, the first "
        "halves, or the second; every half where it is left out",
    )
    switch_drop_v: float = Field(default=0.0, ge=0.0, description="forward drop of a switch, in volts")
    diode_drop_v: float = Field(default=0.0, ge=0.0, description="forward drop of a diode, in volts")
    turn_on_energy_j: _Energy = Field(
        default=0.0, description="energy lost each time a switch closes, in joules"
    )
    turn_off_energy_j: _Energy = Field(
        default=0.0, description="energy lost each time a switch opens, in joules"
    )

    @field_validator("hysteresis_band_a")
    @classmethod
    def _band_is_resolvable(cls, band: float) -> float:
        if 0.0 < band < 0.001:
            raise ValueError("must be 0 for the ideal regulator, or at least 0.001")
        return band

    @model_validator(mode="after")
    def _drops_leave_a_voltage(self) -> Self:
        for key in ("switch_drop_v", "diode_drop_v"):
            if getattr(self, key) >= self.supply_voltage_v:
                raise ValueError(
                    f"the key '{key}' is {getattr(self, key)}, "
                    f"but must be below the supply's {self.supply_voltage_v} V"
                )
        return self
