"""Ranges that a PM AC drive's values leave only in a wrong unit."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING, Final

from drivegate_cases.drive.pm_ac.flux_constant import (
    MILLIVOLT_SECONDS,
    RMS_PER_1000_RPM,
    SPEED_PER_VOLT,
    TORQUE_PER_PEAK_AMPERE,
    VOLTS_PER_HERTZ,
)
from drivegate_cases.drive.usual_values import (
    UsualRange,
    range_of_current,
    ranges_of_supply_and_speed,
    usual_scale,
)

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_values import DriveValues

_LINE_OF_PHASE: Final = sqrt(3.0)
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
    """Return the ranges in the order in which they are compared."""
    link, pole_pairs = drive.inverter.link_voltage_v, drive.machine.pole_pairs
    phase_voltage = link / _LINE_OF_PHASE
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
                "volt seconds",
                f"for {link:g} V {scale.geared}",
                other_quantities=tuple(
                    (name, constant.of_pairs(pole_pairs)) for name, constant in _CONSTANTS.items()
                ),
            ),
            *scale.shaft_and_core(),
        ),
    )
