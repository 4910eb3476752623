"""Sensors that fail for a moment or show something wrong."""

from typing import Literal, Self

from pydantic import Field, field_validator, model_validator

from drivegate_cases.documents.document import Section


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
