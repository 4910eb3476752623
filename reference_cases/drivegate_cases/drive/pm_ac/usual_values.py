"""What data sheets state in place of the magnet's flux, and ranges that values leave only in a wrong unit."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi, sqrt
from types import MappingProxyType
from typing import Final

from drivegate_cases.drive.usual_values import (
    DriveValues,
    UsualRange,
    range_of_current,
    ranges_of_supply_and_speed,
    usual_scale,
)
from drivegate_models.units import RADIANS_PER_RPM

_KRPM: Final = 1000.0 * RADIANS_PER_RPM
_SQRT3: Final = sqrt(3.0)


@dataclass(frozen=True)
class FluxConstant:
    """A constant of a machine in one unit."""

    flux: Callable[[float, int], float]
    """Flux linkage (V·s) of the stated value and the pairs of poles."""
    formula: str
    """The conversion, as a drive's file states it."""

    def of_pairs(self, pairs: int) -> Callable[[float], float]:
        """Return the conversion for a number of pole pairs."""
        return lambda value: self.flux(value, pairs)


SPEED_PER_VOLT: Final = FluxConstant(
    lambda value, pairs: 1.0 / (_SQRT3 * pairs * value * RADIANS_PER_RPM),
    "60 / (2 pi sqrt(3) pole pairs Kv), with the peak EMF between two terminals",
)
TORQUE_PER_PEAK_AMPERE: Final = FluxConstant(
    lambda value, pairs: value / (1.5 * pairs), "Kt / (1.5 pole pairs)"
)
RMS_PER_1000_RPM: Final = FluxConstant(
    lambda value, pairs: value * sqrt(2.0) / (_SQRT3 * _KRPM * pairs),
    "Ke sqrt(2) / (sqrt(3) 104.72 pole pairs), with the rms EMF between two terminals",
)
PEAK_PER_1000_RPM: Final = FluxConstant(
    lambda value, pairs: value / (_SQRT3 * _KRPM * pairs),
    "Ke / (sqrt(3) 104.72 pole pairs), with the peak EMF between two terminals",
)
VOLTS_PER_HERTZ: Final = FluxConstant(lambda value, _: value / (2.0 * pi), "V/Hz / (2 pi)")
MILLIVOLT_SECONDS: Final = FluxConstant(lambda value, _: 1e-3 * value, "in volt seconds")

FLUX_CONSTANTS: Final[Mapping[str, FluxConstant]] = MappingProxyType(
    {
        "rpm/v": SPEED_PER_VOLT,
        "kv": SPEED_PER_VOLT,
        "nm/arms": FluxConstant(
            lambda value, pairs: value / (1.5 * sqrt(2.0) * pairs), "Kt / (1.5 sqrt(2) pole pairs)"
        ),
        "nm/apeak": TORQUE_PER_PEAK_AMPERE,
        "nm/adc": FluxConstant(
            lambda value, pairs: value / (_SQRT3 * pairs),
            "Kt / (sqrt(3) pole pairs), since Kt of a dc current is the peak EMF between two terminals over speed",
        ),
        "v/krpmrms": RMS_PER_1000_RPM,
        "vrms/krpm": RMS_PER_1000_RPM,
        "v/krpmpeak": PEAK_PER_1000_RPM,
        "vpeak/krpm": PEAK_PER_1000_RPM,
        "vs": FluxConstant(lambda value, _: value, "as stated"),
        "mvs": MILLIVOLT_SECONDS,
        "wb": FluxConstant(lambda value, _: value, "a weber is a volt second"),
        "mwb": FluxConstant(lambda value, _: 1e-3 * value, "a weber is a volt second"),
    }
)
"""The constants that data sheets state, by their unit in small letters and without spaces."""


_CONSTANTS: Final = {
    "millivolt seconds": MILLIVOLT_SECONDS,
    "newton metres per ampere": TORQUE_PER_PEAK_AMPERE,
    "volts per 1000 turns a minute": RMS_PER_1000_RPM,
    "volts per hertz": VOLTS_PER_HERTZ,
    "turns a minute per volt": SPEED_PER_VOLT,
}
"""What a data sheet may state in place of the flux, by its name in words."""
_HIGHEST_EMF: Final = 1.3
"""Greatest usual EMF at base speed over the voltage of a phase: above 1 only weakening reaches that speed (1)."""


def ranges_of_pm_ac(drive: DriveValues) -> tuple[tuple[UsualRange, ...], ...]:
    link, pole_pairs = drive.inverter.link_voltage_v, drive.machine.pole_pairs
    phase_voltage = link / _SQRT3
    scale = usual_scale(drive, phase_voltage, link)
    flux = phase_voltage / (pole_pairs * scale.speed)
    return (
        ranges_of_supply_and_speed("link_voltage_v"),
        range_of_current(drive, link, ""),
        (
            scale.resistance(),
            scale.inductance("direct_inductance_h", pole_pairs),
            scale.inductance("quadrature_inductance_h", pole_pairs),
            UsualRange(
                "magnet_flux_v_s",
                0.02 * flux,
                _HIGHEST_EMF * flux,
                f"for {link:g} V {scale.geared}",
                other_quantities=tuple(
                    (name, constant.of_pairs(pole_pairs)) for name, constant in _CONSTANTS.items()
                ),
            ),
            *scale.shaft_and_core(),
        ),
    )
