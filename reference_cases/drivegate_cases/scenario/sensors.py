"""What stands between plant and controller: ideal sensors, or those of the published implementation (Fig. 8)."""

from dataclasses import fields
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from drivegate_cases.documents.document import Section
from drivegate_cases.drive.converter_ranges import ConverterRanges, converter_ranges
from drivegate_cases.drive.drive_document import DriveDocument


class IdealSensors(Section):
    """Sensors that show the plant as it is, without delay."""

    kind: Literal["ideal"] = Field(description="kind of sensors")


class Mcs96Sensors(Section):
    """Encoder, Hall sensors and converter of a microcontroller of the MCS-96 family (paper, Fig. 8).

    The speed comes from encoder edges timed by the high-speed inputs' clock, the currents and the supply through
    an analogue-to-digital converter. Each phase's gain and offset are drawn once a run from the scenario's seed.
    Ranges and errors that are left out are those of converters chosen for the drive.
    """

    kind: Literal["mcs96"] = Field(description="kind of sensors")
    encoder_lines: int = Field(
        default=500, ge=1, le=1_000_000, description="lines of the quadrature encoder a turn"
    )
    speed_window_s: float = Field(
        default=0.005, ge=1e-5, le=1.0, description="time over which encoder edges are counted, in seconds"
    )
    clock_s: float = Field(
        default=1e-6, gt=0.0, le=1e-3, description="resolution of the edges' times, in seconds"
    )
    current_range_a: float | None = Field(
        default=None,
        gt=0.0,
        le=1e6,
        description="greatest current that the converter shows, in amperes, by default 1.54 times the current limit",
    )
    current_gain_spread: float = Field(
        default=0.005, ge=0.0, le=0.5, description="greatest error of a current sensor's gain, as a share"
    )
    current_offset_a: float | None = Field(
        default=None,
        ge=0.0,
        le=1e3,
        description="greatest offset of a current sensor, in amperes, by default 0.19 % of the current limit",
    )
    current_noise_a: float | None = Field(
        default=None,
        ge=0.0,
        le=1e3,
        description="standard deviation of a current sensor's noise, in amperes, by default 0.077 % of the limit",
    )
    voltage_range_v: float | None = Field(
        default=None,
        gt=0.0,
        le=1e6,
        description="greatest half-supply voltage shown, in volts, by default 2.08 times the supply",
    )
    voltage_noise_v: float | None = Field(
        default=None,
        ge=0.0,
        le=1e3,
        description="standard deviation of the voltage's noise, in volts, by default 0.042 % of the supply",
    )
    converter_bits: int = Field(default=10, ge=4, le=24, description="bits of the converter")


def _by_kind(value: Any) -> Any:
    """Take a bare name for the sensors of that kind with all their defaults."""
    return {"kind": value} if isinstance(value, str) else value


Sensors = Annotated[
    Annotated[IdealSensors | Mcs96Sensors, Field(discriminator="kind")], BeforeValidator(_by_kind)
]
"""Sensors of a run, also given as a bare name."""

IDEAL = IdealSensors(kind="ideal")
MCS96 = Mcs96Sensors(kind="mcs96")
_OF_CONVERTERS = tuple(field.name for field in fields(ConverterRanges))


def fitted(sensors: Sensors, drive: DriveDocument) -> Sensors:
    """Take the ranges and errors of the drive's converters where none are stated."""
    if not isinstance(sensors, Mcs96Sensors):
        return sensors
    missing = [key for key in _OF_CONVERTERS if getattr(sensors, key) is None]
    ranges = converter_ranges(drive)
    return sensors.model_copy(update={key: getattr(ranges, key) for key in missing})


def unfitted(sensors: Sensors, drive: DriveDocument) -> Sensors:
    """Leave out the ranges and errors that are those of the drive's converters."""
    if not isinstance(sensors, Mcs96Sensors):
        return sensors
    ranges = converter_ranges(drive)
    own = [key for key in _OF_CONVERTERS if getattr(sensors, key) == getattr(ranges, key)]
    return sensors.model_copy(update=dict.fromkeys(own))
