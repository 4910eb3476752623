"""The table `[inverter]` of a PM AC drive: its dc link, bridge and modulator."""

from typing import Annotated, Final, Literal, Self

from pydantic import Field, field_validator, model_validator

from drivegate_cases.documents.document import Section

Carrier = Literal["single", "double", "sawtooth"]
UPDATES: Final = {"single": 1, "double": 2, "sawtooth": 0}
"""Number of the plant for each kind of carrier: updates in a period of the symmetric one, 0 for the sawtooth."""
MOST_CARRIERS: Final = 32
"""Greatest number of carrier periods in a control period."""
_LONGEST_DEAD_SHARE: Final = 0.25
_LONGEST_PERIOD_S: Final = 0.0005


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
    control_every: Annotated[int, Field(ge=1, le=MOST_CARRIERS)] | None = Field(
        default=None,
        description="carrier periods in a control period, in which duty ratios hold, by default 1",
    )
    update_delay: Literal[0, 1] = Field(
        default=1, description="control periods between a step and the period that its duty ratios act in"
    )
    counter_levels: int = Field(
        default=0,
        ge=0,
        le=1_000_000,
        description="steps of a duty ratio from 0 to 1, which are the modulator's counts in half a period of a "
        "symmetric carrier, with one update or two, or in a period of a sawtooth; 0 for real numbers",
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
            longest = _LONGEST_DEAD_SHARE * self.update_period_s
            if getattr(self, key) > longest:
                raise ValueError(
                    f"the key '{key}' is {getattr(self, key):g}, but must be at most a quarter of the time between "
                    f"two updates of the modulator, {longest:g} s"
                )
        return self

    @field_validator("control_every")
    @classmethod
    def _one_is_the_default(cls, every: int | None) -> int | None:
        """Drop a 1, so that drives are equal, and have the same hash, whether or not they state it."""
        return None if every == 1 else every

    @model_validator(mode="after")
    def _control_period_is_possible(self) -> Self:
        if self.control_every is None:
            return self
        if self.carrier == "double":
            raise ValueError(
                f"the key 'control_every' is {self.control_every}, but must be left out with carrier = \"double\", "
                'which takes new duty ratios twice a period; state carrier = "single"'
            )
        if self.control_period_s > _LONGEST_PERIOD_S:
            most = sum(n * self.update_period_s <= _LONGEST_PERIOD_S for n in range(1, MOST_CARRIERS + 1))
            raise ValueError(
                f"the key 'control_every' is {self.control_every}, but with a carrier of "
                f"{self.carrier_frequency_hz:g} Hz must be at most {most}, a control period of 500 µs"
            )
        return self

    @property
    def supply_voltage_v(self) -> float:
        """Half of the link's voltage (V), by which scenarios of every kind of drive state their supply."""
        return 0.5 * self.link_voltage_v

    @property
    def lost_voltage_v(self) -> float:
        """Mean voltage that dead time and drops take from a leg against its current (V)."""
        lost = self.dead_time_s * self.carrier_frequency_hz * self.link_voltage_v
        return lost + 0.5 * (self.switch_drop_v + self.diode_drop_v)

    @property
    def update_period_s(self) -> float:
        """Time between two updates of the modulator: a period of the carrier, or half of one (s)."""
        return 1.0 / (self.carrier_frequency_hz * (2.0 if self.carrier == "double" else 1.0))

    @property
    def control_period_s(self) -> float:
        """Time between two steps of the controller (s)."""
        return (self.control_every or 1) * self.update_period_s
