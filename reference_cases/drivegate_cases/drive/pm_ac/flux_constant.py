"""What data sheets state in place of the magnet's flux, and its conversion."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi, sqrt
from types import MappingProxyType
from typing import Final

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
