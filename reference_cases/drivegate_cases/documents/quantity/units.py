"""The units library, with the angles of shaft and field, which its own units leave out."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    import pint

_DEFINITIONS: Final = (
    "shaft_turn = [shaft_angle]",
    "shaft_radian = shaft_turn / 6.283185307179586",
    "shaft_degree = shaft_turn / 360",
    "shaft_rpm = shaft_turn / minute",
    "field_cycle = [field_angle]",
    "field_hertz = field_cycle / second",
)
"""Angles have dimensions here, so that volts per 1000 rpm, volts per hertz and volt seconds differ."""
_CURRENT: Final = "ampere"


@cache
def registry() -> pint.UnitRegistry[float]:
    """Return the one registry of units; it is loaded when the first quantity is read."""
    import pint

    units: pint.UnitRegistry[float] = pint.UnitRegistry()
    for definition in _DEFINITIONS:
        units.define(definition)
    return units


def size(unit: str, of: str) -> float | None:
    """Return how many of one unit another is (1), or none if they are of different quantities.

    A torque per current is no flux linkage, although newton metres per ampere are volt seconds: of two units, both name
    the ampere or none does.
    """
    one, other = registry().Quantity(1.0, unit), registry().Quantity(1.0, of)
    if one.dimensionality != other.dimensionality or _has_current(unit) != _has_current(of):
        return None
    return float(one.m_as(other.units))


def _has_current(unit: str) -> bool:
    return _CURRENT in unit
