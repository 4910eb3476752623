"""Disturbances besides steps of load, speed and supply: drift of parameters, and sensors that fail for a moment."""

from typing import Literal, Self

from pydantic import Field, field_validator, model_validator

from drivegate_cases.documents.document import Section
from drivegate_cases.scenario.piecewise import Profile, check_times

_LEAST_FACTOR, _GREATEST_FACTOR = 0.1, 10.0


class Drift(Section):
    """How the plant's parameters change during a run.

    Windings and magnets change with temperature, and the inertia where a wheel is lifted from the ground or set down.
    """

    resistance: Profile | None = Field(
        default=None, description="factor on the phase resistance, a list of [seconds, factor]"
    )
    emf_constant: Profile | None = Field(
        default=None, description="factor on the EMF constant, a list of [seconds, factor]"
    )
    inertia: Profile | None = Field(
        default=None, description="factor on the inertia of rotor and load, a list of [seconds, factor]"
    )

    @field_validator("resistance", "emf_constant", "inertia")
    @classmethod
    def _factors_in_range(cls, profile: Profile | None) -> Profile | None:
        if profile is None:
            return None
        if any(not _LEAST_FACTOR <= factor <= _GREATEST_FACTOR for _, factor in profile):
            raise ValueError(f"must have factors from {_LEAST_FACTOR:g} to {_GREATEST_FACTOR:g}")
        return check_times(profile)

    @model_validator(mode="after")
    def _has_one(self) -> Self:
        if self.resistance is None and self.emf_constant is None and self.inertia is None:
            raise ValueError("must give 'resistance', 'emf_constant' or 'inertia'")
        return self


class Dropout(Section):
    """A sensor signal that reads 0 for a while."""

    signal: Literal["speed", "currents", "supply"] = Field(description="signal that is lost")
    phase: int | None = Field(
        default=None, ge=1, le=31, description="the one phase whose current is lost, by default all of them"
    )
    start_s: float = Field(ge=0.0, le=86400.0, description="time at which it is lost, in seconds")
    duration_s: float = Field(gt=0.0, le=86400.0, description="time until it is back, in seconds")

    @model_validator(mode="after")
    def _phases_have_currents(self) -> Self:
        if self.phase is not None and self.signal != "currents":
            raise ValueError(f"must not give 'phase' for the signal '{self.signal}', which is no phase's")
        return self

    @property
    def end_s(self) -> float:
        """Time at which the signal is back (s)."""
        return self.start_s + self.duration_s


class CurrentError(Section):
    """What the current sensor of one phase shows wrongly throughout a run."""

    phase: int = Field(ge=1, le=31, description="number of the phase, from 1")
    gain: float = Field(default=1.0, ge=0.0, le=10.0, description="factor on what the sensor shows")
    offset_a: float = Field(
        default=0.0, ge=-1e3, le=1e3, description="what the sensor shows of no current, in amperes"
    )

    @model_validator(mode="after")
    def _does_something(self) -> Self:
        if self.gain == 1.0 and self.offset_a == 0.0:
            raise ValueError("must give a 'gain' other than 1 or an 'offset_a' other than 0")
        return self


class Glitch(Section):
    """Edges that the encoder's counter sees and the encoder did not give."""

    time_s: float = Field(ge=0.0, le=86400.0, description="time of the false edges, in seconds")
    counts: int = Field(ge=-100_000, le=100_000, description="number of false edges, negative for lost ones")

    @field_validator("counts")
    @classmethod
    def _does_something(cls, counts: int) -> int:
        if counts == 0:
            raise ValueError("must not be 0")
        return counts
