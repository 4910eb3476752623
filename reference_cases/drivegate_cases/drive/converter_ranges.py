"""Ranges and errors of the converters that measure a drive's currents and supply, where a scenario leaves them out."""

from dataclasses import dataclass

from drivegate_cases.documents.rounding import significant
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import nearest_step

_CURRENT_RANGE = 1.54
_CURRENT_OFFSET = 0.0019
_CURRENT_NOISE = 0.00077
_VOLTAGE_RANGE = 2.08
_VOLTAGE_NOISE = 0.00042


@dataclass(frozen=True)
class ConverterRanges:
    """What converters chosen for a drive show of it: 40 A and 100 V on the paper's, the same shares on any other."""

    current_range_a: float
    """Greatest current shown (A): half as much again as the current limit, and a little."""
    current_offset_a: float
    current_noise_a: float
    """Greatest offset of a current sensor, and standard deviation of its noise (A): about 0.2 % and 0.08 % of
    the current limit."""
    voltage_range_v: float
    voltage_noise_v: float
    """Greatest voltage shown, and standard deviation of its noise (V): about twice the voltage of each half
    of the supply, and 0.04 % of it."""


def converter_ranges(drive: DriveDocument) -> ConverterRanges:
    """Choose the converters for a drive."""
    limit, supply = drive.rating.current_limit_a, drive.inverter.supply_voltage_v
    return ConverterRanges(
        current_range_a=significant(_CURRENT_RANGE * limit, 2),
        current_offset_a=nearest_step(_CURRENT_OFFSET * limit),
        current_noise_a=nearest_step(_CURRENT_NOISE * limit),
        voltage_range_v=significant(_VOLTAGE_RANGE * supply, 2),
        voltage_noise_v=nearest_step(_VOLTAGE_NOISE * supply),
    )
