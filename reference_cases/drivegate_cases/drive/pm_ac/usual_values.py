"""Ranges that a PM AC drive's values leave only in a wrong unit."""

from __future__ import annotations

from math import pi, sqrt
from typing import TYPE_CHECKING, Final

from drivegate_cases.drive.usual_values import (
    UsualRange,
    range_of_current,
    ranges_of_supply_and_speed,
    usual_scale,
)
from drivegate_models.units import RADIANS_PER_RPM

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_values import DriveValues

_LINE_OF_PHASE: Final = sqrt(3.0)
_HIGHEST_EMF: Final = 1.3
"""Greatest usual EMF at base speed over the voltage of a phase: above 1 only weakening reaches that speed (1)."""


def ranges_of_pm_ac(drive: DriveValues) -> tuple[tuple[UsualRange, ...], ...]:
    """Return the ranges in the order in which they are compared."""
    link, pole_pairs = drive.inverter.link_voltage_v, drive.machine.pole_pairs
    phase_voltage = link / _LINE_OF_PHASE
    scale = usual_scale(drive, phase_voltage, link)
    flux = phase_voltage / (pole_pairs * scale.speed)
    per_1000_rpm = sqrt(2.0) / (_LINE_OF_PHASE * pole_pairs * 1000.0 * RADIANS_PER_RPM)
    torque_per_ampere = 1.0 / (1.5 * pole_pairs)
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
                (
                    ("millivolt seconds", 1e-3),
                    ("newton metres per ampere", torque_per_ampere),
                    ("volts per 1000 turns a minute", per_1000_rpm),
                    ("volts per hertz", 1.0 / (2.0 * pi)),
                ),
                speed_per_volt=1.0 / (_LINE_OF_PHASE * pole_pairs * RADIANS_PER_RPM),
            ),
            *scale.shaft_and_core(),
        ),
    )
