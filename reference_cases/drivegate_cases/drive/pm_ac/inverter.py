"""The table `[inverter]` of a PM AC drive: its dc link, bridge and modulator."""

from typing import Final, Literal, Self

from pydantic import Field, model_validator

from drivegate_cases.documents.document import Section

Carrier = Literal["single", "double", "sawtooth"]
UPDATES: Final = {"single": 1, "double": 2, "sawtooth": 0}
"""Number of the plant for each kind of carrier: updates in a period of the symmetric one, 0 for the sawtooth."""
_LONGEST_DEAD_SHARE: Final = 0.25


class PmAcInverter(Section):
    """A two-level bridge at a dc link, whose legs follow duty ratios once a control period."""

    link_voltage_v: float = Field(gt=0.0, le=1e5, description="voltage of the dc link, in volts")
    carrier_frequency_hz: float = Field(
        ge=2000.0,
        le=500e3,
        description="frequency of the carrier, in hertz; the control period follows from it",
    )
    carrier: Carrier = Field(
        default="single",
        description='"single": symmetric, new duty ratios once a period; "double": twice; "sawtooth": edge-aligned',
    )
    update_delay: Literal[0, 1] = Field(
        default=1, description="control periods between a step and the period that its duty ratios act in"
    )
    counter_levels: int = Field(
        default=0,
        ge=0,
        le=1_000_000,
        description="steps of the modulator's counter in a control period, or 0 for real numbers",
    )
    dead_time_s: float = Field(
        default=0.0, ge=0.0, description="time between turn-off and turn-on in a leg, in seconds"
    )
    minimum_pulse_s: float = Field(
        default=0.0, ge=0.0, description="shortest pulse or gap that the modulator gives, in seconds"
    )
    switch_drop_v: float = Field(default=0.0, ge=0.0, description="forward drop of a switch, in volts")
    diode_drop_v: float = Field(default=0.0, ge=0.0, description="forward drop of a diode, in volts")

    @model_validator(mode="after")
    def _times_and_drops_leave_something(self) -> Self:
        for key in ("switch_drop_v", "diode_drop_v"):
            if getattr(self, key) >= self.supply_voltage_v:
                raise ValueError(
                    f"the key '{key}' is {getattr(self, key):g}, but must be below half of the link's "
                    f"{self.link_voltage_v:g} V"
                )
        for key in ("dead_time_s", "minimum_pulse_s"):
            longest = _LONGEST_DEAD_SHARE * self.control_period_s
            if getattr(self, key) > longest:
                raise ValueError(
                    f"the key '{key}' is {getattr(self, key):g}, but must be at most a quarter of the control period, "
                    f"{longest:g} s"
                )
        return self

    @property
    def supply_voltage_v(self) -> float:
        """Half of the link's voltage (V), by which scenarios of every kind of drive state their supply."""
        return 0.5 * self.link_voltage_v

    @property
    def control_period_s(self) -> float:
        """Time between two steps of the controller (s)."""
        return 1.0 / (self.carrier_frequency_hz * (2.0 if self.carrier == "double" else 1.0))
