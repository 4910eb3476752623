"""Ranges that values leave only in a wrong unit."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import pi, sqrt
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


_CONSTANTS: Final[dict[str, Callable[[int, float], float]]] = {
    "millivolt seconds": lambda _, value: 1e-3 * value,
    "newton metres per ampere": lambda pairs, value: value / (1.5 * pairs),
    "volts per 1000 turns a minute": lambda pairs, value: value * sqrt(2.0) / (_SQRT3 * _KRPM * pairs),
    "volts per hertz": lambda _, value: value / (2.0 * pi),
    "turns a minute per volt": lambda pairs, value: 1.0 / (_SQRT3 * pairs * value * RADIANS_PER_RPM),
}
"""Flux linkage (V·s) by pole pairs and by what a data sheet may state in its place, by its name in words."""
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
                    (name, partial(flux_of, pole_pairs)) for name, flux_of in _CONSTANTS.items()
                ),
            ),
            *scale.shaft_and_core(),
        ),
    )
